"""A unit that is noted before each call, for `towage.process.mark`."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from pathlib import Path

from towage.units.description import Description, Value
from towage.units.fmu import Unit
from towage.units.wiring import Wanted

Note = Callable[[bytes, bytes, float], None]
"""Takes the unit, the stage and the time, s."""


class Watched(Unit):
    """A unit whose every call is noted first."""

    def __init__(self, note: Note, name: str, description: Description, directory: Path, wanted: Wanted) -> None:
        label = name.encode()
        self._note, self._label = note, label
        note(label, b"instantiation", math.nan)
        super().__init__(name, description, directory, wanted)
        advance = self.advance

        def noted(time: float, size: float) -> list[float]:
            """As ``advance`` of `Unit`."""
            note(label, b"step", time)
            return advance(time, size)

        self.advance = noted

    def enter(self, start: Mapping[str, Value], span: tuple[float, float], tolerance: float | None) -> None:
        """As `Unit.enter`."""
        self._note(self._label, b"initialisation", span[0])
        super().enter(start, span, tolerance)

    def begin(self, time: float) -> None:
        """As `Unit.begin`."""
        self._note(self._label, b"initialisation", time)
        super().begin(time)

    def set(self, time: float) -> None:
        """As `Unit.set`; a step begins with its inputs."""
        self._note(self._label, b"step", time)
        super().set(time)

    def save(self, time: float) -> None:
        """As `Unit.save`."""
        self._note(self._label, b"state", time)
        super().save(time)

    def restore(self, time: float) -> None:
        """As `Unit.restore`."""
        self._note(self._label, b"state", time)
        super().restore(time)

    def frozen(self, time: float) -> bytes:
        """As `Unit.frozen`."""
        self._note(self._label, b"state", time)
        return super().frozen(time)

    def thaw(self, data: bytes, time: float) -> None:
        """As `Unit.thaw`."""
        self._note(self._label, b"state", time)
        super().thaw(data, time)

    def close(self) -> None:
        """As `Unit.close`."""
        self._note(self._label, b"termination", math.nan)
        super().close()
