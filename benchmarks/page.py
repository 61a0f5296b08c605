"""All benchmarks in one run, their page and what changed: ``python benchmarks/page.py [--quick] [--out docs]``.

Writes ``benchmarks.md`` with the machine, versions, tables, diagrams of error over cost and the peers measured in the same
run, and ``benchmarks.json`` with every ratio. A ratio that is more than 1.5 times worse than on the last committed page is
red on the page and on the terminal; the exit code is 1 then, or if a benchmark failed. ``--quick``: a minute, two tables.
"""

from __future__ import annotations

import argparse
import datetime
import json
import os
import platform
import re
import subprocess
import sys
import time
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path
from typing import Any

from page_plot import draw
from page_tables import Column, Curves, Ratio, curves, ratios, tables

ROOT = Path(__file__).resolve().parents[1]
FALLEN = 1.5
"""Ratios of one machine differ by a third from run to run when it is loaded; what is more than this is looked into."""
LIMIT = 3600.0
"""s, for one benchmark."""
PEERS = ("moordyn", "libcosimpy", "scipy", "weatherrouting")
VERSIONS = ("fmpy", "pythonfmu", "numpy", "casadi", *PEERS)
RED = "#b00020"


@dataclass(frozen=True)
class Benchmark:
    """A program of this directory that prints Markdown; with ``quick``, its arguments, it is part of a quick run."""

    name: str
    title: str
    columns: tuple[Column, ...]
    curves: tuple[Curves, ...] = ()
    quick: tuple[str, ...] | None = None


MOORDYN = Column("^MoorDyn .* over it$", "more")
BENCHMARKS = (
    Benchmark(
        "coupling", "Coupling, beside libcosim",
        (Column("^over raw FMI", "less"), Column("^us$", "more", over="libcosim")), (Curves("^cost", r"^\d+ steps$"),),
        ("step",),
    ),
    Benchmark("cable", "Tow cable, beside MoorDyn", (MOORDYN,), (Curves("^(CPU )?ms per", "^error"),)),
    Benchmark(
        "native", "Native units",
        (Column("^over (Python|bare)", "less"), MOORDYN, Column("^ratio$", "more")), (Curves("^(CPU )?ms per", "^error"),),
        ("cradle",),
    ),
    Benchmark("ensemble", "Ensembles", (Column("times faster$", "more"),)),
    Benchmark("native_scene", "A scene as one FMU", (Column("^times faster", "more"),), (Curves("^CPU ms", "^error"),)),
    Benchmark(
        "slender_body", "Slender body, beside scipy's integrators", (Column("^s$", "more", over="RK45"),),
        (Curves("^ms a speed", "^u = 4$"), Curves("^s$", "^error$")),
    ),
    Benchmark(
        "route", "Routes, beside weatherrouting", (Column("^CPU s", "more", over="weatherrouting"),),
        (Curves("^CPU s", "error h$"),),
    ),
)  # fmt: skip


def main() -> int:
    """The exit code."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="what can be run in a minute, into build/benchmarks")
    parser.add_argument("--out", type=Path, help="directory of the page (default: docs; with --quick build/benchmarks)")
    arguments = parser.parse_args()
    out = arguments.out or ROOT / ("build/benchmarks" if arguments.quick else "docs")
    out.mkdir(parents=True, exist_ok=True)
    machine, before = the_machine(), committed()
    sections: list[str] = []
    now: dict[str, Ratio] = {}
    failed = False
    for benchmark in BENCHMARKS:
        if arguments.quick and benchmark.quick is None:
            continue
        print(f"{benchmark.name} ...", file=sys.stderr, flush=True)
        begin = time.perf_counter()
        text, good = run(benchmark, (benchmark.quick or ()) if arguments.quick else ())
        print(f"{benchmark.name}: {'' if good else 'FAILED after '}{time.perf_counter() - begin:.0f} s", file=sys.stderr)
        failed |= not good
        found = tables(text)
        now |= {f"{benchmark.name}: {key}": ratio for key, ratio in ratios(found, benchmark.columns).items()}
        diagram, panels = "", [panel for wanted in benchmark.curves for panel in curves(found, wanted)]
        if panels:
            draw(panels, out / f"benchmarks_{benchmark.name}.svg")
            diagram = f"![error over cost](benchmarks_{benchmark.name}.svg)\n\n"
        sections.append(f"## {benchmark.title}\n\n`python benchmarks/{benchmark.name}.py`\n\n{diagram}{below(text)}")
    page = "\n\n".join([front(machine, before), *sections, comparison(now, before)]) + "\n"
    (out / "benchmarks.md").write_text(page, encoding="utf-8")
    document = {**machine, "ratios": {key: ratio._asdict() for key, ratio in now.items()}}
    (out / "benchmarks.json").write_text(json.dumps(document, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    worse = fallen(now, before)
    for key, gain in worse.items():
        text = f"{key}: {now[key].value:.3g}, was {before['ratios'][key]['value']:.3g} ({1.0 / gain:.1f} times worse)"
        print(f"\033[31m{text}\033[0m" if sys.stderr.isatty() else f"WORSE  {text}", file=sys.stderr)
    print(f"{out / 'benchmarks.md'}: {len(now)} ratios, {len(worse)} more than {FALLEN} times worse", file=sys.stderr)
    return 1 if failed or worse else 0


def run(benchmark: Benchmark, arguments: tuple[str, ...]) -> tuple[str, bool]:
    """(what it printed, whether it ended well); what went wrong stands at the end of the text."""
    command = [sys.executable, str(ROOT / "benchmarks" / f"{benchmark.name}.py"), *arguments]
    one_thread = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    try:
        done = subprocess.run(
            command, cwd=ROOT, env=os.environ | one_thread, text=True, capture_output=True, timeout=LIMIT, check=False
        )
        code, text, last = done.returncode, done.stdout, (done.stderr.strip().splitlines() or [""])[-1]
    except subprocess.TimeoutExpired as error:
        text = error.stdout.decode() if isinstance(error.stdout, bytes) else error.stdout or ""
        code, last = -1, f"no end after {LIMIT:g} s"
    if code:
        print(f"{benchmark.name} ended with code {code}: {last}", file=sys.stderr)
        text += f'\n\n<span style="color:{RED}">**Failed**</span>: the tables above are not complete.\n'
    return text, code == 0


def the_machine() -> dict[str, Any]:
    """What the numbers depend on; no names of hosts or users."""
    cpu = platform.processor() or platform.machine()
    if (info := Path("/proc/cpuinfo")).is_file() and (name := re.search(r"model name\s*: (.+)", info.read_text())):
        cpu = name[1]
    versions = {"Python": platform.python_version()}
    for package in VERSIONS:
        try:
            versions[package] = metadata.version(package)
        except metadata.PackageNotFoundError:
            versions[package] = "absent"
    return {
        "date": datetime.datetime.now(datetime.UTC).date().isoformat(),
        "cpu": f"{cpu}, {os.cpu_count()} cores",
        "system": f"{platform.system()} {platform.machine()}",
        "load": round(os.getloadavg()[0], 1) if hasattr(os, "getloadavg") else None,
        "versions": versions,
    }


def committed() -> dict[str, Any]:
    """The last committed ``docs/benchmarks.json``; without ratios where there is none, or no repository."""
    command = ["git", "-C", str(ROOT), "show", "HEAD:docs/benchmarks.json"]
    try:
        found: dict[str, Any] = json.loads(subprocess.run(command, capture_output=True, check=True).stdout)
    except (OSError, subprocess.CalledProcessError, ValueError):
        return {"ratios": {}}
    return found


def fallen(now: dict[str, Ratio], before: dict[str, Any]) -> dict[str, float]:
    """Gain, below 1/1.5, of the ratios that are so much worse; the worst first."""
    gains = {key: ratio.gain(before["ratios"][key]["value"]) for key, ratio in now.items() if key in before["ratios"]}
    return {key: gain for key, gain in sorted(gains.items(), key=lambda item: item[1]) if gain < 1.0 / FALLEN}


def front(machine: dict[str, Any], before: dict[str, Any]) -> str:
    """How to read the page, and where it was made."""
    load = "" if machine["load"] is None else f", load {machine['load']} at the start"
    versions = ", ".join(f"{name} {version}" for name, version in machine["versions"].items())
    other = before.get("cpu") and before["cpu"] != machine["cpu"]
    text = (
        "# Benchmarks\n\nWritten by `make bench`; numbers are not edited by hand. Times on a shared machine mean little by "
        "themselves: read the ratios, which are taken in one run, peers (MoorDyn, libcosim, scipy, weatherrouting) "
        f"included. [All ratios](benchmarks.json) are kept, and [compared](#ratios).\n\n{machine['date']}, "
        f"{machine['cpu']}{load}, {machine['system']}. {versions}."
    )
    return text + (f"\n\nThe last page was made on another machine ({before['cpu']})." if other else "")


def comparison(now: dict[str, Ratio], before: dict[str, Any]) -> str:
    """The table of all ratios beside those of the last page."""
    worse = fallen(now, before)
    lines = ["## Ratios", ""]
    lines += [f"Beside the last committed page; red: more than {FALLEN} times worse.", ""]
    lines += ["| ratio | better is | now | last | times better |", "|---|---|---|---|---|"]
    for key, ratio in now.items():
        last = before["ratios"].get(key)
        gain = f"{ratio.gain(last['value']):.2f}" if last else ""
        value = f"{ratio.value:.3g}"
        if key in worse:
            value, gain = (f'<span style="color:{RED}">**{text}**</span>' for text in (value, gain))
        was = f"{last['value']:.3g}" if last else "new"
        lines.append(f"| {key} | {ratio.better} | {value} | {was} | {gain} |")
    gone = [key for key in before["ratios"] if key not in now]
    return "\n".join(lines) + (f"\n\nNot measured this time: {'; '.join(gone)}." if gone and now else "")


def below(markdown: str) -> str:
    """The text with its headings from level 3 on."""
    levels = [len(found) for found in re.findall(r"^(#+) ", markdown, re.MULTILINE)]
    shift = "#" * max(0, 3 - min(levels, default=3))
    return re.sub(r"^#", f"{shift}#", markdown, flags=re.MULTILINE).strip()


if __name__ == "__main__":
    sys.exit(main())
