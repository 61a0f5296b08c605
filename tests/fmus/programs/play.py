"""Steps FMUs as told: reads jobs (JSON) from standard input, prints all outputs as hexadecimal floats.

A job: unit, start values, steps of (time, size, inputs) and whether outputs are read before the step too. Arguments:
directory to unpack to, directories of FMUs (each job is played on all of them in turn, step by step), after ``--import``
a path that is imported from first.
"""

import importlib
import json
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
from host import CASES, OK, Fmu

work, *directories = sys.argv[1:]
if "--import" in directories:
    *directories, _, tree = directories
    sys.path.insert(0, tree)
    for module in ("python.slave", *CASES):
        importlib.import_module(f"towage.fmus.{module}")
    # what an FMU of another origin may bring along
    sys.modules["models"] = sys.modules["towage.models"]
    sys.modules["fmus"] = sys.modules["towage.fmus"]

jobs, answers = json.load(sys.stdin), []
for job in jobs:
    fmus = [Fmu(f"{d}/{job['unit']}.fmu", work) for d in directories]
    # what the build of a native FMU fixed stays so
    players = [fmu.ready(job["start"] | {n: v for n, v in fmu.start.items() if n in fmu.fixed}) for fmu in fmus]
    answers.append([[] for _ in players])
    for time, size, inputs, read in job["steps"]:
        for it, seen in zip(players, answers[-1]):
            assert it.set(inputs) == OK, it.messages
            if read:
                seen.append(it.observe())
            assert it.step(time, size) == OK, it.messages
            seen.append(it.observe())
    for it in players:
        it.free()
json.dump(answers, sys.stdout)
