"""Speed against error of the coupling: every scheme on the thesis's taut, slack and two-way problems, and the cost of a
communication step beside the same raw FMI calls and beside libcosim. Prints Markdown; ``python benchmarks/coupling.py``.

Times on a shared machine mean little: read the ratios, which are taken in one run.
"""

from __future__ import annotations

import math
import sys
import tempfile
import time
from collections.abc import Callable
from ctypes import addressof, c_double
from importlib.util import find_spec
from pathlib import Path

import numpy as np
from msgspec.structs import replace

from towage.errors import RunError
from towage.fmus.declare.unit import load
from towage.fmus.python.instance import Instance
from towage.master.master import Master
from towage.master.recorder import Recorder
from towage.master.schemes import JACOBI
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
        unit = None
        rows = []
        for scheme in reversed(SCHEMES.own):
            errors, costs = [], []
            for steps in STEPS:
                master = Master(problem(case, scheme, steps))
                result = master.run()
                heave, _ = solve(master.resolved, result.time)
                errors.append(float(np.max(np.abs(result["cradle.heave"] - heave)) / np.max(np.abs(heave))))
                costs.append(result.statistics["cpu_s"])
            unit = unit or (costs[0] if scheme == "jacobi" else None)
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
            master = Master(scene)
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
            found = [growth(scheme, ratio, product) for product in products]
            cells = " | ".join("fails" if g is None else f"{g:+.4f}" for g in found)
            print(f"| {scheme} | {ratio:g} | {cells} |")


def _best(runs: list[Callable[[], float]], repeats: int = 15) -> list[float]:
    """Smallest of several results of each, taken in turns: the least disturbed, on equal terms."""
    return [min(column) for column in zip(*([run() for run in runs] for _ in range(repeats)))]


def step_cost(steps: int = 500, size: float = 0.01) -> None:
    """us per communication step of ship, spring_line and cradle with zero-order hold, as ratios."""
    scene = dimensionless_scene(
        DRAG, RATIO, 10.0, periods=steps * size / (2.0 * math.pi), coupling={"scheme": "jacobi", "step": size},
        cradle={"integration_tolerance": 1e-8},
    )  # fmt: skip
    scene = replace(scene, record=replace(scene.record, variables=("ship.heave", "line.tension", "cradle.heave")))
    resolved = described(scene, locator())
    with tempfile.TemporaryDirectory() as directory:

        def started() -> System:
            system = System(resolved, Path(directory), held=True)
            system.start(0.0, 1e9)
            return system

        def master() -> float:
            system = started()
            recorder = Recorder([f"{u.name}.{o}" for u in system.units for o in u.outputs])
            settings = Settings(JACOBI, size, None, size, False, size, steps * size)
            run = simulate(system, settings, recorder)
            system.close()
            return run.wall / steps * 1e6

        def inputs() -> list[list[list[float]]]:
            """What the master sets on each unit at each step."""
            system = started()
            sent = []
            for k in range(steps):
                JACOBI.step(system, k * size, size)
                sent.append([unit.input_buffer[:] for unit in system.units])
                system.accept(size)
            system.close()
            return sent

        sent = inputs()

        def raw() -> float:
            system = started()
            calls = []
            for i, unit in enumerate(system.units):
                buffers = [(c_double * len(row[i]))(*row[i]) for row in sent]
                references, count, _ = unit.wiring.set_values or (0, 0, 0)
                instance = unit.instance
                calls.append((
                    instance.component, instance.set_real, references, count, [addressof(b) for b in buffers], buffers,
                    instance.do_step, instance.get_real, unit.wiring.get_values,
                ))  # fmt: skip
            begin = time.perf_counter()
            for k in range(steps):
                t = k * size
                for component, set_real, inputs, count, addresses, _, do_step, get_real, outputs in calls:
                    if count:
                        set_real(component, inputs, count, addresses[k])
                    do_step(component, t, size, 0)
                    get_real(component, *outputs)
            cost = (time.perf_counter() - begin) / steps * 1e6
            system.close()
            return cost

        def model() -> float:
            instances = []
            for name, unit in resolved.units.items():
                declared = load(unit.description.model_name)
                instance = Instance(declared)
                instance.set_values([declared.index[n] for n in unit.parameters], list(unit.parameters.values()))
                instance.set_up(0.0, None)
                instance.enter_initialization()
                instance.exit_initialization()
                targets = [c.target for c in resolved.connections if c.target_unit == name]
                references = [declared.index[n] for n in targets]
                instances.append((instance, references))
            begin = time.perf_counter()
            for k in range(steps):
                for (instance, references), values in zip(instances, sent[k]):
                    if references:
                        instance.set_values(references, values)
                    instance.do_step(k * size, size)
            return (time.perf_counter() - begin) / steps * 1e6

        def cosim() -> float:
            from libcosimpy.CosimExecution import CosimExecution
            from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
            from libcosimpy.CosimSlave import CosimLocalSlave

            log_output_level(CosimLogLevel.WARNING)
            execution = CosimExecution.from_step_size(int(size * 1e9))
            index, references = {}, {}
            for name, unit in resolved.units.items():
                index[name] = execution.add_local_slave(CosimLocalSlave(str(unit.path), name))
                references[name] = {v.name: v.value_reference for v in unit.description.variables}
                for parameter, value in unit.parameters.items():
                    execution.real_initial_value(index[name], references[name][parameter], float(value))
            for c in resolved.connections:
                execution.connect_real_variables(
                    index[c.source_unit], references[c.source_unit][c.source],
                    index[c.target_unit], references[c.target_unit][c.target],
                )  # fmt: skip
            execution.step(1)
            begin = time.perf_counter()
            execution.step(steps)
            return (time.perf_counter() - begin) / steps * 1e6

        peers = [cosim] if find_spec("libcosimpy") else []
        floor, ours, bare, *theirs = _best([raw, master, model, *peers])
        print("\n## Cost of a communication step\n")
        print(f"Ship, spring_line and cradle, zero-order hold, the best of 15 runs of {steps} steps each, in turns.\n")
        print("| what | us | over raw FMI calls |\n|---|---|---|")
        print(f"| the models alone, in Python | {bare:.1f} | {bare / floor:.2f} |")
        print(f"| raw FMI calls, nothing around them | {floor:.1f} | 1 |")
        print(f"| towage master, `jacobi`, recording | {ours:.1f} | {ours / floor:.2f} |")
        for cost in theirs:
            print(f"| libcosim through libcosimpy | {cost:.1f} | {cost / floor:.2f} |")
            print(f"\nThe master takes {ours / cost:.2f} of libcosim's time on the same three FMUs.")
        if not theirs:
            print("\nlibcosimpy is not installed: no comparison with libcosim.")


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
