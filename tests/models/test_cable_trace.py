"""The linear towing units as traces: the same functions with CasADi symbols and with numbers."""

from __future__ import annotations

import math
import random
from dataclasses import replace
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from towage.fmus.declare.unit import load
from towage.models.cable.case import CableError
from towage.models.cable.lumped.fidelity import choose
from towage.models.cable.lumped.forces import COMPLEX_STEP, segment_forces
from towage.models.cable.lumped.linear import tow_rigid
from towage.models.cable.lumped.lumped import BALANCE, equilibrium, hang, matrices
from towage.models.cable.lumped.reduction import relative_error, transfer
from towage.models.cable.parameters import tow_of
from towage.models.cable.units import tow_cable, tow_system
from towage.models.cable.units.linear_tow import setup_requirements
from towage.models.numeric.matrix_ops import numbers, traces
from towage.models.numeric.ops import FLOATS, symbols

SIZES = [
    (tow_system, tow_system.Size(10, 0)),
    (tow_system, tow_system.Size(20, 0)),
    (tow_system, tow_system.Size(10, 1)),
    (tow_system, tow_system.Size(20, 1)),
    (tow_cable, tow_cable.Size(10)),
    (tow_cable, tow_cable.Size(20)),
]
SCALED = (
    "tow_speed", "cable_length", "cable_mass", "cable_weight", "cable_thickness", "cable_drag_coefficient", "body_mass",
    "body_drag", "axial_stiffness",
)  # fmt: skip
IDS = [f"{m.__name__.rsplit('.', 1)[1]}-{'-'.join(map(str, s))}" for m, s in SIZES]


def parameters(model: ModuleType, count: int, spread: float = 0.7) -> list[Any]:
    """Tows of random proportions, of both quadrants, all forms of the loading and of the added mass."""
    rng = random.Random(3)
    found = []
    unit = load("tow_system" if model is tow_system else "tow_cable")
    start = {v.name: v.start or 0.0 for v in unit.parameters} | {"axial_stiffness": 4e6}
    for k in range(count):
        p = start | {name: start[name] * math.exp(rng.uniform(-spread, spread)) for name in SCALED}
        p |= {
            "loading_form": float(k % 3),
            "momentum_added_mass": float(k % 2),
            "loading_friction": rng.uniform(0, 0.3),
        }
        p |= {"normal_a0": 0.4, "normal_a2": -0.4, "normal_b1": 0.05, "tangential_a1": 0.03, "tangential_b2": 0.02}
        if k % 4 == 3:
            lift = p["body_weight_in_water"] * rng.uniform(1.2, 3.0)
            p |= {"quadrant": 2.0, "body_lift": lift, "cable_weight": 0.05 * p["cable_weight"]}
        found.append(model.Parameters(**p))
    return found


def flat(constants: Any) -> list[Any]:
    return [v for part in constants for v in (part if isinstance(part, tuple) else (part,))]


def traced_setup(model: ModuleType, size: Any) -> Any:
    ca = pytest.importorskip("casadi")
    names = list(model.Parameters.__dataclass_fields__)
    p = ca.MX.sym("p", len(names))
    made = model.setup(model.Parameters(**{n: p[i] for i, n in enumerate(names)}), size, traces())
    return ca.Function("setup", [p], [ca.vertcat(*flat(made.constants)), *made.a, *made.b, made.c, made.d, made.e])


@pytest.mark.parametrize("model, size", SIZES, ids=IDS)
def test_trace_of_the_setup_equals_the_numbers(model: ModuleType, size: Any) -> None:
    function = traced_setup(model, size)
    n = model.setup(parameters(model, 1)[0], size, numbers()).a[0].shape[0]
    for p in parameters(model, 20):
        made = model.setup(p, size, numbers())
        expected = [np.array([flat(made.constants)]).T, *made.a, *made.b, made.c, made.d, made.e]
        for i, (found, wanted) in enumerate(zip(function([*vars(p).values()]), expected)):
            # rows of one unit together: constants and rows of y one by one, states in two halves
            rows = (
                [slice(k, k + 1) for k in range(len(wanted))]
                if i in (0, 3, 4)
                else [slice(0, n // 2), slice(n // 2, n)]
            )
            rows = [slice(0, 8), slice(8, None)] if i == 5 else rows
            for r in rows:
                if i == 0 and r.stop == len(wanted):
                    # imbalance: rounding itself
                    assert float(found[r, :]) < BALANCE
                    continue
                # the inertia of the rotations is inverted: its condition times rounding
                assert np.abs(np.array(found)[r] - wanted[r]).max() <= 1e-10 * np.abs(wanted[r]).max(), (i, r)


def test_text_of_the_setup_is_small() -> None:
    ca = pytest.importorskip("casadi")
    for model, size in (SIZES[1], SIZES[3], SIZES[5]):
        generator = ca.CodeGenerator("setup.c")
        generator.add(traced_setup(model, size))
        # 0.23 MB at 20 segments; a text that holds every node on its own takes 0.5 MB and ten times the compiler's time
        assert len(generator.dump()) < 400_000


@pytest.mark.parametrize("model, size", [SIZES[0], SIZES[4]], ids=[IDS[0], IDS[4]])
def test_trace_of_the_observation_equals_the_numbers(model: ModuleType, size: Any) -> None:
    ca = pytest.importorskip("casadi")
    ops, rng = symbols(), np.random.default_rng(5)
    p = parameters(model, 1)[0]
    made = model.setup(p, size, numbers())
    constants = made.constants._replace(model_error=0.01)
    r = len(made.c)
    own, u, du = rng.standard_normal(len(model.Own._fields)), rng.standard_normal(4), rng.standard_normal(4)
    y, rate, cubics = rng.standard_normal(r), rng.standard_normal(r), rng.standard_normal((4, 4))

    def results(ops: Any, h: Any, own: Any, u: Any, du: Any, y: Any, rate: Any, cubics: Any) -> list[Any]:
        own, u, du, cubics = model.Own(*own), model.Inputs(*u), model.Inputs(*du), model.Inputs(*cubics)
        observed, tensions = model.observe(0.0, own, y, rate, u, du, 0.0, p, constants, ops)
        parts = [
            observed,
            tensions,
            *model.core(own, u, du, p, constants, ops),
            *model.drive(own, cubics, p, constants, ops),
        ]
        parts += [model.own_after(h, own, cubics, p, constants, ops), model.own_rates(own, u, du, p, constants, ops)]
        return [v for part in (*parts, model.describe(p, constants, ops)) for v in part]

    values = [0.3, own, u, du, y, rate, *cubics]
    arguments = [ca.SX.sym("a", np.size(v)) for v in values]
    scalars = [arguments[0], *(tuple(ca.vertsplit(a)) for a in arguments[1:])]
    function = ca.Function("observe", arguments, [ca.vertcat(*results(ops, *scalars[:6], scalars[6:]))])
    expected = results(FLOATS, *values[:6], [list(c) for c in cubics])
    # rounding
    assert np.array(function(*values)).ravel() == pytest.approx(np.array(expected, dtype=float), rel=1e-13, abs=1e-13)


@pytest.mark.parametrize("name, model", [("tow_system", tow_system), ("tow_cable", tow_cable)])
@pytest.mark.parametrize(
    "change",
    [
        {}, {"quadrant": 2.0}, {"quadrant": 1.5}, {"tow_speed": 0.0}, {"body_lift": 9e3}, {"loading_form": 0.5},
        {"axial_stiffness": -1.0}, {"cable_drag_coefficient": -1.0}, {"body_weight_in_water": 0.0, "body_drag": 0.0},
    ],
)  # fmt: skip
def test_traced_requirements_are_those_of_numbers(name: str, model: ModuleType, change: dict[str, float]) -> None:
    ca = pytest.importorskip("casadi")
    start = {v.name: v.start or 0.0 for v in load(name).parameters} | {"axial_stiffness": 4e6}
    p = model.Parameters(**start | change)
    names = list(start)
    symbol = ca.SX.sym("p", len(names))
    traced = model.requirements(model.Parameters(**{n: symbol[i] for i, n in enumerate(names)}), symbols())
    values = ca.Function("required", [symbol], [ca.vertcat(*(v for v, _ in traced))])([getattr(p, n) for n in names])
    met = [bool(v > 0.0) for v in np.array(values).ravel()]
    assert met == [v > 0.0 for v, _ in model.requirements(p, FLOATS)]
    assert all(met) == (not change)
    assert all(isinstance(text, str) and text for _, text in traced)


def test_requirements_of_the_setup() -> None:
    p = parameters(tow_system, 1)[0]
    size = tow_system.Size(10, 0)
    # a slight, buoyant cable lifts the chain out of Quadrant I
    for change, good in (({}, True), ({"cable_weight": -100.0}, False)):
        q = replace(p, **change)
        constants = tow_system.setup(q, size, numbers()).constants
        assert all(v > 0.0 for v, _ in setup_requirements(q, constants, FLOATS)) == good
        if not good:
            with pytest.raises(CableError, match=r"segment \d of 10 leaves the quadrant or is slack"):
                equilibrium(tow_of(q), 10)


def test_equilibrium_is_found_in_any_tow_inside_its_quadrant() -> None:
    found = 0
    for p in parameters(tow_system, 200, spread=2.5):
        chain = hang(tow_of(p), 20, numbers())
        # a fixed count of iterations: what it leaves is rounding, or there is no equilibrium in the quadrant
        assert not 1e-14 < chain.imbalance[-1] < BALANCE
        found += chain.imbalance[-1] < BALANCE
    assert found > 150


@pytest.mark.parametrize("elastic", [False, True])
def test_matrices_are_derivatives_of_the_forces(elastic: bool) -> None:
    for p in parameters(tow_system, 12):
        chain = equilibrium(tow_of(p), 6)
        m = matrices(chain, elastic)
        position, velocity = chain.nodes.T.astype(complex), np.zeros((2, 7), dtype=complex)
        velocity[0] = chain.tow.speed
        for node in range(7):
            for i in range(2):
                for matrix, k in ((m.stiffness, 0), (m.damping, 1)):
                    moved = [position.copy(), velocity.copy()]
                    moved[k][i, node] += 1j * COMPLEX_STEP
                    lower, upper = segment_forces(
                        chain.tow, chain.segment, moved[0][:, :-1], moved[0][:, 1:], moved[1][:, :-1], moved[1][:, 1:],
                        None if elastic else chain.tension,
                    )  # fmt: skip
                    force = np.zeros((2, 7))
                    force[:, :-1] += lower.imag / COMPLEX_STEP
                    force[:, 1:] += upper.imag / COMPLEX_STEP
                    # rounding of the stretch, 1e-3 of the length
                    assert np.abs(matrix[:, 2 * node + i] + force.T.ravel()).max() < 1e-11 * np.abs(matrix).max()


def test_error_by_half_the_segments_is_that_against_the_frequency_domain() -> None:
    size = tow_system.Size(20, 0)
    (half, _) = tow_system.study(size).comparisons
    assert half.size.segments == 10
    for p in parameters(tow_system, 3):
        tow, frequencies = tow_of(p), np.geomspace(0.02, 2.0, 20)
        rigid = replace(tow, cable=replace(tow.cable, axial_stiffness=math.inf))
        gains = [transfer(tow_rigid(rigid, n), frequencies)[:, :4] for n in (10, 20)]
        estimate = half.weight * relative_error(gains[0], gains[1], 2)
        measured = choose(tow, False, 2.0, 0.5, nodes=20, reduced=False).error
        # measured at three frequencies, and second order is not reached by all
        assert estimate == pytest.approx(measured, rel=0.5)
