"""A scene as one native FMU beside the same scene coupled by the master: error and CPU time, from one run. Prints
Markdown; ``python benchmarks/native_scene.py [SCENE ...]``.

The master needs its communication step for the coupling; the scene's own FMU has none, and is asked for the same outputs at
the same points and at every eighth of them. There, most of the time is that of the two calls from Python. The error is that
of the body's heave against the monolithic solution, relative to its largest value; CPU time is the best of three runs,
without start-up. Times on a shared machine mean little: read the ratios.
"""

from __future__ import annotations

import sys
import tempfile
import time
from ctypes import c_double, c_uint32
from itertools import pairwise
from pathlib import Path

import numpy as np
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave
from msgspec.structs import replace
from numpy.typing import NDArray

from towage.fmus.native.build import build_unit
from towage.master.master import Master
from towage.scene.compose import unit_of
from towage.scene.flavour import Flavour
from towage.scene.resolve import ResolvedScene, described
from towage.scene.scene import Scene
from towage.units.store import locator
from towage.verify.monolithic import solve

RUNS = 3
SCENES = {"sea_cliff": "8 s wave", "slack": None, "docking": "plastic capture", "stiff_line": None, "light_body": None}
TOLERANCE = 1e-10
Array = NDArray[np.float64]


def bare(name: str, case: str | None) -> Scene:
    """The scene without its checks and its second run for the error of the coupling."""
    scene = Scene.load(name)
    scene = scene.case(case) if case else scene
    coupling = replace(scene.coupling, error_estimate=False)
    return replace(scene, cases=(), coupling=coupling, checks=scene.checks.without("sdof", "simpler"))


def error(computed: Array, exact: Array) -> float:
    """Largest difference over the largest exact value."""
    return float(np.max(np.abs(computed - exact)) / np.max(np.abs(exact)))


def coupled(scene: Scene, flavour: Flavour) -> tuple[float, float, Array]:
    """CPU time, s, error, and the times of the communication points."""
    master = Master(scene, flavour=flavour)
    costs = []
    for _ in range(RUNS):
        result = master.run()
        costs.append(result.statistics["cpu_s"])
    heave, _ = solve(master.resolved, result.time)
    return min(costs), error(result["cradle.heave"], heave), result.time


def composed(resolved: ResolvedScene, fmu: Path, time_points: Array) -> tuple[float, float]:
    """CPU time, s, and error of the scene's own FMU, driven call by call."""
    description = read_model_description(str(fmu))
    references = {v.name: v.valueReference for v in description.modelVariables}
    names = [f"{unit}.{variable}" for unit, variable in resolved.record]
    wanted = (c_uint32 * len(names))(*(references[n] for n in names))
    table = np.empty((len(time_points), len(names)))
    rows = [(c_double * len(names)).from_buffer(row) for row in table]
    steps = [(float(a), float(b - a)) for a, b in pairwise(time_points)]
    exact, _ = solve(resolved, time_points)
    with tempfile.TemporaryDirectory() as folder:
        extract(str(fmu), folder)
        slave = FMU2Slave(
            guid=description.guid, unzipDirectory=folder, instanceName="scene",
            modelIdentifier=description.coSimulation.modelIdentifier,
        )  # fmt: skip
        costs = []
        for _ in range(RUNS):
            slave.instantiate()
            slave.setReal([references["integration_tolerance"]], [TOLERANCE])
            slave.setupExperiment(startTime=steps[0][0])
            slave.enterInitializationMode()
            slave.exitInitializationMode()
            step, get, component, count = slave.dll.fmi2DoStep, slave.dll.fmi2GetReal, slave.component, len(names)
            begin = time.process_time()
            get(component, wanted, count, rows[0])
            for (t, h), row in zip(steps, rows[1:]):
                step(component, t, h, True)
                get(component, wanted, count, row)
            costs.append(time.process_time() - begin)
            slave.terminate()
            slave.fmi2FreeInstance(slave.component)
        slave.freeLibrary()
    return min(costs), error(table[:, names.index("cradle.heave")], exact)


def main(chosen: list[str]) -> None:
    """One table a scene."""
    for name in chosen:
        scene = bare(name, SCENES[name])
        resolved = described(scene, locator())
        with tempfile.TemporaryDirectory() as folder:
            fmu, _ = build_unit(unit_of(resolved, name), Path(folder))
            rows = []
            flavours: tuple[Flavour, ...] = ("python", "native")
            for flavour in flavours:
                cost, off, points = coupled(scene, flavour)
                rows.append((f"master, {flavour} units", off, cost))
            for share in (1, 8):
                some = points[::share]
                cost, off = composed(resolved, fmu, some)
                rows.append((f"one native FMU, every {some[1] - some[0]:g} s", off, cost))
        base = rows[0][-1]
        print(f"\n### {name}: {scene.stop_time:g} s in {len(points) - 1} steps\n")
        print("| what | error | CPU ms | times faster |\n|---|---|---|---|")
        for what, off, cost in rows:
            print(f"| {what} | {off:.1e} | {1e3 * cost:.1f} | {base / cost:.0f} |", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:] or list(SCENES))
