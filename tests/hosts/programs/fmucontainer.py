"""A scene put into one FMU by fmucontainer, which couples the units inside, and stepped by fmpy.

From the description in JSON: what reads SSP takes no parameter sets."""

import json
from importlib.metadata import version
from pathlib import Path

import fmpy
from fmpy.fmi2 import FMU2Slave
from fmu_manipulation_toolbox.assembly import Assembly
from job import Job, Series, answer


def container(job: Job) -> Path:
    """The FMU, every watched output among its own. ``unit.name`` is what it calls the ends of its links itself."""
    folder = Path(job["folder"])
    watched = [(f"{unit}.fmu", name, f"{unit}__{name}") for unit, name, _ in job["watch"]]
    description = {
        "name": "container.fmu", "step_size": job["step"], "auto_link": False, "auto_input": False, "auto_output": False,
        "fmu": [f"{name}.fmu" for name in job["units"]],
        "path": {f"{name}.fmu": unit["fmu"] for name, unit in job["units"].items()},
        "link": [[f"{a}.fmu", b, f"{c}.fmu", d] for a, b, c, d, _, _ in job["connections"]],
        "output": [list(each) for each in watched],
        "start": [[f"{name}.fmu", key, value] for name, unit in job["units"].items() for key, value in unit["start"].items()],
    }  # fmt: skip
    assert all(connection[4:] == [1.0, 0.0] for connection in job["connections"]), "no conversion in a connection"
    (folder / "container.json").write_text(json.dumps(description))
    Assembly("container.json", fmu_directory=folder).make_fmu()
    return folder / "container.fmu"


def run(job: Job) -> Series:
    """Values after every step."""
    path = container(job)
    description, directory = fmpy.read_model_description(str(path)), fmpy.extract(str(path))
    references = {v.name: v.valueReference for v in description.modelVariables}
    fmu = FMU2Slave(guid=description.guid, unzipDirectory=directory,
                    modelIdentifier=description.coSimulation.modelIdentifier, instanceName="container")  # fmt: skip
    fmu.instantiate()
    fmu.setupExperiment(startTime=0.0)
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()
    names = {f"{unit}.{name}": references[f"{unit}__{name}"] for unit, name, _ in job["watch"]}
    series: Series = {name: [] for name in names}
    for k in range(job["steps"]):
        fmu.doStep(currentCommunicationPoint=k * job["step"], communicationStepSize=job["step"])
        for name, value in zip(names, fmu.getReal(list(names.values())), strict=True):
            series[name].append(value)
    fmu.terminate()
    fmu.freeInstance()
    return series


answer(run, version("fmu-manipulation-toolbox"))
