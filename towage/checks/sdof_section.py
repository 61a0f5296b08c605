"""The table ``[checks.sdof]`` of a scene."""

from __future__ import annotations

import msgspec

from towage.scene.parts import Seconds


class SdofCheck(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """``[checks.sdof]``: the run is repeated without ``cut``; ``settle`` in s, compared from there on."""

    cut: tuple[str, ...]
    driver: str
    motion: str
    tension: str
    tolerance: float = 0.05
    settle: Seconds = 0.0

    @property
    def reaction(self) -> str:
        """The output that acts back on the ship."""
        return self.cut[0].rpartition(" -> ")[0]

    @property
    def ship(self) -> str:
        """The unit that the cut connections end at."""
        return self.cut[0].rpartition(" -> ")[2].split(".")[0]
