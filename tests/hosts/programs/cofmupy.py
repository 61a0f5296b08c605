"""A scene in cofmupy's master, all units in one group, so that its Jacobi method couples them all.

Its file format is its own: units, values and connections are given as its classes take them. It starts connected inputs at
zero, so that the values that they have at time 0 are among the start values."""

import sys
from importlib.metadata import version

here = sys.path.pop(0)  # this file is called like the package
from cofmupy.master.default_master import DefaultMaster  # noqa: E402

sys.path.insert(0, here)
from job import Job, Series, answer  # noqa: E402


def run(job: Job) -> Series:
    """Values after every step."""
    units = [
        {"id": name, "path": unit["fmu"], "initialization": {**unit["start"], **job["initial"].get(name, {})}}
        for name, unit in job["units"].items()
    ]
    connections: dict[tuple[str, str], list[tuple[str, str]]] = {}
    for source, output, target, given, factor, offset in job["connections"]:
        assert (factor, offset) == (1.0, 0.0), "cofmupy has no conversion in a connection"
        connections.setdefault((source, output), []).append((target, given))
    master = DefaultMaster(units, connections, [[unit["id"] for unit in units]], cosim_method="jacobi")
    master.init_simulation()
    for _ in range(job["steps"]):
        master.do_step(job["step"])
    results = master.get_results()
    return {f"{unit}.{name}": [float(value) for value in results[unit, name]] for unit, name, _ in job["watch"]}


answer(run, version("cofmupy"))
