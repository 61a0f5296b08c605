"""Closed-form heave: limits, both Smith factors, and the irregular record of the ship in a sea."""

from __future__ import annotations

import cmath
import json
import math
from dataclasses import replace
from importlib.resources import files

import numpy as np
import pytest

from towage.models.heave import ship
from towage.models.numeric.ops import FLOATS, arrays
from towage.models.sea import heave_response as hr
from towage.models.sea import kernel, motion, ship_in_sea, waves
from towage.verify import verify

HULL = hr.Hull(174.65, 14.26, 7.77)
CASES = json.loads((files("towage") / "reference" / "sea_and_route.json").read_text("utf-8"))["cases"]
SEA = [case for case in CASES if case["kind"] != "route"]
PARAMETERS = ship_in_sea.Parameters(
    length=174.65, breadth=14.26, draught=7.77, block_coefficient=1.0, smith_oblique=0.0, peakedness=1.0,
    components=100.0, spreading=-1.0, directions=8.0, seed=1964.0, update_interval=10.0, ramp_time=0.0, mass=4e7,
    damping=7e6, stiffness=3e7, sdof_tolerance=0.05, order=1.0, second_share=0.0, second_frequency=0.5,
    second_peakedness=1.0, second_order=1.0, second_direction=0.0, point_x=0.0, point_y=0.0, point_z=0.0,
)  # fmt: skip


@pytest.mark.parametrize("case", SEA, ids=lambda case: case["name"])
def test_reference_case(case: dict[str, object]) -> None:
    found = verify.check(case)
    assert found.ok, found.message


def test_long_waves_lift_the_ship_as_they_are() -> None:
    assert hr.heave_rao(0.02, 0.0, -1.0, HULL, FLOATS) == pytest.approx(1.0, abs=1e-3)  # kL = 0.007


@pytest.mark.parametrize("beta", [0.0, math.pi])
def test_smith_factors_agree_along_the_ship(beta: float) -> None:
    values = [hr.heave_rao(0.6, 7.5, math.cos(beta), HULL._replace(smith_oblique=s), FLOATS) for s in (0.0, 1.0)]
    assert values[0] == values[1]


def test_smith_factors_differ_in_a_beam_sea_as_the_two_programs_do() -> None:
    values = [hr.heave_rao(0.7, 7.5, 0.0, HULL._replace(smith_oblique=s), FLOATS) for s in (0.0, 1.0)]
    assert values == pytest.approx([1.2098, 1.7837], abs=5e-5)  # printed digits


def test_response_is_regular_where_the_encounter_stands_still() -> None:
    speed = waves.GRAVITY / 0.8  # omega_e = 0 at 0.8 rad/s in a following sea
    values = [hr.heave_rao(0.8 + d, speed, 1.0, HULL, FLOATS) for d in (-1e-7, 0.0, 1e-7)]
    assert values[1] == pytest.approx(0.5 * (values[0] + values[2]), rel=1e-9)  # curvature times 1e-14


def test_arrays_and_floats_agree() -> None:
    omega = np.linspace(0.2, 2.0, 50)
    batch = hr.heave_rao(omega, 5.0, -0.3, HULL, arrays())
    assert batch == pytest.approx([hr.heave_rao(float(w), 5.0, -0.3, HULL, FLOATS) for w in omega], rel=1e-13)


Motion = tuple[ship_in_sea.State, ship_in_sea.Modes]
SEES = ship_in_sea.transition
HEAVE = 8
"""The signal: z of the point."""


def start(sea: ship_in_sea.Inputs, p: ship_in_sea.Parameters = PARAMETERS) -> Motion:
    return SEES(0.0, *ship_in_sea.initial(p, FLOATS), sea, p, FLOATS)


def heave(t: float, m: ship_in_sea.Modes, p: ship_in_sea.Parameters = PARAMETERS) -> tuple[float, ...]:
    return ship_in_sea.free_motion(t, m, p, HEAVE, FLOATS)


HEAD = ship_in_sea.Inputs(0.0, 6.096, 0.0, math.pi, 7.5)


def exact(t: float) -> tuple[float, ...]:
    """Heave, velocity and acceleration in a head sea: the sum over the components in extended precision."""
    components, omega_p = PARAMETERS_SEA, np.longdouble(waves.peak_frequency(6.096))
    amplitudes = np.array(hr.heave_amplitudes(6.096, float(omega_p), 7.5, math.pi, HULL, components), np.longdouble)
    x, shift = np.array(components.x, np.longdouble), omega_p * omega_p * np.longdouble(-7.5) / np.longdouble(waves.GRAVITY)
    omega = x * omega_p - x * x * shift
    phase = omega * np.longdouble(t) + np.array(components.phase, np.longdouble)
    along, across = amplitudes * np.cos(phase), amplitudes * np.sin(phase)
    return float(along.sum()), -float((omega * across).sum()), -float((omega * omega * along).sum())


PARAMETERS_SEA = hr.components(100, 1964)


@pytest.mark.parametrize(("around", "error"), [(0.0, 3e-13), (10800.0, 5e-12), (36000.0, 1e-11)])
def test_windows_do_not_drift(around: float, error: float) -> None:
    """After three and ten hours as at the start, but for the rounding of the phases themselves: 3e4 rad times 1e-16 after
    three hours, 7e-12 in the fastest components; the velocity, a derivative of 18 coefficients, has a few hundred roundings.
    Every window of a block, whose phasors turn up to 31 times, is met."""
    m = start(HEAD)[1]
    for k in range(64):
        t = around + 0.41 * k
        assert heave(t, m)[:3] == pytest.approx(exact(t), abs=error)


def test_turning_phasors_does_not_drift() -> None:
    """After the 31 turns of a block, three hours into the run, the phasors are those of their phases: 1e-13, where 1e-12 is asked
    for. Phases anew every block keep it there."""
    sea = motion.Sea(6.096, waves.peak_frequency(6.096), math.pi, 7.5)
    made = motion.Motion(motion.State(0.0, 0.0, 0.0, 0.0, sea, sea, 10.0), PARAMETERS_SEA, lambda *_: (1 + 0j,) * 100)
    first = motion.BLOCK * int(10800.0 / made.width / motion.BLOCK)
    begun, rates = made._phasors_at(first), motion.encounter(sea, PARAMETERS_SEA)
    turned = made._phasors_at(first + motion.BLOCK - 1)
    for z, w, found in zip(begun, rates, turned):
        assert abs(found - z * cmath.exp(1j * w * (made.width * (motion.BLOCK - 1)))) < 1e-13


def test_the_answer_does_not_depend_on_what_was_asked_before() -> None:
    m = start(HEAD)[1]
    forth = [heave(0.7 * k, m)[:4] for k in range(200)]
    kernel.sea_kernel.cache_clear()
    back = [heave(0.7 * k, m)[:4] for k in reversed(range(200))]
    assert forth == back[::-1]


def test_a_steady_sea_adds_no_rounding_at_its_looks() -> None:
    x, m = start(HEAD)
    for k in range(1, 400):
        x, m = SEES(10.0 * k, x, m, HEAD, PARAMETERS, FLOATS)
    assert m.looks == 399.0 and m[3:] == start(HEAD)[1][3:]


def changing(t: float) -> ship_in_sea.Inputs:
    """A sea that changes by a third within minutes, and turns through the stern."""
    return ship_in_sea.Inputs(0.0, 5.0 + 1.5 * math.sin(t / 70.0), 11.0 + math.cos(t / 90.0), math.pi + t / 200.0, 6.0)


def test_no_jump_and_exact_velocity_while_the_sea_changes() -> None:
    (x, m), h = start(changing(0.0)), 0.05
    record = []
    for k in range(4000):
        t = k * h
        x, m = SEES(t + 1e-12, x, m, changing(t), PARAMETERS, FLOATS)
        out = ship_in_sea.outputs(t, x, m, changing(t), changing(t), PARAMETERS, FLOATS)
        record.append((out.heave, out.velocity, out.velocity_rate, out.margin_slow_sea))
    values, velocity, acceleration, slow = np.array(record).T
    # Hermite: heave(t + h) follows from values, rates and accelerations at both ends but for h^5/720 of the fifth
    # derivative: 1e-8 m for 2 m at 1.5 rad/s; a jump of the amplitude of a component would be 1e-3 m
    h2 = h * h / 12.0
    gap = np.diff(values) - 0.5 * h * (velocity[1:] + velocity[:-1]) + h2 * np.diff(acceleration)
    assert np.max(np.abs(gap)) < 1e-7
    assert np.max(np.abs(values)) > 0.5
    assert 0.0 < slow.min() < 0.9  # the sea changes, and slowly enough


def test_variance_of_a_long_record_is_that_of_the_theory() -> None:
    m = start(HEAD)[1]
    free = [heave(7.3 * k, m) for k in range(6000)]
    # 6000 samples 7.3 s apart of a Gaussian record, correlation time near 10 s: 3 % is three standard errors
    assert np.var([f[0] for f in free]) == pytest.approx(0.4626958, rel=0.05)
    assert free[0][4] == pytest.approx(0.46269584308, rel=1e-9)  # the rule's variance error is 1.5e-9


def test_spread_components_have_frequencies_of_their_own_and_the_right_variance() -> None:
    sea = hr.components(300, 1964, 1.0, 5, 24)
    assert len(set(sea.x)) == len(sea.x)
    amplitudes = hr.heave_amplitudes(6.096, waves.peak_frequency(6.096), 7.5, math.pi, HULL, sea)
    # about a dozen frequencies a direction integrate the response to a percent
    assert 0.5 * sum(a * a for a in amplitudes) == pytest.approx(0.80002, rel=1e-2)


def test_response_to_the_line_is_that_of_the_ship() -> None:
    u = HEAD._replace(reaction=4e5)
    c = ship_in_sea.Inputs(*((value, 0.0, 0.0, 0.0) for value in u))
    x, m = start(u)
    p = ship.Parameters(1.0, 8.0, 0.0, 0.0, PARAMETERS.mass, PARAMETERS.damping, PARAMETERS.stiffness, 0.05)
    z = ship.State(0.0, 0.0)
    for k in range(50):
        x = ship_in_sea.advance(k * 0.2, 0.2, x, m, c, PARAMETERS, FLOATS)
        z = ship.advance(k * 0.2, 0.2, z, ship.Modes(), ship.Inputs(c.reaction), p, FLOATS)
    assert x == z


def test_calm_is_still_and_its_margins_are_finite() -> None:
    calm = ship_in_sea.Inputs(0.0, 0.0, 0.0, math.pi, 0.0)
    out = ship_in_sea.outputs(0.0, *start(calm), calm, calm, PARAMETERS, FLOATS)
    assert (out.heave, out.velocity, out.significant_heave) == (0.0, 0.0, 0.0)
    assert (out.margin_sdof, out.margin_froude, out.margin_slow_sea, out.margin_strip) == (1.0, 1.0, 1.0, 1.0)


def test_too_few_directions_are_refused() -> None:
    for spreading, enough in ((8.0, False), (-1.0, True)):
        (value, text), _ = ship_in_sea.requirements(replace(PARAMETERS, spreading=spreading), FLOATS)
        assert (value > 0.0) == enough and "directions" in text
