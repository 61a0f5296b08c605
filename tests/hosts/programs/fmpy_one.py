"""One FMU in fmpy's ``simulate_fmu``."""

import fmpy
import numpy as np
from job import Job, Series, answer


def run(job: Job) -> Series:
    """Values at the communication points 0, 1, ...; inputs from a CSV file, held between its rows."""
    table = np.genfromtxt(job["inputs"], delimiter=",", names=True, deletechars="") if job["inputs"] else None
    result = fmpy.simulate_fmu(
        job["fmu"], stop_time=job["steps"] * job["step"], step_size=job["step"], output_interval=job["step"],
        start_values=job["start"], input=table, output=job["watch"], fmi_type="CoSimulation", validate=False,
    )  # fmt: skip
    return {name: [float(value) for value in result[name]] for name in job["watch"]}


answer(run, fmpy.__version__)
