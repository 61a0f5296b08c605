"""The tables of docs/hosts.md: ``python -m tests.hosts.table [SCENE, UNIT or HOST ...]`` runs every shipped scene and unit in
every host that is here, keeps what it found in docs/hosts.json and writes the tables. Names choose among them, and what was found
of the others stays.

``--page`` writes the tables from what is kept. `tests.hosts.jobs` says where the hosts are looked for.
"""

from __future__ import annotations

import csv
import io
import json
import os
import platform
import re
import signal
import subprocess
import sys
import tempfile
import time
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple
from xml.etree import ElementTree

import numpy as np

from tests.hosts.jobs import HOSTS, Host, HostError, Job, Series, alone, difference, one_job, ours, short, system_job
from towage.fmus import UNITS
from towage.fmus.declare.unit import load
from towage.fmus.native.build import build
from towage.fmus.python.build import build as build_python
from towage.scene.scene import available_scenes
from towage.units.archive import read_description

DOCS = Path(__file__).parents[2] / "docs"
KEPT, PAGE = DOCS / "hosts.json", DOCS / "hosts.md"
STEPS = 100
"""Steps of a scene's own length in every host."""
BUILD_LIMIT = 300
"""Seconds for a scene as one FMU. Most take some ten; the compiler takes very long over the functions of the largest."""
Cell = dict[str, Any]
Kept = dict[str, Any]


class Tried(NamedTuple):
    """The chosen hosts, why they are missing or "", and the versions that they tell when they run."""

    missing: dict[str, str]
    versions: dict[str, str]

    def of(self, takes: str) -> list[Host]:
        """The chosen hosts that take systems, or units."""
        return [host for host in HOSTS if host.takes == takes and host.name in self.missing]


def scene_cells(name: str, tried: Tried) -> Iterator[tuple[str, Cell]]:
    """(host, what it found) of a shipped scene: as a system, against our `jacobi`; as one FMU, against that FMU in towage."""
    scene = short(name, STEPS)
    with tempfile.TemporaryDirectory() as directory:
        result = ours(scene, "jacobi", "native")
        job = system_job(scene, "native", Path(directory), "osp", result)
        expected = {f"{unit}.{name}": result[f"{unit}.{name}"][1:] for unit, name, _ in job["watch"]}
        needed = any(host.first_order and not tried.missing[host.name] for host in tried.of("system"))
        exact = ours(scene, scene.coupling.scheme, "native") if needed else result
        converged = {signal: exact[signal][1:] for signal in expected}
        for host in tried.of("system"):
            yield host.name, cell(host, job, converged if host.first_order else expected, tried)
        if not tried.of("unit"):
            return
        fmu = Path(directory) / f"{name}.fmu"
        if why := whole(name, fmu.parent):
            yield from ((host.name, {"reason": why}) for host in tried.of("unit"))
            return
        watch, single = alone(fmu, scene.coupling.step or 0.0, STEPS)
        job = one_job(fmu, Path(directory), scene.coupling.step or 0.0, STEPS, watch, {}, "")
        expected = {signal: single[f"it.{signal}"] for signal in watch}
        for host in tried.of("unit"):
            yield host.name, cell(host, job, expected, tried)


def whole(name: str, directory: Path) -> str:
    """Builds a scene as one FMU; why there is none, or nothing."""
    command = [sys.executable, "build_fmus.py", "--scene", name, "--out", str(directory)]
    with subprocess.Popen(command, cwd=DOCS.parent, stderr=subprocess.PIPE, text=True, start_new_session=True) as build:
        try:
            said = build.communicate(timeout=BUILD_LIMIT)[1]
        except subprocess.TimeoutExpired:
            os.killpg(build.pid, signal.SIGKILL)  # the compiler too
            return f"is not one FMU: not compiled within {BUILD_LIMIT} s"
    lines = [line for line in said.splitlines() if line.startswith("[1/1]")] or ["no message"]
    return f"is not one FMU: {lines[-1].rpartition('cannot be composed: ')[2]}" if build.returncode else ""


def unit_cells(name: str, tried: Tried) -> Iterator[tuple[str, Cell]]:
    """(host and FMI version, what it found) of a unit's reference run, against the reference result that the FMU carries."""
    native = not load(name).not_native
    with tempfile.TemporaryDirectory() as text:
        directory = Path(text)
        for fmi in (2, 3):
            if fmi == 3 and not native:
                yield from ((f"{host.name}, FMI 3", {"reason": "no native flavour"}) for host in tried.of("unit"))
                continue
            place = directory / str(fmi)
            path, _ = build(name, place, fmi) if native else build_python(name, place)
            try:
                start, inputs, step, expected = reference_run(path, name)
            except KeyError:
                none = {"reason": "carries no reference run"}
                yield from ((f"{host.name}, FMI {fmi}", none) for host in tried.of("unit"))
                continue
            # which states are left out is measured by one flavour and estimated by the other: so is this margin
            estimates = {"tolerance", "reduced"} <= set(read_description(path).by_name())
            watch = [each for each in expected if not (estimates and each == "margin_resolution")]
            for host in tried.of("unit"):
                column = f"{host.name}, FMI {fmi}"
                if host.variable and not native:
                    yield column, {"reason": "a C program finds no Python in its process"}
                    continue
                job = one_job(path, place, step, len(expected[watch[0]]) - 1, watch, start, inputs)
                yield column, cell(host, job, expected, tried)


def reference_run(fmu: Path, name: str) -> tuple[dict[str, float], str, float, Series]:
    """(start values, inputs as CSV, step, outputs) of the reference run that an FMU carries."""
    with zipfile.ZipFile(fmu) as archive:
        start, inputs, options, outputs = (
            archive.read(f"documentation/{name}_{end}").decode()
            for end in ("start.ssv", "in.csv", "ref.opt", "ref.csv")
        )
    given = (p for p in ElementTree.fromstring(start).iter() if p.tag.endswith("}Parameter"))
    values = {p.attrib["name"]: float(p[0].attrib["value"]) for p in given}
    rows = list(csv.DictReader(io.StringIO(outputs)))
    columns = {key: np.array([float(row[key]) for row in rows]) for key in rows[0] if key != "time"}
    step = float(re.search(r"StepSize, (\S+)", options)[1])  # type: ignore[index]
    return values, inputs if len(inputs.splitlines()[0].split(",")) > 1 else "", step, columns


def cell(host: Host, job: Job, expected: Series, tried: Tried) -> Cell:
    """What one host makes of one job: the largest difference, or why there is none."""
    if tried.missing[host.name]:
        return {"reason": tried.missing[host.name]}
    begin = time.perf_counter()
    try:
        tried.versions[host.name], theirs = host.run(job)
        if host.own_order:
            theirs = {name: values for name, values in theirs.items() if name not in job["direct"]}
        if not theirs:
            return {"reason": "every output follows its inputs without delay, and is read at another point"}
        share, variable = difference(theirs, expected)
    except (HostError, AssertionError, OSError) as error:
        return {"reason": reason(error)}
    print(f"    {host.name}: {share:.1e} {variable} ({time.perf_counter() - begin:.0f} s)", file=sys.stderr, flush=True)
    return {"difference": share, "variable": variable}


def reason(error: Exception) -> str:
    """The last line of a message, without the names of temporary folders."""
    text = re.sub(rf"{re.escape(tempfile.gettempdir())}/[^\s:]*/", "", str(error).strip().splitlines()[-1])
    return text[:200].rstrip(".")


def table(rows: dict[str, dict[str, Cell]], first: str, notes: list[str]) -> list[str]:
    """A Markdown table of cells; reasons become numbered ``notes``."""
    found = {column for cells in rows.values() for column in cells}
    columns = [
        column
        for host in HOSTS
        for column in (host.name, f"{host.name}, FMI 2", f"{host.name}, FMI 3")
        if column in found
    ]
    lines = [f"| {first} | {' | '.join(columns)} |", "|---" * (len(columns) + 1) + "|"]
    for name, cells in rows.items():
        texts = [shown(cells.get(column, {}), notes) for column in columns]
        lines.append(f"| `{name}` | {' | '.join(texts)} |")
    return lines


def shown(found: Cell, notes: list[str]) -> str:
    """A difference, or the number of the reason why there is none."""
    if "difference" in found:
        return f"{found['difference']:.0e}" if found["difference"] else "0"
    text = found.get("reason", "not tried")
    if text not in notes:
        notes.append(text)
    return f"({notes.index(text) + 1})"


def page(kept: Kept) -> str:
    """The part of docs/hosts.md between its two marks."""
    notes: list[str] = []
    hosts = ", ".join(f"{name} {entry['version'] or entry['reason']}" for name, entry in kept["hosts"].items())
    lines = [f"Hosts: {hosts}. {kept['system']}, {kept['date']}.", "", *table(kept["scenes"], "scene", notes), ""]
    lines += [*table(kept["units"], "unit", notes), ""]
    return "\n".join([*lines, *(f"{k}. {text}." for k, text in enumerate(notes, 1))])


def put(text: str, path: Path) -> None:
    """The tables into the page."""
    before, begin, rest = path.read_text("utf-8").partition("<!-- made by tests/hosts/table.py -->\n")
    _, end, after = rest.partition("\n<!-- end -->")
    assert begin and end, f"{path} has lost its marks"
    path.write_text(before + begin + text + end + after, encoding="utf-8")


def main(chosen: list[str]) -> int:
    """Runs what is chosen, keeping what was found of the rest."""
    kept: Kept = json.loads(KEPT.read_text("utf-8")) if KEPT.is_file() else {"hosts": {}, "scenes": {}, "units": {}}
    if chosen != ["--page"]:
        hosts = [host for host in HOSTS if host.name in chosen] or list(HOSTS)
        tried = Tried({host.name: host.missing() for host in hosts}, {})
        names = {"scenes": [scene.name for scene in available_scenes()], "units": list(UNITS)}
        some = [name for name in chosen if name not in tried.missing]
        for kind, cells in (("scenes", scene_cells), ("units", unit_cells)):
            for name in names[kind]:
                if not some or name in some:
                    print(name, file=sys.stderr, flush=True)
                    keep(kept, kind, names[kind], name, dict(cells(name, tried)), tried)
    put(page(kept), PAGE)
    return 0


def keep(kept: Kept, kind: str, order: list[str], name: str, cells: dict[str, Cell], tried: Tried) -> None:
    """What was found of one scene or unit, in the file at once: the next one may take long."""
    kept[kind][name] = kept[kind].get(name, {}) | cells
    kept[kind] = {each: kept[kind][each] for each in order if each in kept[kind]}
    for host, missing in tried.missing.items():
        kept["hosts"][host] = {"version": tried.versions.get(host), "reason": missing or None}
    kept["hosts"] = {host.name: kept["hosts"][host.name] for host in HOSTS if host.name in kept["hosts"]}
    kept |= {"date": time.strftime("%Y-%m-%d"), "system": f"{platform.system()} {platform.machine()}"}
    KEPT.write_text(json.dumps(kept, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
