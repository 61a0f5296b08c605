"""All benchmarks in one run, and what changed: ``python benchmarks/run_all.py [--quick] [--out docs]``.

Writes ``benchmarks.json`` with the machine, versions, what every benchmark printed, and every ratio; then the page of it
(`page`). A ratio that is more than 1.5 times worse than in the last committed file is told on the terminal; the exit code
is 1 then, or if a benchmark failed. ``--quick``: a minute, two tables.
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
from importlib import metadata
from pathlib import Path
from typing import Any

from page import BENCHMARKS, FALLEN, RED, ROOT, Benchmark, fallen, ratios_of, write_page

LIMIT = 3600.0
"""s, for one benchmark."""
PEERS = ("moordyn", "libcosimpy", "scipy", "weatherrouting")
VERSIONS = ("fmpy", "pythonfmu", "numpy", "casadi", *PEERS)


def main() -> int:
    """The exit code."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="what can be run in a minute, into build/benchmarks")
    parser.add_argument("--out", type=Path, help="directory of the files (default: docs; with --quick build/benchmarks)")
    arguments = parser.parse_args()
    out = arguments.out or ROOT / ("build/benchmarks" if arguments.quick else "docs")
    out.mkdir(parents=True, exist_ok=True)
    before = committed()
    document: dict[str, Any] = {**the_machine(), "last": last_of(before), "texts": {}}
    failed = False
    for benchmark in BENCHMARKS:
        if arguments.quick and benchmark.quick is None:
            continue
        text, good = run(benchmark, (benchmark.quick or ()) if arguments.quick else ())
        failed |= not good
        document["texts"][benchmark.name] = text.strip().splitlines()
    now = ratios_of(document)
    document["ratios"] = {key: ratio._asdict() for key, ratio in now.items()}
    (out / "benchmarks.json").write_text(json.dumps(document, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    page = write_page(document, out)
    worse = fallen(now, document["last"])
    for key, gain in worse.items():
        text = f"{key}: {now[key].value:.3g}, was {before['ratios'][key]['value']:.3g} ({1.0 / gain:.1f} times worse)"
        print(f"\033[31m{text}\033[0m" if sys.stderr.isatty() else f"WORSE  {text}", file=sys.stderr)
    print(f"{page}: {len(now)} ratios, {len(worse)} more than {FALLEN} times worse", file=sys.stderr)
    return 1 if failed or worse else 0


def run(benchmark: Benchmark, arguments: tuple[str, ...]) -> tuple[str, bool]:
    """(what it printed, whether it ended well); what went wrong stands at the end of the text."""
    print(f"{benchmark.name} ...", file=sys.stderr, flush=True)
    begin = time.perf_counter()
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
    print(f"{benchmark.name}: {'FAILED after ' if code else ''}{time.perf_counter() - begin:.0f} s", file=sys.stderr)
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
        document: dict[str, Any] = json.loads(subprocess.run(command, capture_output=True, check=True).stdout)
    except (OSError, subprocess.CalledProcessError, ValueError):
        return {"ratios": {}}
    return document


def last_of(before: dict[str, Any]) -> dict[str, Any] | None:
    """What is kept of the file before: its machine and the values of its ratios."""
    if not before["ratios"]:
        return None
    return {"cpu": before["cpu"], "ratios": {key: ratio["value"] for key, ratio in before["ratios"].items()}}


if __name__ == "__main__":
    sys.exit(main())
