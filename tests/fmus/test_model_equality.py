"""An FMU equals the functions of its model to the last bit, and always runs its own code."""

from __future__ import annotations

import json
import random
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from towage.fmus.declare.unit import Unit, load
from towage.fmus.python.instance import Instance
from towage.models.numeric.integrate import integrate
from towage.models.numeric.ops import FLOATS

from .conftest import UNITS, Program

Job = dict[str, Any]
ROOT = Path(__file__).resolve().parents[2]
STARTS: dict[str, dict[str, float]] = {
    "ship": {"mass": 8e5, "damping": 1e5, "stiffness": 2e6, "ramp_time": 4.0, "heave_phase": 0.3},
    "spring_line": {"stiffness": 1e4, "static_tension": 2e4, "length": 30.0, "breaking_load": 2e5, "wave_speed": 900.0},
    "cradle": {"mass": 5e3, "drag_area": 10.0, "weight_in_water": 2e4, "docking_time": 3.0, "submersible_mass": 8e3},
    "cradle_on_line": {
        "stiffness": 1e4, "mass": 5e3, "drag_area": 10.0, "weight_in_water": 2e4, "docking_time": 3.0,
        "submersible_mass": 8e3, "docked_drag_area": 15.0, "length": 30.0, "wave_speed": 900.0,
    },
}  # fmt: skip
SIZES = {"reaction": 5e4, "heave_top": 4.0, "heave_bottom": 4.0, "line_tension": 3e4, "submersible_velocity": 0.5}


def random_job(unit: str, seed: int, start: dict[str, float] | None = None, steps: int = 40) -> Job:
    """A run with random steps and cubics, slack and docking included; every fourth input is held."""
    rng, time, rows = random.Random(seed), 0.0, []
    inputs = [v.name for v in load(unit).inputs]
    for _ in range(steps):
        held = rng.random() < 0.25
        values = {
            f"{name}{suffix}": 0.0 if held and suffix else SIZES[name] * rng.uniform(-1.0, 1.0)
            for name in inputs
            for suffix in ("", "_d1", "_d2", "_d3")
        }
        size = rng.choice([0.001, 0.02, 0.1, 0.5])
        rows.append((time, size, values, rng.random() < 0.5))
        time += size
    return {"unit": unit, "start": STARTS[unit] | (start or {}), "steps": rows}


JOBS = [random_job(unit, seed) for seed in range(3) for unit in UNITS] + [
    random_job(unit, 3, {"freeze_branches": 1.0}) for unit in ("spring_line", "cradle_on_line")
]


def by_instance(job: Job) -> list[list[str]]:
    """The job through `Instance`."""
    unit = load(job["unit"])
    it, seen = Instance(unit), []
    observed = [unit.index[v.name] for v in unit.observed]
    it.set_values([unit.index[n] for n in job["start"]], list(job["start"].values()))
    it.enter_initialization()
    it.exit_initialization()
    for time, size, inputs, read in job["steps"]:
        it.set_values([unit.index[n] for n in inputs], list(inputs.values()))
        if read:
            seen.append([v.hex() for v in it.get_values(observed)])
        it.do_step(time, size)
        seen.append([v.hex() for v in it.get_values(observed)])
    return seen


def by_model(job: Job) -> list[list[str]]:
    """The job through nothing but the functions of the model and the integrator."""
    unit: Unit = load(job["unit"])
    model: Any = unit.model
    values = {v.name: v.start for v in unit.parameters} | job["start"]
    p = model.Parameters(**{v.name: values[v.name] for v in unit.parameters})
    x, m = model.initial(p, FLOATS)
    names, seen, first_step = [v.name for v in unit.inputs], [], 0.0

    inputs_of, state_of = model.Inputs._make, model.State._make

    def outputs(t: float, u: list[float], du: list[float]) -> None:
        seen.append([float(v).hex() for v in model.outputs(t, x, m, inputs_of(u), inputs_of(du), p, FLOATS)])

    def change(t: float, u: list[float]) -> None:
        nonlocal x, m
        if model.transition:
            x, m = model.transition(t, x, m, inputs_of(u), p, FLOATS)

    # the start is a communication point with all inputs zero
    change(0.0, [0.0] * len(names))
    for time, size, inputs, read in job["steps"]:
        c = [(inputs[n], inputs[f"{n}_d1"], 0.5 * inputs[f"{n}_d2"], inputs[f"{n}_d3"] / 6.0) for n in names]

        def at(s: float, c: list[Any] = c) -> list[float]:
            return [a0 + s * (a1 + s * (a2 + s * a3)) for a0, a1, a2, a3 in c]

        change(time, at(0.0))
        if read:
            outputs(time, at(0.0), [a[1] for a in c])
        if model.advance:
            x = model.advance(time, size, x, m, inputs_of(c), p, FLOATS)
        elif len(x):
            stops = [size]
            if model.next_event_time:
                due = model.next_event_time(time, m, p, FLOATS) - time
                stops = [due, size] if 0.0 < due < size else [size]
            begin = 0.0
            for end in stops:

                def event(s: float, y: Any, time: float = time, at: Any = at) -> Any:
                    nonlocal m
                    if not values.get("freeze_branches"):
                        y, m = model.transition(time + s, state_of(y), m, inputs_of(at(s)), p, FLOATS)
                    return tuple(y)

                x, first_step = integrate(
                    lambda s, y, time=time, at=at: model.derivatives(
                        time + s, state_of(y), m, inputs_of(at(s)), p, FLOATS
                    ),
                    begin, tuple(x), end, rtol=1e-8, atol=(1e-8,) * len(x), on_event=event, first_step=first_step,
                    indicators=lambda s, y, time=time, at=at: model.indicators(
                        time + s, state_of(y), m, inputs_of(at(s)), p, FLOATS
                    ),
                )  # fmt: skip
                x = state_of(x)
                if end < size:
                    change(values["docking_time"], at(end))
                begin = end
        outputs(time + size, at(size), [a1 + size * (2.0 * a2 + size * 3.0 * a3) for _, a1, a2, a3 in c])
    return seen


def test_consistency_of_the_fmu_with_the_model(fmus: Path, program: Program, tmp_path: Path) -> None:
    """Every output of every step: FMU = Instance = functions of the model."""
    answers = json.loads(program("play", tmp_path, fmus, stdin=json.dumps(JOBS)))
    branches: dict[str, set[float]] = {"taut": set(), "docked": set()}
    for job, (by_fmu,) in zip(JOBS, answers, strict=True):
        names = [v.name for v in load(job["unit"]).observed]
        for step, (a, b, c) in enumerate(zip(by_fmu, by_instance(job), by_model(job), strict=True)):
            differing = [(n, *row) for n, *row in zip(names, a, b, c) if len(set(row)) > 1]
            assert not differing, (job["unit"], step, differing)
            for name in branches.keys() & set(names):
                branches[name].add(float.fromhex(a[names.index(name)]))
    assert branches == {"taut": {0.0, 1.0}, "docked": {0.0, 1.0}}, "the runs did not meet all branches"


@pytest.fixture(scope="module")
def variant(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """FMUs of the same names from sources with other physics."""
    root = tmp_path_factory.mktemp("variant")
    for folder in ("models", "fmus"):
        shutil.copytree(ROOT / folder, root / "towage" / folder, ignore=shutil.ignore_patterns("__pycache__"))
    (root / "towage" / "__init__.py").touch()
    for module, old, new in (
        ("ship", "velocity = rate + z_rate", "velocity = 2.0 * (rate + z_rate)"),
        ("spring_line", "return static_tension / k + heave_top", "return 1.0 + static_tension / k + heave_top"),
        ("cradle", "return 0.5 * p.water_density", "return 0.75 * p.water_density"),
    ):
        file = root / "towage" / "models" / "heave" / f"{module}.py"
        text = file.read_text()
        assert text.count(old) == 1
        file.write_text(text.replace(old, new))
    command = (
        f"import sys, pathlib; sys.path.insert(0, {str(root)!r}); from towage.fmus.python.build import build\n"
        f"for name in {UNITS!r}: build(name, pathlib.Path({str(root / 'other')!r}))"
    )
    subprocess.run([sys.executable, "-I", "-c", command], check=True, cwd=root, timeout=60)
    return root / "other"


def test_two_versions_in_one_process_each_run_their_own_code(
    fmus: Path, variant: Path, program: Program, tmp_path: Path
) -> None:
    """Together, in both orders, and in a host that has imported the work tree, each gives what it gives alone."""
    jobs = [random_job(unit, 7, steps=12) for unit in UNITS]
    text = json.dumps(jobs)
    own = [a for (a,) in json.loads(program("play", tmp_path / "1", fmus, stdin=text))]
    other = [a for (a,) in json.loads(program("play", tmp_path / "2", variant, stdin=text))]
    for job, a, b in zip(jobs, own, other):
        assert a != b, f"the two versions of {job['unit']} do not differ: nothing would be tested"
    both = json.loads(program("play", tmp_path / "3", fmus, variant, stdin=text))
    assert both == [[a, b] for a, b in zip(own, other)]
    both = json.loads(program("play", tmp_path / "4", variant, fmus, stdin=text))
    assert both == [[b, a] for a, b in zip(own, other)]
    imported = json.loads(program("play", tmp_path / "5", variant, "--import", ROOT, stdin=text))
    assert imported == [[b] for b in other]


def test_states_of_another_version_are_refused(fmus: Path, variant: Path, program: Program, tmp_path: Path) -> None:
    assert program("foreign", tmp_path, fmus / "ship.fmu", variant / "ship.fmu").strip() == "refused"
