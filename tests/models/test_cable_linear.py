"""The tow cable in the time domain, linear: against the frequency domain, its limits, and its exact steps."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from functools import lru_cache
from importlib.resources import files

import numpy as np
import pytest

from towage.models.cable.case import Body, Cable, CableError, Tow
from towage.models.cable.loading import eames
from towage.models.cable.lumped.fidelity import choose, exact_gains
from towage.models.cable.lumped.forces import node_load, segment_forces
from towage.models.cable.lumped.linear import StateSpace, cable_elastic, rigid_model, tow_elastic, tow_rigid
from towage.models.cable.lumped.lumped import Chain, equilibrium, matrices
from towage.models.cable.lumped.reduction import reduce, relative_error, stable, transfer
from towage.models.cable.steady.response import respond
from towage.models.cable.steady.steady import steady
from towage.models.numeric.exact_step import exact_step
from towage.verify.cable import excitation_of, tow_of

CASES = {
    c["name"][:2]: c["inputs"] for c in json.loads((files("towage") / "reference" / "cable.json").read_text())["cases"]
}
NAMES = ("R1", "R3", "R4", "R6")
STEPS = (0.001, 0.003, 0.01, 0.03, 0.1, 0.3, 1.0)


def tow(name: str, stiffness: float = math.inf) -> Tow:
    found = tow_of(CASES[name])
    return replace(found, cable=replace(found.cable, axial_stiffness=stiffness))


@lru_cache
def rigid(name: str, count: int) -> StateSpace:
    return tow_rigid(tow(name), count)


def difference(model: StateSpace, name: str, exact: Tow) -> tuple[float, float]:
    """Relative errors of force on the towpoint and displacement of the body at the case's frequency and excitation."""
    omega, excitation = CASES[name]["omega"], excitation_of(CASES[name])
    r = respond(exact, omega, excitation)
    force = -np.array(r.towpoint_force)
    body = np.array([d[0, 0] for d in r.displacement])
    u = np.array([-1j * omega * excitation.surge, -1j * omega * excitation.heave, -excitation.drag, excitation.lift])
    y = model.response(omega, u)
    return (
        float(np.abs(y[:2] - force).max() / np.abs(force).max()),
        float(np.abs(y[2:4] * 1j / omega - body).max() / np.abs(body).max()),
    )


@pytest.mark.parametrize("name", NAMES)
def test_second_order_convergence_to_the_frequency_domain(name: str) -> None:
    counts = (20, 40, 80)
    errors = np.array([difference(rigid(name, n), name, tow(name)) for n in counts])
    order = -np.polyfit(np.log(counts), np.log(errors), 1)[0]
    # fitted exponents 1.96 to 2.0: the next order is still felt at 20 segments
    assert order == pytest.approx([2.0, 2.0], abs=0.08)
    # R1 as measured before: 1.1e-3 and 3.1e-3
    assert errors[-1].max() < 4e-3


@pytest.mark.parametrize("name", ["R1", "R6"])
def test_elastic_model_converges_to_the_elastic_frequency_domain(name: str) -> None:
    exact = tow(name, 2e6)
    errors = np.array([difference(tow_elastic(exact, n), name, exact) for n in (20, 40, 80)])
    order = -np.polyfit(np.log((20, 40, 80)), np.log(errors), 1)[0]
    assert order == pytest.approx([2.0, 2.0], abs=0.08)


def test_elastic_model_tends_to_the_rigid_one_as_one_over_stiffness() -> None:
    omega = CASES["R1"]["omega"]
    u = np.array([0.0, -1j * omega, 0.0, 0.0])
    goal = rigid("R1", 40).response(omega, u)[:2]
    errors = [
        float(np.abs(tow_elastic(tow("R1", ea), 40).response(omega, u)[:2] - goal).max() / np.abs(goal).max())
        for ea in (2e6, 2e7, 2e8, 2e9)
    ]
    # 0.18, 1.5e-2, 1.5e-3, ...: the exponent is 1 from 2e7 on
    assert errors[0] == pytest.approx(0.18, abs=0.02)
    assert np.log10(np.array(errors[1:-1]) / np.array(errors[2:])) == pytest.approx([1.0, 1.0], abs=0.05)


def test_cable_between_two_units_and_body_make_the_tow() -> None:
    # the same equations split at the body and joined again in the frequency domain
    exact, omega, n = tow("R1", 2e7), 1.9, 12
    whole, cable = tow_elastic(exact, n), cable_elastic(exact, n)
    s = -1j * omega
    top = s * np.array([1.0, 0.5j])

    def forces(body: np.ndarray) -> np.ndarray:
        return cable.response(omega, np.array([*top, *body, *((body - top) / s)]))

    at_rest = forces(np.zeros(2, dtype=complex))
    slope = np.column_stack([forces(e)[2:4] - at_rest[2:4] for e in np.eye(2, dtype=complex)])
    inertia = np.diag([exact.body.mass + exact.body.added_mass_surge, exact.body.mass + exact.body.added_mass_heave])
    body = np.linalg.solve(s * inertia - slope, at_rest[2:4])
    joined, one = forces(body), whole.response(omega, np.array([*top, 0.0, 0.0]))
    # rounding times EA/(force per displacement)
    assert body == pytest.approx(one[2:4], rel=1e-8)
    assert joined[:2] == pytest.approx(one[:2], rel=1e-8)
    assert joined[6:] == pytest.approx(one[6:], rel=1e-8)


def test_cable_alone_approaches_the_inextensible_two_end_problem() -> None:
    # 947.30 lbf/ft: largest force at an end for unit motions of the ends, from the frequency domain at 40 digits
    omega = CASES["R1"]["omega"]
    s = -1j * omega
    found = []
    for n in (40, 80):
        cable = cable_elastic(tow("R1", 2e9), n)
        ends = np.eye(4, dtype=complex)
        found.append(max(np.abs(cable.response(omega, np.array([*(s * e), *(e[2:] - e[:2])]))[:4]).max() for e in ends))
    # 6.9e-3 and 1.7e-3
    assert abs(found[1] / 947.30 - 1.0) < 3e-3
    assert (found[0] / 947.30 - 1.0) / (found[1] / 947.30 - 1.0) == pytest.approx(4.0, abs=0.4)


def test_apparent_mass() -> None:
    # R1: 11.8, 3.1, 0.95 slug of a cable of 10.4 and a body of 120 and 160 slug; the rest is in the end segment
    mass = rigid("R1", 80).apparent_mass
    assert mass == pytest.approx(mass.T, rel=1e-9)
    assert mass.ravel() == pytest.approx([11.83, 3.14, 3.14, 0.945], rel=0.05)


@pytest.mark.parametrize("name", NAMES)
def test_every_step_operator_contracts(name: str) -> None:
    elastic = tow(name, 2e6)
    for model in (rigid(name, 20), tow_elastic(elastic, 10), cable_elastic(elastic, 10)):
        growth = float(np.linalg.eigvals(model.a).real.max())
        for h in STEPS:
            radius = exact_step(model.a, model.b, h).spectral_radius
            assert radius < 1.0
            # the slowest mode's own decay, to the rounding of the squarings
            assert radius == pytest.approx(math.exp(growth * h), abs=1e-9)


def residual_model(name: str, count: int, stiffness: float) -> np.ndarray:
    """Eigenvalues of the elastic chain linearised at the nodes of the continuous shape, as a trap."""
    exact = tow(name, stiffness)
    shape = steady(exact)
    segment = exact.cable.length / count
    at = [shape.at(k * segment) for k in range(count + 1)]
    nodes = np.array([[p[2], p[3]] for p in at])
    tension = np.array([shape.at((k + 0.5) * segment)[1] for k in range(count)])
    m = matrices(Chain(exact, nodes, tension, np.full(len(tension), segment)), elastic=True)
    mass, damping = m.mass.copy(), m.damping.copy()
    mass[:2, :2] += m.body_mass
    damping[:2, :2] += m.body_damping
    f = slice(0, 2 * count)
    inverse = np.linalg.inv(mass[f, f])
    zero, one = np.zeros((2 * count, 2 * count)), np.eye(2 * count)
    a = np.block([[zero, one], [-inverse @ m.stiffness[f, f], -inverse @ damping[f, f]]])
    return np.asarray(np.linalg.eigvals(a))


def test_trap_of_linearising_at_the_continuous_shape() -> None:
    # chords of the continuous shape are shorter than its arcs: the stiff segments there go slack, and the chain has a
    # growing mode although the tow is stable
    assert residual_model("R1", 10, 2e7).real.max() > 1e-3
    assert np.linalg.eigvals(tow_elastic(tow("R1", 2e7), 10).a).real.max() < -0.01


def test_discrete_equilibrium_is_one() -> None:
    for name in ("R1", "R6"):
        exact = tow(name, 2e6)
        chain = equilibrium(exact, 15)
        velocity = np.zeros((2, 15))
        velocity[0] = exact.speed
        lower, upper = segment_forces(
            exact, chain.segment, chain.nodes[:-1].T, chain.nodes[1:].T, velocity, velocity, None
        )
        forces = np.zeros((2, 16))
        forces[:, :-1] += lower
        forces[:, 1:] += upper
        forces[:, 0] += np.array([-exact.body.drag, exact.body.lift - exact.body.weight])
        # rounding of EA
        assert np.abs(forces[:, :-1]).max() < 1e-13 * exact.cable.axial_stiffness


def test_equilibrium_converges_to_the_steady_shape() -> None:
    exact = tow("R1")
    shape = steady(exact)
    errors = []
    for n in (10, 20, 40):
        chain = equilibrium(exact, n)
        errors.append(math.hypot(chain.nodes[-1, 0] - shape.x[-1, -1], chain.nodes[-1, 1] - shape.y[-1, -1]))
    assert np.diff(np.log2(errors)) == pytest.approx([-2.0, -2.0], abs=0.15)


def test_load_is_mirror_symmetric() -> None:
    exact = tow("R1")
    one = node_load(exact, 1.0, (0.6, 0.8), (3.0, -1.0))
    # an untwisted round cable does not know which way its tangent points
    assert one == pytest.approx(node_load(exact, 1.0, (-0.6, -0.8), (3.0, -1.0)), rel=1e-14)
    against = node_load(exact, 1.0, (0.6, 0.8), (-3.0, 1.0))
    assert against == pytest.approx([-one[0], -one[1]], rel=1e-14)


def test_exact_step_is_the_same_in_one_or_two() -> None:
    model = tow_elastic(tow("R1", 2e8), 8)
    rng = np.random.default_rng(3)
    x, c, h = 0.01 * rng.standard_normal(len(model.a)), rng.standard_normal((4, 4)), 0.2
    one = exact_step(model.a, model.b, h).advance(x, c)
    half = exact_step(model.a, model.b, 0.5 * h)
    shifted = np.array(
        [np.polynomial.Polynomial(c[:, j])(np.polynomial.Polynomial([0.5 * h, 1.0])).coef for j in range(4)]
    )
    two = half.advance(half.advance(x, c), shifted.T)
    # rounding
    assert np.abs(one - two).max() < 1e-12 * np.abs(one).max()


@pytest.mark.parametrize(
    "name, tolerance, most", [("R1", 0.1, 8), ("R1", 0.01, 12), ("R6", 0.01, 12), ("R3", 0.01, 12)]
)
def test_balanced_reduction(name: str, tolerance: float, most: int) -> None:
    full = rigid(name, 40)
    found = reduce(full, tolerance, 2.0 * math.pi, extensible=False)
    assert len(found.model.a) <= most and 0.0 < found.error <= tolerance and stable(found.model)
    # exact at rest
    at_rest = transfer(found.model, np.array([1e-9])) - transfer(full, np.array([1e-9]))
    assert np.abs(at_rest[:, :4]).max() < 1e-6 * np.abs(transfer(full, np.array([1e-9]))[:, :4]).max()
    assert found.model.apparent_mass == pytest.approx(full.apparent_mass)
    for h in STEPS:
        assert exact_step(found.model.a, found.model.b, h).spectral_radius < 1.0


def test_modal_reduction_of_elastic_models() -> None:
    exact = tow("R1", 2e6)
    for full in (tow_elastic(exact, 20), cable_elastic(exact, 20)):
        found = reduce(full, 0.01, 2.0 * math.pi, extensible=True)
        assert len(found.model.a) <= 20 and found.error <= 0.01 and stable(found.model)
        for h in STEPS:
            assert exact_step(found.model.a, found.model.b, h).spectral_radius < 1.0


def test_reduction_error_is_what_it_says() -> None:
    full = rigid("R6", 40)
    found = reduce(full, 0.05, 3.0, extensible=False)
    between = np.geomspace(0.021, 2.99, 333)
    # off the frequencies where it was measured
    assert relative_error(transfer(found.model, between), transfer(full, between)) <= 1.1 * found.error


def test_choice_by_tolerance() -> None:
    exact = tow("R3", 2e6)
    found = choose(exact, False, 2.0, 0.05)
    assert found.error <= 0.05 and len(found.model.a) < 12
    # a stretchy cable against heave at 2 rad/s
    assert found.inextensible_error > 0.05
    frequencies = np.array([0.5, 1.5])
    gains = transfer(found.model, frequencies)[:, :4]
    truth = exact_gains(tow("R3"), frequencies.tolist())
    # measured at three other frequencies of the band
    assert relative_error(gains, truth, 2) < 0.05


def test_segments_are_graded_where_a_light_body_bends_the_cable() -> None:
    """280 N at the end of 900 m at 4 knots: of as many segments a third of the error; the order stays 2."""
    light = Tow(
        Cable(900.0, 0.5, 3.0, 0.012, 1.2, eames(0.02), 1.0, False, 4e6), Body(60.0, 15.0, 15.0, 280.0, 0.0, 100.0, 100.0, 50.0),
        2.0, 1025.0, 1,
    )  # fmt: skip
    found = choose(light, True, 1.0, 0.1)
    assert found.grading > 1.0 and found.error <= 0.1
    n, by = found.nodes, found.grading
    equal, *graded = (
        choose(light, True, 1.0, 0.1, count, reduced=False, grading=g).error for count, g in ((n, 1.0), (n, by), (2 * n, by))
    )
    assert equal > 2.0 * graded[0]
    assert math.log2(graded[0] / graded[1]) == pytest.approx(2.0, abs=0.3)


def test_refusals() -> None:
    with pytest.raises(CableError, match="finite axial stiffness"):
        tow_elastic(tow("R1"), 10)
    with pytest.raises(CableError, match="at least 2"):
        cable_elastic(tow("R1", 2e6), 1)
    with pytest.raises(CableError, match="at least 1"):
        equilibrium(tow("R1"), 0)
    with pytest.raises(CableError, match="tolerance"):
        choose(tow("R1"), False, 2.0, 0.0)
    with pytest.raises(CableError, match="positive"):
        reduce(rigid("R1", 20), 0.1, -1.0, extensible=False)


def test_one_segment_is_a_rigid_rod() -> None:
    model = rigid_model(matrices(equilibrium(tow("R3"), 1), elastic=False))
    assert model.a.shape == (2, 2) and stable(model)
