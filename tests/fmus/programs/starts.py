"""Initialises FMUs and takes ten steps with nothing set, in fmpy: ``starts.py FMU ...`` prints each unit's outputs at the end."""

import json
import sys

import fmpy

STEP = 0.1

for path in sys.argv[1:]:
    rows = fmpy.simulate_fmu(path, fmi_type="CoSimulation", stop_time=10 * STEP, step_size=STEP, output_interval=STEP)
    last = dict(zip(rows.dtype.names, map(float, rows[-1])))
    print(json.dumps({"path": path, "steps": len(rows) - 1, "last": last}))
