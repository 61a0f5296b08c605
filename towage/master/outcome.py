"""What a run leaves behind as a result: one that is begun, one that failed, one that is made of a journal."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from towage.master.recorder import record_of, texts_at
from towage.master.system import System
from towage.result.journal import Kept
from towage.result.records import Finding, Verdict
from towage.result.result import Result
from towage.scene.provenance import provenance
from towage.scene.resolve import ResolvedScene

Columns = dict[str, NDArray[np.float64]]


def salvaged(resolved: ResolvedScene, kept: Kept | None, message: str) -> Result:
    """A failed result with what is in the journal of a run that ended with its process."""
    if kept:
        return recovered(kept, message)
    result = begun(resolved, resolved.scene.coupling.scheme, [])
    fail(result, message)
    keep(result, resolved, {})
    return result


def recovered(kept: Kept, message: str) -> Result:
    """A failed result with what is in a journal, of which no more is known than it says. Raises `TowageError` where it
    does not say what a result needs."""
    result = Result.from_metadata(kept.about)
    lost = f"; the last {kept.lost} bytes of its journal are no whole rows" if kept.lost else ""
    fail(result, message + lost)
    result.time, columns = record_of(kept)
    result.columns = {name: columns[name] for name in result.units if name in columns}
    result.events, result.messages = kept.events, kept.messages
    result.texts = texts_at(kept.texts, result.time)
    return result


def begun(resolved: ResolvedScene, scheme: str, findings: list[Finding]) -> Result:
    """A result of which nothing is recorded yet."""
    scene = resolved.scene
    return Result(
        title=scene.title,
        case=scene.chosen,
        scheme=scheme,
        status="done",
        message="",
        time=np.empty(0),
        columns={},
        units={},
        checks=findings,
        scene_source=scene.source,
        provenance=provenance(resolved),
        flavours={name: unit.flavour for name, unit in resolved.units.items()},
    )


def fail(result: Result, message: str) -> None:
    """Make it that of a failed run."""
    result.status, result.message = "failed", message
    result.verdict = Verdict("not judged", "the run failed", None, None)


def keep(result: Result, resolved: ResolvedScene, columns: Columns) -> None:
    """Those columns that the scene records, as far as they are known, with their units of measure."""
    variables = {name: unit.description.by_name() for name, unit in resolved.units.items()}
    for unit, name in resolved.record:
        column = f"{unit}.{name}"
        result.units[column] = variables[unit][name].unit or ""
        if column in columns:
            result.columns[column] = columns[column]


def meddled(system: System) -> list[Finding]:
    """A warning for every unit that changed what it shares with the others, which was set back after each call."""
    return [
        Finding("process", "warning", None, None,
                f"{unit.name} changed {', '.join(what)}: set back after each of its calls",
                "ask the supplier of the unit: another master may compute wrong numbers in silence")
        for unit in system.units if (what := unit.instance.meddled)
    ]  # fmt: skip
