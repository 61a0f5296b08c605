"""What a sweep varies: a grid over ranges, or a scrambled Sobol sequence in their box.

A range is written "unit.parameter=A:B:N" (grid: N values from A to B, ends included), "unit.parameter=A,B,C" (grid: these values,
taken in rising order) or "unit.parameter=A:B" (Sobol), its values as in a scene file: numbers, or texts with a unit. Keys of the
scene, as coupling.step, can be varied too.

Source of the sequence: S. Joe and F. Y. Kuo, SIAM J. Sci. Comput. 30 (2008), as in scipy; scrambling after Owen.
"""

from __future__ import annotations

import functools
import hashlib
import math
import operator
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from towage.errors import SceneError
from towage.scene.resolve import described
from towage.scene.scene import Scene
from towage.units.store import locator

Array = NDArray[np.float64]
MOST = 1_000_000
"""Runs of a sweep: a mistyped count should be told, not begun."""
VARY = "--vary"
"""The key of faults in what is varied: the option of ``towage sweep``."""
_TIMES = ("stop_time", "coupling.step", "record.interval", "checks.sdof.settle", "checks.simpler.settle")


@dataclass(frozen=True)
class Vary:
    """A range as written: its two ends, ``count`` None where none is given; or a list of ``texts`` with their ``count``."""

    target: str
    texts: tuple[str, ...]
    count: int | None
    listed: bool = False


@dataclass(frozen=True)
class Design:
    """Points of a sweep: ``points`` of shape (runs, targets), each column in the unit of measure ``units`` that its
    variable declares (SI for the shipped units). ``shape``: values along each target of a grid, () for a sequence.
    ``whole``: whether a target takes whole numbers only. ``text``: the ranges
    as they were written."""

    targets: tuple[str, ...]
    units: tuple[str, ...]
    points: Array
    shape: tuple[int, ...]
    whole: tuple[bool, ...]
    text: str

    def values(self, index: int) -> dict[str, float | int]:
        """What run ``index`` sets, by target, in the unit of its variable."""
        point = self.points[index].tolist()
        return {t: int(v) if whole else v for t, v, whole in zip(self.targets, point, self.whole)}

    def digest(self) -> str:
        """A hash of the points, to the last bit."""
        return hashlib.sha256(np.ascontiguousarray(self.points).tobytes()).hexdigest()[:16]


def parse_vary(text: str) -> Vary:
    """The range or list in ``text``. Raises `SceneError`."""
    target, separator, rest = text.partition("=")
    listed = "," in rest
    parts = [part.strip() for part in rest.split("," if listed else ":")]
    count = len(parts) if listed else None
    try:
        if not separator or not target.strip() or not (listed or len(parts) in (2, 3)) or not all(parts):
            raise ValueError
        if not listed and len(parts) == 3:
            count = int(parts.pop())
    except ValueError:
        raise SceneError(
            f"{text!r}: expected unit.parameter=FROM:TO:COUNT, a list unit.parameter=A,B,C, or unit.parameter=FROM:TO with "
            "--sobol, as in 'ship.heave_amplitude=2 ft:6 ft:9'",
            key=VARY,
        ) from None
    if count is not None and count < 2:
        raise SceneError(f"{text!r}: a range has at least 2 values; a single one is given with --set", key=VARY)
    return Vary(target.strip(), tuple(parts), count, listed)


def design(
    scene: Scene, ranges: Sequence[str], samples: int | None = None, seed: int = 0, fmus: Path | None = None
) -> Design:
    """`grid`, or with ``samples`` `sobol`. Raises `SceneError`."""
    return grid(scene, ranges, fmus) if samples is None else sobol(scene, ranges, samples, seed, fmus)


def grid(scene: Scene, ranges: Sequence[str], fmus: Path | None = None) -> Design:
    """All combinations of ``ranges`` ("unit.parameter=FROM:TO:COUNT" or "=A,B,C"), the first target changing slowest. Raises
    `SceneError` for a range that does not fit the scene."""
    axes = _axes(scene, ranges, fmus)
    counts = []
    for axis in axes:
        if axis.vary.count is None:
            raise SceneError(f"{axis.vary.target}: how many values? Write FROM:TO:COUNT, or use --sobol", key=VARY)
        counts.append(axis.vary.count)
    _refuse_too_many(math.prod(counts))
    columns = [
        _checked(
            axis, np.array(axis.values) if axis.vary.listed else np.linspace(axis.values[0], axis.values[-1], count)
        )
        for axis, count in zip(axes, counts)
    ]
    shape = tuple(counts)
    points = np.stack([part.ravel() for part in np.meshgrid(*columns, indexing="ij")], axis=1)
    return _design(axes, points, shape, "grid " + "; ".join(ranges))


def sobol(scene: Scene, ranges: Sequence[str], samples: int, seed: int = 0, fmus: Path | None = None) -> Design:
    """The first ``samples`` points of a scrambled Sobol sequence in the box of ``ranges``; more samples with the same
    seed begin with the same points. Raises `SceneError`."""
    from scipy.stats import qmc

    if samples < 1:
        raise SceneError(f"{samples} samples: expected at least 1", key="--samples")
    _refuse_too_many(samples)
    axes = _axes(scene, ranges, fmus)
    for axis in axes:
        if axis.vary.count is not None:
            raise SceneError(f"{axis.vary.target}: a sequence takes FROM:TO, without a count or a list", key=VARY)
        if axis.whole:
            raise SceneError(f"{axis.vary.target} takes whole numbers: vary it in a grid", key=VARY)
    sequence = qmc.Sobol(len(axes), scramble=True, seed=seed)
    unit_cube = sequence.random_base2(max(samples - 1, 0).bit_length())[:samples]
    low, high = np.array([a.values for a in axes]).T
    text = f"sobol {samples}, seed {seed}; " + "; ".join(ranges)
    return _design(axes, low + (high - low) * unit_cube, (), text)


class _Axis(NamedTuple):
    vary: Vary
    values: tuple[float, ...]
    unit: str
    whole: bool


def _axes(scene: Scene, ranges: Sequence[str], fmus: Path | None) -> list[_Axis]:
    varied = [parse_vary(text) for text in ranges]
    if not varied:
        raise SceneError("nothing is varied: give at least one range", key=VARY)
    names = [vary.target for vary in varied]
    if twice := next((name for name in names if names.count(name) > 1), None):
        raise SceneError(f"{twice} is varied twice", key=VARY)
    return [_axis(scene, vary, fmus) for vary in varied]


def _axis(scene: Scene, vary: Vary, fmus: Path | None) -> _Axis:
    """The values as numbers in the declared unit, all accepted by the scene and its units."""
    values, units, whole = zip(*(_end(scene, vary.target, text, fmus) for text in vary.texts))
    if len(set(values)) < len(values):
        twice = f"{max(values, key=values.count)!r} is listed twice"
        said = twice if vary.listed else f"both ends of the range are {values[0]!r}"
        raise SceneError(f"{vary.target}: {said}", key=VARY)
    return _Axis(vary, tuple(sorted(values)) if vary.listed else values, units[0], whole[0])


def _end(scene: Scene, target: str, text: str, fmus: Path | None) -> tuple[float, str, bool]:
    """(value, unit of measure, whether only whole numbers are taken)."""
    given: Any = text
    for kind in (int, float):
        try:
            given = kind(text)
            break
        except ValueError:
            continue
    changed = scene.setting({target: given}, VARY)
    head, _, rest = target.partition(".")
    value: Any
    if head in scene.units:
        resolved = described(changed, locator(fmus)).units[head]
        variable, value = resolved.description.by_name()[rest], resolved.parameters[rest]
        unit, whole = variable.unit or "", variable.type != "Real"
    else:
        value = functools.reduce(operator.getitem, target.split("."), changed.to_dict())
        unit, whole = "s" if target in _TIMES else "", False
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise SceneError(f"{target} is no number and cannot be varied over a range", file=scene.file, key=VARY)
    return float(value), unit, whole


def _checked(axis: _Axis, values: Array) -> Array:
    if axis.whole and np.any(values != np.rint(values)):
        raise SceneError(
            f"{axis.vary.target} takes whole numbers, and {axis.vary.count} values from {axis.values[0]:g} to "
            f"{axis.values[-1]:g} are not: choose another count",
            key=VARY,
        )
    return values


def _refuse_too_many(count: int) -> None:
    if count > MOST:
        raise SceneError(f"{count} runs, more than {MOST}: take fewer values, or --sobol", key=VARY)


def _design(axes: Sequence[_Axis], points: Array, shape: tuple[int, ...], text: str) -> Design:
    targets, units, whole = zip(*((axis.vary.target, axis.unit, axis.whole) for axis in axes))
    return Design(targets, units, points, shape, whole, text)
