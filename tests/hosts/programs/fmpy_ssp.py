"""A system of SSP in fmpy's ``simulate_ssp``, which takes a single parameter set with names ``unit.name``."""

from types import SimpleNamespace

import fmpy
from fmpy.ssp.simulation import simulate_ssp
from job import Job, Series, answer


def run(job: Job) -> Series:
    """Values after every step; its first row is that of the start time."""
    values = [
        SimpleNamespace(name=f"{name}.{key}", value=value)
        for name, unit in job["units"].items()
        for key, value in unit["start"].items()
    ]
    stop = (job["steps"] - 0.5) * job["step"]  # it adds steps up until the stop time is reached
    rows = simulate_ssp(job["ssp"], stop_time=stop, step_size=job["step"],
                        parameter_set=SimpleNamespace(parameters=values))  # fmt: skip
    return {f"{unit}.{name}": [float(v) for v in rows[f"{unit}.{name}"]] for unit, name, _ in job["watch"]}


answer(run, fmpy.__version__)
