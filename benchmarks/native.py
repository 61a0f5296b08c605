"""What native units cost: a step in four hosts, a linear cable against its matrix, sizes, runs of the master.

    python benchmarks/native.py [cradle] [cable] [sizes] [moordyn] [master]

Prints Markdown. Times are processor time, the least of several batches; read the ratios, which are taken in one run. The C
host is ``tests/fmus/host``, the bare integrator ``benchmarks/bare.c``; both need a C compiler, all of it CasADi.
"""

from __future__ import annotations

import math
import sys
import tempfile
import time
from collections.abc import Callable
from ctypes import CDLL, Structure, c_size_t
from pathlib import Path

import cable
import numpy as np
from cable import AMPLITUDE, FREQUENCY, SPEED, harmonic, tow_case
from fmpy.fmi2 import FMU2Slave
from msgspec.structs import replace
from native_host import ROOT, Native, c_host, compiled, output

from towage.fmus.python import build as python_fmu
from towage.master.master import Master
from towage.scene.flavour import Flavour
from towage.scene.scene import Scene
from towage.units.archive import extract, read_description
from towage.units.description import Description
from towage.units.fmu import Unit
from towage.units.wiring import Wanted

STEP = 0.01
BATCH = 5
INSTANCES = 50
CABLE = {"segments": 20.0, "extensible": 1.0}


def least(call: Callable[[], object], count: int) -> float:
    """Least mean of `BATCH` batches of ``count`` calls, us."""
    best = math.inf
    for _ in range(BATCH):
        begin = time.process_time()
        for _ in range(count):
            call()
        best = min(best, (time.process_time() - begin) / count * 1e6)
    return best


# ---- a step of the cradle -------------------------------------------------------------------------------------------

START = {"mass": 5000.0, "drag_area": 10.0, "weight_in_water": 2e4}
TENSION = {"line_tension": (1e4, 0.9)}
OUTPUTS = ["heave", "velocity"]


def fmpy_methods(description: Description, directory: Path, count: int) -> float:
    """us per setReal, doStep and getReal, as fmpy's user writes them."""
    slave = FMU2Slave(guid=description.guid, unzipDirectory=str(directory),
                      modelIdentifier=description.model_identifier, instanceName="it")  # fmt: skip
    index = {v.name: v.value_reference for v in description.variables}
    slave.instantiate()
    slave.setReal([index[n] for n in START], list(START.values()))
    slave.setupExperiment(startTime=0.0)
    slave.enterInitializationMode()
    slave.exitInitializationMode()
    ((name, (a, w)),) = TENSION.items()
    inputs, outputs = [index[name]] + [index[f"{name}_d{k}"] for k in (1, 2, 3)], [index[n] for n in OUTPUTS]
    k = 0

    def step() -> None:
        """Set, step and get once."""
        nonlocal k
        t = k * STEP
        s, c = a * math.sin(w * t), a * w * math.cos(w * t)
        slave.setReal(inputs, [s, c, -w * w * s, -w * w * c])
        slave.doStep(t, STEP)
        slave.getReal(outputs)
        k += 1

    cost = least(step, count)
    slave.terminate()
    slave.freeInstance()
    return cost


def raw_calls(description: Description, directory: Path, by_function: bool, count: int) -> float:
    """us per step of the master's unit, with derivatives as variables or through the standard's function."""
    wanted = Wanted(list(TENSION), OUTPUTS, OUTPUTS, by_function=by_function)
    unit = Unit("it", description, directory, wanted)
    unit.start(START, 0.0, 1e9)
    ((name, (a, w)),) = TENSION.items()
    place, buffer, k = unit.inputs[name], unit.input_buffer, 0

    def step() -> None:
        """Set, step and get once."""
        nonlocal k
        t = k * STEP
        s, c, d = a * math.sin(w * t), a * w * math.cos(w * t), place.derivatives
        buffer[place.slot], buffer[d], buffer[d + 1], buffer[d + 2] = s, c, -w * w * s, -w * w * c
        unit.advance(t, STEP)
        k += 1

    cost = least(step, count)
    unit.close()
    return cost


def bare(native: Native, folder: Path, script: str, count: int) -> float:
    """us per step of the integrator on the traced function."""
    sources = [ROOT / "benchmarks/bare.c", *(native.sources / f"{name}.c" for name in ("unit", "model", "integrate"))]
    program = compiled(folder, "bare", sources, native.sources)
    return float(output([program, str(count)], script).split()[0])


def cradle(folder: Path, host: Path) -> None:
    """The table of a step in four hosts."""
    python_path = python_fmu.build("cradle", folder)[0]
    extract(python_path, folder / "python_cradle")
    python_description = read_description(python_path)
    native = Native("cradle", folder)
    script = native.script(START, TENSION, OUTPUTS, STEP, 1)
    rows = {
        "Python flavour, fmpy's methods": fmpy_methods(python_description, folder / "python_cradle", 4000),
        "native, fmpy's methods": fmpy_methods(native.description, native.directory, 8000),
        "Python flavour, the master's calls": raw_calls(python_description, folder / "python_cradle", False, 4000),
        "native, the master's calls, derivatives as variables": raw_calls(native.description, native.directory, False, 20000),
        "native, the master's calls, derivatives by function": raw_calls(native.description, native.directory, True, 20000),
        "native, C host": float(native.hosted(host, script, "time", "100000")),
        "the integrator on the traced function, no FMI": bare(native, folder, script, 100000),
    }
    slowest, fastest = rows["Python flavour, fmpy's methods"], rows["the integrator on the traced function, no FMI"]
    print("## A step of the cradle\n\nInput with three derivatives, step of 0.01 s, two outputs.\n")
    print("| host | us | over Python in fmpy | over bare |\n|---|---|---|---|")
    for what, cost in rows.items():
        print(f"| {what} | {cost:.3g} | {cost / slowest:.3g} | {cost / fastest:.3g} |")


# ---- linear units ---------------------------------------------------------------------------------------------------


def cable_step(folder: Path, host: Path) -> None:
    """A step of a cable of 80 states against the products that it is made of."""
    native = Native("tow_system", folder, CABLE)
    start = {"axial_stiffness": 4e6, "reduced": 0.0}
    sine = {"velocity_heave": (0.2, FREQUENCY)}
    script = native.script(start, sine, ["reaction_surge", "reaction_heave", "tension_top", "body_heave"], 0.05, 1)
    program = compiled(folder, "gemv", [ROOT / "benchmarks/gemv.c", native.sources / "dense.c"], native.sources)
    n, held, shown = 80, 4 * 4, 48 + 8  # states; inputs times powers of time; outputs and rates of states

    def products(*sizes: int) -> float:
        """us of matrix products of these sizes."""
        return float(output([program, "20000", *map(str, sizes)]).split()[0])

    rows = {
        "a step in the C host, all states kept": float(native.hosted(host, script, "time", "20000")),
        f"product of {n} by {n}": products(n, n),
        f"products of {n} by {n + held} (step) and {shown} by {n + 3 * 4} (outputs, rates)":
            products(n, n + held, shown, n + 3 * 4),
    }  # fmt: skip
    print("\n## A step of a cable of 80 states\n\n`tow_system`, 20 segments, extensible, not reduced.\n")
    print("| what | us |\n|---|---|")
    for what, cost in rows.items():
        print(f"| {what} | {cost:.3g} |")


def moordyn(folder: Path, host: Path) -> None:
    """The reduced cable in the C host against MoorDyn, in the case and the measure of ``cable.py``."""
    tow = tow_case()
    native = Native("tow_system", folder, {"segments": 40.0, "extensible": 1.0})
    start = {
        "tow_speed": SPEED, "cable_weight": tow.cable.weight, "loading_form": 1.0, "loading_friction": 0.05,
        "axial_stiffness": 4e6, "body_added_mass_surge": 256.25, "body_added_mass_heave": 256.25,
        "body_weight_in_water": tow.body.weight, "body_drag": tow.body.drag, "tolerance": 0.005,
    }  # fmt: skip
    sine = {"velocity_heave": (AMPLITUDE * FREQUENCY, FREQUENCY)}
    rows = [(f"MoorDyn, N = {n}, coupling {step:g} s", *cable.moordyn(n, inner, step))
            for n, inner, step in ((10, 4e-3, 0.01), (20, 2e-3, 0.01))]  # fmt: skip
    for step in (0.1, 0.5):
        script = native.script(start, sine, ["reaction_surge", "reaction_heave"], step, round(120.0 / step))
        lines = native.hosted(host, script, "run").splitlines()
        table = np.array([[float.fromhex(word) for word in line.split()] for line in lines])
        table = table[table[:, 0] > 115.0 + 1e-9]
        # a sine of the velocity is a heave a quarter of a period later
        times = table[:, 0] - math.pi / 2.0 / FREQUENCY
        force = np.array([harmonic(times, table[:, k]) for k in (1, 2)]) / AMPLITUDE
        cost = float(native.hosted(host, script, "time", "20000")) / 1e3 / step
        rows.append((f"native, N = 40, reduced, C host, step {step:g} s", cable.error(force), cost))
    base = rows[1][2]
    print("\n## The linear cable against MoorDyn\n\nCase and error of `benchmarks/cable.py`.\n")
    print("| model | error | ms per simulated s | MoorDyn N = 20 over it |\n|---|---|---|---|")
    for what, wrong, cost in rows:
        print(f"| {what} | {wrong:.2g} | {cost:.3g} | {base / cost:.3g} |")


# ---- sizes, runs ----------------------------------------------------------------------------------------------------


def sizes(folder: Path) -> None:
    """Bytes of FMUs and instances, and what it takes to make one."""
    print("\n## Sizes\n\nOne platform; instances are initialised with the start values.\n")
    print("| unit | FMU, kB | library, kB | an instance, kB | made and initialised, ms |\n|---|---|---|---|---|")
    for name, structure in (("ship", None), ("spring_line", None), ("cradle", None), ("slender_body", None),
                            ("tow_system", CABLE)):  # fmt: skip
        native = Native(name, folder, structure)
        slave = FMU2Slave(guid=native.description.guid, unzipDirectory=str(native.directory),
                          modelIdentifier=name, instanceName="it")  # fmt: skip
        slave.instantiate()
        made, before, begin = [], memory(), time.process_time()
        for _ in range(INSTANCES):
            slave.instantiate()
            if structure:
                slave.setReal([native.index["axial_stiffness"]], [4e6])
            slave.setupExperiment(startTime=0.0)
            slave.enterInitializationMode()
            slave.exitInitializationMode()
            made.append(slave.component)
        cost = (time.process_time() - begin) / INSTANCES * 1e3
        size = (memory() - before) / INSTANCES
        for slave.component in made:
            slave.fmi2FreeInstance(slave.component)
        library = native.library.stat().st_size / 1e3
        print(f"| {name} | {native.path.stat().st_size / 1e3:.0f} | {library:.0f} | {size:.0f} | {cost:.3g} |")


def memory() -> float:
    """What malloc has given away in this process (glibc), kB."""

    class Statistics(Structure):
        """``struct mallinfo2``."""

        _fields_ = tuple((name, c_size_t) for name in ("arena", "ordblks", "smblks", "hblks", "hblkhd", "usmblks",
                                                       "fsmblks", "uordblks", "fordblks", "keepcost"))  # fmt: skip

    mallinfo = CDLL(None).mallinfo2
    mallinfo.restype = Statistics
    counts = mallinfo()
    return float(counts.uordblks + counts.hblkhd) / 1e3


def master() -> None:
    """A run with native units against one with Python units: the first case, the coupled run alone."""
    print("\n## The master with native units\n\n| scene | steps | Python, s | native, s | ratio |\n|---|---|---|---|---|")
    for name in ("sea_cliff", "tow_600ft"):
        scene = Scene.load(name)
        scene = replace(scene, coupling=replace(scene.coupling, error_estimate=False),
                        checks=scene.checks.without("sdof"))  # fmt: skip
        seconds: dict[Flavour, float] = {}
        steps = 0.0
        for flavour in ("python", "native"):
            prepared = Master(scene, scene.cases[0].name, None, flavour)
            runs = [prepared.run().statistics for _ in range(3)]
            seconds[flavour], steps = min(r["cpu_s"] for r in runs), runs[0]["steps"]
        print(f"| {name} | {steps:.0f} | {seconds['python']:.3g} | {seconds['native']:.3g} | "
              f"{seconds['python'] / seconds['native']:.3g} |")  # fmt: skip


def main() -> None:
    """Print the tables chosen."""
    chosen = sys.argv[1:] or ["cradle", "cable", "sizes", "moordyn", "master"]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        host = c_host(folder)
        if "cradle" in chosen:
            cradle(folder, host)
        if "cable" in chosen:
            cable_step(folder, host)
        if "sizes" in chosen:
            sizes(folder)
        if "moordyn" in chosen:
            moordyn(folder, host)
    if "master" in chosen:
        master()


if __name__ == "__main__":
    main()
