"""The nonlinear wire: closed forms, reference values by independent codes, orders, energy, state, bad input."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from towage.models.cable.case import CableError
from towage.models.cable.loading import Loading, eames
from towage.models.cable.wire.chain import Chain, Drive
from towage.models.cable.wire.elements import rule
from towage.models.cable.wire.grading import graded_mesh
from towage.models.cable.wire.jacobian import derivatives
from towage.models.cable.wire.mesh import Mesh, uniform_mesh
from towage.models.cable.wire.parts import Flow, Mass, Section, Wire, cross_flow_section, uniform_flow
from towage.models.cable.wire.rest import Frame, equilibrium, march
from towage.models.cable.wire.stepper import State, Stepper, consistent
from towage.models.cable.wire.tableaus import FOURTH, SECOND, THIRD, Tableau
from towage.verify.wire import steady_chain

FISH = Section(150.0, 0.6, 4.747156, 0.012, 8e6, *cross_flow_section(1.5, 0.01))
BODY = Mass(800.0, 300.0, 5000.0, 0.3)


def fish(**changes: Any) -> Wire:
    return Wire((replace(FISH, **changes),), BODY, 1025.0)


def towed(wire: Wire, speed: float, elements: int, degree: int, dimensions: int = 2) -> tuple[Chain, Array]:
    flow, frame = uniform_flow(np.zeros(dimensions)), Frame(np.array([speed, *np.zeros(dimensions - 1)]))
    shape = march(wire, flow, frame, dimensions)
    chain = Chain(wire, graded_mesh(wire, shape, degree, elements).mesh, flow, dimensions)
    return chain, equilibrium(chain, frame, shape.position(chain.mesh.places))


Array = np.ndarray[Any, np.dtype[np.float64]]
ZERO = np.zeros(2)


@pytest.mark.parametrize("degree", range(1, 7))
def test_elements_are_exact_for_polynomials(degree: int) -> None:
    """Slopes to degree p, quadrature to 2p - 1, integrals to p."""
    points, weights, slopes, integrals = rule(degree)
    for k in range(2 * degree):
        assert weights @ points**k == pytest.approx((1.0 + (-1.0) ** k) / (k + 1.0), abs=1e-14)
    for k in range(degree + 1):
        assert slopes @ points**k == pytest.approx(k * points ** max(k - 1, 0), abs=1e-12)
        assert integrals @ points**k == pytest.approx((points ** (k + 1) - (-1.0) ** (k + 1)) / (k + 1.0), abs=1e-13)


@pytest.mark.parametrize("table", [SECOND, THIRD, FOURTH], ids=lambda t: t.name)
def test_tableaus_have_their_order(table: Tableau) -> None:
    """Conditions up to the order for u' = t^k, stage order 2, L-stability at infinity by the stiffly accurate last row."""
    places = np.array([0.0, *table.places])
    for row, place in zip(table.rows, table.places):
        weights = np.array([*row, *[0.0] * (len(places) - len(row))])
        assert weights.sum() == pytest.approx(place, abs=1e-14)
        assert weights @ places == pytest.approx(0.5 * place**2, abs=1e-12)
    last = np.array(table.rows[-1])
    for k in range(1, table.order + 1):
        assert last @ places ** (k - 1) == pytest.approx(1.0 / k, abs=1e-12)
    assert table.places[-1] == pytest.approx(1.0, abs=1e-14) and sum(table.error) == pytest.approx(0.0, abs=1e-12)


def test_a_hanging_wire_is_the_bar_of_the_closed_form() -> None:
    """Stretch W L/EA + w L^2/(2 EA), tension W + w L at the top."""
    wire = fish()
    chain, r = towed(wire, 0.0, 2, 4)
    length, w, weight, ea = 150.0, FISH.weight, BODY.weight, FISH.axial_stiffness
    assert r[0, 1] == pytest.approx(-(length + weight * length / ea + w * length**2 / (2.0 * ea)), rel=1e-12)
    still = np.zeros_like(r)
    assert chain.needed(r, still, still, Drive(ZERO, ZERO, ZERO))[-1, 1] == pytest.approx(weight + w * length, rel=1e-12)


def test_steady_shape_converges_with_the_degree() -> None:
    """Order at least 4 in the place of the body, of elements of degree 3 to 5, where the shape is smooth."""
    _, exact = towed(fish(), 3.0, 16, 6)
    for degree in (3, 4, 5):
        chain_errors = []
        for elements in (4, 8):
            flow, frame = uniform_flow(ZERO), Frame(np.array([3.0, 0.0]))
            chain = Chain(fish(), uniform_mesh(fish(), elements, degree), flow, 2)
            r = equilibrium(chain, frame, march(fish(), flow, frame, 2).position(chain.mesh.places))
            chain_errors.append(np.abs(r[0] - exact[0]).max())
        assert math.log2(chain_errors[0] / chain_errors[1]) > 4.0


def heave(t: float) -> Drive:
    """1 m at 7 s, from rest without a jump."""
    omega, ramp = 2.0 * math.pi / 7.0, min(t / 7.0, 1.0)
    s, s1 = ramp**3 * (10.0 - 15.0 * ramp + 6.0 * ramp**2), 30.0 * ramp**2 * (1.0 - ramp) ** 2 / 7.0
    s2 = 60.0 * ramp * (1.0 - ramp) * (1.0 - 2.0 * ramp) / 49.0
    sine, cosine = math.sin(omega * t), math.cos(omega * t)
    return Drive(
        np.array([3.0 * t, s * sine]), np.array([3.0, s1 * sine + s * omega * cosine]),
        np.array([0.0, s2 * sine + 2.0 * s1 * omega * cosine - s * omega**2 * sine]),
    )  # fmt: skip


def begun(elements: int = 2, degree: int = 4) -> tuple[Chain, State]:
    chain, r = towed(fish(), 3.0, elements, degree)
    return chain, State(r, np.broadcast_to([3.0, 0.0], r.shape).copy(), np.zeros_like(r))


@pytest.mark.parametrize(("table", "least"), [(SECOND, 1.8), (THIRD, 2.6)], ids=["tr-bdf2", "esdirk3"])
def test_steps_have_their_order(table: Tableau, least: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of the body's place at equal steps, against shorter steps of order 4."""

    def end(tableau: Tableau, h: float) -> Array:
        chain, state = begun()
        stepper = Stepper(chain, 1e-3, tableau=tableau)
        for k in range(round(7.0 / h)):
            state, made = stepper.step(k * h, h, state, heave)
            assert made == h
        return state.position[0]

    monkeypatch.setattr("towage.models.cable.wire.stepper.NEWTON", 1e-7)
    exact = end(FOURTH, 0.0625)
    errors = [np.abs(end(table, h) - exact).max() for h in (0.25, 0.125)]
    assert math.log2(errors[0] / errors[1]) > least


def test_a_state_is_all_there_is() -> None:
    """Set back, also for a stepper that has never seen it, it goes on to the last bit."""
    chain, state = begun()
    stepper = Stepper(chain, 1e-3)
    for k in range(4):
        state = stepper.advance(0.5 * k, 0.5, state, heave)
    kept = state
    first = stepper.advance(2.0, 0.5, kept, heave)
    again, fresh = stepper.advance(2.0, 0.5, kept, heave), Stepper(chain, 1e-3).advance(2.0, 0.5, kept, heave)
    for one in (again, fresh):
        assert np.array_equal(one.position, first.position) and np.array_equal(one.acceleration, first.acceleration)
        assert one.step == first.step


def test_energy_does_not_grow_without_a_source() -> None:
    """No water, no drag, the top held: kinetic, elastic and potential energy of a pendulum of wire that goes slack."""
    dry = replace(FISH, drag_coefficient=0.0, loading=Loading((0.0,) * 5, (0.0,) * 5), added_mass_coefficient=0.0)
    wire = Wire((dry,), Mass(800.0, 0.0, 5000.0, 0.0), 1025.0)
    chain = Chain(wire, uniform_mesh(wire, 2, 4), uniform_flow(ZERO), 2)
    s = chain.mesh.places
    r, still = np.stack([0.7 * (150.0 - s), -0.7 * (150.0 - s)], axis=1), Drive(ZERO, ZERO, ZERO)
    state, stepper = consistent(chain, r, np.zeros_like(r), still), Stepper(chain, 0.5)
    weights = chain.scatter(np.repeat((chain.rule.weights * chain.lengths().half)[:, :, None], 2, axis=2))[:, 0]

    def energy(state: State) -> float:
        stretch = np.linalg.norm(chain.slope(chain.gather(state.position), chain.lengths().half), axis=2) - 1.0
        elastic = 0.5 * FISH.axial_stiffness * np.maximum(stretch, 0.0) ** 2
        kinetic = 0.5 * (dry.mass * weights @ (state.velocity**2).sum(1) + 800.0 * (state.velocity[0] ** 2).sum())
        height = dry.weight * weights @ state.position[:, 1] + 5000.0 * state.position[0, 1]
        return float(kinetic + height + ((chain.rule.weights * chain.lengths().half) * elastic).sum())

    first, t = energy(state), 0.0
    scale = 5000.0 * 150.0
    for _ in range(200):
        state, h = stepper.step(t, min(state.step or 0.02, 0.1), state, lambda t: still)
        t += h
        assert energy(state) < first + 1e-3 * scale
    assert t > 1.0


def test_a_violent_towpoint_is_followed() -> None:
    """40 m/s2 of heave of the towpoint, the wire slack for part of each period."""
    omega, a = 8.0, 40.0 / 64.0

    def shaken(t: float) -> Drive:
        return Drive(
            np.array([3.0 * t, a * (1.0 - math.cos(omega * t))]), np.array([3.0, a * omega * math.sin(omega * t)]),
            np.array([0.0, a * omega**2 * math.cos(omega * t)]),
        )  # fmt: skip

    chain, state = begun(4, 3)
    stepper = Stepper(chain, 1e-2)
    state = stepper.advance(0.0, 2.0, state, shaken)
    assert np.all(np.isfinite(state.position)) and np.abs(state.position[:, 1]).max() < 150.0


def test_steps_that_lead_nowhere_end(monkeypatch: pytest.MonkeyPatch) -> None:
    """A span of 1e9 s in steps of at most 0.1 s."""
    monkeypatch.setattr("towage.models.cable.wire.stepper.PATIENCE", 20)
    chain, state = begun()
    with pytest.raises(CableError, match="the wire's motion was not found at t = 2"):
        Stepper(chain, 1e-3, largest=0.1).advance(0.0, 1e9, state, heave)


def test_payout_drags_the_material() -> None:
    """A wire that hangs and is paid out from a held top: the body sinks as fast as wire is added, but for its stretch."""
    chain, r = towed(fish(), 0.0, 2, 4)

    def winch(t: float) -> Drive:
        s = min(t / 5.0, 1.0)
        rate = s**3 * (10.0 - 15.0 * s + 6.0 * s * s)
        paid = 5.0 * (s**4 * (2.5 - 3.0 * s + s * s)) + max(t - 5.0, 0.0)
        return Drive(ZERO, ZERO, ZERO, (paid, rate, 30.0 * s * s * (1.0 - s) ** 2 / 5.0))

    stepper = Stepper(chain, 1e-4)
    still = np.zeros_like(r)
    state = stepper.advance(0.0, 40.0, State(r, still, still), winch)
    # the stretch of what was added, W dL/EA, is 2e-2 m of 37.5 m; the body falls at 1 m/s against its drag
    assert state.velocity[0, 1] == pytest.approx(-1.0, abs=2e-3)
    assert state.position[0, 1] - r[0, 1] == pytest.approx(-37.5, rel=2e-3)
    with pytest.raises(CableError, match="hauled in but for"):
        chain.lengths((-150.0, 0.0, 0.0))


def test_grading_reaches_its_tolerance() -> None:
    """The light body on a long cable: the error that is told is that of the body's place, within a factor."""
    light = Wire((replace(FISH, length=900.0),), Mass(60.0, 30.0, 300.0, 0.1), 1025.0)
    flow, frame = uniform_flow(ZERO), Frame(np.array([6.0, 0.0]))
    shape = march(light, flow, frame, 2)
    exact = shape.position(np.zeros(1))[0]
    for tolerance in (1e-3, 1e-5):
        graded = graded_mesh(light, shape, 4, 0, tolerance)
        chain = Chain(light, graded.mesh, flow, 2)
        r = equilibrium(chain, frame, shape.position(graded.mesh.places))
        assert graded.error <= tolerance and np.abs(r[0] - exact).max() < 3.0 * tolerance * 900.0


@pytest.mark.parametrize(
    ("section", "message"),
    [
        ({"length": 0.0}, "section 1: length"), ({"mass": -1.0}, "section 1: mass"), ({"diameter": -0.1}, "section 1: diameter"),
        ({"axial_stiffness": math.inf}, "section 1: axial_stiffness"), ({"weight": math.nan}, "section 1: weight"),
    ],
)  # fmt: skip
def test_what_makes_no_sense_is_named(section: dict[str, float], message: str) -> None:
    with pytest.raises(CableError, match=message):
        fish(**section)


def test_a_clump_stands_at_a_joint() -> None:
    with pytest.raises(CableError, match="divide the section there"):
        Wire((FISH, FISH), BODY, 1025.0, ((70.0, BODY),))
    with pytest.raises(ValueError, match="degree of an element"):
        rule(7)


def test_flow_is_a_table_over_depth() -> None:
    flow = Flow(np.array([-10.0, 0.0]), np.array([[0.0, 0.0], [1.0, 0.0]]))
    values, slopes = flow.at(np.array([-20.0, -5.0, 3.0]))
    assert values[:, 0].tolist() == [0.0, 0.5, 1.0] and slopes[:, 0].tolist() == [0.0, 0.1, 0.0]


def test_jacobian_is_the_derivative_of_the_forces() -> None:
    """In space, with damping, payout, shear and Eames' loading, against central differences."""
    wire = Wire((replace(FISH, damping=1e3, drag_coefficient=1.2, loading=eames(0.03)),), BODY, 1025.0)
    flow = Flow(np.array([-200.0, 10.0]), np.array([[0.0, 0.1, 0.0], [0.4, 0.3, 0.0]]))
    chain, r = towed(wire, 3.0, 2, 3, 3)
    chain = Chain(wire, chain.mesh, flow, 3)
    generator = np.random.default_rng(1)
    u, b = generator.normal(size=r.shape), generator.normal(size=r.shape)
    r = 1.01 * r + 0.1 * generator.normal(size=r.shape)
    drive = Drive(np.zeros(3), np.zeros(3), np.zeros(3), (3.0, 0.0, 0.0))
    for local, which in zip(derivatives(chain, r, u, b, drive.paid), range(3)):
        direction = generator.normal(size=r.shape)
        values = [tuple(x + sign * 1e-5 * direction if k == which else x for k, x in enumerate((r, u, b))) for sign in (1, -1)]
        slope = (chain.needed(*values[0], drive) - chain.needed(*values[1], drive)) / 2e-5
        found = chain.scatter(np.einsum("eiajb,ejb->eia", local, chain.gather(direction)))
        assert np.abs(found - slope).max() < 1e-6 * np.abs(slope).max()


def test_a_case_that_makes_no_sense_is_named() -> None:
    inputs = {
        "water_density": 1025.0, "body": {"mass": 1.0, "added_mass": 0.0, "weight": 1.0, "drag_area": 0.0},
        "sections": [{"length": 1.0, "mass": 1.0, "weight": 0.0, "diameter": 0.01, "axial_stiffness": 1e6,
                      "added_mass_coefficient": 1.0, "loading": "paint", "normal_drag": 1.0}],
        "top": {"position": [0.0, 0.0, 0.0], "speed": 1.0},
    }  # fmt: skip
    with pytest.raises(ValueError, match='expected "eames" or "cross_flow"'):
        steady_chain(inputs)
    assert isinstance(uniform_mesh(fish(), 3, 2), Mesh)
