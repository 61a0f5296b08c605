"""A system of SSP in OMSimulator, in a process of its own; the step is an option."""

import csv
import re
import subprocess
import sys
from pathlib import Path

from job import Job, Series, answer

PROGRAM = sys.argv[1]


def run(job: Job) -> Series:
    """Values after every step."""
    output = Path(job["folder"]) / "oms.csv"
    stop = job["steps"] * job["step"]
    command = [PROGRAM, f"--stepSize={job['step']!r}", f"--stopTime={stop!r}", f"--intervals={job['steps']}", "--mode=cs",
               f"--resultFile={output}", "--stripRoot=true", job["ssp"]]  # fmt: skip
    done = subprocess.run(command, capture_output=True, text=True, timeout=600)
    if done.returncode or not output.is_file():
        lines = (done.stdout + done.stderr).splitlines()
        said = [line for line in lines if line.startswith(("error:", "Loading shared object failed"))] or ["no message"]
        raise SystemExit(said[0])
    with output.open(newline="") as file:
        rows = {round(float(row["time"]) / job["step"]): row for row in csv.DictReader(file)}
    return {
        f"{unit}.{name}": [float(rows[k][f"{unit}.{name}"]) for k in range(1, job["steps"] + 1)]
        for unit, name, _ in job["watch"]
    }


def version() -> str:
    """What the program says of itself."""
    said = subprocess.run([PROGRAM, "--version"], capture_output=True, text=True).stdout
    found = re.search(r"v?\d+(\.\w+)+(-\w+)*", said)
    return found[0] if found else said.strip()


answer(run, version())
