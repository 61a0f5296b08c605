"""The points of a sweep as members of one ensemble: thousands a second in compiled code, for scenes that compose.

    from towage.sweeps.sweep import sweep

    table = sweep("slack", "ship.heave_amplitude=2 ft:6 ft:10001", engine="ensemble")

The table has the columns of `row` that an ensemble can give: extremes and margins. It has no comparison with a second
run, and so no SDOF verdict; no counts of events, attractors or estimates of the coupling error. Differences from runs of
the master are its coupling error; what it refuses for its step alone is not refused here.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from towage.checks.margins import item_of
from towage.checks.tow_names import LINEAR, SMALL
from towage.checks.verdict import verdict
from towage.ensemble.ensemble import Members, measures
from towage.errors import SceneError
from towage.fmus.declare.unit import BuildError
from towage.result.result import Margin
from towage.scene.scene import Scene
from towage.sweeps.design import Array, Design
from towage.sweeps.table import Table

_MARGIN = "margin:"


def by_ensemble(
    scene: Scene,
    design: Design,
    units: Mapping[str, str],
    sample: int,
    seed: int = 0,
    threads: int | None = None,
) -> Table:
    """The table of a scene without cases over a design; ``units`` of the recorded variables, as `Sweep.measures` has them.

    ``sample`` points, drawn with ``seed``, are computed again by the FMU path (`towage.ensemble.ensemble`).
    Raises `RunError` with the point that differs most if one does, `SceneError` where the scene or what is varied does
    not compose, or nothing can be compiled.
    """
    if foreign := next((target for target in design.targets if target.partition(".")[0] not in scene.units), None):
        raise SceneError(
            f"{foreign} is of the master, which an ensemble does without: vary parameters of units, or take --engine runs",
            file=scene.file, key="--vary",
        )  # fmt: skip
    try:
        columns, members = measures(scene, design.targets, design.points, sample, seed, threads)
    except BuildError as error:
        raise SceneError(f"{error}; or take --engine runs", file=scene.file, key="--engine ensemble") from error
    status = tuple(
        "done" if done else "refused" if refused else "failed" for done, refused in zip(members.done, members.refused)
    )
    words, reasons = zip(*(_judged(scene, columns, members, k) for k in range(len(design.points))))
    return Table.from_columns(scene.title, design, (status, words, reasons), columns, units, _note(scene, members))


def _judged(scene: Scene, columns: Mapping[str, Array], members: Members, k: int) -> tuple[str, str]:
    """(verdict, reason) of a member. One that passes its margins is not valid if a check that the scene asks for was not
    made. The rough sign of a linear tow decides nothing."""
    if members.message[k]:
        return "not judged", members.message[k]
    margins = [
        Margin(name, float(values[k]), np.nan, name not in scene.checks.report_only and not name.endswith(f".{SMALL}"))
        for name, values in ((name.removeprefix(_MARGIN), v) for name, v in columns.items() if name.startswith(_MARGIN))
    ]
    judged = verdict([item_of(margins)])
    if judged.word == "invalid":
        return judged.word, f"{min((m for m in margins if m.decides), key=lambda m: m.worst).variable} is negative"
    if left := _left_out(scene):
        return "not judged", f"no margin that decides is negative; left out: the {left}"
    return judged.word, judged.reason


def _left_out(scene: Scene) -> str:
    """The checks that the scene asks for or its tows need, none of which an ensemble makes; empty without any."""
    known = {"sdof": "SDOF comparison", "simpler": "comparison with the simpler model"}
    asked = scene.checks.sections
    names = [*(name for name in known if name in asked), *(name for name in asked if name not in known)]
    asking = [known.get(name, f"check {name}") for name in names]
    if any(Path(unit.fmu).stem in LINEAR for unit in scene.units.values()):
        asking.append("error of the linear tow, of which its margin is a rough sign")
    return " and the ".join(asking)


def _note(scene: Scene, members: Members) -> str:
    """How the table was made, and what it does not have."""
    worst = max((s.difference for s in members.samples), default=0.0)
    made = (
        f"Computed as one ensemble; {len(members.samples)} of its members, drawn at random, were computed again by the FMU "
        f"path and differ by at most {worst:.1e} of a variable's largest value."
    )
    left = _left_out(scene)
    absent = f" The {left}: left out, as more than one computation of every point is needed (--engine runs)." if left else ""
    rest = "The check wire (mass of a line), counts of events, attractors and coupling errors: left out too (--engine runs)."
    return f"{made}{absent} {rest}"
