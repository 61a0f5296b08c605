"""What a communication step of ship, spring_line and cradle costs: the master, the same raw FMI calls, the models alone,
and libcosim. Zero-order hold, so that all set and get the same values. A part of ``python benchmarks/coupling.py``.
"""

from __future__ import annotations

import math
import tempfile
import time
from collections.abc import Callable
from ctypes import addressof, c_double
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

from msgspec.structs import replace

from towage.fmus.declare.unit import load
from towage.fmus.python.instance import Instance
from towage.master.recorder import Recorder
from towage.master.schemes import JACOBI
from towage.master.simulation import Settings, simulate
from towage.master.system import System
from towage.scene.resolve import ResolvedScene, described
from towage.units.store import locator
from towage.verify.monolithic import dimensionless_scene

REPEATS = 15
Sent = list[list[list[float]]]
"""What the master sets: by step and unit, the values of its inputs."""


@dataclass(frozen=True)
class Coupled:
    """Three units, coupled for ``steps`` steps of ``size`` s. Every method is one way to step them: us a step."""

    scene: ResolvedScene
    directory: Path
    steps: int
    size: float

    def started(self) -> System:
        """The units, initialised."""
        system = System(self.scene, self.directory, held=True)
        system.start(0.0, 1e9)
        return system

    def master(self) -> float:
        """The master, which also records."""
        system = self.started()
        recorder = Recorder([f"{u.name}.{o}" for u in system.units for o in u.outputs])
        settings = Settings(JACOBI, self.size, None, self.size, False, self.size, self.steps * self.size)
        run = simulate(system, settings, recorder)
        system.close()
        return run.wall / self.steps * 1e6

    def sent(self) -> Sent:
        """What the master sets on each unit at each step."""
        system = self.started()
        values = []
        for k in range(self.steps):
            JACOBI.step(system, k * self.size, self.size)
            values.append([unit.input_buffer[:] for unit in system.units])
            system.accept(self.size)
        system.close()
        return values

    def raw_calls(self, sent: Sent) -> float:
        """The FMI calls of a step with the same values, and nothing around them."""
        system = self.started()
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
        for k in range(self.steps):
            t = k * self.size
            for component, set_real, inputs, count, addresses, _, do_step, get_real, outputs in calls:
                if count:
                    set_real(component, inputs, count, addresses[k])
                do_step(component, t, self.size, 0)
                get_real(component, *outputs)
        cost = (time.perf_counter() - begin) / self.steps * 1e6
        system.close()
        return cost

    def models(self, sent: Sent) -> float:
        """The models in Python, without FMI."""
        instances = []
        for name, unit in self.scene.units.items():
            declared = load(unit.description.model_name)
            instance = Instance(declared)
            instance.set_values([declared.index[n] for n in unit.parameters], list(unit.parameters.values()))
            instance.set_up(0.0, None)
            instance.enter_initialization()
            instance.exit_initialization()
            targets = [c.target for c in self.scene.connections if c.target_unit == name]
            instances.append((instance, [declared.index[n] for n in targets]))
        begin = time.perf_counter()
        for k in range(self.steps):
            for (instance, references), values in zip(instances, sent[k]):
                if references:
                    instance.set_values(references, values)
                instance.do_step(k * self.size, self.size)
        return (time.perf_counter() - begin) / self.steps * 1e6

    def libcosim(self) -> float:
        """libcosim through its Python bindings."""
        from libcosimpy.CosimExecution import CosimExecution
        from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
        from libcosimpy.CosimSlave import CosimLocalSlave

        log_output_level(CosimLogLevel.WARNING)
        execution = CosimExecution.from_step_size(int(self.size * 1e9))
        index, references = {}, {}
        for name, unit in self.scene.units.items():
            index[name] = execution.add_local_slave(CosimLocalSlave(str(unit.path), name))
            references[name] = {v.name: v.value_reference for v in unit.description.variables}
            for parameter, value in unit.parameters.items():
                execution.real_initial_value(index[name], references[name][parameter], float(value))
        for c in self.scene.connections:
            execution.connect_real_variables(
                index[c.source_unit], references[c.source_unit][c.source],
                index[c.target_unit], references[c.target_unit][c.target],
            )  # fmt: skip
        execution.step(1)
        begin = time.perf_counter()
        execution.step(self.steps)
        return (time.perf_counter() - begin) / self.steps * 1e6


def best(ways: list[Callable[[], float]]) -> list[float]:
    """Smallest of `REPEATS` results of each, taken in turns: the least disturbed, on equal terms."""
    return [min(column) for column in zip(*([way() for way in ways] for _ in range(REPEATS)))]


def step_cost(steps: int = 500, size: float = 0.01) -> None:
    """us per communication step, and over the raw calls."""
    scene = dimensionless_scene(
        0.3, 1.0, 10.0, periods=steps * size / (2.0 * math.pi), coupling={"scheme": "jacobi", "step": size},
        cradle={"integration_tolerance": 1e-8},
    )  # fmt: skip
    scene = replace(scene, record=replace(scene.record, variables=("ship.heave", "line.tension", "cradle.heave")))
    with tempfile.TemporaryDirectory() as directory:
        coupled = Coupled(described(scene, locator()), Path(directory), steps, size)
        sent = coupled.sent()
        peers = [coupled.libcosim] if find_spec("libcosimpy") else []
        floor, ours, alone, *theirs = best(
            [lambda: coupled.raw_calls(sent), coupled.master, lambda: coupled.models(sent), *peers]
        )
    print("\n## Cost of a communication step\n")
    print(f"Ship, spring_line and cradle, zero-order hold, the best of {REPEATS} runs of {steps} steps each, in turns.\n")
    print("| what | us | over raw FMI calls |\n|---|---|---|")
    print(f"| the models alone, in Python | {alone:.1f} | {alone / floor:.2f} |")
    print(f"| raw FMI calls, nothing around them | {floor:.1f} | 1 |")
    print(f"| towage master, `jacobi`, recording | {ours:.1f} | {ours / floor:.2f} |")
    for cost in theirs:
        print(f"| libcosim through libcosimpy | {cost:.1f} | {cost / floor:.2f} |")
        print(f"\nThe master takes {ours / cost:.2f} of libcosim's time on the same three FMUs.")
    if not theirs:
        print("\nlibcosimpy is not installed: no comparison with libcosim.")
