"""Error against time of the linear tow cable on one case, and cost against segments.

    OPENBLAS_NUM_THREADS=1 python benchmarks/cable.py

Case: ``moordyn_tow.py`` with 0.2 m of heave. Error: complex amplitude of the force on the towpoint at the driving
frequency, largest component, against the elastic frequency response. Time: milliseconds of processor time a simulated
second, one thread, the least of three where repeated; initialisation is not in it, MoorDyn's neither. All in one run: only
ratios mean something. The nonlinear wire is in ``wire.py``.
"""

from __future__ import annotations

import argparse
import math
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import moordyn_tow
import numpy as np
from moordyn_tow import FREQUENCY, SPEED, harmonic, tow_case

from towage.master.master import Master
from towage.models.cable.lumped.linear import StateSpace, tow_elastic
from towage.models.cable.lumped.reduction import reduce
from towage.models.cable.steady.perturbation import Excitation
from towage.models.cable.steady.response import respond
from towage.models.numeric.exact_step import exact_step
from towage.scene.scene import Scene

AMPLITUDE = 0.2
SCENE = """title = "benchmark"
stop_time = "{stop} s"
connections = ["ship.velocity -> tow.velocity_heave"]
[units.ship]
fmu = "ship"
[units.ship.parameters]
heave_amplitude = {amplitude}
heave_period = "5 s"
ramp_time = "10 s"
[units.tow]
fmu = "{fmu}"
[units.tow.parameters]
tow_speed = "{speed} m/s"
cable_weight = {weight}
loading_form = 1
loading_friction = 0.05
axial_stiffness = 4e6
body_added_mass_surge = 256.25
body_added_mass_heave = 256.25
body_weight_in_water = {net}
body_drag = {drag}
{own}
[coupling]
scheme = "extrapolate"
step = "{step} s"
error_estimate = false
"""


def exact() -> np.ndarray:
    """Amplitudes of the force of the towpoint on the cable for heave a sin(omega t) = Re(i a exp(-i omega t)), N a m."""
    return np.array(respond(tow_case(), FREQUENCY, Excitation(heave=1j)).towpoint_force)


def error(force: np.ndarray) -> float:
    """Relative, phase included, whichever of force and reaction is given."""
    wanted = exact()
    return float(min(np.abs(force - s * wanted).max() for s in (1.0, -1.0)) / np.abs(wanted).max())


def timed(call: Callable[[], float]) -> float:
    """Least of three of what ``call`` returns."""
    return min(call() for _ in range(3))


def linear(model: StateSpace, step: float) -> tuple[float, float]:
    """(error, ms a simulated second) of the exact step, bare."""
    operators = exact_step(model.a, model.b, step)
    periods, per = 24, round(5.0 / step)
    omega, a = FREQUENCY, AMPLITUDE

    def coefficients(t: float) -> np.ndarray:
        """Heave velocity and its derivatives over their factorials, as the step takes its inputs."""
        s, c = math.sin(omega * t), math.cos(omega * t)
        table = np.zeros((4, 4))
        table[:, 1] = a * omega * c, -a * omega**2 * s, -a * omega**3 * c / 2.0, a * omega**4 * s / 6.0
        return table

    inputs = [coefficients(k * step) for k in range(per)]
    x, rows = np.zeros(len(model.a)), []
    for k in range(periods * per):
        x = operators.advance(x, inputs[k % per])
        if k >= (periods - 1) * per:
            u = inputs[(k + 1) % per]
            rows.append(model.c[:2] @ x + model.d[:2] @ u[0] + model.e[:2] @ u[1])
    times = step * np.arange((periods - 1) * per + 1, periods * per + 1)
    force = np.array([harmonic(times, column) for column in np.array(rows).T]) / a

    def once() -> float:
        """ms a simulated second, of four periods."""
        state, count = np.zeros(len(model.a)), 4 * per
        begin = time.process_time()
        for k in range(count):
            u = inputs[k % per]
            state = operators.advance(state, u)
            model.c[:2] @ state + model.d[:2] @ u[0] + model.e[:2] @ u[1]
        return 1e3 * (time.process_time() - begin) / (count * step)

    return error(force), timed(once)


def coupled(fmu: str, own: str, step: float, stop: float) -> tuple[float, float]:
    """(error, ms a simulated second) through Python FMU and master."""
    tow = tow_case()
    text = SCENE.format(stop=stop, amplitude=AMPLITUDE, fmu=fmu, speed=SPEED, weight=tow.cable.weight,
                        net=tow.body.weight, drag=tow.body.drag, own=own, step=step)  # fmt: skip
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "benchmark.toml"
        path.write_text(text)
        scene = Scene.load(path)
        # the least of three; equal parameters are set up once in a process
        results = [Master(scene, flavour="python").run() for _ in range(3)]
    result = min(results, key=lambda r: r.statistics["cpu_s"])
    if result.status != "done":
        raise SystemExit(result.message)
    keep = result.time > stop - 5.0 + 1e-9
    force = [harmonic(result.time[keep], result.columns[f"tow.reaction_{c}"][keep]) for c in ("surge", "heave")]
    return error(np.array(force) / AMPLITUDE), 1e3 * result.statistics["cpu_s"] / stop


def moordyn(segments: int, inner: float, step: float) -> tuple[float, float]:
    """(error, ms a simulated second) of MoorDyn."""
    run = moordyn_tow.run(AMPLITUDE, segments, inner, step, 120.0, 5.0)
    return error(np.array([harmonic(run.time, run.force[:, c]) for c in (0, 1)]) / AMPLITUDE), 1e3 * run.cost


def main() -> None:
    """Print the tables as Markdown."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--no-moordyn", action="store_true")
    arguments = parser.parse_args()
    rows: list[tuple[str, float, float]] = []
    if not arguments.no_moordyn:
        for n, inner, step in ((10, 4e-3, 0.01), (20, 2e-3, 0.01), (20, 2e-3, 0.05)):
            rows.append((f"MoorDyn, N = {n}, dt {inner:g}, coupling {step:g} s", *moordyn(n, inner, step)))
    models = {n: tow_elastic(tow_case(), n) for n in (10, 20, 40)}
    for n, model in models.items():
        rows.append((f"linear full, N = {n}, {len(model.a)} states, step 0.1 s", *linear(model, 0.1)))
    for n, tolerance in ((20, 0.005), (40, 0.002)):
        small = reduce(models[n], tolerance, 2.0, True, 2).model
        for step in (0.1, 0.5):
            rows.append((f"linear reduced, N = {n}, {len(small.a)} states, step {step:g} s", *linear(small, step)))
    for step in (0.1, 0.5):
        rows.append((f"linear reduced, N = 40, FMU and master, step {step:g} s",
                     *coupled("tow_system", "extensible = 1\nsegments = 40\ntolerance = 0.005", step, 120.0)))  # fmt: skip
    reference = next(
        (cost for name, _, cost in rows if name.startswith("MoorDyn, N = 20, dt 0.002, coupling 0.01")), None
    )
    print("| model | error | ms per simulated s | MoorDyn N = 20 over it |\n|---|---|---|---|")
    for name, wrong, cost in rows:
        ratio = f"{reference / cost:.3g}" if reference else ""
        print(f"| {name} | {wrong:.2g} | {cost:.3g} | {ratio} |")
    counts, costs = (10, 20, 40, 80, 160), []
    for n in counts:
        costs.append(linear(tow_elastic(tow_case(), n), 0.1)[1])
    exponent = np.polyfit(np.log(counts[1:]), np.log(costs[1:]), 1)[0]
    print("\n| segments (linear full, bare) | ms per simulated s |\n|---|---|")
    for n, cost in zip(counts, costs):
        print(f"| {n} | {cost:.3g} |")
    print(f"\nCost goes with segments to the power {exponent:.2f} (20 to 160).")


if __name__ == "__main__":
    main()
