"""Which unit is at work: a few bytes in a file that is mapped into memory and outlives the process.

Noting costs a fifth of a microsecond, so every call into a unit can do it; when the process crashes or hangs, the
mark names the unit.
"""

from __future__ import annotations

import math
import mmap
import struct
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from towage.units.description import Description
    from towage.units.fmu import Unit
    from towage.units.wiring import Wanted

LAYOUT = struct.Struct("d120s120s")
"""Time in s (NaN before the start), stage, unit."""


class Mark:
    """The file at ``path``, created here."""

    def __init__(self, path: Path) -> None:
        path.write_bytes(LAYOUT.pack(math.nan, b"", b""))
        with open(path, "r+b") as file:
            self._memory = mmap.mmap(file.fileno(), LAYOUT.size)

    def note(self, unit: bytes, stage: bytes, time: float) -> None:
        """``unit`` is about to be called."""
        LAYOUT.pack_into(self._memory, 0, time, stage, unit)

    @staticmethod
    def read(path: Path) -> tuple[str, str, float | None]:
        """(unit, stage, time in s) as last noted, as far as they are known."""
        try:
            time, stage, unit = LAYOUT.unpack(path.read_bytes())
        except (OSError, struct.error):
            return "", "", None
        texts = [text.rstrip(b"\0").decode(errors="replace") for text in (unit, stage)]
        return texts[0], texts[1], None if math.isnan(time) else time

    def unit(self, name: str, description: Description, directory: Path, wanted: Wanted) -> Unit:
        """A unit that is noted before each call: a `UnitFactory`."""
        from towage.process.watched import Watched

        return Watched(self.note, name, description, directory, wanted)
