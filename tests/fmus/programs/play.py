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
from host import OK, Fmu

work, *directories = sys.argv[1:]
if "--import" in directories:
    *directories, _, tree = directories
    sys.path.insert(0, tree)
    for module in (
        "towage.fmus.python.slave",
        "towage.fmus.ship",
        "towage.fmus.cradle_on_line",
        "towage.fmus.spring_line",
    ):
        importlib.import_module(module)
    # what an FMU of another origin may bring along
    sys.modules["models"] = sys.modules["towage.models"]
    sys.modules["fmus"] = sys.modules["towage.fmus"]

jobs, answers = json.load(sys.stdin), []
for job in jobs:
    players = [Fmu(f"{d}/{job['unit']}.fmu", work).ready(job["start"]) for d in directories]
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
