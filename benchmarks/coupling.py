"""Speed against error of the coupling: every scheme on the thesis's taut, slack and two-way problems, and the cost of a
communication step beside the same raw FMI calls and beside libcosim. Prints Markdown; ``python benchmarks/coupling.py``.

Times on a shared machine mean little: read the ratios, which are taken in one run.
"""

from __future__ import annotations

import math
import sys
import tempfile
from pathlib import Path

import numpy as np
from msgspec.structs import replace
from step_cost import step_cost

from towage.errors import RunError
from towage.master.master import Master
from towage.master.recorder import Recorder
from towage.master.simulation import Settings, simulate
from towage.master.system import System
from towage.models.heave import orbits
from towage.registry import SCHEMES
from towage.scene.resolve import described
from towage.scene.scene import Scene
from towage.units.store import locator
from towage.verify.cradle import dimensionless_system
from towage.verify.monolithic import dimensionless_scene, solve

STEPS = (16, 32, 64, 128)
DRAG, RATIO = 0.3, 1.0


def problem(case: str, scheme: str, steps: int) -> Scene:
    """taut: w = 10; slack: w = 1.6, from the exact orbit, 8 periods; two-way: mass ratio 1, from rest, 40 units."""
    if case == "two-way":
        period = 2.0 * math.pi / 1.1
        return dimensionless_scene(
            DRAG, 1.1, 8.0, periods=40.0 / period, steps=steps, coupling={"scheme": scheme},
            ship={"mass": 1.0, "stiffness": 2.25, "damping": 0.15},
        )  # fmt: skip
    weight = 10.0 if case == "taut" else 1.6
    orbit = orbits.steady(dimensionless_system(DRAG, RATIO, None if case == "taut" else weight))
    return dimensionless_scene(
        DRAG, RATIO, weight, start=(orbit.state[0], orbit.state[1]), steps=steps, coupling={"scheme": scheme}
    )


def work_precision() -> None:
    """Largest error of the cradle's heave relative to its largest value, and the CPU time of the run."""
    print("## Error against cost\n")
    print(
        "Error of the heave against the monolithic solution; cost in CPU time of one `jacobi` run at 16 steps a period."
    )
    for case in ("taut", "slack", "two-way"):
        print(f"\n### {case}\n")
        print("| scheme | " + " | ".join(f"{n} steps" for n in STEPS) + " | order | cost |")
        print("|---|" + "---|" * (len(STEPS) + 2))
        rows = []
        for scheme in reversed(SCHEMES.own):
            errors, costs = [], []
            for steps in STEPS:
                master = Master(problem(case, scheme, steps), flavour="python")
                result = master.run()
                heave, _ = solve(master.resolved, result.time)
                errors.append(float(np.max(np.abs(result["cradle.heave"] - heave)) / np.max(np.abs(heave))))
                costs.append(result.statistics["cpu_s"])
            order = math.log2(errors[1] / errors[3]) / 2.0
            rows.append((scheme, errors, order, costs))
        base = next(costs[0] for scheme, _, _, costs in rows if scheme == "jacobi")
        for scheme, errors, order, costs in reversed(rows):
            cost = " / ".join(f"{c / base:.1f}" for c in costs)
            print(f"| {scheme} | " + " | ".join(f"{e:.1e}" for e in errors) + f" | {order:.2f} | {cost} |")


def error_control() -> None:
    """Achieved error against the tolerance asked for."""
    print("\n## Error control\n\n| case | tolerance | error | steps | tried again |\n|---|---|---|---|---|")
    for case in ("taut", "slack"):
        for tolerance in (1e-3, 1e-4, 1e-5, 1e-6):
            scene = problem(case, "hermite", 32)
            scene = replace(
                scene,
                coupling=replace(scene.coupling, step=None, tolerance=tolerance),
                record=replace(scene.record, interval=2.0 * math.pi),
            )
            master = Master(scene, flavour="python")
            result = master.run()
            heave, _ = solve(master.resolved, result.time)
            error = float(np.max(np.abs(result["cradle.heave"] - heave)) / np.max(np.abs(heave)))
            s = result.statistics
            print(f"| {case} | {tolerance:g} | {error:.1e} | {s['steps']:.0f} | {s['rejected']:.0f} |")


def growth(scheme: str, ratio: float, product: float, steps: int = 400) -> float | None:
    """Growth of the undamped two-way loop's energy per radian at H w = ``product``, mass ratio ``ratio``, natural
    frequencies 1 : 2.039; None if the run fails."""
    mass = 1.0 / ratio
    stiffness = 2.039**2 * mass
    frequency = math.sqrt(1.0 + ratio)
    scene = dimensionless_scene(
        0.0,
        1.0,
        1e4,
        start=(1.0, 0.0),
        periods=steps * product / frequency / (2.0 * math.pi),
        coupling={"scheme": scheme, "step": product / frequency, "events": False},
        ship={"heave_amplitude": 0.0, "mass": mass, "stiffness": stiffness},
    )
    size = product / frequency
    settings = Settings(SCHEMES.get(scheme), size, None, size, False, size, scene.stop_time)
    with tempfile.TemporaryDirectory() as directory:
        system = System(described(scene, locator()), Path(directory))
        system.start(0.0, scene.stop_time)
        recorder = Recorder([f"{u.name}.{o}" for u in system.units for o in u.outputs])
        try:
            simulate(system, settings, recorder)  # no check before the run: what is measured is what its limits rest on
        except RunError:
            return None
        finally:
            system.close()
    columns = recorder.columns()[1]
    x, y = columns["ship.heave"], columns["cradle.heave"]
    energy = columns["cradle.velocity"] ** 2 + mass * columns["ship.velocity"] ** 2 + stiffness * x**2 + (x - y) ** 2
    return float(np.log(energy[-100:].mean() / energy[:100].mean()) / (0.75 * steps * product))


def stability() -> None:
    """Where the loop begins to grow by itself: what the limits of ``towage/master/schemes.py`` rest on."""
    products = (0.5, 0.8, 1.2, 1.6, 1.9, 2.4)
    print(
        "\n## Stability of the two-way loop\n\nGrowth of the energy per radian of the undamped loop (negative: damped).\n"
    )
    print("| scheme | mass ratio | " + " | ".join(f"H w = {p:g}" for p in products) + " |")
    print("|---|---|" + "---|" * len(products))
    for scheme in (name for name in SCHEMES.own if SCHEMES.get(name).limits):
        for ratio in (0.0578, 0.3, 1.0, 10.0, 100.0):
            rates = [growth(scheme, ratio, product) for product in products]
            cells = " | ".join("fails" if g is None else f"{g:+.4f}" for g in rates)
            print(f"| {scheme} | {ratio:g} | {cells} |")


if __name__ == "__main__":
    chosen = sys.argv[1:] or ["precision", "control", "stability", "step"]
    if "precision" in chosen:
        work_precision()
    if "control" in chosen:
        error_control()
    if "stability" in chosen:
        stability()
    if "step" in chosen:
        step_cost()
