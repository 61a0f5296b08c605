"""Thousands of members of one scene, each with its own parameters, integrated together in compiled code.

    from towage.ensemble.ensemble import Ensemble

    members = Ensemble("slack", {"ship.heave_amplitude": np.linspace(0.5, 2.0, 10_000)}).run()
    members.high["line.tension"]

The scene's equations are joined (`compose`), so that there is no coupling error; `fmus.ensemble` makes them C code, which is
compiled once and kept in the cache. Members are independent: each has its own steps, branches and events. Of every run some
members, drawn at random, are computed again by the FMU path (`fmus.instance`, the behaviour of the scene's own FMU), and the
run is refused if they differ. Open inputs are constant, and can be varied like parameters.
"""

from __future__ import annotations

import copy
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from towage.checks.tow_names import SMALL
from towage.ensemble.engine import DONE, Engine
from towage.ensemble.rows import composed, equally_many, refusals, rows
from towage.errors import RunError, SceneError, suggest
from towage.fmus.declare.unit import BuildError, Unit
from towage.fmus.python.instance import Instance
from towage.fmus.python.values import CallError, StepError
from towage.scene.resolve import described
from towage.scene.scene import Scene
from towage.scene.select import one_case
from towage.units.store import locator

Array = NDArray[np.float64]
ENDINGS = ("done", "no step is small enough", "too many steps between two times", "an output is not finite")
"""Words for what the compiled code says of a member."""
REFERENCE_TOLERANCE = 1e-11
"""``integration_tolerance`` of the FMU path, so small that the difference is the ensemble's."""


class Sample(NamedTuple):
    """A member computed again: the output that differs most, by how much of its largest value, and when, s."""

    member: int
    variable: str
    difference: float
    time: float


@dataclass(frozen=True)
class Members:
    """The results of a run, SI. ``time``: shape (times,), s. ``low`` and ``high``: extremes over it by output, shape
    (members,); ``series``: shape (members, times). NaN where ``message`` says that the member was ``refused`` for its values,
    or why it ended early. ``samples``: the members that were computed again. ``steps``: mean number of steps that a member
    tried, waiting lanes included."""

    time: Array
    low: dict[str, Array]
    high: dict[str, Array]
    series: dict[str, Array]
    message: tuple[str, ...]
    refused: NDArray[np.bool_]
    samples: tuple[Sample, ...]
    steps: float

    @property
    def done(self) -> NDArray[np.bool_]:
        """Which members came to their end, shape (members,)."""
        return np.array([not text for text in self.message])


class Ensemble:
    """Members of one scene, or of one unit, that differ in their values.

    ``scene``: a scene, the path of its file or the name of a shipped one, ``case`` one of its cases (as in `towage.run`);
    or a unit. ``varied``: values of parameters ("unit.parameter") and open inputs, shape (members,) each, in the units of
    measure that they declare (SI for the shipped units); what the scene makes equal ("= unit.parameter") follows.
    ``observed``: outputs that are kept, by default what the scene records or every output of the unit.

    Raises `SceneError` for names and values that do not fit, and for a scene that cannot be composed into one unit;
    `BuildError` where nothing can be traced or compiled, with what to install.
    """

    def __init__(
        self,
        scene: Scene | Unit | str | Path,
        varied: Mapping[str, ArrayLike],
        observed: Sequence[str] | None = None,
        case: str | None = None,
    ) -> None:
        try:
            from towage.fmus.native.ensemble.build import text
        except ImportError as error:
            raise BuildError(f"an ensemble is traced with casadi ({error}): pip install 'towage[native]'") from error

        self.scene: Scene | None = None
        if isinstance(scene, Unit):
            unit = scene
        else:
            self.scene = one = one_case(scene, case)
            unit = composed(one)
        self.unit = unit
        self.varied = equally_many(varied)
        if self.scene and observed is None:
            observed = [f"{unit}.{name}" for unit, name in described(self.scene, locator()).record]
        self.observed = tuple(observed or (v.name for v in unit.observed if v.causality == "output"))
        for name in self.observed:
            if name not in {v.name for v in unit.observed}:
                raise SceneError(f"{unit.name} has no output {name!r}{suggest(name, [v.name for v in unit.observed])}")
        self._text = text(unit, self.observed)
        self.rows = rows(self.scene, unit, self.varied)
        self._engine = Engine(self._text)

    def __len__(self) -> int:
        return len(self.rows)

    def part(self, members: ArrayLike) -> Ensemble:
        """Some of the members, by their numbers, in an ensemble of their own with the same compiled code."""
        which, other = np.asarray(members, np.int64), copy.copy(self)
        other.rows = self.rows[which]
        other.varied = {name: values[which] for name, values in self.varied.items()}
        return other

    def run(
        self,
        times: ArrayLike | None = None,
        series: Sequence[str] = (),
        *,
        accuracy: float = 1e-8,
        samples: int = 3,
        seed: int = 0,
        tolerance: float = 1e-8,
        threads: int | None = None,
    ) -> Members:
        """Run all members over ``times``, s, from 0 on: by default those of the scene's record.

        ``accuracy``: relative error of a step. ``samples`` members, drawn with ``seed``, are computed again, and must agree
        in all outputs at all times within ``tolerance`` of the output's largest value; else `RunError`. ``threads``: by
        default one a processor.
        """
        grid = self._times(times)
        shown = [self._column(name) for name in series]
        refused = refusals(self.unit, self._text.traced, self.rows)
        which = np.array([k for k in range(len(self)) if k not in refused], np.int64)
        drawn = _drawn(which, samples, seed)
        computed = self._engine.run(self.rows[which], grid, shown, accuracy, threads or os.cpu_count() or 1)
        message = [refused.get(k, "") for k in range(len(self))]
        for k, ending, when in zip(which, computed.status, computed.when):
            if ending != DONE:
                message[k] = f"{ENDINGS[ending]} at t = {when:.9g} s"
        alive = computed.status[np.searchsorted(which, drawn)] == DONE
        checked = self._check(drawn[alive], grid, accuracy, tolerance)

        def spread(values: Array) -> Array:
            """Values of the members that ran, as values of all; NaN for the others."""
            whole = np.full((len(self), *values.shape[1:]), np.nan)
            whole[which] = np.where((computed.status == DONE).reshape(-1, *[1] * (values.ndim - 1)), values, np.nan)
            return whole

        low, high, kept = spread(computed.low), spread(computed.high), spread(computed.series)
        return Members(
            grid,
            {name: low[:, i] for i, name in enumerate(self.observed)},
            {name: high[:, i] for i, name in enumerate(self.observed)},
            {name: kept[:, :, i] for i, name in enumerate(series)},
            tuple(message),
            np.isin(np.arange(len(self)), which, invert=True),
            checked,
            computed.steps / max(1, len(which)),
        )

    def _times(self, times: ArrayLike | None) -> Array:
        if times is None:
            if not self.scene:
                raise SceneError("a unit has no stop time of its own: give the times of the outputs")
            stop, coupling = self.scene.stop_time, self.scene.coupling
            interval = self.scene.record.interval or coupling.step or stop / 2000
            times = np.append(interval * np.arange(int(np.ceil(stop / interval - 1e-9))), stop)
        grid = np.ascontiguousarray(times, np.float64)
        if (
            grid.ndim != 1
            or not len(grid)
            or not np.isfinite(grid).all()
            or grid[0] < 0.0
            or (np.diff(grid) <= 0.0).any()
        ):
            raise SceneError("times: expected finite numbers of seconds, from 0 on, growing")
        return grid

    def _column(self, name: str) -> int:
        if name not in self.observed:
            raise SceneError(f"{name!r} is not observed{suggest(name, self.observed)}: name it in observed")
        return self.observed.index(name)

    def compare(self, times: Array, accuracies: Sequence[float], *, samples: int = 3, seed: int = 0) -> list[float]:
        """The largest difference of drawn members from the FMU path, one for each of ``accuracies``: work and precision."""
        refused = refusals(self.unit, self._text.traced, self.rows)
        drawn = _drawn(np.array([k for k in range(len(self)) if k not in refused], np.int64), samples, seed)
        others = [self.reference(int(k), times) for k in drawn]
        return [max(s.difference for s in self._samples(drawn, times, each, others)) for each in accuracies]

    def _samples(
        self, drawn: NDArray[np.int64], times: Array, accuracy: float, others: Sequence[Array]
    ) -> tuple[Sample, ...]:
        """The members ``drawn`` against their tables from the FMU path."""
        series = self._engine.run(self.rows[drawn], times, range(len(self.observed)), accuracy, 1).series
        samples = []
        for k, own, other in zip(drawn, series, others):
            off = np.abs(own - other) / np.maximum(np.abs(other).max(axis=0), 1e-300)
            at, i = np.unravel_index(int(np.argmax(np.where(np.isnan(off), np.inf, off))), off.shape)
            samples.append(Sample(int(k), self.observed[i], float(off[at, i]), float(times[at])))
        return tuple(samples)

    def _check(self, drawn: NDArray[np.int64], times: Array, accuracy: float, tolerance: float) -> tuple[Sample, ...]:
        """The members ``drawn`` against the FMU path. Raises `RunError` with the member that differs most."""
        checked = self._samples(drawn, times, accuracy, [self.reference(int(k), times) for k in drawn])
        worst = max(checked, key=lambda s: s.difference, default=None)
        if worst and not worst.difference <= tolerance:
            values = ", ".join(f"{name} = {v[worst.member]:.9g}" for name, v in self.varied.items())
            raise RunError(
                f"member {worst.member} ({values}) differs from the FMU path by {worst.difference:.1e} of the largest value, "
                f"more than {tolerance:.1e}: ask for more accuracy (now {accuracy:.1e}), allow a larger tolerance, or "
                "run the members one by one (towage sweep --engine runs)",
                variable=worst.variable, time=worst.time,
            )  # fmt: skip
        return checked

    def reference(self, member: int, times: Array) -> Array:
        """Outputs of one member by the FMU path, shape (times, outputs). Raises `RunError`."""
        unit = self.unit
        instance = Instance(unit)
        names = self._text.columns
        references, values = [unit.index[n] for n in names], self.rows[member].tolist()
        if unit.model.integrated:
            references, values = [*references, unit.index["integration_tolerance"]], [*values, REFERENCE_TOLERANCE]
        wanted = [unit.index[name] for name in self.observed]
        table = np.empty((len(times), len(wanted)))
        try:
            instance.set_values(references, values)
            instance.set_up(0.0, None)
            instance.enter_initialization()
            instance.exit_initialization()
            now = 0.0
            for row, time in zip(table, times.tolist()):
                if time > now:
                    instance.do_step(now, time - now)
                    now = instance.time
                row[:] = instance.get_values(wanted)
        except (CallError, StepError) as error:
            raise RunError(f"member {member} fails in the FMU path: {error}") from error
        return table


def measures(
    scene: Scene,
    names: Sequence[str],
    values: ArrayLike,
    samples: int = 3,
    seed: int = 0,
    threads: int | None = None,
) -> tuple[dict[str, Array], Members]:
    """Columns of a sweep's table (`sweeps.row`) for members with ``values``, shape (members, names), and the members.

    The columns: ``min:`` and ``max:`` of what the scene records, ``margin:`` and ``worst_margin``, shape (members,).
    Comparisons with a second run, and counts of events, an ensemble does not have. The options are those of
    `Ensemble.run`."""
    table = np.asarray(values, np.float64).reshape(-1, len(names))
    ensemble = Ensemble(scene, dict(zip(names, table.T)))
    members = ensemble.run(samples=samples, seed=seed, threads=threads)
    margins = [name for name in ensemble.observed if name.partition(".")[2].startswith("margin_")]
    shown = scene.checks.report_only
    deciding = [members.low[name] for name in margins if name not in shown and not name.endswith(f".{SMALL}")]
    columns = {"worst_margin": np.min(deciding or [members.low[name] for name in margins], axis=0)} if margins else {}
    columns |= {f"margin:{name}": members.low[name] for name in margins}
    for name in ensemble.observed:
        if name not in margins:
            columns |= {f"min:{name}": members.low[name], f"max:{name}": members.high[name]}
    return columns, members


def _drawn(members: NDArray[np.int64], count: int, seed: int) -> NDArray[np.int64]:
    """``count`` of the members, or all if there are fewer."""
    return np.random.default_rng(seed).permutation(members)[:count]
