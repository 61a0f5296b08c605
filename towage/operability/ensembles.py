"""The runs of a study as members of one ensemble, in batches on several threads: extremes after the transient, one row a run."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait

import numpy as np
from numpy.typing import NDArray

from towage.ensemble.ensemble import Ensemble, Members
from towage.errors import SceneError
from towage.fmus.declare.unit import BuildError
from towage.operability.cells import SEA, Cells
from towage.scene.scene import Scene
from towage.sweeps.row import Row
from towage.sweeps.workers import LOOK

Array = NDArray[np.float64]
ACCURACY = 1e-6
"""Relative error of a step: a thousandth of what differs from seed to seed costs nothing, as outputs are wanted often."""
BATCH = 32
"""Runs that a thread does before it reports; a study that is interrupted waits for them."""
POINTS = 40
"""Outputs in the shortest peak period, where the scene says no interval: between two of them a peak of that period is missed by
at most 1 - cos(pi/40) = 0.3 % of its amplitude."""
SAMPLE, SAMPLED = 3, 60.0
"""Runs computed again by the FMU path, from the start for so long, s."""
SAMPLE_TOLERANCE = 1e-4
"""Of a variable's largest value: a hundred steps of `ACCURACY` each."""
SAME = 1e-9
"""Relative difference of a motion from that in the mirrored sea, where both are one: phases are rounded differently."""


def interval(scene: Scene, cells: Cells) -> float:
    """Time between outputs, s: as the scene says, else `POINTS` in the shortest peak period."""
    given = scene.record.interval or scene.coupling.step
    return given or float(cells.peaks.min()) / POINTS


def times_of(length: float, transient: float, step: float) -> Array:
    """From the end of the transient on over the length, s."""
    count = max(1, math.ceil(length / step - 1e-9))
    return transient + np.linspace(0.0, length, count + 1)


def ensemble_of(scene: Scene, cells: Cells, names: Sequence[str]) -> Ensemble:
    """All runs, of which ``names`` and the margins of all units are observed. Raises `SceneError` where the scene does not
    compose or nothing can be compiled."""
    design = cells.design()
    varied = dict(zip(design.targets, design.points.T))
    try:
        from towage.ensemble.rows import composed

        margins = [
            v.name for v in composed(scene).observed
            if v.causality == "output" and v.name.partition(".")[2].startswith("margin_")
        ]  # fmt: skip
        return Ensemble(scene, varied, list(dict.fromkeys([*names, *margins])))
    except BuildError as error:
        raise SceneError(f"{error}; or take --engine runs", file=scene.file, key="--engine") from error


def mirrored(ensemble: Ensemble, cells: Cells) -> bool:
    """Whether seas from port and from starboard do the same: motions of one height in all periods, one seed each, from every
    heading and from its mirror, are compared over `SAMPLED` s. Long-crested waves on a ship with a plane of symmetry that
    holds the point do; with spreading, phases differ and only statistics agree."""
    height = float(np.median(cells.scatter.heights))
    angles = np.array(cells.headings.angles)
    pairs = np.stack([angles, 2.0 * math.pi - angles], axis=1).ravel()
    sea = np.array([(height, peak, angle, float(cells.first)) for angle in pairs for peak in cells.peaks])
    names = [f"{cells.unit}.{name}" for name in (*SEA, "seed")]
    both = Ensemble(ensemble.scene, dict(zip(names, sea.T)), ensemble.observed)  # type: ignore[arg-type]
    found = both.run(np.arange(0.0, SAMPLED, 0.5), accuracy=ACCURACY, samples=0)
    for values in (*found.low.values(), *found.high.values()):
        one, other = values.reshape(len(angles), 2, -1).transpose(1, 0, 2)
        if not np.allclose(one, other, rtol=SAME, atol=SAME * float(np.abs(one).max()), equal_nan=True):
            return False
    return True


def rows(
    ensemble: Ensemble, todo: Sequence[int], times: Array, workers: int, accuracy: float = ACCURACY
) -> Iterator[list[Row] | None]:
    """Rows of the runs ``todo``, a batch at a time as they end; None every `LOOK` seconds without one. Closing the iterator waits
    for the batches under way."""
    left = iter([list(todo[k : k + BATCH]) for k in range(0, len(todo), BATCH)])
    given: dict[Future[Members], list[int]] = {}
    with ThreadPoolExecutor(workers) as pool:

        def hand_out() -> None:
            """One more batch, if there is one."""
            if batch := next(left, None):
                part = ensemble.part(batch)
                given[pool.submit(part.run, times, accuracy=accuracy, samples=0, threads=1)] = batch

        for _ in range(workers):
            hand_out()
        while given:
            done, _ = wait(given, LOOK, FIRST_COMPLETED)
            if not done:
                yield None
            for future in done:
                batch = given.pop(future)
                hand_out()
                yield [_row(future.result(), k, index) for k, index in enumerate(batch)]


def _row(members: Members, k: int, index: int) -> Row:
    """The row of member ``k``, run ``index`` of the study."""
    if said := members.message[k]:
        return Row(index, "refused" if members.refused[k] else "failed", message=said)
    measures = {}
    for name, low in members.low.items():
        if name.partition(".")[2].startswith("margin_"):
            measures[f"margin:{name}"] = float(low[k])
        else:
            measures |= {f"min:{name}": float(low[k]), f"max:{name}": float(members.high[name][k])}
    return Row(index, "done", measures=measures)


def checked(ensemble: Ensemble, step: float, seed: int = 0) -> float:
    """The largest difference of `SAMPLE` runs, drawn with ``seed``, from the FMU path over `SAMPLED` s, of a variable's largest
    value. Raises `RunError` where it is above `SAMPLE_TOLERANCE`."""
    drawn = np.random.default_rng(seed).permutation(len(ensemble))[:SAMPLE]
    short = ensemble.part(drawn).run(
        np.arange(0.0, SAMPLED, step), accuracy=ACCURACY, samples=SAMPLE, tolerance=SAMPLE_TOLERANCE
    )
    return max((s.difference for s in short.samples), default=0.0)
