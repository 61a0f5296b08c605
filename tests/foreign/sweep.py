"""Every FMU of a folder, alone, in the master with its default settings and in fmpy with equal steps:
``python -m tests.foreign.sweep FOLDER [--only WORD] [--json FILE]`` prints tables in Markdown.

The folder holds a folder for each place that FMUs are from; nothing is fetched. Files of one content count once. Each run has a
process, a folder and a time limit of its own, because a foreign unit may end its process, write files, or never return.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import signal
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

from towage.errors import TowageError
from towage.units.archive import check_platform, read_description
from towage.units.description import Description

STEPS, MOST = 100, 5000
"""Steps of a unit whose default experiment names none, and the most of any."""
STOP = 5.0
"""Of a unit whose default experiment names none, s."""
LIMIT = {"towage": 240.0, "fmpy": 60.0}
"""Seconds of a run; the master's has a second run for the coupling error in it, and repeated steps."""
SAME_TIME = 1e-9
ENDLESS = "not done within"
WORDS = ("equal to the bit", "equal to its tolerance", "differs", "nothing to compare", "refused", "stopped")
"""What comes of a unit. Its tolerance: that of its default experiment, relative to the largest value of an output."""
Run = tuple[np.ndarray, dict[str, np.ndarray]]


def experiment(description: Description) -> tuple[float, float]:
    """(stop, step), s, of the run: the unit's default experiment, cut to `MOST` steps."""
    told = description.default_experiment
    stop = told.stop_time or STOP
    step = min(told.step_size or stop / STEPS, stop)
    return step * max(1, round(min(stop / step, MOST))), step


def in_towage(path: Path, stop: float, step: float) -> tuple[Run, str]:
    """(outputs, why the run stopped or "") in the master, as a scene of one unit."""
    from towage.process.worker import run_isolated
    from towage.scene.flavour import resolve
    from towage.scene.scene import Scene

    units = {"a": {"fmu": str(path)}}
    scene = {"title": path.stem, "stop_time": stop, "units": units, "connections": [], "coupling": {"step": step}}
    result = run_isolated(resolve(Scene.from_dict(scene)))
    columns = {name.removeprefix("a."): np.asarray(values) for name, values in result.columns.items()}
    return (result.time, columns), "" if result.status == "done" else result.message


def in_fmpy(path: Path, stop: float, step: float) -> tuple[Run, str]:
    """The same in fmpy."""
    from fmpy import read_model_description, simulate_fmu

    description = read_model_description(str(path), validate=False)
    outputs = [v.name for v in description.modelVariables if v.causality == "output"]
    rows = simulate_fmu(
        str(path), start_time=0.0, stop_time=stop, step_size=step, output_interval=step, fmi_type="CoSimulation",
        output=outputs, validate=False, model_description=description, logger=lambda *_: None,
    )  # fmt: skip
    columns: dict[str, np.ndarray] = {}
    for name in rows.dtype.names[1:]:
        values = np.asarray(rows[name])
        for place in np.ndindex(*values.shape[1:]):
            index = f"[{','.join(str(k + 1) for k in place)}]" if place else ""
            columns[name + index] = values[(slice(None), *place)]
    return (np.asarray(rows["time"]), columns), ""


def one(host: str, path: Path, stop: float, step: float, out: Path) -> None:
    """The child: one run, its numbers to ``out``."""
    (time, columns), why = {"towage": in_towage, "fmpy": in_fmpy}[host](path, stop, step)
    numbers = {name: values.astype(float) for name, values in columns.items() if values.dtype.kind in "biuf"}
    np.savez(out, time=time, names=np.array([*numbers], dtype=str), values=np.array([*numbers.values()]), why=np.array(why))


def apart(host: str, path: Path, stop: float, step: float) -> tuple[Run | None, str]:
    """(outputs or None, why there are none, or no more) of a run in a process of its own."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder, "out.npz")
        command = [sys.executable, __file__, "--one", host, str(path), repr(stop), repr(step), str(out)]
        here = os.pathsep.join([str(Path(__file__).parents[2]), os.environ.get("PYTHONPATH", "")])
        environment = os.environ | {"PYTHONPATH": here}
        with subprocess.Popen(
            command, cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, env=environment, start_new_session=True
        ) as child:
            try:
                said = child.communicate(timeout=LIMIT[host])[1]
            except subprocess.TimeoutExpired:
                os.killpg(child.pid, signal.SIGKILL)  # what it started too
                return None, f"{ENDLESS} {LIMIT[host]:g} s"
        if not out.is_file():
            lines = said.decode(errors="replace").strip().splitlines()
            return None, lines[-1] if lines else f"ended with {child.returncode}"
        with np.load(out) as kept:
            columns = dict(zip(kept["names"].tolist(), kept["values"]))
            return (kept["time"], columns), str(kept["why"])


def gap(ours: Run, theirs: Run) -> tuple[float, str, int, int]:
    """(largest difference over the largest value of its output, that output, common times, common outputs); of several rows at
    one time the last counts."""
    worst, which = 0.0, ""
    mine, yours = (dict(zip(np.round(time / SAME_TIME).tolist(), range(len(time)))) for time in (ours[0], theirs[0]))
    times = [t for t in mine if t in yours]
    names = [name for name in ours[1] if name in theirs[1]]
    for name in names:
        a, b = ours[1][name][[mine[t] for t in times]], theirs[1][name][[yours[t] for t in times]]
        known = np.isfinite(a) | np.isfinite(b)  # where both are no number they are equal
        size = float(np.max(np.abs(b[known]), initial=0.0))
        share = float(np.max(np.abs(a - b)[known], initial=0.0)) / (size or 1.0)
        if not share <= worst:
            worst, which = share, name
        if share != share:  # nothing is worse than no number
            break
    return worst, which, len(times), len(names)


def tried(path: Path) -> dict[str, Any]:
    """What comes of one FMU: its word, the reason, the gap where there is one."""
    try:
        description = read_description(path)
        check_platform(description)
    except TowageError as error:
        return {"word": "refused", "why": str(error), "fmpy": "not tried"}
    about: dict[str, Any] = {"fmi": description.fmi_version, "tool": description.generation_tool}
    (ours, why), (theirs, whyever) = (apart(host, path, *experiment(description)) for host in ("towage", "fmpy"))
    about |= {"why": why, "fmpy": whyever or "runs"}
    if ours is None:
        return about | {"word": "stopped" if why.startswith(ENDLESS) else "refused"}
    if theirs is None:
        return about | {"word": "stopped" if why else "nothing to compare", "why": why or "runs, which fmpy does not do"}
    share, _, times, names = about["gap"] = gap(ours, theirs)
    wanted = len(set(theirs[0]))
    if why:
        return about | {"word": "stopped"}
    if times < wanted or not names:
        return about | {"word": "nothing to compare", "why": f"{times} of {wanted} times, {names} outputs that are numbers"}
    tolerance = description.default_experiment.tolerance or 0.0
    return about | {"word": WORDS[0] if share == 0.0 else WORDS[1] if share <= tolerance else WORDS[2]}


def tables(found: dict[str, dict[str, Any]], folder: Path) -> str:
    """A table of places, and one of what was not equal to the bit, with reasons."""
    places = sorted({name.split("/")[0] for name in found})
    lines = [f"| from | FMUs | {' | '.join(WORDS)} |", "|---" * (len(WORDS) + 2) + "|"]
    for place in [*places, "all"]:
        words = Counter(each["word"] for name, each in found.items() if place in ("all", name.split("/")[0]))
        lines.append(f"| {place} | {words.total()} | {' | '.join(str(words[word]) for word in WORDS)} |")
    lines += ["", "| FMU | what came of it | fmpy |", "|---|---|---|"]
    for name, each in found.items():
        if each["word"] != WORDS[0] or each["why"]:
            shown = f"{each['gap'][1]} by {each['gap'][0]:.1e}" if each["word"] in WORDS[1:3] and "gap" in each else each["why"]
            told = " ".join(shown.replace(str(folder) + os.sep, "").replace("|", "/").split())
            lines.append(f"| {name} | {each['word']}: {told} | {' '.join(each['fmpy'].split())[:120]} |")
    return "\n".join(lines)


def main(arguments: list[str]) -> int:
    """Try them and print."""
    if arguments[:1] == ["--one"]:
        host, path, stop, step, out = arguments[1:]
        one(host, Path(path), float(stop), float(step), Path(out))
        return 0
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--only", default="", help="FMUs with this in their path")
    parser.add_argument("--json", type=Path, help="what was found, written after each FMU")
    given = parser.parse_args(arguments)
    folder = given.folder.resolve()
    seen: set[str] = set()
    found: dict[str, dict[str, Any]] = {}
    for path in sorted(folder.rglob("*.fmu")):
        digest = hashlib.sha256(path.read_bytes()).hexdigest() if path.is_file() else ""
        name = path.relative_to(folder).as_posix()
        if given.only in name and digest not in seen:
            seen.add(digest)
            found[name] = tried(path)
            print(f"{name}: {found[name]['word']}", file=sys.stderr, flush=True)
            if given.json:
                given.json.write_text(json.dumps(found, indent=1))
    print(tables(found, folder))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
