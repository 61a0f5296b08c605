"""Speed against error of every shipped scene, and its ladder of models: ``python benchmarks/scenes.py [SCENE ...]``.

Writes ``docs/scenes/<scene>.json``, which `docs/make_scenes.py` puts into the page of the scene, and its diagrams. What was
measured is kept in the cache by the code and the scene, so that only what changed is measured again; a case is given
`BUDGET` s of processor time for its table of errors, and the rest of its runs are left out and said so.
"""

from __future__ import annotations

import hashlib
import json
import math
import os
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from page_plot import draw
from scene_error import BUDGET, Precision, precision

from towage.errors import TowageError
from towage.files import atomic_write
from towage.ladder.report import markdown, picture
from towage.ladder.simplest import simplest
from towage.report.format import number, percent
from towage.scene.scene import Scene, available_scenes
from towage.units.sources import code_digest
from towage.units.store import cache, sources_digest

OUT = Path(__file__).resolve().parents[1] / "docs" / "scenes"
SVG = '<svg xmlns="http://www.w3.org/2000/svg" style="font-family:sans-serif;background:#fff" '
NICE = 10


def write(name: str, out: Path) -> None:
    """Measures every case of a shipped scene and writes what its page shows."""
    scene = Scene.load(name)
    out.mkdir(parents=True, exist_ok=True)
    ladders, errors, panels = [], [], []
    for k, case in enumerate([scene.case(case.name) for case in scene.cases] or [scene]):
        begin = time.process_time()
        found = _kept(case)
        print(f"{name} {case.chosen}: {time.process_time() - begin:.0f} s here", file=sys.stderr, flush=True)
        head = f"\n### {case.chosen}\n" if case.chosen else ""
        ladders.append(f"{head}\n{found['ladder']}\n")
        if found["picture"]:
            (out / f"{name}_ladder_{k}.svg").write_text(found["picture"].replace("<svg ", SVG, 1), encoding="utf-8")
            ladders.append(f"\n![Error over cost of the models]({name}_ladder_{k}.svg)\n")
        errors.append(f"{head}\n{found['errors']}\n")
        panels += [(f"{case.chosen or name}: {signal}", series) for signal, series in found["curves"].items() if series]
    if panels:
        draw(panels, out / f"{name}_error.svg")
        errors.append(f"\n![Error over processor time]({name}_error.svg)\n")
    with atomic_write(out / f"{name}.json") as stream:
        stream.write(json.dumps({"ladder": "".join(ladders), "error": "".join(errors)}, indent=1).encode())


def _kept(case: Scene) -> dict[str, Any]:
    """What was measured of a case, from the cache if it is there."""
    here = [Path(__file__).with_name(name).read_text("utf-8") for name in ("scenes.py", "scene_error.py")]
    what = [code_digest("towage.ladder.simplest"), code_digest("towage.ladder.report"), sources_digest(), *here]
    key = hashlib.sha256(json.dumps([*what, repr(case.to_dict()), case.chosen]).encode()).hexdigest()[:32]
    path = cache() / "scenes" / f"{key}.json"
    if path.is_file():
        found: dict[str, Any] = json.loads(path.read_text("utf-8"))
        return found
    found = {**_ladder(case), **_errors(case)}
    path.parent.mkdir(parents=True, exist_ok=True)
    with atomic_write(path) as stream:
        stream.write(json.dumps(found).encode())
    return found


def _ladder(case: Scene) -> dict[str, str]:
    """Table and diagram of the models."""
    try:
        ladder = simplest(case)
    except TowageError as error:
        return {"ladder": f"No ladder: {error}", "picture": ""}
    return {"ladder": markdown(ladder), "picture": picture(ladder, "ladder")}


def _errors(case: Scene) -> dict[str, Any]:
    """Table and curves of schemes and steps."""
    try:
        measured = precision(case)
    except TowageError as error:
        return {"errors": f"Not measured: {error}", "curves": {}}
    curves: dict[str, dict[str, list[tuple[float, float]]]] = {}
    for row in measured.rows:
        points = [(c, e) for c, e in zip(row.costs, row.errors) if c is not None and e is not None and 0.0 < e < math.inf]
        if points:
            curves.setdefault(row.signal, {})[row.scheme] = points
    return {"errors": "\n".join(_table(measured)), "curves": curves}


def _table(measured: Precision) -> Iterator[str]:
    """Markdown of a case."""
    yield f"Reference: {measured.reference}."
    if not measured.own <= 0.1:
        yield "The motion is chaotic, or the reference not resolved: the numbers below are no errors of a step."
    yield f"\n| scheme | signal | {' | '.join(measured.heads)} | order | cost |"
    yield "|---|---|" + "--:|" * (len(measured.heads) + 1) + "---|"
    for row in measured.rows:
        cells = [row.notes[k] if error is None else percent(error, 2) for k, error in enumerate(row.errors)]
        costs = " / ".join("–" if cost is None else number(cost / measured.unit, 2) for cost in row.costs)
        order = "–" if row.order is None else f"{row.order:.1f}"
        yield f"| {row.scheme} | {row.signal} | {' | '.join(cells)} | {order} | {costs} |"
    yield (
        f"\nrms of the error over the standard deviation, from {number(measured.settle)} s to {number(measured.stop)} s; cost: "
        f"processor time of stepping over that of the scene as it is ({number(measured.unit, 2)} s)."
    )
    if measured.left_out:
        yield f" {measured.left_out} runs were left out: the {BUDGET:g} s of processor time of the case were used up."


if __name__ == "__main__":
    os.nice(NICE)
    started = time.process_time(), time.perf_counter()
    for scene_name in sys.argv[1:] or [scene.name for scene in available_scenes()]:
        write(scene_name, OUT)
    children = os.times()
    spent = time.process_time() - started[0] + children.children_user + children.children_system
    print(f"all scenes: {spent:.0f} s of processor time, {time.perf_counter() - started[1]:.0f} s", file=sys.stderr)
