"""The unit's model in the time domain: exactness, order on a speed ramp, resolution, fast modes, refusals, margins."""

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.linalg import eig, expm

from towage.fmus.slender_body import UNIT
from towage.models.numeric.matrix_ops import numbers
from towage.models.numeric.ops import FLOATS
from towage.models.protocol.linear_model import NoModes
from towage.models.slender import body as slender_body
from towage.models.slender import critical as slender_critical
from towage.models.slender.coefficients import Body
from towage.models.slender.damping import FAST, exponential, fast_mode_damping
from towage.models.slender.galerkin import Matrices
from towage.models.slender.modes import matrices, roots, spectrum
from towage.models.slender.prepared import prepare
from towage.models.slender.setup import Parameters, masses, refusal

Array = NDArray[np.float64]
MODEL = slender_body.SLENDER_BODY
advanced: Any = MODEL.advance
BASE = Parameters(**{v.name: float(v.start or 0.0) for v in UNIT.parameters})
FLUID, _ = masses(BASE, FLOATS)
SPEED = 2.7


def run(
    p: Parameters, step: float, stop: float, speed: Callable[[float], float], craft: Callable[[float], float],
    order: int = 3,
) -> Array:
    """(tip, tail, yaw) every 0.4 s. The craft's motion is a cubic over a step from values and central differences of
    1e-6, or with ``order`` = 1 linear; the speed is linear."""
    x, m = MODEL.initial(p, FLOATS)
    rows = []

    def rate(f: Callable[[float], float], t: float) -> float:
        return (f(t + 1e-6) - f(t - 1e-6)) / 2e-6

    for k in range(round(stop / step)):
        t = k * step
        a, b = craft(t), craft(t + step)
        slope = (b - a) / step
        if order == 1:
            w = (a, slope, 0.0, 0.0)
        else:
            da, db = rate(craft, t), rate(craft, t + step)
            w = (a, da, (3.0 * slope - 2.0 * da - db) / step, (da + db - 2.0 * slope) / step**2)
        u = (speed(t), (speed(t + step) - speed(t)) / step, 0.0, 0.0)
        x = advanced(t, step, x, m, (u, w), p, FLOATS)
        if round((t + step) / 0.4 * 1e6) % 10**6 == 0:
            found = observe(p, x, speed(t + step), craft(t + step), t + step)
            rows.append((found.tip, found.tail, found.yaw_angle * p.length))
    return np.array(rows)


def observe(p: Parameters, x: tuple[float, ...], speed: float, craft: float, t: float = 0.0) -> slender_body.Outputs:
    return MODEL.outputs(
        t, x, NoModes(), slender_body.Inputs(speed, craft), slender_body.Inputs(0.0, 0.0), p, FLOATS
    )


def advance(p: Parameters, x: tuple[float, ...], h: float, speed: float, craft: float) -> tuple[float, ...]:
    held = [(speed, 0.0, 0.0, 0.0), (craft, 0.0, 0.0, 0.0)]
    return advanced(0.0, h, x, NoModes(), held, p, FLOATS)


def test_step_is_exact() -> None:
    """One step of 5 s equals fifty of 0.1 s, up to the rounding of matrix exponentials of norm 1e3."""
    start, _ = MODEL.initial(BASE, FLOATS)
    once, many = advance(BASE, start, 5.0, SPEED, 0.1), start
    for _ in range(50):
        many = advance(BASE, many, 0.1, SPEED, 0.1)
    assert once == pytest.approx(many, abs=1e-10)


def test_consistency_with_implicit_integration() -> None:
    """Radau on the same equations, to its tolerance of 1e-9 a step."""
    made = prepare(BASE)
    u = SPEED / made.speed
    a, b = made.system.companion(u) / made.tau, made.system.load(u) / made.tau

    def craft(t: float) -> float:
        return 0.1 * math.sin(0.5 * t)

    solution = solve_ivp(
        lambda t, z: a @ z + b * craft(t), (0.0, 4.0), np.zeros(28), "Radau", rtol=1e-9, atol=1e-12,
        jac=a,
    )  # fmt: skip
    wanted = (made.points @ solution.y[:14, -1])[:2]
    # cubic over 0.1 s: (0.05)^4/384 of the motion; Radau adds its tolerance over some thousand steps
    assert run(BASE, 0.1, 4.0, lambda t: SPEED, craft)[-1, :2] == pytest.approx(wanted, abs=2e-8)


def test_craft_at_rest_beside_the_course() -> None:
    """The body follows to w, at speeds at which it is stable."""
    x = advance(BASE, MODEL.initial(BASE, FLOATS)[0], 4000.0, SPEED, 0.1)
    found = observe(BASE, x, SPEED, 0.1)
    # decay exp(-0.0144 * 4000) = 1e-25; the matrix exponential squares its rounding over 4000 s
    assert (found.tip, found.tail, found.rope_angle, found.lateral_force) == pytest.approx((0.1, 0.1, 0.0, 0.0), abs=1e-9)


def ramp_errors(order: int) -> tuple[list[float], list[float]]:
    """Steps, s, and errors relative to the largest motion, on the ramp of the spec."""

    def speed(t: float) -> float:
        return 1.5 + 1.5 * t / 20.0

    def craft(t: float) -> float:
        return 0.1 * math.sin(0.5 * t)

    reference = run(BASE, 0.025, 20.0, speed, craft)
    steps = [0.4, 0.2, 0.1]
    errors = [
        float(np.max(np.abs(run(BASE, h, 20.0, speed, craft, order) - reference)) / np.max(np.abs(reference)))
        for h in steps
    ]
    return steps, errors


def test_second_order_on_a_speed_ramp() -> None:
    """Speed frozen at mid-step, craft linear over a step: order 2; 2.1e-4 at 0.1 s as in the spec."""
    steps, errors = ramp_errors(1)
    order = np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert order == pytest.approx(2.0, abs=0.1)
    assert errors[-1] < 3e-4


def test_speed_ramp_with_cubic_craft_motion() -> None:
    """What a unit sees under cubic coupling: below 1e-4 at 0.1 s."""
    _, errors = ramp_errors(3)
    assert errors[-1] < 1e-5  # measured 2e-6
    assert errors[0] > errors[1] > errors[2]


def damped(body: Body, n: int, zeta: float = 0.02) -> Matrices:
    plain = matrices(body, n)
    return replace(plain, extra=fast_mode_damping(plain, zeta, numbers()))


SPEEDS = (0.05, 0.7, 2.0, 3.5, 5.0, 6.5, 8.0, 10.0, 12.0)


@pytest.mark.parametrize("rope", [0.5, 1.0, 10.0])
def test_first_five_modes_to_four_digits_with_28_states(rope: float) -> None:
    """|s| < 125, damping of fast modes included: 1e-4 at every speed up to u = 12."""
    body = Body(rope_length=rope)
    system = damped(body, 14)
    for u in SPEEDS:
        wanted = spectrum(matrices(body), u, 6)
        found = roots(system, u)
        for s in wanted[np.abs(wanted) < 125.0]:
            assert np.min(np.abs(found - s)) < 1e-4 * abs(s)


@pytest.mark.parametrize("n", [12, 14, 16, 20])
@pytest.mark.parametrize("body", [Body(), Body(rope_length=0.5), Body(rope_length=10.0, tail_cut=0.4), Body(damping=1e-4)])
def test_no_growing_mode_that_the_body_does_not_have(n: int, body: Body) -> None:
    """Every growing mode lies next to one of the converged spectrum that grows."""
    system = damped(body, n)
    for u in SPEEDS:
        found, wanted = roots(system, u), roots(matrices(body), u)
        for s in found[found.real > 0.0]:
            true = wanted[np.argmin(np.abs(wanted - s))]
            assert true.real > 0.0
            assert abs(true - s) < 0.02 * abs(s)  # n = 12 has the modes near |s| = 120 to 3e-3 and up to 200 to 1e-2


def test_without_damping_fast_modes_do_grow() -> None:
    """The trap that the damping is for: n = 14 at u = 12 has Re s near 10.6 at |s| near 1900."""
    s = roots(matrices(Body(), 14), 12.0)
    fast = s[np.abs(s) > FAST]
    assert np.max(fast.real) > 10.0
    assert np.max(roots(matrices(Body(), 26), 12.0).real[:40]) < 12.0


def test_damping_leaves_slow_modes_alone() -> None:
    """5e-6 of the first five modes with n = 14; at u = 0 nothing at all but rounding."""
    plain, system = matrices(Body(), 14), damped(Body(), 14)
    for u in (4.0, 12.0):
        before, after = spectrum(plain, u, 5), spectrum(system, u, 5)
        assert np.max(np.abs(after - before) / np.abs(before)) < 2e-5
    # (K0 + s^2 M) q = 0 of the slow modes is met by the damped system too: E q = 0
    slow = np.linalg.eig(np.linalg.solve(plain.mass, plain.bending))
    chosen = slow.eigenvectors[:, np.sqrt(np.abs(slow.eigenvalues)) < 500.0].real
    assert np.max(np.abs(system.extra @ chosen)) < 1e-8 * np.max(np.abs(system.extra))


@pytest.mark.parametrize("n", [10, 14, 20])
@pytest.mark.parametrize("body", [Body(), Body(end_length=0.1, mass_ratio=0.8), Body(theory="corrected", tail_cut=0.3)])
def test_damping_is_that_of_eigenvectors(n: int, body: Body) -> None:
    """The definition, mode by mode: E = sum of 2 zeta kappa M v w^H M/(w^H M v) over the fast modes; measured 1e-14."""
    plain = matrices(body, n)
    square, left, right = eig(plain.bending, plain.mass, left=True, right=True)
    wanted = np.zeros((n, n))
    for value, w, v in zip(square, left.T.conj(), right.T):
        kappa = math.sqrt(max(0.0, value.real))
        if kappa > FAST:
            wanted += (2.0 * 0.02 * kappa * np.outer(plain.mass @ v, w @ plain.mass) / (w @ plain.mass @ v)).real
    found = fast_mode_damping(plain, 0.02, numbers())
    assert np.max(np.abs(wanted)) > 1.0
    assert np.max(np.abs(found - wanted)) < 1e-11 * np.max(np.abs(wanted))


def test_rigid_has_two_pairs_of_states_and_its_own_resolution() -> None:
    rigid = replace(BASE, flexible=0.0)
    x, _ = MODEL.initial(replace(rigid, lateral_start=0.2, yaw_start=0.01), FLOATS)
    assert len(x) == 4
    found = observe(rigid, x, 1.0, 0.2)
    assert found.yaw_angle == pytest.approx(0.01, rel=1e-12)
    assert found.tip - found.tail == pytest.approx(0.01 * (10.0 + 0.15), rel=1e-12)
    assert found.margin_resolution < 0.0  # u = 1.33: flexure matters for the rope modes beyond 5 %
    assert observe(BASE, MODEL.initial(BASE, FLOATS)[0], 1.0, 0.0).margin_resolution > 0.8


def test_growth_rate_and_margin_change_sign_at_the_critical_speed() -> None:
    made = prepare(BASE)
    limit = slender_critical.yaw(made.body, 5.0)[0] * made.speed
    x, _ = MODEL.initial(BASE, FLOATS)
    below, above = observe(BASE, x, limit * 0.9999, 0.0), observe(BASE, x, limit * 1.0001, 0.0)
    assert below.growth_rate > 0.0 > above.growth_rate
    assert below.margin_stability < 0.0 < above.margin_stability
    assert observe(BASE, x, 0.0, 0.0).margin_stability == 1.0


def test_margins() -> None:
    x, _ = MODEL.initial(replace(BASE, yaw_start=0.1), FLOATS)
    assert observe(BASE, x, SPEED, x[0] + 0.0).margin_small_slope == pytest.approx(0.5, abs=0.02)  # 0.1 of 0.2 rad
    heavy = replace(BASE, mass_per_length=1.05 * FLUID)
    x, _ = MODEL.initial(heavy, FLOATS)
    assert observe(heavy, x, SPEED, 0.0).margin_neutral_buoyancy == pytest.approx(0.5, rel=1e-9)
    assert all(math.isfinite(v) for v in observe(heavy, x, 1e-12, 0.0))


def test_rates_of_outputs_against_differences() -> None:
    x, _ = MODEL.initial(replace(BASE, yaw_start=0.02), FLOATS)
    x = advance(BASE, x, 2.0, SPEED, 0.1)
    h = 1e-4
    before, after = observe(BASE, x, SPEED, 0.1), observe(BASE, advance(BASE, x, h, SPEED, 0.1), SPEED, 0.1)
    for name in ("tip", "tail", "yaw_angle", "lateral_force"):
        mean = 0.5 * (getattr(before, f"{name}_rate") + getattr(after, f"{name}_rate"))
        difference = (getattr(after, name) - getattr(before, name)) / h
        assert difference == pytest.approx(mean, rel=1e-5, abs=1e-9)  # h^2/12 times fast curvature, rounding over h


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"end_length": 0.12}, "more than 0.5"),
        ({"tail_cut": 0.0}, "tail_cut"),
        ({"tail_cut": 1.5}, "tail_cut"),
        ({"theory": 3.0}, "theory"),
        ({"theory": 0.5}, "theory"),
        ({"flexible": 0.5}, "flexible"),
        ({"shape_functions": 14.5}, "shape_functions"),
        ({"shape_functions": 3.0}, "shape_functions"),
        ({"rope_length": 0.0}, "rope_length"),
        ({"length": math.nan}, "length"),
        ({"structural_damping": -1.0}, "damping"),
        ({"friction_coefficient": math.inf}, "finite"),
        ({"theory": 2.0, "tail_factor": 3.0}, "tension"),
    ],
)
def test_refusals_give_the_reason(change: dict[str, float], message: str) -> None:
    assert refusal(BASE) == ""
    reason = refusal(replace(BASE, **change))
    assert reason is not None
    assert message in reason


def test_negative_speed_is_refused() -> None:
    x, m = MODEL.initial(BASE, FLOATS)
    with pytest.raises(ValueError, match="towed nose first"):
        advance(BASE, x, 0.1, -1.0, 0.0)
    with pytest.raises(ValueError, match="towed nose first"):
        advanced(0.0, 1.0, x, m, [(0.1, -1.0, 0.0, 0.0), (0.0,) * 4], BASE, FLOATS)
    assert observe(BASE, x, -1.0, 0.0).tension == 0.0


@pytest.mark.parametrize("speed", [0.0, 1e-9])
def test_no_speed_is_a_free_body(speed: float) -> None:
    """At rest nothing pulls: a body that drifts goes on drifting."""
    x, _ = MODEL.initial(BASE, FLOATS)
    moving = (*x[:14], 0.5, *x[15:])
    after = advance(BASE, moving, 10.0, speed, 0.0)
    # 0.5 m/tau for 10 s; M couples translation to the other modes by the end masses, which cancels here to 1 %
    assert observe(BASE, after, speed, 0.0).tip == pytest.approx(0.5 * 10.0 / prepare(BASE).tau, rel=0.02)


@pytest.mark.parametrize("nu", [1e-4, 0.1, 10.0])
def test_step_is_exact_with_strong_structural_damping(nu: float) -> None:
    """Kelvin-Voigt numbers up to 10, where |s| reaches 1e9/tau: one step against fifty."""
    p = replace(BASE, structural_damping=nu * math.sqrt(BASE.bending_stiffness * 2.0 * FLUID) * BASE.length**2)
    assert prepare(p).body.damping == pytest.approx(nu, rel=1e-12)
    start, _ = MODEL.initial(replace(p, yaw_start=0.01), FLOATS)
    once, many = advance(p, start, 5.0, SPEED, 0.1), start
    for _ in range(50):
        many = advance(p, many, 0.1, SPEED, 0.1)
    # squaring a matrix exponential of norm 1e7 leaves 1e-9
    assert once == pytest.approx(many, abs=1e-7)
    assert all(map(math.isfinite, observe(p, once, SPEED, 0.1)))


@pytest.mark.parametrize(
    "change",
    [{"tail_cut": 1e-6}, {"rope_length": 1e-5}, {"rope_length": 1e4}, {"end_length": 0.1251}, {"end_length": 5.0},
     {"theory": 1.0}, {"theory": 2.0, "nose_factor": 0.62, "tail_factor": 0.43}, {"shape_functions": 4.0},
     {"shape_functions": 24.0}],
)  # fmt: skip
def test_extreme_bodies_step_and_report(change: dict[str, float]) -> None:
    p = replace(BASE, **change)
    assert refusal(p) == ""
    x, _ = MODEL.initial(replace(p, yaw_start=0.01), FLOATS)
    for _ in range(20):
        x = advance(p, x, 0.1, SPEED, 0.05)
    assert all(map(math.isfinite, observe(p, x, SPEED, 0.05)))


@pytest.mark.parametrize("scale", [0.0, 1e-8, 1.0, 5.0, 300.0])
def test_matrix_exponential_against_scipy(scale: float) -> None:
    """Both scale and square; 1e-12 of the norm for skew matrices, whose exponentials do not grow."""
    a = scale * np.random.default_rng(1).standard_normal((12, 12))
    a = a - a.T
    assert np.max(np.abs(exponential(a) - expm(a))) < 1e-12 * max(1.0, scale)
    assert exponential(np.array([[scale / 100.0]]))[0, 0] == pytest.approx(math.exp(scale / 100.0), rel=1e-14)
