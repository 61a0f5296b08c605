"""The towed slender body by CasADi: its set-up and functions give what numpy and floats give; the C text stays small."""

from __future__ import annotations

import math
import random
from dataclasses import fields
from typing import Any

import numpy as np
import pytest

from towage.fmus.slender_body import UNIT
from towage.models.numeric.matrix_ops import numbers, traces
from towage.models.numeric.ops import FLOATS, symbols
from towage.models.protocol.linear_model import NoOwn
from towage.models.slender import body as slender_body
from towage.models.slender.body import Parameters, Size
from towage.models.slender.setup import Constants, Undamped, assemble, system_of

casadi = pytest.importorskip("casadi")
BASE = {v.name: float(v.start or 0.0) for v in UNIT.parameters}
SIZES = [Size(1.0, 14.0), Size(0.0, 14.0), Undamped(1.0, 20.0)]


def random_body(seed: int) -> dict[str, float]:
    """Parameters of a body: near-spherical and long ends, every theory, light and heavy."""
    rng = random.Random(seed)
    diameter = rng.uniform(0.1, 0.5)
    length = diameter * rng.uniform(20.0, 60.0)
    fluid = BASE["water_density"] * 0.25 * math.pi * diameter**2
    return BASE | {
        "length": length, "diameter": diameter, "end_length": diameter * rng.choice([0.5001, 0.55, 0.6, 3.0]),
        "tail_cut": rng.uniform(0.05, 1.0), "rope_length": length * 10.0 ** rng.uniform(-0.5, 1.0),
        "bending_stiffness": 10.0 ** rng.uniform(3.0, 5.0), "friction_coefficient": rng.uniform(0.005, 0.04),
        "normal_drag_coefficient": rng.uniform(0.0, 0.02), "structural_damping": rng.choice([0.0, 1.0]),
        "mass_per_length": rng.choice([0.0, fluid * rng.uniform(0.5, 2.0)]), "theory": float(seed % 3),
        "nose_factor": 0.8, "tail_factor": 0.6, "nose_drag": 0.05, "fast_mode_damping": rng.uniform(0.0, 0.1),
        "yaw_start": 0.01, "lateral_start": 0.2,
    }  # fmt: skip


def symbolic(symbol: Any, **known: float) -> Any:
    return Parameters(**{f.name: known.get(f.name, symbol[i]) for i, f in enumerate(fields(Parameters))})


def parts(found: Any) -> list[Any]:
    return [*found.a, *found.b, found.c, found.d, found.e]


def set_up(size: Size) -> Any:
    p = casadi.MX.sym("p", len(BASE))
    found = slender_body.setup(symbolic(p), size, traces())
    return casadi.Function("setup", [p], [*map(casadi.densify, parts(found)), casadi.vertcat(*found.constants)])


@pytest.mark.parametrize("size", SIZES)
def test_set_up_by_casadi_is_that_of_numpy(size: Size) -> None:
    """20 bodies. Relative to each matrix's largest entry; measured 6e-15, 1e-15 and 2e-14."""
    function = set_up(size)
    for seed in range(20):
        values = random_body(seed)
        p = Parameters(**values)
        exact = assemble(p, system_of(p, size, numbers()), numbers())
        found = [np.array(each) for each in function(list(values.values()))]
        for one, other in zip(found, [*parts(exact), np.array(exact.constants)[:, None]], strict=True):
            assert one.shape == other.shape
            assert np.max(np.abs(one - other)) <= 1e-12 * np.max(np.abs(other))


@pytest.mark.parametrize("size", SIZES)
def test_generated_text_stays_small(size: Size) -> None:
    """What a compiler has to read: 0.31, 0.16 and 0.30 MB."""
    generator = casadi.CodeGenerator("setup.c")
    generator.add(set_up(size))
    assert len(generator.dump()) < 1_000_000


@pytest.mark.parametrize("size", SIZES[:2])
def test_functions_by_casadi_are_those_of_floats(size: Size) -> None:
    """Scalars, every theory; 1e-12: CasADi reorders sums."""
    structure = size._asdict()
    p, c, v = casadi.SX.sym("p", len(BASE)), casadi.SX.sym("c", 9), casadi.SX.sym("v", 61)
    rng = random.Random(0)

    def every(p: Any, c: Any, v: Any, ops: Any) -> list[Any]:
        own = NoOwn()
        u, du = slender_body.Inputs(*v[:2]), slender_body.Inputs(*v[2:4])
        cubics, y, rate = slender_body.Inputs(v[4:8], v[8:12]), v[4:32], v[32:60]
        observed, extras = slender_body.observe(0.0, own, y, rate, u, du, v[60], p, c, ops)
        z, own_start = slender_body.start(p, c, ops)
        w, w_rate, w_second = slender_body.core(own, u, du, p, c, ops)
        return [
            *observed, *z, *own_start, *extras, *w, *w_rate, *w_second, *slender_body.describe(p, c, ops),
            slender_body.schedule(u, p, c, ops), *slender_body.drive(own, cubics, p, c, ops)[0],
            *(value for value, _ in slender_body.requirements(p, ops)),
        ]  # fmt: skip

    components = tuple(v[i] for i in range(61))
    constants = Constants(*(c[i] for i in range(9)))
    traced = every(symbolic(p, **structure), constants, components, symbols())
    function = casadi.Function("f", [p, c, v], [casadi.vertcat(*traced)])
    for seed in range(6):
        values = random_body(seed) | structure
        made = Parameters(**values)
        known = slender_body.setup(made, size, numbers()).constants._replace(resolved=8.0)
        numbers_in = [abs(rng.gauss(0.0, 1.0)) for _ in range(61)]
        numbers_in[0] *= seed % 2  # at rest, too
        exact = every(made, known, tuple(numbers_in), FLOATS)
        found = np.array(function(list(values.values()), list(known), numbers_in)).ravel()
        assert found.tolist() == pytest.approx(exact, rel=1e-12, abs=1e-12)


def test_requirements_of_impossible_bodies() -> None:
    """Traced or not, the same ones fail; nothing but numbers comes out of what makes no sense."""
    p = casadi.SX.sym("p", len(BASE))
    function = casadi.Function(
        "f", [p], [casadi.vertcat(*(value for value, _ in slender_body.requirements(symbolic(p), symbols())))]
    )
    bad: list[dict[str, float]] = [
        {}, {"length": 0.0}, {"length": math.nan}, {"diameter": math.inf}, {"end_length": 0.12}, {"end_length": -1.0},
        {"tail_cut": 1.5}, {"tail_cut": 0.0}, {"theory": 0.5}, {"mass_per_length": -300.0}, {"shape_functions": 4.5},
        {"friction_coefficient": -0.1}, {"water_density": 1e-200}, {"theory": 2.0, "tail_factor": 3.0},
    ]  # fmt: skip
    for change in bad:
        values = BASE | change
        exact = [value > 0.0 for value, _ in slender_body.requirements(Parameters(**values), FLOATS)]
        assert (np.array(function(list(values.values()))).ravel() > 0.0).tolist() == exact
        assert all(exact) == (change in ({}, {"water_density": 1e-200}))
