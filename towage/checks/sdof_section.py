"""The table ``[checks.sdof]`` of a scene, and what it names in the scene."""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec

from towage.scene.parts import Seconds

if TYPE_CHECKING:
    from towage.scene.resolve import ResolvedScene


class SdofCheck(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """``[checks.sdof]``: the run is repeated without ``cut``; ``settle`` in s, compared from there on."""

    cut: tuple[str, ...]
    driver: str
    motion: str
    tension: str
    tolerance: float = 0.05
    settle: Seconds = 0.0


class Sdof(SdofCheck, frozen=True, kw_only=True):
    """The table of a scene whose connections are known: ``reaction``, the output that acts back by the first of the cut
    connections; ``ship``, the unit at which that ends."""

    reaction: str
    ship: str


def sdof_of(scene: ResolvedScene) -> Sdof:
    """Of a scene with the table. Names of variables may hold arrows, so that the ends are those of the resolved connection."""
    section: SdofCheck = scene.scene.checks.get("sdof")
    back = scene.connections[scene.scene.connections.index(section.cut[0])]
    return Sdof(**msgspec.structs.asdict(section), reaction=f"{back.source_unit}.{back.source}", ship=back.target_unit)
