"""One FMU in fmusim, the program of the Reference FMUs, in a process of its own."""

import csv
import re
import subprocess
import sys
from pathlib import Path

from job import Job, Series, answer

PROGRAM = sys.argv[1]


def run(job: Job) -> Series:
    """Values at the communication points 0, 1, ...; inputs from a CSV file."""
    output = Path(job["folder"]) / "fmusim.csv"
    command = [PROGRAM, "--interface-type", "cs", "--stop-time", repr(job["steps"] * job["step"])]
    command += ["--output-interval", repr(job["step"]), "--output-file", str(output)]
    for name, value in job["start"].items():
        command += ["--start-value", name, repr(value)]
    for name in job["watch"]:
        command += ["--output-variable", name]
    if job["inputs"]:
        command += ["--input-file", job["inputs"]]
    done = subprocess.run([*command, job["fmu"]], capture_output=True, text=True, timeout=600)
    if done.returncode:
        raise SystemExit((done.stderr or done.stdout)[-500:])
    with output.open(newline="") as file:
        rows = list(csv.DictReader(file))
    return {name: [float(row[name]) for row in rows] for name in job["watch"]}


def version() -> str:
    """What the program says of itself."""
    said = subprocess.run([PROGRAM, "--version"], capture_output=True, text=True).stdout
    found = re.search(r"\d+(\.\d+)+", said)
    return found[0] if found else said.strip()


answer(run, version())
