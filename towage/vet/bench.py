"""A unit on the bench: what a trial does with an instance of an FMU."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

from towage.units.archive import read_description, unpacked
from towage.units.description import Description, Value
from towage.units.fmu import StepRefused, Unit
from towage.units.store import cache
from towage.units.wiring import Wanted

STEPS = 50
"""Of a trial."""
DEFAULT_STEP = 0.01
"""Step of a unit whose default experiment names none, s."""
LONG = 1e9
"""Stop time that no trial reaches, s."""


class Trial(NamedTuple):
    """What one trial found: ``level`` ok, note, warning or fault; the number that decided, if there is one."""

    name: str
    level: str
    message: str
    value: float | None = None


class Bench:
    """An FMU that is tried with steps of ``step`` s."""

    def __init__(self, path: Path) -> None:
        self.description: Description = read_description(path)
        self.directory = unpacked(path, cache() / "unpacked")
        self.step = self.description.default_experiment.step_size or DEFAULT_STEP
        every = self.description.variables
        self.inputs = [v for v in every if v.causality == "input" and v.type == "Real"]
        self.outputs = [v for v in every if v.causality == "output" and v.type == "Real"]

    @contextmanager
    def unit(
        self, name: str = "tried", slopes: bool = False, values: Mapping[str, Value] | None = None
    ) -> Iterator[Unit]:
        """An initialised instance, with these start ``values``, freed at the end; ``slopes``: it is given derivatives of its
        inputs. Raises `RunError` and `FmuError`."""
        unit = self.made(name, slopes, values or {})
        try:
            yield unit
        finally:
            unit.close()

    def made(self, name: str, slopes: bool, values: Mapping[str, Value]) -> Unit:
        """An initialised instance."""
        wanted = Wanted([v.name for v in self.inputs], [], [v.name for v in self.outputs], cubic=slopes)
        unit = Unit(name, self.description, self.directory, wanted)
        try:
            unit.enter(values, (0.0, LONG), self.description.default_experiment.tolerance)
            unit.begin(0.0)
        except BaseException:
            unit.close()
            raise
        return unit

    def excite(self, unit: Unit, time: float) -> None:
        """Inputs that move: a slow sine about the start value, of its size or of 1, inside the bounds."""
        for k, v in enumerate(self.inputs):
            start = float(v.start or 0.0)
            value = start + 0.1 * (abs(start) or v.nominal or 1.0) * math.sin((0.7 + 0.1 * k) * time / (10.0 * self.step))
            low, high = -math.inf if v.min is None else v.min, math.inf if v.max is None else v.max
            unit.input_buffer[unit.inputs[v.name].slot] = min(max(value, low), high)

    def row(self, unit: Unit, values: Sequence[float]) -> list[float]:
        """Values of a unit in the order of ``outputs``."""
        return [values[unit.slot[v.name]] for v in self.outputs]

    def run(self, unit: Unit, count: int, first: int = 0) -> list[list[float]]:
        """Values of the outputs after each of ``count`` steps from step ``first`` on; fewer where the unit ends or refuses."""
        rows = []
        for k in range(first, first + count):
            self.excite(unit, k * self.step)
            try:
                rows.append(self.row(unit, unit.advance(k * self.step, self.step)))
            except StepRefused:
                break
        return rows

    def worst(
        self, one: Sequence[Sequence[float]], other: Sequence[Sequence[float]], smooth: bool = False
    ) -> tuple[float, str]:
        """(largest relative difference of two runs, the output), relative to the largest value of the output; ``smooth``: of
        continuous outputs alone."""
        worst, which = 0.0, ""
        for k, v in enumerate(self.outputs):
            if smooth and v.variability != "continuous":
                continue
            scale = max((abs(row[k]) for row in (*one, *other)), default=0.0)
            gap = max((abs(a[k] - b[k]) for a, b in zip(one, other)), default=0.0)
            if gap > worst * scale:
                worst, which = gap / scale, v.name
        return worst, which
