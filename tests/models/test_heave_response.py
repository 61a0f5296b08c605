"""Closed-form heave: limits, both Smith factors, and the irregular record of the ship in a sea."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from importlib.resources import files

import numpy as np
import pytest

from towage.models.heave import ship
from towage.models.numeric.ops import FLOATS, arrays
from towage.models.sea import heave_response as hr
from towage.models.sea import ship_in_sea, waves
from towage.verify import verify

HULL = hr.Hull(174.65, 14.26, 7.77)
CASES = json.loads((files("towage") / "reference" / "sea_and_route.json").read_text("utf-8"))["cases"]
SEA = [case for case in CASES if case["kind"] != "route"]
PARAMETERS = ship_in_sea.Parameters(
    length=174.65, breadth=14.26, draught=7.77, block_coefficient=1.0, smith_oblique=0.0, peakedness=1.0,
    components=100.0, spreading=-1.0, directions=8.0, seed=1964.0, update_interval=10.0, ramp_time=0.0, mass=4e7,
    damping=7e6, stiffness=3e7, sdof_tolerance=0.05,
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


def start(sea: ship_in_sea.Inputs, p: ship_in_sea.Parameters = PARAMETERS) -> ship_in_sea.State:
    x, m = ship_in_sea.initial(p, FLOATS)
    return ship_in_sea.transition(0.0, x, m, sea, p, FLOATS)[0]


def cubics(u: ship_in_sea.Inputs) -> ship_in_sea.Inputs:
    return ship_in_sea.Inputs(*((value, 0.0, 0.0, 0.0) for value in u))


HEAD = ship_in_sea.Inputs(0.0, 6.096, 0.0, math.pi, 7.5)


def test_ten_hours_at_a_tenth_of_a_second_do_not_drift() -> None:
    """Phases at the end against omega_e t in extended precision; every hundredth step is done as one of 10 s, because
    the phases advance once a look whatever the step (the last test shows it)."""
    x, m = start(HEAD), ship_in_sea.Modes()
    for k in range(3600):
        x = ship_in_sea.advance(k * 10.0, 10.0, x, m, cubics(HEAD), PARAMETERS, FLOATS)
    components = PARAMETERS.sea
    omega_p = np.longdouble(waves.peak_frequency(6.096))
    exact = np.longdouble(0.0)
    amplitudes = hr.heave_amplitudes(6.096, float(omega_p), 7.5, math.pi, HULL, components)
    shift = np.longdouble(float(omega_p) * float(omega_p) * 7.5 / waves.GRAVITY) * np.longdouble(-1.0)
    for a, n, e in zip(amplitudes, components.x, components.phase):
        n = np.longdouble(n)
        exact += np.longdouble(a) * np.cos((n * omega_p - n * n * shift) * np.longdouble(36000.0) + np.longdouble(e))
    heave = ship_in_sea.free_motion(36000.0, x, PARAMETERS)[0]
    assert heave == pytest.approx(float(exact), abs=1e-9)


def test_the_length_of_the_steps_does_not_matter() -> None:
    small, large, m = start(HEAD), start(HEAD), ship_in_sea.Modes()
    for k in range(400):
        small = ship_in_sea.advance(k * 0.1, 0.1, small, m, cubics(HEAD), PARAMETERS, FLOATS)
    large = ship_in_sea.advance(0.0, 40.0, large, m, cubics(HEAD), PARAMETERS, FLOATS)
    assert small[2:10] == large[2:10]


def changing(t: float) -> ship_in_sea.Inputs:
    """A sea that changes by a third within minutes, and turns through the stern."""
    return ship_in_sea.Inputs(0.0, 5.0 + 1.5 * math.sin(t / 70.0), 11.0 + math.cos(t / 90.0), math.pi + t / 200.0, 6.0)


def test_no_jump_and_exact_velocity_while_the_sea_changes() -> None:
    x, m, h = start(changing(0.0)), ship_in_sea.Modes(), 0.05
    record = []
    for k in range(4000):
        t = k * h
        out = ship_in_sea.outputs(t, x, m, changing(t), changing(t), PARAMETERS, FLOATS)
        record.append((out.heave, out.velocity, out.velocity_rate, out.margin_slow_sea))
        x = ship_in_sea.advance(t, h, x, m, cubics(changing(t)), PARAMETERS, FLOATS)
    heave, velocity, acceleration, slow = np.array(record).T
    # Hermite: heave(t + h) follows from values, rates and accelerations at both ends but for h^5/720 of the fifth
    # derivative: 1e-8 m for 2 m at 1.5 rad/s; a jump of the amplitude of a component would be 1e-3 m
    h2 = h * h / 12.0
    gap = np.diff(heave) - 0.5 * h * (velocity[1:] + velocity[:-1]) + h2 * np.diff(acceleration)
    assert np.max(np.abs(gap)) < 1e-7
    assert np.max(np.abs(heave)) > 0.5
    assert 0.0 < slow.min() < 0.9  # the sea changes, and slowly enough


def test_variance_of_a_long_record_is_that_of_the_theory() -> None:
    x = start(HEAD)
    free = [ship_in_sea.free_motion(7.3 * k, x._replace(looks=0.0), PARAMETERS) for k in range(6000)]
    # 6000 samples 7.3 s apart of a Gaussian record, correlation time near 10 s: 3 % is three standard errors
    assert np.var([f[0] for f in free]) == pytest.approx(0.4626958, rel=0.05)
    assert free[0][3] == pytest.approx(0.46269584308, rel=1e-9)  # the rule's variance error is 1.5e-9


def test_spread_components_have_frequencies_of_their_own_and_the_right_variance() -> None:
    p = replace(PARAMETERS, spreading=5.0, directions=24.0, components=300.0)
    sea = p.sea
    assert len(set(sea.x)) == len(sea.x)
    amplitudes = hr.heave_amplitudes(6.096, waves.peak_frequency(6.096), 7.5, math.pi, HULL, sea)
    # about a dozen frequencies a direction integrate the response to a percent
    assert 0.5 * sum(a * a for a in amplitudes) == pytest.approx(0.80002, rel=1e-2)


def test_response_to_the_line_is_that_of_the_ship() -> None:
    u = HEAD._replace(reaction=4e5)
    c = cubics(u)
    x, m = start(u), ship_in_sea.Modes()
    p = ship.Parameters(1.0, 8.0, 0.0, 0.0, PARAMETERS.mass, PARAMETERS.damping, PARAMETERS.stiffness, 0.05)
    z = ship.State(0.0, 0.0)
    for k in range(50):
        x = ship_in_sea.advance(k * 0.2, 0.2, x, m, c, PARAMETERS, FLOATS)
        z = ship.advance(k * 0.2, 0.2, z, ship.Modes(), ship.Inputs(c.reaction), p, FLOATS)
    assert (x.response, x.response_rate) == z


def test_calm_is_still_and_its_margins_are_finite() -> None:
    calm = ship_in_sea.Inputs(0.0, 0.0, 0.0, math.pi, 0.0)
    out = ship_in_sea.outputs(0.0, start(calm), ship_in_sea.Modes(), calm, calm, PARAMETERS, FLOATS)
    assert (out.heave, out.velocity, out.significant_heave) == (0.0, 0.0, 0.0)
    assert (out.margin_sdof, out.margin_froude, out.margin_slow_sea) == (1.0, 1.0, 1.0)


def test_too_few_directions_are_refused() -> None:
    for spreading, enough in ((8.0, False), (-1.0, True)):
        ((value, text),) = ship_in_sea.requirements(replace(PARAMETERS, spreading=spreading), FLOATS)
        assert (value > 0.0) == enough and "directions" in text
