"""The bar with a load at its end: against its closed form, and the bound of the check `wire` against a chain of masses."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from towage.checks.wire_cost import Line, apart, cost_of, frequency
from towage.models.heave import elastic_bar

Array = NDArray[np.float64]
NODES, PERIOD, RECORDED = 12, 8.0, 64
ROUGH = 0.005
"""Errors below are those of the chain, second order in 1/NODES."""


def test_deep_lift_has_its_published_values() -> None:
    """3000 m of wire of 45 kg/m and 5e8 N under 250 t at 10 s: load/top 3.531 and 472.55 kN/m; without mass 2.452 and 242.0."""
    omega, k = 2.0 * math.pi / 10.0, 5e8 / 3000.0
    load, top, _ = elastic_bar.response(omega, k, 45.0 * 3000.0, 250e3)
    assert load == pytest.approx(3.531, abs=5e-4) and abs(top) == pytest.approx(472.55e3, abs=10.0)
    load, top, low = elastic_bar.response(omega, k, 0.0, 250e3)
    assert load == pytest.approx(2.452, abs=5e-4) and abs(top) == pytest.approx(242.0e3, abs=50.0) and low == top
    assert elastic_bar.angle(omega, k, 45.0 * 3000.0) == pytest.approx(0.57, abs=0.005)


@pytest.mark.parametrize("theta", [1e-6, 0.019999, 0.020001, 0.5, 1.5])
def test_shares_are_those_of_the_bar(theta: float) -> None:
    """K (x - y) with them is K theta (x cos theta - y)/sin theta at the top and K theta (x - y cos theta)/sin theta below."""
    a, b = elastic_bar.shares(theta)
    for x, y in ((1.0, 0.0), (0.0, 1.0)):
        top = x - y - theta**2 * (a * x + b * y)
        low = x - y + theta**2 * (b * x + a * y)
        stiff = theta / math.sin(theta)
        assert top == pytest.approx(stiff * (x * math.cos(theta) - y), rel=1e-9)
        assert low == pytest.approx(stiff * (x - y * math.cos(theta)), rel=1e-9)


def test_beyond_its_first_frequency_nothing_is_said() -> None:
    with pytest.raises(ValueError, match="expected less than pi/2"):
        elastic_bar.shares(1.58)


def test_motion_in_time_is_that_of_the_closed_form() -> None:
    omega, k, wire, load = 0.628, 1.6e5, 1.3e5, 2.5e5
    h, periods = 0.02, 3
    half = np.arange(2 * round(periods * 2.0 * math.pi / omega / h) + 1) * h / 2.0
    y, top, low = elastic_bar.response(omega, k, wire, load)
    x = np.cos(omega * half)
    path = elastic_bar.follow(
        elastic_bar.Lift(k, wire, load, 0.0, 1e7, omega), h, x.tolist(), (-(omega**2) * x).tolist(), (y, 0.0)
    )
    for found, size, mean in ((path.load, y, 0.0), (path.top, top, 1e7), (path.low, low, 1e7)):
        assert np.abs(np.array(found) - mean - size * x[::2]).max() < 1e-6 * abs(size)
    assert path.impact == 0.0


def chain(k: Array, wire: Array, load: Array, drag: Array, weight: Array, own: Array, drive: tuple[Array, Array, Array],
          zeta: float, periods: int, settle: int) -> tuple[Array, Array, Array, Array, Array]:  # fmt: skip
    """(times; x; y; tensions at top and load without the wire's own weight), of `NODES` masses on springs that cannot push,
    with a wire damped by ``zeta`` of critical in its first mode; each argument of shape (cases,). Leapfrog."""
    theta = 2.0 * math.pi / PERIOD * np.sqrt(wire / k)
    finer = 6.0 if zeta else 2.2
    steps = math.ceil(2.0 * math.pi / float(theta.min()) * NODES * finer / RECORDED) * RECORDED
    dt, each = PERIOD / steps, steps // RECORDED
    stiff, node = (k * NODES)[:, None], np.repeat((wire / NODES)[:, None], NODES, 1)
    loss = (2.0 * zeta * k * NODES / (0.5 * math.pi * np.sqrt(k / wire)))[:, None]
    mass, pulls = node.copy(), np.repeat((own / NODES)[:, None], NODES, 1)
    mass[:, -1] = 0.5 * node[:, 0] + load
    pulls[:, -1] = 0.5 * pulls[:, -1] + weight
    static = weight[:, None] + own[:, None] * (NODES - np.arange(NODES) - 0.5) / NODES
    u = np.zeros_like(mass)
    v = np.zeros_like(mass)
    frequencies, sizes, phases = drive

    def top(t: float) -> tuple[Array, Array, Array]:
        s = min(t / (5.0 * PERIOD), 1.0)
        rise = s**3 * (10.0 - 15.0 * s + 6.0 * s * s)
        angle = frequencies * t + phases
        rate, second = sizes * frequencies * np.cos(angle), -sizes * frequencies**2 * np.sin(angle)
        return rise * (sizes * np.sin(angle)).sum(1), rise * rate.sum(1), rise * second.sum(1)

    def tension(t: float) -> Array:
        x, x1, _ = top(t)
        stretch = static - stiff * np.diff(np.column_stack([x, u]), axis=1)
        damped = stretch - loss * np.diff(np.column_stack([x1, v]), axis=1)
        return np.where(stretch > 0.0, np.maximum(damped, 0.0), 0.0)

    rows = []
    for n in range(steps * periods):
        if n % each == 0:
            x, _, x2 = top(n * dt)
            pulled = tension(n * dt)
            above = pulled[:, 0] + 0.5 * node[:, 0] * x2 - own * (NODES - 0.5) / NODES
            rows.append((x, u[:, -1].copy(), above, pulled[:, -1] - 0.5 * own / NODES))
        u += 0.5 * dt * v
        pulled = tension((n + 0.5) * dt)
        force = pulled - pulls
        force[:, :-1] -= pulled[:, 1:]
        force[:, -1] -= drag * np.abs(v[:, -1]) * v[:, -1]
        v += dt * force / mass
        u += 0.5 * dt * v
    x, y, above, below = (np.array(a) for a in zip(*rows))
    return np.arange(len(x)) * PERIOD / RECORDED, x, y, above, below


def errors(seed: int, kind: str, slack: bool, cases: int, periods: int, settle: int, zeta: float = 0.0) -> Array:
    """Rows (true error, bound) of random lifts on a wire damped by ``zeta`` of critical: omega L/c from 0.1 to 0.7 (slack: 0.05
    to 0.3), omega over the natural frequency from 0.1 to 4 (0.4 to 2.5), drag b X/M from 0.03 to 5 (0.2 to 5)."""
    rng = np.random.default_rng(seed)
    omega = 2.0 * math.pi / PERIOD
    low, high, r0, r1, d0 = (-1.3, -0.5, -0.4, 0.4, -0.7) if slack else (-1.0, -0.155, -1.0, 0.6, -1.5)
    theta, ratio = 10 ** rng.uniform(low, high, cases), 10 ** rng.uniform(r0, r1, cases)
    load = np.full(cases, 1e5)
    k = omega**2 * load / ratio**2
    wire, drag = (theta / ratio) ** 2 * load, 10 ** rng.uniform(d0, 0.7, cases) * load
    count = {"regular": 1, "two": 2, "irregular": 12}[kind]
    frequencies, sizes = np.full((cases, count), omega), np.ones((cases, count))
    phases = rng.uniform(0.0, 2.0 * math.pi, (cases, count))
    if kind == "two":
        frequencies[:, 1], sizes[:, 1] = omega * rng.uniform(0.4, 2.2, cases), rng.uniform(0.1, 1.0, cases)
    elif kind == "irregular":
        frequencies = omega * rng.uniform(0.5, 1.8, (cases, count))
        sizes = np.exp(-(((frequencies / omega - 1.0) / 0.35) ** 2)) / math.sqrt(count)
    swing = k * np.abs(1.0 / np.abs(1.0 - ratio**2 + 1j * 0.85 * drag / load * ratio) - 1.0) + 0.5 * wire * omega**2
    weight = swing * (rng.uniform(0.5, 1.0, cases) if slack else 50.0)
    own = np.where(rng.random(cases) < 0.5, 0.0, np.minimum(0.85 * 9.81 * wire, 0.5 * weight)) if slack else np.zeros(cases)
    times, x, y, top, below = chain(
        k, wire, load, drag, weight, own, (frequencies, sizes, phases), zeta, periods, settle
    )
    late, rows = times >= settle * PERIOD, []
    for i in range(cases):
        line = Line("line", "", "", (load[i],), drag[i], k[i], wire[i], 1.0, weight[i], (0.0, 0.0), zeta)
        cost, heave = cost_of(line, load[i], wire[i], times, x[:, i], settle * PERIOD, False)
        own_tension = np.maximum(0.0, weight[i] + k[i] * (x[:, i] - heave))
        true = max(
            apart(heave[late], y[late, i], None, False),
            *(apart(own_tension[late], t[late, i], weight[i], False) for t in (top, below)),
        )
        settled = all(np.abs(a[-RECORDED:] - a[-2 * RECORDED : -RECORDED]).max() < 0.02 * a.std() for a in (heave, y[:, i]))
        if settled or not slack:
            rows.append((true, cost.bound))
    return np.array(rows)


@pytest.mark.parametrize("kind", ["regular", "two", "irregular"])
def test_the_bound_holds_on_random_taut_lines(kind: str) -> None:
    """No error above its bound, and the bound is sharp: median of the ratio below 1.3."""
    true, bound = errors(4, kind, False, 24, 14, 7).T
    counts = true > ROUGH
    assert counts.sum() > 12
    assert (bound >= true)[counts].all()
    assert np.median((bound / true)[counts]) < 1.3


@pytest.mark.parametrize(
    ("zeta", "sharp"),
    [(0.05, 7.0), pytest.param(0.01, 20.0, marks=pytest.mark.slow), pytest.param(0.0, 200.0, marks=pytest.mark.slow)],
)
def test_the_bound_holds_where_the_line_goes_slack(zeta: float, sharp: float) -> None:
    """Periodic motions; the wire loses the waves of a snap as its damping says, the undamped one none. The bound is that of the
    larger of the errors in motion and tension, below the size at which both are of order 1; it takes the waves of all snaps
    as in step, so that it is the less ``sharp`` (median of the ratio) the longer they last."""
    true, bound = errors(5, "regular", True, 24, 20, 16, zeta).T
    counts = (true > ROUGH) & (true < 0.5)
    assert counts.sum() > (8 if zeta > 0.01 else 2)  # without damping few lifts settle
    assert (bound >= true)[counts].all()
    assert np.median((bound / true)[counts]) < sharp


def test_waves_of_snaps_add_up_as_they_die_out() -> None:
    """A top that is jerked up by a saw-tooth: every snap adds its speed to what is left of the others."""
    h, period, decay = 0.01, 4.0, 0.5
    time = 0.5 * h * np.arange(2 * 6000 + 1)
    x = 3.0 * np.sin(2.0 * math.pi / period * time)
    lift = elastic_bar.Lift(1e3, 1.0, 100.0, 200.0, 200.0, 2.0 * math.pi / period)
    one, two, all_of = (
        elastic_bar.follow(lift, h, x.tolist(), np.gradient(np.gradient(x, time), time).tolist(), (0.0, 0.0), 3000, rate)
        for rate in (1e3, decay, 0.0)
    )
    assert one.impact == two.impact == all_of.impact > 1.0
    assert one.ringing == pytest.approx(one.impact, rel=1e-4)
    assert two.impact < two.ringing < two.impact / (1.0 - math.exp(-decay * period)) * 1.5
    assert all_of.ringing > 10.0 * two.impact  # 15 periods


def test_frequency_of_one_and_of_many() -> None:
    times = np.arange(0.0, 100.0, 0.1)
    assert frequency(times, np.sin(0.7 * times)) == pytest.approx(0.7, abs=1e-3)
    assert frequency(times, np.sin(0.7 * times) + np.sin(0.7 * times + 1.0)) == pytest.approx(0.7, abs=1e-3)
    assert frequency(times, np.sin(0.7 * times) + np.sin(1.4 * times)) == pytest.approx(1.4, rel=0.1)
    assert frequency(times, np.zeros(1000)) == 0.0 == frequency(times[:3], times[:3])


@pytest.mark.parametrize("weight", [0.0, 1e6])
@pytest.mark.parametrize("wire", [0.0, 1e3])
def test_nothing_that_moves_has_no_error(weight: float, wire: float) -> None:
    times = np.arange(0.0, 50.0, 0.1)
    line = Line("line", "", "", (1e5,), 0.0, 1e5, wire, 30.0, weight, (0.0, 0.0))
    assert cost_of(line, 1e5, wire, times, 0.0 * times, 10.0, False)[0].error == 0.0
    assert cost_of(line, 1e5, 0.0, times, np.sin(times), 10.0, False)[0].error == 0.0
    assert cost_of(line, 1e5, wire, times[:1], times[:1], 0.0, False)[0].error == 0.0
