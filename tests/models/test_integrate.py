"""The integrator alone: orders, events, refusals."""

import math

import pytest

from towage.models.heave.system import DORMAND_PRINCE_8
from towage.models.numeric.integrate import SMALLEST, IntegrationError, Vector, integrate, interpolate, unrolled
from towage.models.numeric.tableaus import DORMAND_PRINCE_5, Tableau


def kepler(t: float, x: Vector) -> Vector:
    """Two bodies, eccentricity 0.3 (class D of DETEST; T. E. Hull et al., SIAM J. Numer. Anal. 9 (1972) 603)."""
    cube = (x[0] ** 2 + x[1] ** 2) ** 1.5
    return x[2], x[3], -x[0] / cube, -x[1] / cube


START = (0.7, 0.0, 0.0, math.sqrt(1.3 / 0.7))
FAR = (-1.3, 0.0, 0.0, -math.sqrt(0.7 / 1.3))


@pytest.mark.parametrize(
    ("method", "order", "counts"), [(DORMAND_PRINCE_5, 5, (100, 400)), (DORMAND_PRINCE_8, 8, (8, 64))]
)
def test_fitted_order(method: Tableau, order: int, counts: tuple[int, int]) -> None:
    """Errors after half a revolution with fixed steps."""
    step = unrolled(method, 4)
    errors = []
    for n in counts:
        h, x, f = math.pi / n, START, kepler(0.0, START)
        for k in range(n):
            x, f, _ = step(kepler, k * h, x, f, h)  # type: ignore[assignment]
        errors.append(math.dist(x, FAR))
    fitted = math.log(errors[0] / errors[1]) / math.log(counts[1] / counts[0])
    # between the first steps that resolve the orbit and round-off the local slope of the eighth-order method swings by
    # one; over a factor of eight it averages to 7.7
    assert fitted == pytest.approx(order, abs=0.4)


@pytest.mark.parametrize("method", [DORMAND_PRINCE_5, DORMAND_PRINCE_8])
def test_tableau_rows_sum_to_their_nodes(method: Tableau) -> None:
    for c, row in zip(method.c, method.a, strict=True):
        assert sum(row) == pytest.approx(
            c, abs=1e-14
        )  # entries up to 44 cancel, the tableau is data of SciPy in double precision
    assert sum(method.b) == pytest.approx(1.0, abs=1e-14)
    for error in method.error:
        assert sum(error) == pytest.approx(0.0, abs=1e-14)


@pytest.mark.parametrize("method", [DORMAND_PRINCE_5, DORMAND_PRINCE_8])
@pytest.mark.parametrize("rtol", [1e-6, 1e-9, 1e-12])
def test_error_follows_the_tolerance(method: Tableau, rtol: float) -> None:
    x, _ = integrate(kepler, 0.0, START, 2.0 * math.pi, rtol=rtol, atol=(rtol,) * 4, first_step=0.01, method=method)
    assert math.dist(x, START) < 300.0 * rtol  # a revolution amplifies local errors about a hundredfold


@pytest.mark.parametrize("method", [DORMAND_PRINCE_5, DORMAND_PRINCE_8])
def test_event_is_located_to_round_off(method: Tableau) -> None:
    """x" = -x: zeros at odd multiples of pi/2."""
    times: list[float] = []

    def note(t: float, x: Vector) -> Vector:
        times.append(t)
        return x

    def rates(t: float, x: Vector) -> Vector:
        return x[1], -x[0]

    def zero(t: float, x: Vector) -> Vector:
        return (x[0],)

    integrate(
        rates, 0.0, (1.0, 0.0), 20.0, rtol=1e-13, atol=(1e-13, 1e-13), indicators=zero, on_event=note, method=method,
        first_step=0.1,
    )  # fmt: skip
    assert len(times) == 6
    for k, t in enumerate(times):
        assert t == pytest.approx((k + 0.5) * math.pi, abs=2e-12)  # 20 units of time at 1e-13


@pytest.mark.parametrize(("located", "order"), [(True, 5.0), (False, 2.0)])
def test_order_at_a_kink(located: bool, order: float) -> None:
    """x = t + u, u' = 1 - |u| from u = -1/2: u = e^t/2 - 1 up to ln 2, then 1 - 2 e^-t. One step an interval."""

    def rates(t: float, x: Vector) -> Vector:
        return (2.0 - abs(x[0] - t),)

    def kink(t: float, x: Vector) -> Vector:
        return (x[0] - t,)

    end, errors, ends = 3.0, [], list[float]()
    counts = [11, 13, 15, 17, 19, 22, 26, 30, 34, 38]  # ln 2 falls anywhere in its step
    for n in counts:
        x: Vector = (-0.5,)
        for k in range(n):
            x, _ = integrate(
                rates, k * end / n, x, (k + 1) * end / n, rtol=1e9, atol=(1.0,), first_step=end,
                indicators=kink if located else None, on_step=lambda t0, x0, f0, t1, x1, f1: ends.append(t1),
            )  # fmt: skip
        errors.append(abs(x[0] - (end + 1.0 - 2.0 * math.exp(-end))))
    first, second = (math.fsum(map(math.log, part)) / 5.0 for part in (errors[:5], errors[5:]))
    assert (first - second) / math.log(2.0) == pytest.approx(order, abs=0.6)  # means over five places of the kink
    assert (min(abs(t - math.log(2.0)) for t in ends) < 1e-6) == located  # to the error of the steps before it


def test_two_events_inside_one_step_are_both_seen() -> None:
    """A dip below zero that is over before a step ends: the middle of the step betrays it."""
    seen: list[float] = []

    def note(t: float, x: Vector) -> Vector:
        seen.append(t)
        return x

    integrate(
        lambda t, x: (1.0,), 0.0, (0.0,), 1.0, rtol=1e-9, atol=(1e-9,), first_step=1.0,
        indicators=lambda t, x: ((x[0] - 0.4) * (x[0] - 0.6),), on_event=note,
    )  # fmt: skip
    assert seen == pytest.approx([0.4, 0.6], abs=1e-11)  # the bracket is 1e-12 of the step


@pytest.mark.parametrize(("first", "second"), [(0.45, 0.55), (0.2, 0.25), (0.3, 0.31), (0.7, 0.75)])
@pytest.mark.parametrize("depth", [1.0, 1e-3, 1e-5])
def test_zeros_in_a_single_step_are_seen_in_spite_of_rounding(first: float, second: float, depth: float) -> None:
    """A shallow dip away from mid-step, or with equal values at both ends; where it has begun, the sign of 1 + g - 1 is
    that of rounding."""
    seen: list[float] = []
    integrate(
        lambda t, x: (1.0,), 0.0, (0.0,), 1.0, rtol=1e-9, atol=(1e-9,), first_step=1.0,
        indicators=lambda t, x: (1.0 + depth * (x[0] - first) * (x[0] - second) - 1.0,),
        on_event=lambda t, x: (seen.append(t), x)[1],  # type: ignore[func-returns-value]
    )  # fmt: skip
    resolution = 2.0**-52 / (depth * (second - first))  # a unit in the last place of 1 over the slope
    assert seen == pytest.approx([first, second], abs=2.0 * resolution + 1e-11)  # the bracket is 1e-12 of the step


def test_another_indicator_crosses_twice_before_an_event() -> None:
    """The step that an event has cut short is looked into as well."""
    seen: list[float] = []
    integrate(
        lambda t, x: (1.0,), 0.0, (0.0,), 1.0, rtol=1e-9, atol=(1e-9,), first_step=1.0,
        indicators=lambda t, x: (x[0] - 0.9, (x[0] - 0.2) * (x[0] - 0.25)),
        on_event=lambda t, x: (seen.append(t), x)[1],  # type: ignore[func-returns-value]
    )  # fmt: skip
    assert seen == pytest.approx([0.2, 0.25, 0.9], abs=1e-11)


def test_time_goes_on_where_every_branch_leads_back() -> None:
    """x' = -sign(x) slides along x = 0: an event follows every event."""
    falling, events = [True], [0]

    def turn(t: float, x: Vector) -> Vector:
        falling[0] = x[0] > 0.0
        events[0] += 1
        return x

    x, _ = integrate(
        lambda t, x: (-1.0 if falling[0] else 1.0,), 0.0, (0.5,), 2.0, rtol=1e-9, atol=(1e-9,), first_step=0.1,
        indicators=lambda t, x: x, on_event=turn,
    )  # fmt: skip
    assert abs(x[0]) < 0.01  # a tenth of the step: how far a sign is not trusted at most
    # some hundred in each 1/10; were every one found to 1e-12 of the step, there would be 1e12 of them
    assert events[0] < 20_000


def test_event_that_begins_at_its_own_double_zero() -> None:
    """g = t^2 - d from g = 0 at the start for d = 0: the secant rule alone never leaves such a point."""
    seen: list[float] = []
    for d in (0.0, 1e-8, 0.04):
        seen.clear()
        integrate(
            lambda t, x: (x[1], 1.0), 0.0, (0.0, 0.0), 1.0, rtol=1e-9, atol=(1e-9, 1e-9), first_step=1.0,
            indicators=lambda t, x, d=d: (2.0 * x[0] - d,),  # type: ignore[misc]
            on_event=lambda t, x: (seen.append(t), x)[1],  # type: ignore[func-returns-value]
        )  # fmt: skip
        assert seen == pytest.approx([math.sqrt(d)], abs=1e-11)  # the bracket is 1e-12 of the step


def test_state_may_jump_at_an_event() -> None:
    """A ball that bounces without loss comes back: the height of x" = -1 from 1/2 has period 2."""
    x, _ = integrate(
        lambda t, x: (x[1], -1.0), 0.0, (0.5, 0.0), 10.0, rtol=1e-12, atol=(1e-12, 1e-12), first_step=0.1,
        indicators=lambda t, x: (x[0],), on_event=lambda t, x: (abs(x[0]), -x[1]),
    )  # fmt: skip
    assert x == pytest.approx((0.5, 0.0), abs=1e-9)  # five bounces, each found to 1e-12 of a step


def test_refusal_names_the_place() -> None:
    """x' = x^2 from 1 has its pole at t = 1."""
    with pytest.raises(IntegrationError, match=r"no step is small enough at t = 0\.99|steps were not enough"):
        integrate(lambda t, x: (x[0] * x[0],), 0.0, (1.0,), 2.0, rtol=1e-9, atol=(1e-9,), first_step=0.1)


def test_refusal_of_nan() -> None:
    with pytest.raises(IntegrationError, match=r"no step is small enough at t = 0\.0"):
        integrate(lambda t, x: (math.nan,), 0.0, (1.0,), 2.0, rtol=1e-9, atol=(1e-9,))


def test_number_of_steps_is_bounded() -> None:
    with pytest.raises(IntegrationError, match="5 steps were not enough to reach t = 20"):
        integrate(
            lambda t, x: (x[1], -x[0]), 0.0, (1.0, 0.0), 20.0, rtol=1e-12, atol=(1e-12, 1e-12), max_steps=5,
            first_step=0.01,
        )  # fmt: skip


def test_errors_too_small_to_square() -> None:
    x, _ = integrate(
        lambda t, x: (-x[0],), 0.0, (1e-165,), 1.0, rtol=1e-9, atol=(1.0,), first_step=0.1, method=DORMAND_PRINCE_8
    )
    assert x[0] == pytest.approx(1e-165 * math.exp(-1.0), rel=1e-6)  # five steps, each five times the one before


def test_tolerances_that_underflow() -> None:
    """x' = -x to a relative accuracy that is less than the smallest number, or zero."""
    for start in (1e-300, 2.2e-311, 5e-324, 0.0):
        x, _ = integrate(lambda t, x: (-x[0],), 0.0, (start,), 1.0, rtol=1e-13, atol=(0.0,), first_step=0.1)
        assert x[0] == pytest.approx(start * math.exp(-1.0), abs=10.0 * SMALLEST)  # that for each of some steps


def test_indicator_at_the_smallest_number() -> None:
    """Halved by the rule of the location, it is zero, as at the other end."""
    seen: list[float] = []
    integrate(
        lambda t, x: (1.0,), 0.0, (0.0,), 1.0, rtol=1e-9, atol=(1e-9,), first_step=1.0,
        indicators=lambda t, x: (5e-324 if x[0] < 0.3 else 0.0,),
        on_event=lambda t, x: (seen.append(t), x)[1],  # type: ignore[func-returns-value]
    )  # fmt: skip
    assert seen == pytest.approx([0.3], abs=1e-11)


def test_nothing_to_do() -> None:
    assert integrate(lambda t, x: (1.0,), 3.0, (7.0,), 3.0, rtol=1e-6, atol=(1e-6,))[0] == (7.0,)


def test_interpolant_is_exact_for_cubics() -> None:
    def cubic(t: float) -> float:
        return 1.0 + t * (2.0 + t * (-3.0 + 0.5 * t))

    def slope(t: float) -> float:
        return 2.0 + t * (-6.0 + 1.5 * t)

    h = 0.8
    value = interpolate(0.3, h, (cubic(0.0),), (slope(0.0),), (cubic(h),), (slope(h),))
    assert value[0] == pytest.approx(cubic(0.3 * h), abs=1e-15)
