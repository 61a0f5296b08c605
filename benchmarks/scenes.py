"""Speed against error of every shipped scene, and its ladder of models: ``python benchmarks/scenes.py [--draw] [SCENE ...]``.

What is measured stands in ``docs/measured/<scene>.json``, committed, and is kept by the code and the scene, so that only what
changed is measured again; a case is written as soon as it is done, so that a run that was stopped goes on. A case is given
`BUDGET` s of processor time for its table of errors, and the rest of its runs are left out and said so. ``docs/scenes`` gets
what `docs/make_scenes.py` puts into the page of the scene. ``--draw`` measures nothing: what is missing or old is said there.
"""

from __future__ import annotations

import datetime
import functools
import hashlib
import json
import math
import os
import sys
import time
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import Any

from page_plot import draw
from run_all import the_machine
from scene_error import BUDGET, Precision, Row, precision

from towage.errors import TowageError
from towage.files import atomic_write
from towage.ladder.report import document, ladder_of, markdown, picture
from towage.ladder.simplest import simplest
from towage.report.format import number, percent
from towage.report.svg import STANDALONE
from towage.scene.scene import Scene, available_scenes
from towage.units.store import sources_digest

DOCS = Path(__file__).resolve().parents[1] / "docs"
NICE = 10
MEASURES = ("towage/master", "towage/ladder", "towage/verify")
"""Folders on whose code the numbers depend, beside the models and units; a change of what only writes or refuses is none."""
PATIENCE = 300.0
"""Without progress of a rung for so long, s, it is given up."""
DIGITS = 4
"""Of numbers that are written."""


def write(name: str, docs: Path, measures: bool = True) -> None:
    """Measures every case of a shipped scene and writes what its page shows; ``measures`` not: out of what was measured."""
    scene, kept = Scene.load(name), docs / "measured" / f"{name}.json"
    known: dict[str, Any] = json.loads(kept.read_text("utf-8")) if kept.is_file() else {}
    found = {}
    for case in [scene.case(case.name) for case in scene.cases] or [scene]:
        key = digest(case)
        if known.get(case.chosen, {}).get("key") != key and measures:
            known[case.chosen] = measured(case) | {"key": key}
            kept.parent.mkdir(parents=True, exist_ok=True)
            with atomic_write(kept) as stream:
                text = json.dumps(known, indent=1, ensure_ascii=False) + "\n"
                stream.write(text.replace(f"{DOCS.parent}/", "").encode())  # reasons name the file of the scene
        found[case.chosen] = known.get(case.chosen, {}) | {"old": known.get(case.chosen, {}).get("key") != key}
    _page(name, found, docs / "scenes")


def digest(case: Scene) -> str:
    """What the numbers of a case depend on: the code that computes them, the units and the scene."""
    scene = {key: value for key, value in case.to_dict().items() if key not in ("title", "description")}
    return hashlib.sha256(json.dumps([*_code(), repr(scene), case.chosen]).encode()).hexdigest()[:32]


@functools.cache
def _code() -> list[str]:
    """As it is at the start, so that a change while this runs is not taken for what was measured: the units, the master, the
    ladder, the reference, and what compares."""
    files = sorted(file for place in MEASURES for file in (DOCS.parent / place).glob("*.py"))
    return [sources_digest(), *(file.read_text("utf-8") for file in (*files, Path(__file__).with_name("scene_error.py")))]


def measured(case: Scene) -> dict[str, Any]:
    """Ladder and errors of a case, or why there are none, with the day, the machine and what it cost."""
    begin = _spent()
    told: dict[str, Any] = {"date": datetime.datetime.now(datetime.UTC).date().isoformat(), "cpu": the_machine()["cpu"]}
    parts = {"ladder": lambda: document(simplest(case, timeout=PATIENCE)), "errors": lambda: asdict(precision(case))}
    for part, measure in parts.items():
        start = _spent()
        try:
            told[part] = _plain(measure())
        except TowageError as error:
            told[part] = {"refused": str(error)}
        told[f"{part}_s"] = round(_spent() - start, 1)
    print(f"{case.title}, {case.chosen}: {_spent() - begin:.0f} s of processor time", file=sys.stderr, flush=True)
    return told


def _spent() -> float:
    """Processor time of this process and its children, s."""
    return sum(os.times()[:4])


def _plain(value: Any) -> Any:
    """As JSON has it: few digits; what is infinite as a text, which `float` reads."""
    if isinstance(value, dict):
        return {key: _plain(one) for key, one in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(one) for one in value]
    if isinstance(value, float):
        return float(f"{value:.{DIGITS}g}") if math.isfinite(value) else str(value)
    return value


def _page(name: str, cases: dict[str, dict[str, Any]], out: Path) -> None:
    """Tables and diagrams of a scene."""
    out.mkdir(parents=True, exist_ok=True)
    ladders, errors, panels = [], [], []
    for k, (case, told) in enumerate(cases.items()):
        head = f"\n### {case}\n" if case else ""
        if told["old"] and "key" not in told:
            missing = f"Not measured: `python benchmarks/scenes.py {name}`."
            told |= {"ladder": {"refused": missing}, "errors": {"refused": missing}}
        ladders.append(f"{head}\n{_ladder(told['ladder'], f'{name}_ladder_{k}', out)}\n")
        text, curves = _errors(told["errors"])
        errors.append(f"{head}\n{text}\n{_when(told)}")
        panels += [(f"{case or name}: {signal}", series) for signal, series in curves.items()]
    if panels:
        draw(panels, out / f"{name}_error.svg")
        errors.append(f"\n![Error over processor time]({name}_error.svg)\n")
    with atomic_write(out / f"{name}.json") as stream:
        stream.write(json.dumps({"ladder": "".join(ladders), "error": "".join(errors)}, indent=1).encode())


def _when(told: dict[str, Any]) -> str:
    """Where and when a case was measured."""
    if "date" not in told:
        return ""
    old = ", with an earlier version" if told["old"] else ""
    return f"\nMeasured {told['date']}, {told['cpu']}{old}; ladder {told['ladder_s']:g} s, errors {told['errors_s']:g} s.\n"


def _ladder(told: dict[str, Any], name: str, out: Path) -> str:
    """Table of the models; the diagram is written."""
    if "refused" in told:
        return f"No ladder: {told['refused']}"
    ladder = ladder_of(told)
    if not (drawn := picture(ladder, "ladder")):
        return markdown(ladder)
    (out / f"{name}.svg").write_text(drawn.replace("<svg ", STANDALONE, 1), encoding="utf-8")
    return f"{markdown(ladder)}\n\n![Error over cost of the models]({name}.svg)"


def _errors(told: dict[str, Any]) -> tuple[str, dict[str, dict[str, list[tuple[float, float]]]]]:
    """Table and curves of schemes and steps."""
    if "refused" in told:
        return f"No errors: {told['refused']}", {}
    rows = tuple(Row(**{**row, "errors": [e if e is None else float(e) for e in row["errors"]]}) for row in told["rows"])
    found = Precision(**{**told, "rows": rows, "own": float(told["own"]), "floor": float(told["floor"])})
    curves: dict[str, dict[str, list[tuple[float, float]]]] = {}
    for row in found.rows:
        points = [(c, e) for c, e in zip(row.costs, row.errors) if c is not None and e is not None and 0.0 < e < math.inf]
        if points and found.own <= CHAOS:
            curves.setdefault(row.signal, {})[row.scheme] = points
    return "\n".join(_table(found)), curves


CHAOS = 0.1
"""rms over standard deviation from which the motion is chaotic, or its reference not resolved."""


def _table(measured: Precision) -> Iterator[str]:
    """Markdown of a case."""
    yield f"Reference: {measured.reference}."
    if not measured.own <= CHAOS:
        yield "The motion is chaotic, or the reference not resolved: the numbers below are no errors of a step."
    ratio, power = (2.0, "order") if measured.fixed else (10.0, "power of the tolerance")
    yield f"\n| scheme | signal | {' | '.join(measured.heads)} | {power} | cost |"
    yield "|---|---|" + "--:|" * (len(measured.heads) + 1) + "---|"
    for row in measured.rows:
        cells = [row.notes[k] if error is None else percent(error, 2) for k, error in enumerate(row.errors)]
        costs = " / ".join("–" if cost is None else number(cost / measured.unit, 2) for cost in row.costs)
        known = row.order(measured.floor, ratio) if measured.own <= CHAOS else None
        yield f"| {row.scheme} | {row.signal} | {' | '.join(cells)} | {'–' if known is None else f'{known:.1f}'} | {costs} |"
    yield (
        f"\nrms of the error over the standard deviation, from {number(measured.settle)} s to {number(measured.stop)} s; cost: "
        f"processor time of stepping over that of the scene as it is ({number(measured.unit, 2)} s)."
    )
    if not measured.fixed:
        yield (
            "Steps follow the error of what is connected. Between two of them a signal is read off a cubic, so that one which "
            "acts on nothing at the time, as the motion on a slack line, does not become better with the tolerance."
        )
    if measured.left_out:
        yield f" {measured.left_out} runs were left out: the {BUDGET:g} s of processor time of the case were used up."


if __name__ == "__main__":
    os.nice(NICE)
    _code()
    started = _spent(), time.perf_counter()
    names = [argument for argument in sys.argv[1:] if argument != "--draw"]
    for scene_name in names or [scene.name for scene in available_scenes()]:
        write(scene_name, DOCS, "--draw" not in sys.argv)
    spent, lasted = _spent() - started[0], time.perf_counter() - started[1]
    print(f"all scenes: {spent:.0f} s of processor time, {lasted:.0f} s", file=sys.stderr)
