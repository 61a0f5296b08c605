"""The towing units as instances: against the frequency domain and each other, state, refusals, margins."""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable

import numpy as np
import pytest

from towage.fmus.declare.unit import load
from towage.fmus.python.instance import Instance
from towage.fmus.python.values import CallError
from towage.models.cable.parameters import TowParameters, tow_of
from towage.models.cable.steady.perturbation import Excitation
from towage.models.cable.steady.response import respond
from towage.models.cable.units import tow_system

OMEGA, STEP = 1.2, 0.1
LINEAR = ("tow_system", "tow_cable")
ALL = (*LINEAR, "towed_body", "body_force")


def started(name: str, **parameters: float) -> Instance:
    unit = load(name)
    instance = Instance(unit)
    values = {**unit.start, **parameters}
    instance.set_up(0.0, None)
    instance.set_values([unit.index[k] for k in values], list(values.values()))
    instance.enter_initialization()
    instance.exit_initialization()
    return instance


def get(instance: Instance, *names: str) -> list[float]:
    return instance.get_values([instance.unit.index[n] for n in names])


def sine(instance: Instance, name: str, amplitude: float, t: float, omega: float = OMEGA) -> None:
    """Value and three derivatives of amplitude sin(omega t)."""
    s, c = amplitude * math.sin(omega * t), amplitude * omega * math.cos(omega * t)
    index = instance.unit.index
    instance.set_values(
        [index[name], *(index[f"{name}_d{k}"] for k in (1, 2, 3))], [s, c, -s * omega**2, -c * omega**2]
    )


def amplitudes(
    instance: Instance, names: tuple[str, ...], drive: Callable[[float], None], periods: int
) -> list[complex]:
    """Complex amplitudes of Re(q exp(-i omega t)) over the last period of many."""
    step = 2.0 * math.pi / OMEGA / 64
    rows = []
    for k in range(64 * periods):
        drive(k * step)
        instance.do_step(k * step, step)
        if k >= 64 * (periods - 1):
            rows.append(get(instance, *names))
    t = step * np.arange(64 * (periods - 1) + 1, 64 * periods + 1)
    return list(2.0 * np.mean(np.array(rows) * np.exp(1j * OMEGA * t)[:, None], axis=0))


def test_tow_system_agrees_with_the_frequency_domain() -> None:
    instance = started("tow_system", segments=40.0, tolerance=0.005, body_quadratic_drag=1.0)
    # a decaying start: the slowest mode needs many periods
    found = amplitudes(
        instance, ("reaction_surge", "reaction_heave", "body_velocity_heave", "tension_top"),
        lambda t: sine(instance, "velocity_heave", 0.1, t), 24,
    )  # fmt: skip
    values = {v.name: get(instance, v.name)[0] for v in instance.unit.parameters}
    tow = tow_of(TowParameters(**{k: values[k] for k in TowParameters.__dataclass_fields__}))
    # velocity 0.1 sin = Re(0.1 i exp(-i omega t)): displacement i v/omega
    r = respond(tow, OMEGA, Excitation(heave=1j * 0.1j / OMEGA))
    fx, fy = r.towpoint_force
    expected = (fx, fy, -1j * OMEGA * r.displacement[1][0, 0], r.tension[-1, -1])
    for a, b in zip(found, expected):
        # 40 segments and the reduction together; the apparent mass acts through the derivatives
        assert a == pytest.approx(complex(b), rel=0.01)


@pytest.mark.parametrize("name", LINEAR)
def test_one_step_is_two_half_steps(name: str) -> None:
    one, two = started(name), started(name)
    entry = next(iter(one.unit.reference_inputs))
    index = one.unit.index
    coefficients = (0.3, 0.2, -0.4, 0.5)
    names = [entry, *(f"{entry}_d{k}" for k in (1, 2, 3))]
    one.set_values([index[n] for n in names], list(coefficients))
    one.do_step(0.0, 0.4)
    a, b, c, d = coefficients
    two.set_values([index[n] for n in names], list(coefficients))
    two.do_step(0.0, 0.2)
    h = 0.2
    shifted = [a + h * (b + h * (c / 2 + h * d / 6)), b + h * (c + h * d / 2), c + h * d, d]
    two.set_values([index[n] for n in names], shifted)
    two.do_step(0.2, 0.2)
    outputs = [v.name for v in one.unit.observed]
    # rounding of two exponentials
    assert get(one, *outputs) == pytest.approx(get(two, *outputs), rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("name", ALL)
def test_state_restores_to_the_bit(name: str) -> None:
    instance = started(name)
    entry = next(iter(instance.unit.reference_inputs))
    outputs = [v.name for v in instance.unit.observed]

    def advance(first: int, last: int) -> list[float]:
        for k in range(first, last):
            sine(instance, entry, 0.2, k * STEP)
            instance.do_step(k * STEP, STEP)
        return get(instance, *outputs)

    advance(0, 5)
    saved = instance.state()
    once = advance(5, 10)
    instance.restore(saved)
    assert advance(5, 10) == once
    other = Instance(instance.unit)
    other.restore(saved)
    instance = other
    assert advance(5, 10) == once


@pytest.mark.parametrize(
    "name, values, message",
    [
        ("tow_system", {"body_lift": 9e3}, "buoyant"),
        ("tow_system", {"tow_speed": 0.0}, "speed is 0"),
        ("tow_system", {"tow_speed": -1.0}, "speed is -1"),
        ("tow_system", {"extensible": 1.0, "axial_stiffness": 0.0}, "axial stiffness"),
        ("tow_system", {"quadrant": 2.0}, "heavy"),
        ("tow_system", {"body_weight_in_water": 0.0, "body_drag": 0.0}, "no tension"),
        ("tow_system", {"body_mass": -1.0}, "at least 0"),
        ("tow_system", {"cable_length": -3.0}, "positive"),
        ("tow_cable", {"axial_stiffness": 0.0}, "over-determined"),
    ],
)
def test_refused_parameters(name: str, values: dict[str, float], message: str) -> None:
    with pytest.raises(CallError, match=message):
        started(name, **values)


def test_margins_at_rest_and_beyond() -> None:
    instance = started("tow_system")
    margins = [v.name for v in instance.unit.observed if v.name.startswith("margin_")]
    rest = dict(zip(margins, get(instance, *margins)))
    assert {n for n, v in rest.items() if v == pytest.approx(1.0)} >= {
        "margin_small_perturbation", "margin_slack", "margin_quadrant", "margin_inextensible",
    }  # fmt: skip
    assert rest["margin_resolution"] > 0.0
    sine(instance, "velocity_heave", 6.0, 0.0)
    for k in range(30):
        sine(instance, "velocity_heave", 6.0, k * STEP)
        instance.do_step(k * STEP, STEP)
    beyond = dict(zip(margins, get(instance, *margins)))
    assert beyond["margin_small_perturbation"] < 0.0
    assert all(math.isfinite(v) for v in beyond.values())


def test_rates_are_the_derivatives() -> None:
    instance = started("tow_system")
    names = ("reaction_heave", "tension_top", "body_velocity_heave", "body_heave")
    h = 1e-3
    for k in range(400):
        sine(instance, "velocity_heave", 0.2, k * h)
        instance.do_step(k * h, h)
        if k == 397:
            before = get(instance, *names)
        if k == 398:
            rates = get(instance, *(f"{n}_rate" for n in names))
    after = get(instance, *names)
    central = [(b - a) / (2.0 * h) for a, b in zip(before, after)]
    # central difference, h^2 omega^2 = 1e-6, and states of the apparent mass
    assert rates == pytest.approx(central, rel=1e-3, abs=1e-3)


def test_cable_and_body_units_make_the_tow_system() -> None:
    shared = {"axial_stiffness": 4e6, "segments": 10.0, "tolerance": 0.2, "reduced": 0.0, "body_quadratic_drag": 0.0}
    whole = started("tow_system", extensible=1.0, **shared)
    cable, body = started("tow_cable", **shared), started("towed_body", quadratic_drag=0.0)
    h, period = 0.01, 2.0 * math.pi / OMEGA

    def top(unit: Instance, name: str, t: float) -> None:
        sine(unit, name, 0.2, t)

    count = round(2.0 * period / h)
    force, velocity, rate = [0.0, 0.0], [0.0, 0.0], [0.0, 0.0]
    entries = ("force_surge", "force_heave")
    for k in range(count):
        t = k * h
        top(whole, "velocity_heave", t)
        whole.do_step(t, h)
        # body with the force and its slope, then the cable with the cubic that the body made; one corrector
        saved = cable.state(), body.state()
        guess, slope = force, [0.0, 0.0]
        for _ in range(3):
            cable.restore(saved[0])
            body.restore(saved[1])
            for e, f, s in zip(entries, force, slope):
                body.set_values([body.unit.index[e], body.unit.index[f"{e}_d1"]], [f, s])
            body.do_step(t, h)
            end = get(body, "velocity_surge", "velocity_heave")
            end_rate = get(body, "velocity_surge_rate", "velocity_heave_rate")
            top(cable, "top_velocity_heave", t)
            for axis, v0, v1, r0, r1 in zip(("surge", "heave"), velocity, end, rate, end_rate):
                c2 = 3.0 * (v1 - v0) / h**2 - (2.0 * r0 + r1) / h
                c3 = -2.0 * (v1 - v0) / h**3 + (r0 + r1) / h**2
                n = f"body_velocity_{axis}"
                cable.set_values([cable.unit.index[x] for x in (n, f"{n}_d1", f"{n}_d2", f"{n}_d3")],
                                 [v0, r0, 2.0 * c2, 6.0 * c3])  # fmt: skip
            cable.do_step(t, h)
            guess = get(cable, "body_force_surge", "body_force_heave")
            slope = [(b - a) / h for a, b in zip(force, guess)]
        force, velocity, rate = guess, end, end_rate
    got, expected = get(body, "velocity_heave")[0], get(whole, "body_velocity_heave")[0]
    # order 2 in the interface step: w h = 0.24 for the stiff last segment
    assert got == pytest.approx(expected, rel=0.02)
    assert get(cable, "reaction_heave")[0] == pytest.approx(get(whole, "reaction_heave")[0], rel=0.02)


def test_reaction_signs() -> None:
    # the towpoint is lifted: the cable pulls it down more
    instance = started("tow_system")
    index = instance.unit.index["velocity_heave"]
    instance.set_values([index], [0.5])
    instance.do_step(0.0, 1.0)
    reaction, tension, steady = get(instance, "reaction_heave", "tension_top", "steady_tension_top")
    assert reaction > 0.0 and tension > steady


def test_tuning_keeps_the_state_and_moves_the_steady_tow() -> None:
    instance, fresh = started("tow_system", reduced=0.0), started("tow_system", reduced=0.0, tow_speed=4.0)
    index = instance.unit.index
    sine(instance, "velocity_heave", 0.2, 0.0)
    instance.do_step(0.0, STEP)
    x, (before,) = instance.state()[7], get(instance, "steady_tension_top")
    assert any(x)
    instance.set_values([index["tow_speed"]], [4.0])
    assert get(instance, "steady_tension_top") == get(fresh, "steady_tension_top") != [before]
    assert instance.state()[7] == x
    instance.do_step(STEP, STEP)
    instance.set_values([index["tow_speed"]], [-4.0])
    with pytest.raises(CallError, match="speed is -4"):
        instance.do_step(2.0 * STEP, STEP)
    assert get(instance, "tow_speed") == [4.0]


@pytest.mark.parametrize(
    "options, why",
    [
        ({"reduced": 1.0}, "the states of another reduced model mean something else, this needs reduced = 0"),
        ({"reduced": 0.0, "segments": 0.0, "tolerance": 0.5}, "another number of segments might be chosen"),
    ],
)
def test_a_reduced_model_cannot_be_tuned(options: dict[str, float], why: str) -> None:
    instance = started("tow_system", **options)
    index = instance.unit.index
    before = get(instance, "tension_top", "tow_speed")
    with pytest.raises(CallError, match=f"^tow_speed may not be set: {why}"):
        instance.set_values([index["tow_speed"]], [4.0])
    assert get(instance, "tension_top", "tow_speed") == before
    instance.do_step(0.0, STEP)


def test_parameters_of_unit_and_model_agree() -> None:
    assert {v.name for v in load("tow_system").parameters} == set(tow_system.Parameters.__dataclass_fields__)
    assert cmath.isfinite(complex(get(started("tow_system"), "model_error")[0]))
