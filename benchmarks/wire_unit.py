"""The unit `wire` beside MoorDyn on the tow of ``moordyn_tow.py``: native in a C host, native and Python under towage's master.

    OPENBLAS_NUM_THREADS=1 python benchmarks/wire_unit.py [--no-moordyn]

Heave of 0.2 m. Error: force on the towpoint at the driving frequency against the bare wire on a fine mesh, as in ``wire.py``;
at least that of MoorDyn with 20 segments is asked for. Time: milliseconds of processor time a simulated second, the least of
three runs of a minute, set-up included; of the master that of the whole run. All in one run: only ratios mean something.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path

import moordyn_tow
import numpy as np
from fmpy.fmi2 import FMU2Slave
from moordyn_tow import FREQUENCY, SPEED, harmonic, tow_case
from native_host import Native, compiled
from wire import HEAVE_RAMP, HEAVE_SAMPLES, HEAVE_START, HEAVE_STOP, bare, build, heave_force, heave_wire

from towage.master.master import Master
from towage.models.numeric.arrays import Array
from towage.scene.flavour import Flavour
from towage.scene.scene import Scene

ROOT = Path(__file__).resolve().parents[1]
AMPLITUDE, LENGTH = 0.2, 60.0
MESHES = ((1, 6, 1e-2), (1, 6, 3e-3), (2, 5, 1e-3))
"""Elements, degree, tolerance of the velocities, m/s."""
SCENE = """title = "benchmark"
stop_time = "{stop} s"
connections = ["ship.velocity -> wire.velocity_heave"]
[units.ship]
fmu = "ship"
[units.ship.parameters]
heave_amplitude = {amplitude}
heave_period = "5 s"
ramp_time = "{ramp} s"
[units.wire]
fmu = "wire"
[units.wire.parameters]
{values}
[coupling]
scheme = "extrapolate"
step = "{step} s"
error_estimate = false
"""


def values(elements: int, degree: int, tolerance: float) -> dict[str, float]:
    """The unit's parameters."""
    tow = tow_case()
    k, b = tow.cable, tow.body
    return {
        "tow_speed": SPEED, "wire_length": k.length, "wire_mass": k.mass, "wire_weight": k.weight,
        "wire_diameter": k.thickness, "wire_axial_stiffness": moordyn_tow.STIFFNESS, "wire_normal_drag": moordyn_tow.DRAG,
        "wire_tangential_drag": moordyn_tow.FRICTION * moordyn_tow.DRAG / np.pi, "body_mass": b.mass,
        "body_added_mass": b.added_mass_surge, "body_weight": b.weight, "body_drag_area": moordyn_tow.BODY_DRAG_AREA,
        "elements": float(elements), "degree": float(degree), "velocity_tolerance": tolerance, "largest_step": 0.5,
    }  # fmt: skip


def wrong(times: Array, force: Array, fine: Array) -> float:
    """Error of the force, whichever its sign and wherever in its period the heave begins."""
    found = np.array([harmonic(times, column) for column in force.T]) / AMPLITUDE
    turned = found * np.exp(1j * (np.angle(fine[1]) - np.angle(found[1])))
    return float(np.abs(turned - fine).max() / np.abs(fine).max())


def set_up(native: Native, start: dict[str, float]) -> float:
    """ms of processor time until a run may begin."""
    costs = []
    for _ in range(3):
        unit = FMU2Slave(
            guid=native.description.guid, unzipDirectory=str(native.directory), modelIdentifier="wire", instanceName="wire"
        )
        unit.instantiate()
        unit.setupExperiment(startTime=0.0)
        unit.setReal([native.index[n] for n in start], list(start.values()))
        begin = time.process_time()
        unit.enterInitializationMode()
        unit.exitInitializationMode()
        costs.append(1e3 * (time.process_time() - begin))
        unit.terminate()
        unit.freeInstance()
    return min(costs)


def hosted(native: Native, host: Path, start: dict[str, float], step: float, fine: Array) -> tuple[float, float]:
    """(error, cost) in the C host: the towpoint heaves from the start."""
    sines = {"velocity_heave": (AMPLITUDE * FREQUENCY, FREQUENCY)}
    count, wanted = round(HEAVE_STOP / step), ["reaction_surge", "reaction_heave", "tension_top", "body_heave"]
    rows = native.hosted(host, native.script(start, sines, wanted, step, count), "run").splitlines()
    table = np.array([[float.fromhex(x) for x in row.split()] for row in rows])
    keep = table[:, 0] > HEAVE_STOP - 5.0 + 1e-9
    cost = float(native.hosted(host, native.script(start, sines, wanted, step, count), "time", str(count))) / 1e3 / step
    return wrong(table[keep, 0], table[keep, 1:3], fine), cost + set_up(native, start) / LENGTH


def coupled(start: dict[str, float], step: float, flavour: Flavour, fine: Array) -> tuple[float, float]:
    """(error, cost) under the master, the ship's unit included."""
    text = "\n".join(f"{name} = {value!r}" for name, value in start.items())
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "benchmark.toml"
        path.write_text(SCENE.format(stop=LENGTH, amplitude=AMPLITUDE, ramp=HEAVE_RAMP, values=text, step=step))
        master, costs = Master(Scene.load(path), flavour=flavour), []
        for _ in range(3):
            begin = time.process_time()
            result = master.run()
            costs.append(time.process_time() - begin)
    if result.status != "done":
        raise SystemExit(result.message)
    keep = result.time > LENGTH - 5.0 + 1e-9
    force = np.array([result.columns[f"wire.reaction_{c}"][keep] for c in ("surge", "heave")]).T
    return wrong(result.time[keep], force, fine), 1e3 * min(costs) / LENGTH


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--no-moordyn", action="store_true")
    quick = parser.parse_args().no_moordyn
    times = [HEAVE_START + (HEAVE_STOP - HEAVE_START) * k / HEAVE_SAMPLES for k in range(HEAVE_SAMPLES + 1)]
    path = [0.0, SPEED, AMPLITUDE, FREQUENCY, HEAVE_RAMP]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        fine = heave_force(bare(build(folder), heave_wire(), (12, 6), (1e-7, 0.05, 4), path, times).rows)
        tests = ROOT / "tests/fmus/host"
        runtime = ROOT / "fmus/native/runtime"
        host = compiled(
            folder, "host", [tests / "host.c", tests / "fmu.c"], tests, runtime / "fmi2", runtime / "fmi3"
        )  # fmt: skip
        native, rows = Native("wire", folder), []
        if not quick:
            run = moordyn_tow.run(AMPLITUDE, 20, 2e-3, 0.01, 120.0, 5.0)
            rows.append(("MoorDyn, N = 20, dt 0.002", wrong(run.time, run.force, fine), 1e3 * run.cost))
        for mesh in MESHES:
            start, label = values(*mesh), f"{mesh[0]} of degree {mesh[1]}, tolerance {mesh[2]:g} m/s"
            for step in (0.1, 0.25):
                rows.append((f"C host, step {step:g} s, {label}", *hosted(native, host, start, step, fine)))
            for step in (0.1, 0.25):
                rows.append((f"master, native, step {step:g} s, {label}", *coupled(start, step, "native", fine)))
            rows.append((f"master, Python flavour, step 0.25 s, {label}", *coupled(start, 0.25, "python", fine)))
    print("### The unit `wire`, heave of 0.2 m\n\n| what | error of the pull | ms a simulated s | MoorDyn N = 20 over it |")
    print("|---|---|---|---|")
    for what, error, cost in rows:
        ratio = "" if quick else f"{rows[0][2] / cost:.3g}"
        print(f"| {what} | {error:.2g} | {cost:.3g} | {ratio} |")


if __name__ == "__main__":
    main()
