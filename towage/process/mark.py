"""Who is at work: a few bytes in a file that is mapped into memory and outlives the process.

Noting costs a fifth of a microsecond, so every call into a unit can do it; when the process crashes or hangs, the
mark names the unit.
"""

from __future__ import annotations

import math
import mmap
import struct
from collections.abc import Mapping
from pathlib import Path
from typing import Any

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

    def watch(self) -> None:
        """Have every unit of this process noted from now on."""
        from towage.master import system
        from towage.units import fmu

        note = self.note

        class Watched(fmu.Unit):
            """A unit that is noted before each call."""

            def __init__(self, name: str, *rest: Any, **options: Any) -> None:
                label = self._label = name.encode()
                note(label, b"instantiation", math.nan)
                super().__init__(name, *rest, **options)
                advance = self.advance

                def noted(time: float, size: float) -> list[float]:
                    note(label, b"step", time)
                    return advance(time, size)

                self.advance = noted

            def start(self, start: Mapping[str, Any], start_time: float, stop_time: float) -> None:
                note(self._label, b"initialisation", start_time)
                super().start(start, start_time, stop_time)

            def set(self, time: float) -> None:
                note(self._label, b"step", time)  # which begins with its inputs
                super().set(time)

            def save(self, time: float) -> None:
                note(self._label, b"state", time)
                super().save(time)

            def restore(self, time: float) -> None:
                note(self._label, b"state", time)
                super().restore(time)

            def close(self) -> None:
                note(self._label, b"termination", math.nan)
                super().close()

        vars(system)["Unit"] = Watched  # the one place where units are made
