"""A system of SSP in Ecos, with the parameter set that is selected by the name that all sets share."""

from importlib.metadata import version

from ecospy import EcosSimulation
from job import Job, Series, answer


def run(job: Job) -> Series:
    """The step is given: Ecos has no place for it in the file."""
    simulation = EcosSimulation(step_size=job["step"], ssp_path=job["ssp"])
    assert simulation.init(parameter_set=job["parameter_set"]), "Ecos could not initialise"
    series: Series = {f"{unit}.{name}": [] for unit, name, _ in job["watch"]}
    for _ in range(job["steps"]):
        simulation.step()
        for unit, name, _ in job["watch"]:
            series[f"{unit}.{name}"].append(simulation.get_real(f"{unit}::{name}"))
    simulation.terminate()
    return series


answer(run, version("ecospy"))
