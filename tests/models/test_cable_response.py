"""Frequency response of the tow cable against extended-precision references, limits and itself on finer meshes."""

from __future__ import annotations

import json
import math
import warnings
from dataclasses import replace
from importlib.resources import files

import numpy as np
import pytest

from towage.models.cable.case import Body, Cable, CableError, Tow
from towage.models.cable.loading import Loading, cross_flow, eames
from towage.models.cable.steady.perturbation import Excitation, Response
from towage.models.cable.steady.response import mesh, respond
from towage.models.cable.steady.shooting import LostIndependence, respond_by_shooting
from towage.models.cable.steady.steady import Steady, steady
from towage.verify.verify import check

KNOT = 1.68781
"""ft/s"""
HEAVE = Excitation(heave=3.0)


def deep_tow(length: float = 600.0, knots: float = 10.0, momentum: bool = True) -> Tow:
    """Steel cable of 0.6 in with 3000 lbf at its end; feet, slugs, pounds."""
    cable = Cable(length, 0.0173, 0.4315, 0.05, 1.5, eames(0.03), 1.0, momentum)
    return Tow(cable, Body(100.0, 20.0, 60.0, 3000.0, 0.0, 300.0), knots * KNOT, 1.99)


def float_tow() -> Tow:
    """Float above a submarine."""
    cable = Cable(300.0, 0.0173, 0.4315, 0.05, 1.5, eames(0.03), 1.0, True)
    return Tow(cable, Body(20.0, 5.0, 15.0, 640.0, 1400.0, 200.0), 6 * KNOT, 1.99, quadrant=2)


def halved(state: Steady) -> Steady:
    middle = 0.5 * (state.edges[:-1] + state.edges[1:])
    return steady(state.tow, np.sort(np.concatenate([state.edges, middle])))


def ends(r: Response) -> np.ndarray:
    fields = (r.angle, r.tension, r.normal, r.tangential)
    return np.array([f[at] for f in fields for at in ((0, 0), (-1, -1))])


def self_error(tow: Tow, omega: float, excitation: Excitation = HEAVE) -> float:
    """Largest relative difference of the end values to those on elements of half the size."""
    state = mesh(tow, omega)
    coarse, fine = ends(respond(tow, omega, excitation, state)), ends(respond(tow, omega, excitation, halved(state)))
    scale = np.repeat(np.abs(fine).reshape(4, 2).max(axis=1), 2)
    return float((np.abs(coarse - fine) / np.maximum(scale, 1e-300)).max())


CASES = json.loads((files("towage") / "reference" / "cable.json").read_text("utf-8"))["cases"]


@pytest.mark.parametrize("case", CASES, ids=[c["name"] for c in CASES])
def test_consistency_with_extended_precision(case: dict) -> None:
    result = check(case)
    assert result.ok, result.message
    # measured 6e-14; the file asks 1e-9
    assert result.worst_error < 1e-12


@pytest.mark.parametrize("hertz", [1e-8, 0.01, 0.3, 2.0, 5.0, 20.0])
def test_mesh_independence_over_frequency(hertz: float) -> None:
    # measured 4e-14 to 3e-13; shooting is wrong by 67 at 20 Hz
    assert self_error(deep_tow(), 2.0 * math.pi * hertz) < 1e-11


@pytest.mark.parametrize("hertz", [0.01, 0.1, 0.5])
def test_mesh_independence_at_five_kilometres(hertz: float) -> None:
    # measured 2e-13; shooting is wrong by 1e5 and more from 0.1 Hz on
    assert self_error(deep_tow(16404.0, 5.0), 2.0 * math.pi * hertz) < 1e-11


@pytest.mark.parametrize("weight", [30.0, 3.0, 0.3, 0.03])
def test_mesh_independence_at_slight_end_tension(weight: float) -> None:
    tow = deep_tow()
    tow = replace(tow, body=replace(tow.body, weight=weight, drag=0.1 * weight))
    # measured 7e-14: the graded mesh resolves the layer of thickness T0/D
    assert self_error(tow, 2.0 * math.pi * 0.3) < 1e-11


@pytest.mark.parametrize("speed", [1.0, 0.1, 1e-3, 1e-6])
def test_slow_tow(speed: float) -> None:
    # measured 5e-13: D/c is formed in closed form
    assert self_error(replace(deep_tow(), speed=speed), 2.0 * math.pi * 0.3) < 1e-11


def test_low_frequency_limit() -> None:
    # T1 goes with the frequency: the cable moves as a body
    slow, slower = (respond(deep_tow(), 2.0 * math.pi * f, HEAVE) for f in (1e-6, 1e-8))
    assert abs(slower.tension[-1, -1] / slow.tension[-1, -1]) == pytest.approx(0.01, rel=1e-4)
    assert abs(slower.displacement[1][0, 0]) == pytest.approx(3.0, rel=1e-6)


@pytest.mark.parametrize("drag", [0.0, 1e-9])
def test_vertical_lower_end(drag: float) -> None:
    tow = deep_tow()
    assert self_error(replace(tow, body=replace(tow.body, drag=drag)), 1.0) < 1e-11


def test_horizontal_weightless_cable_has_no_tension_from_heave() -> None:
    tow = deep_tow()
    tow = replace(tow, cable=replace(tow.cable, weight=0.0), body=replace(tow.body, weight=0.0))
    r = respond(tow, 1.0, HEAVE)
    # a straight cable along the stream: heave and tension are decoupled; rounding of phi0 = 1e-17
    assert abs(r.tension).max() < 1e-9 * abs(r.angle).max() * tow.end_tension


@pytest.mark.parametrize("degrees", [90.01, 91.0, 91.9])
def test_quadrant_two_near_vertical(degrees: float) -> None:
    tow = float_tow()
    lift = tow.body.weight + 800.0
    drag = -800.0 / math.tan(math.radians(degrees))
    tow = replace(tow, body=replace(tow.body, lift=lift, drag=drag))
    assert self_error(tow, 0.9, Excitation(drag=50.0, lift=100.0)) < 1e-11


def test_added_mass_forms_differ_as_measured() -> None:
    one, other = (respond(deep_tow(momentum=form), 2.0 * math.pi * 0.3, HEAVE) for form in (True, False))
    # 2.7e-5 to 1.7e-4 in T1, 3e-5 to 2.2e-3 in phi1 over the reference cases
    assert 1e-5 < abs(other.tension[-1, -1] / one.tension[-1, -1] - 1.0) < 1e-3
    assert 1e-5 < abs(other.angle[-1, -1] / one.angle[-1, -1] - 1.0) < 5e-3


def test_inextensible_limit_is_of_order_one_over_stiffness() -> None:
    rigid = ends(respond(deep_tow(), 2.0 * math.pi * 0.3, HEAVE))
    errors = []
    for stiffness in (2e7, 2e8, 2e9):
        tow = deep_tow()
        tow = replace(tow, cable=replace(tow.cable, axial_stiffness=stiffness))
        errors.append(float((np.abs(ends(respond(tow, 2.0 * math.pi * 0.3, HEAVE)) - rigid) / np.abs(rigid)).max()))
    # exponents of 1/EA within the next order's share
    assert math.log10(errors[0] / errors[1]) == pytest.approx(1.0, abs=0.1)
    assert math.log10(errors[1] / errors[2]) == pytest.approx(1.0, abs=0.01)


def test_configuration_is_the_accumulated_turn() -> None:
    tow = deep_tow()
    r = respond(tow, 2.0 * math.pi * 0.3, HEAVE, halved(mesh(tow, 2.0 * math.pi * 0.3)))
    s = 0.5 * (r.steady.edges[:-1] + r.steady.edges[1:])[:, None] + 0.5 * np.diff(r.steady.edges)[:, None] * -np.cos(
        np.pi * np.arange(17) / 16
    )
    turn = r.angle * np.cos(r.steady.angle)
    total = (0.5 * (turn[:, 1:] + turn[:, :-1]) * np.diff(s, axis=1)).sum()
    # trapezoidal quadrature on the solution's own nodes
    assert abs(total / r.configuration[1][-1, -1] - 1.0) < 1e-3


def test_shooting_agrees_until_its_modes_lose_independence() -> None:
    short = deep_tow(600.0, 6.0)
    found, condition = respond_by_shooting(short, 2.0 * math.pi * 0.3, HEAVE)
    # relative error 1e-16 times the condition number, and the integrator's 1e-12
    assert condition < 1e5
    assert np.abs(ends(found) / ends(respond(short, 2.0 * math.pi * 0.3, HEAVE)) - 1.0).max() < 1e-9
    with pytest.warns(LostIndependence, match="lost their independence"):
        respond_by_shooting(deep_tow(1200.0, 6.0), 2.0 * math.pi * 0.8, HEAVE)


def test_shooting_on_the_mesh_that_it_is_given() -> None:
    short, omega = deep_tow(600.0, 6.0), 2.0 * math.pi * 0.3
    state = halved(mesh(short, omega))
    fine, _ = respond_by_shooting(short, omega, HEAVE, state)
    assert fine.tension.shape == (len(state.edges) - 1, respond(short, omega, HEAVE).tension.shape[1])
    # the integrator's 1e-12 and 1e-16 times a condition number below 1e5
    assert np.abs(ends(fine) / ends(respond(short, omega, HEAVE, state)) - 1.0).max() < 1e-9


@pytest.mark.slow
def test_shooting_is_useless_at_five_hertz() -> None:
    tow = deep_tow()
    with pytest.warns(LostIndependence):
        found, condition = respond_by_shooting(tow, 2.0 * math.pi * 5.0, HEAVE)
    assert condition > 1e13
    assert np.abs(ends(found) / ends(respond(tow, 2.0 * math.pi * 5.0, HEAVE)) - 1.0).max() > 0.01


# ---- refusals


def refused(message: str, **changes: object) -> None:
    tow = deep_tow()
    parts = {"body": tow.body, "cable": tow.cable}
    own = {}
    for name, value in changes.items():
        owner, _, field = name.partition("__")
        if owner in parts:
            parts[owner] = replace(parts[owner], **{field: value})  # type: ignore[type-var]
        else:
            own[name] = value
    with pytest.raises(CableError, match=message):
        respond(replace(tow, **parts, **own), 1.0, HEAVE)


def test_refuses_what_makes_no_sense() -> None:
    refused("no tension at the body", body__weight=0.0, body__drag=0.0)
    refused("buoyant .* in Quadrant I", body__lift=4000.0)
    refused("heavy .* in Quadrant II", quadrant=2)
    refused("speed is 0", speed=0.0)
    refused("speed is -1", speed=-1.0)
    refused("cable.length is 0", cable__length=0.0)
    refused("cable.mass is -1", cable__mass=-1.0)
    refused("body.drag is -5", body__drag=-5.0)
    refused("density is nan", density=math.nan)
    refused("weight is inf", body__weight=math.inf)
    refused("axial_stiffness is 0", cable__axial_stiffness=0.0)
    refused("quadrant is 3", quadrant=3)
    refused("not finite", cable__loading=Loading((math.nan, 0.0, 0.0, 0.0, 0.0), (0.0,) * 5))
    for omega in (0.0, -1.0, math.nan, math.inf):
        with pytest.raises(CableError, match="angular frequency"):
            respond(deep_tow(), omega, HEAVE)
    with pytest.raises(CableError, match="excitation heave"):
        Excitation(heave=complex(0.0, math.nan))


def test_refuses_a_cable_that_leaves_its_quadrant() -> None:
    tow = float_tow()
    # neutral float: the cable starts along the stream and sinks
    with pytest.raises(CableError, match="leaves Quadrant II at"):
        respond(replace(tow, body=replace(tow.body, lift=tow.body.weight)), 1.0, Excitation(lift=1.0))


def test_refuses_a_frequency_beyond_its_elements() -> None:
    with pytest.raises(CableError, match="elements"):
        respond(deep_tow(16404.0, 5.0), 2.0 * math.pi * 1e4, HEAVE)


# ---- loading


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_loading_gradients_are_those_of_the_load(sign: float) -> None:
    loading = Loading((0.3, 0.1, -0.3, 0.05, 0.02), (0.01, 0.04, 0.02, 0.03, -0.01))
    theta = np.array([0.1, 0.7, 1.4]) if sign > 0 else np.array([1.8, 2.4, 3.0])
    normal, normal_slope, tangential, tangential_slope = loading.gradients(np.sin(theta), np.cos(theta))
    a, b = loading.normal, loading.tangential
    angles = [np.ones_like(theta), np.cos(theta), np.cos(2 * theta), np.sin(theta), np.sin(2 * theta)]
    # the source's form with sigma written out
    assert normal == pytest.approx(sum(c * s * f for c, s, f in zip(a, (1, sign, 1, 1, sign), angles)), abs=1e-15)
    assert tangential == pytest.approx(
        sum(c * s * f for c, s, f in zip(b, (sign, 1, sign, sign, 1), angles)), abs=1e-15
    )
    step = 1e-6
    for value, slope, index in ((normal, normal_slope, 0), (tangential, tangential_slope, 2)):
        ahead = loading.gradients(np.sin(theta + step), np.cos(theta + step))[index]
        # forward difference
        assert (ahead - value) / step == pytest.approx(slope, abs=1e-5)


def test_cross_flow_and_eames_forms() -> None:
    sine, cosine = np.sin(0.6), np.cos(0.6)
    normal, _, tangential, _ = cross_flow(0.07).gradients(sine, cosine)
    assert (normal, tangential) == pytest.approx((sine**2, 0.07 * cosine**2), rel=1e-14)
    normal, _, tangential, _ = eames(0.03).gradients(sine, cosine)
    assert (normal, tangential) == pytest.approx((0.97 * sine**2 + 0.03 * sine, 0.03 * cosine), rel=1e-14)


def test_no_warning_in_an_ordinary_solve() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        respond(deep_tow(), 1.0, HEAVE)
