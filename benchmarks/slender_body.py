"""Towed slender body: error against number of states and cost, per method. Prints the tables of docs/slender_body.md.

    python benchmarks/slender_body.py

Errors are those of the first five modes over their magnitude, against the series determinant about the middle with 90
terms, which shares nothing with the others but the coefficients. Times are medians of one process; only their ratios
within one run mean anything.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.linalg import eig

from towage.fmus.slender_body import UNIT
from towage.models.numeric.matrix_ops import numbers
from towage.models.numeric.ops import FLOATS
from towage.models.slender import prepared as slender_prepared
from towage.models.slender import series as slender_series
from towage.models.slender import setup as slender_setup
from towage.models.slender.coefficients import Body, coefficients
from towage.models.slender.damping import fast_mode_damping
from towage.models.slender.modes import matrices, roots, spectrum

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
MODEL = UNIT.model
SPEEDS = (0.7, 4.0, 8.0, 12.0)
BODY = Body()
MOVING = (0.0, 0.05, 0.0, 0.0)
"""A craft that drifts aside, as a cubic of time."""


def median_ms(call: Callable[[], object], repeats: int = 7) -> float:
    """Median time of a call, ms."""
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        call()
        times.append(time.perf_counter() - start)
    return 1e3 * float(np.median(times))


def reference(u: float) -> Complex:
    """The first five modes."""
    start = spectrum(matrices(BODY), u, 5)
    return slender_series.spectrum(BODY, u, start, 90, slender_series.MIDDLE)


def error(computed: Complex, wanted: Complex) -> float:
    """Largest relative distance of a wanted mode to the nearest computed one; nan counts as lost."""
    known = computed[np.isfinite(computed)]
    return max(float(np.min(np.abs(known - s)) / abs(s)) if len(known) else math.inf for s in wanted)


def collocation(body: Body, u: float, points: int) -> Complex:
    """Exponents by Chebyshev collocation of the strong form on ``points`` nodes, boundary conditions in four rows."""
    n = points - 1
    k = np.arange(points)
    x = np.cos(math.pi * k / n)
    c = np.where((k == 0) | (k == n), 2.0, 1.0) * (-1.0) ** k
    difference = x[:, None] - x[None, :] + np.eye(points)
    d = np.outer(c, 1.0 / c) / difference
    d = 2.0 * (d - np.diag(d.sum(axis=1)))  # by xi = x/2
    xi = 0.5 * x
    powers = [np.eye(points), d, d @ d, d @ d @ d, d @ d @ d @ d]
    terms = coefficients(body.numbers, body.ends, FLOATS)
    parts = []
    for part, scale in (("uu", u * u), ("us", u), ("ss", 1.0)):
        c1, c2, c3, c4, g5, g6, g7, g8, g9, g10 = (scale * getattr(t, part) for t in terms)
        a = (c1 + c2 * xi)[:, None] * powers[2] + c3 * powers[1] + c4 * powers[0]
        if part == "uu":
            a = a + powers[4]
        if part == "us":
            a = a + body.damping * powers[4]
        bend = 1.0 if part == "uu" else body.damping if part == "us" else 0.0
        a[n] = bend * powers[3][n] + g5 * powers[1][n] + g6 * powers[0][n]
        a[n - 1] = bend * powers[2][n] + g7 * powers[1][n] + g8 * powers[0][n]
        a[0] = bend * powers[3][0] + g9 * powers[1][0] + g10 * powers[0][0]
        a[1] = powers[2][0] if part == "uu" else 0.0 * powers[2][0]
        parts.append(a)
    zero, one = np.zeros((points, points)), np.eye(points)
    above, below = eig(
        np.block([[zero, one], [-parts[0], -parts[1]]]), np.block([[one, zero], [zero, parts[2]]]), right=False,
        homogeneous_eigvals=True,
    )  # fmt: skip
    finite = np.abs(below) > 1e-12 * np.abs(above)
    return np.asarray(above[finite] / below[finite])


def modes_table() -> None:
    """Error of the first five modes against states and cost."""
    wanted = {u: reference(u) for u in SPEEDS}
    print("| method | size | states | " + " | ".join(f"u = {u:g}" for u in SPEEDS) + " | ms a speed |")
    print("|---|---|---|" + "---|" * (len(SPEEDS) + 1))

    def line(method: str, size: int, states: str, solve: Callable[[float], Complex]) -> None:
        """A row of the table."""
        with np.errstate(all="ignore"):
            errors = " | ".join(
                f"{e:.0e}" if (e := error(solve(u), wanted[u])) < 0.1 else "lost" for u in SPEEDS
            )
            cost = median_ms(lambda: solve(4.0), 5)
        print(f"| {method} | {size} | {states} | {errors} | {cost:.2f} |")

    for n in (8, 10, 12, 13, 14, 16, 18, 20, 26):
        system = matrices(BODY, n)
        line("Legendre-Galerkin", n, str(2 * n), lambda u, m=system: roots(m, u))  # type: ignore[misc]
    system = matrices(BODY, 26)
    line("the same, polished", 26, "52", lambda u: spectrum(system, u, 8))
    for n in (14, 16, 20):
        plain = matrices(BODY, n)
        damped = replace(plain, extra=fast_mode_damping(plain, 0.02, numbers()))
        line("Galerkin, fast modes damped", n, str(2 * n), lambda u, m=damped: roots(m, u))  # type: ignore[misc]
    for points in (16, 20, 24, 32, 40, 48):
        line("Chebyshev collocation", points, str(2 * points), lambda u, k=points: collocation(BODY, u, k))  # type: ignore[misc]
    for centre, name in ((slender_series.NOSE, "series about the nose"), (slender_series.MIDDLE, "series about the middle")):
        for order in (10, 20, 30, 40, 48, 60, 70):
            line(
                name, order, "-",
                lambda u, k=order, c=centre: slender_series.spectrum(BODY, u, wanted[u], k, c),  # type: ignore[misc]
            )  # fmt: skip
    print("\nThe series has no spectrum of its own: its roots are sought from the exact ones, which flatters it.\n")


def base(**changes: float) -> slender_setup.Parameters:
    """The unit's default parameters."""
    values = {v.name: float(v.start or 0.0) for v in UNIT.parameters} | {"bending_stiffness": 2830.194553649008}
    return slender_setup.Parameters(**(values | changes))


def step_table() -> None:
    """Cost of a step of the unit against states."""
    print("| functions | states | step at constant speed, us | step at a new speed, ms | growth rate at a new speed, ms |")
    print("|---|---|---|---|---|")
    for n in (2, 6, 10, 14, 18, 24):
        p = base(flexible=0.0) if n == 2 else base(shape_functions=float(n))
        x, m = MODEL.initial(p, FLOATS)
        made = slender_prepared.prepare(p)
        counter = iter(range(10**6))

        def held(p=p, x=x, m=m) -> object:  # type: ignore[no-untyped-def]
            """200 steps at one speed."""
            return [MODEL.advance(0.0, 0.1, x, m, MODEL.Inputs((2.7, 0.0, 0.0, 0.0), MOVING), p, FLOATS) for _ in range(200)]

        def new(p=p, x=x, m=m, counter=counter) -> object:  # type: ignore[no-untyped-def]
            """A step at a speed that was not there before."""
            speed = 2.7 + 1e-6 * next(counter)
            return MODEL.advance(0.0, 0.1, x, m, MODEL.Inputs((speed, 0.0, 0.0, 0.0), MOVING), p, FLOATS)

        def growth(made=made, counter=counter) -> object:  # type: ignore[no-untyped-def]
            """Modes at a speed that was not there before."""
            return roots(made.system, 3.6 + 1e-6 * next(counter))

        held()
        print(
            f"| {n} | {2 * n} | {1e3 * median_ms(held) / 200:.1f} | {median_ms(new, 31):.2f} | {median_ms(growth, 31):.2f} |"
        )
    print()


class Ramp:
    """The body behind a craft that sways while the tow speed rises: two points of the body over 20 s, m, by the exact step
    and by scipy's integrators on the same equations."""

    stop = 20.0

    def __init__(self) -> None:
        self.parameters = base()
        self.prepared = slender_prepared.prepare(self.parameters)
        # A and b are quadratic in u: three values give them at all speeds
        a0, a1, a2 = (self.prepared.system.companion(u) for u in (0.0, 1.0, 2.0))
        self.companion = a0, (4.0 * a1 - 3.0 * a0 - a2) / 2.0, (a2 - 2.0 * a1 + a0) / 2.0
        self.load = self.prepared.system.load(1.0)

    def speed(self, t: float) -> float:
        """Tow speed, m/s."""
        return 1.5 + 1.5 * t / self.stop

    @staticmethod
    def craft(t: float) -> float:
        """Sway of the craft, m."""
        return 0.1 * math.sin(0.5 * t)

    def exact(self, h: float) -> Array:
        """By the unit's step of ``h`` s, every 0.4 s."""
        p = self.parameters
        x, m = MODEL.initial(p, FLOATS)
        rows = []
        for k in range(round(self.stop / h)):
            t = k * h
            a, b = self.craft(t), self.craft(t + h)
            da, db = 0.05 * math.cos(0.5 * t), 0.05 * math.cos(0.5 * (t + h))
            slope = (b - a) / h
            w = (a, da, (3.0 * slope - 2.0 * da - db) / h, (da + db - 2.0 * slope) / h**2)
            x = MODEL.advance(t, h, x, m, MODEL.Inputs((self.speed(t), 1.5 / self.stop, 0.0, 0.0), w), p, FLOATS)
            if abs((t + h) / 0.4 - round((t + h) / 0.4)) < 1e-9:
                rows.append(self.prepared.points[:2] @ np.array(x[: self.prepared.n]))
        return np.array(rows)

    def matrix(self, t: float) -> Array:
        """Of the linear equations at the speed of t, 1/s."""
        u = self.speed(t) / self.prepared.speed
        a0, a1, a2 = self.companion
        return np.asarray((a0 + u * (a1 + u * a2)) / self.prepared.tau)

    def rates(self, t: float, z: Array) -> Array:
        """Derivatives of the states."""
        u = self.speed(t) / self.prepared.speed
        return np.asarray(self.matrix(t) @ z + (u * u * self.craft(t) / self.prepared.tau) * self.load)

    def general(self, method: str, rtol: float) -> tuple[Array, int]:
        """(the same points by an integrator of scipy, its evaluations)."""
        extra = {} if method == "RK45" else {"jac": lambda t, z: self.matrix(t)}
        run = solve_ivp(
            self.rates, (0.0, self.stop), np.zeros(2 * self.prepared.n), method, rtol=rtol, atol=1e-3 * rtol,
            t_eval=np.linspace(0.4, self.stop, 50), **extra,
        )  # fmt: skip
        return (self.prepared.points[:2] @ run.y[: self.prepared.n]).T, int(run.nfev)


def integrators_table() -> None:
    """The exact step against general integrators on the ramp, at about equal error."""
    ramp = Ramp()
    reference = ramp.exact(0.0125)
    scale = float(np.max(np.abs(reference)))
    print("| method | setting | error | steps or evaluations | s |")
    print("|---|---|---|---|---|")
    for h in (0.4, 0.2, 0.1, 0.05):
        start = time.perf_counter()
        points = ramp.exact(h)
        took = time.perf_counter() - start
        size = np.max(np.abs(points - reference)) / scale
        print(f"| exact step | {h:g} s | {size:.1e} | {round(ramp.stop / h)} | {took:.2f} |")
    for method in ("Radau", "BDF", "RK45"):
        for rtol in (1e-3, 1e-4, 1e-6):
            start = time.perf_counter()
            points, count = ramp.general(method, rtol)
            took = time.perf_counter() - start
            size = np.max(np.abs(points - reference)) / scale
            print(f"| {method} | rtol {rtol:.0e} | {size:.1e} | {count} | {took:.2f} |", flush=True)
    print()


if __name__ == "__main__":
    print("### Modes\n")
    modes_table()
    print("### Step\n")
    step_table()
    print("### Against general integrators\n")
    integrators_table()
