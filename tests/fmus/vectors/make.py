"""Makes the vectors that steps, event rules and reductions replay in Python and in C: ``python tests/fmus/vectors/make.py``.

Nothing of this project computes here. Numbers are worked out in 50 digits by mpmath from the equations beside them and
rounded once, to doubles; coefficients of the Runge-Kutta method are the fractions of its paper.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any

import mpmath as mp

HERE = Path(__file__).parent
DIGITS = 50
Matrix = Any
Numbers = list[Any]


def exact(value: Any) -> Any:
    """A number of many digits from a double or a fraction."""
    return mp.mpf(value.numerator) / value.denominator if isinstance(value, Fraction) else mp.mpf(value)


def matrix(rows: Sequence[Sequence[float]]) -> Matrix:
    """Of the exact values of doubles."""
    return mp.matrix([[exact(value) for value in row] for row in rows])


def rows_of(a: Matrix) -> list[list[float]]:
    """Rounded to doubles."""
    return [[float(a[i, j]) for j in range(a.cols)] for i in range(a.rows)]


def pair(value: Any) -> list[float]:
    """Real and imaginary part."""
    return [float(mp.re(value)), float(mp.im(value))]


# J. R. Dormand, P. J. Prince, J. Comp. Appl. Math. 6 (1980) 19-26, table 2
A = (
    "", "1/5", "3/40 9/40", "44/45 -56/15 32/9", "19372/6561 -25360/2187 64448/6561 -212/729",
    "9017/3168 -355/33 46732/5247 49/176 -5103/18656", "35/384 0 500/1113 125/192 -2187/6784 11/84",
)  # fmt: skip
FOURTH = "5179/57600 0 7571/16695 393/640 -92097/339200 187/2100 1/40"


def fractions(text: str) -> Numbers:
    """``1/5 3/40`` in many digits."""
    return [exact(Fraction(word)) for word in text.split()]


def runge_kutta() -> dict[str, Any]:
    """One step of x' = v, v' = -x/(1 + x^2) - 0.3 v + t^2, and the difference of the formulae of order 5 and 4."""

    def rates(t: Any, x: Numbers) -> Numbers:
        return [x[1], -x[0] / (1 + x[0] ** 2) - exact(0.3) * x[1] + t * t]

    cases = []
    for t, x, h in ((0.0, [0.7, -0.2], 0.25), (3.5, [-1.25, 2.0], 0.0625), (10.0, [0.0, 40.0], 1.0)):
        state, length, begin = [exact(v) for v in x], exact(h), exact(t)
        k = [rates(begin, state)]
        for text in A[1:]:
            weights = fractions(text)
            point = [state[i] + length * sum(w * each[i] for w, each in zip(weights, k)) for i in range(2)]
            k.append(rates(begin + length * sum(weights), point))
        fifth = [*fractions(A[-1]), mp.mpf(0)]
        weights = [a - b for a, b in zip(fifth, fractions(FOURTH))]
        error = [length * sum(w * each[i] for w, each in zip(weights, k)) for i in range(2)]
        cases.append({"t": t, "x": x, "h": h, "end": [float(v) for v in point], "error": [float(v) for v in error]})
    return {"what": runge_kutta.__doc__, "cases": cases}


def events() -> dict[str, Any]:
    """Times and states at the zeros of indicators in motions x = (y, y') of constant acceleration, y'' = a: indicators are
    y - level. At each event the velocity is multiplied by ``factor``."""
    cases: list[dict[str, Any]] = []
    levels = {
        "slowed at three levels": ([1.5, 0.75, 0.0], 2.0, 0.0, -9.81, 0.5, 1.5),
        "there and back within a step": ([0.0], 0.375, -1.25, 2.0, 1.0, 1.5),
        "two levels in one step": ([1.0, 0.25], 2.0, 0.0, -4.0, 1.0, 1.25),
        "nothing": ([-3.0], 1.0, 0.5, -1.0, 1.0, 1.0),
    }
    for name, (heights, y0, v0, a0, factor, end) in levels.items():
        y, v, t, a = exact(y0), exact(v0), mp.mpf(0), exact(a0)
        times, states = [], []
        while True:
            ahead = [
                (s, height) for height in map(exact, heights) for sign in (-1, 1)
                if mp.im(root := mp.sqrt(v * v - 2 * a * (y - height))) == 0
                and (s := (-v + sign * root) / a) > mp.mpf(10) ** -30
            ]  # fmt: skip
            s, height = min(ahead, default=(mp.inf, mp.mpf(0)))
            if t + s >= exact(end):
                break
            t, y, v = t + s, height, (v + a * s) * exact(factor)
            times.append(float(t))
            states.append([float(y), float(v)])
        rest = exact(end) - t
        final = [float(y + v * rest + a * rest**2 / 2), float(v + a * rest)]
        cases.append({
            "name": name, "levels": heights, "x": [y0, v0], "acceleration": a0, "factor": factor, "end": end, "times": times,
            "states": states, "final": final,
        })  # fmt: skip
    return {"what": events.__doc__, "cases": cases}


CHAIN = [[0, 0, 1, 0], [0, 0, 0, 1], [-2.5e4, 1.5e4, -0.25, 0.125], [1.5e4, -1.5e4, 0.125, -0.125]]
MATRICES: dict[str, list[list[float]]] = {
    "two masses on stiff springs, hardly damped": CHAIN,
    "roots -1, -2, -3 +- 4i": [[0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1], [-50, -87, -45, -9]],
    "a rotation": [[0, 5], [-5, 0]],
    "far from normal": [[-1, 100, 0.5], [0, -1.5, 100], [0, 0.001, -2]],
}


def dense() -> dict[str, Any]:
    """Eigenvalues and exponentials of real matrices, row by row; eigenvalues by real, then imaginary part."""
    cases = []
    for name, rows in MATRICES.items():
        a = matrix(rows)
        values = sorted(
            (pair(value) for value in mp.eig(a, left=False, right=False)), key=lambda each: (each[0], each[1])
        )
        times = (0.001, 0.125) if rows is CHAIN else (0.25, 4.0)
        exponentials = [{"t": t, "exp": rows_of(mp.expm(a * exact(t)))} for t in times]
        cases.append({"name": name, "a": rows, "eigenvalues": values, "exponentials": exponentials})
    return {"what": dense.__doc__, "cases": cases}


def operators(a: Matrix, b: Matrix, h: Any, order: int) -> tuple[Matrix, list[Matrix]]:
    """exp(A h) and int_0^h exp(A (h - s)) B s^k ds, k = 0 to ``order``, from one exponential (Van Loan 1978)."""
    n, m = a.rows, b.cols
    block = mp.zeros(n + m * (order + 1))
    block[:n, :n] = a * h
    block[:n, n : n + m] = b * h
    for i in range(n, n + m * order):
        block[i, i + m] = mp.mpf(1)
    whole = mp.expm(block)
    gains = [
        whole[:n, n + k * m : n + (k + 1) * m] * mp.factorial(k) * h**k for k in range(order + 1)
    ]  # fmt: skip
    return whole[:n, :n], gains


def exact_step() -> dict[str, Any]:
    """The operators of x' = A x + B u, u = sum_k a_k s^k, for a step h: exp(A h), and for each power the integral of
    exp(A (h - s)) s^k B."""
    b = [[0, 0], [0.5, 0], [1e-3, 2], [0, 1]]
    cases = []
    for h, order in ((0.002, 3), (0.05, 3), (0.05, 0)):
        transition, gains = operators(matrix(CHAIN), matrix(b), exact(h), order)
        cases.append({"h": h, "order": order, "transition": rows_of(transition), "gains": [rows_of(g) for g in gains]})
    return {"what": exact_step.__doc__, "a": CHAIN, "b": b, "cases": cases}


def scheduled() -> dict[str, Any]:
    """Steps of two masses of 1 kg, z = (q1, q2, q1', q2'): z' = A(s) z + B(s) (f, i), i' = f, where s, the square of the
    pace in the middle of the step, is constant over it and f is a cubic.

    q1'' = -k q1 + (k + s w)(q2 - q1) - r q1' + (1 + 0.2 s) f + 0.1 i,  q2'' = -(k + s w)(q2 - q1) - r q2', with
    r = d - 0.01 s^2 w."""
    p = {"stiffness": 4.0, "damping": 0.3, "scheduled": 1.5, "start": 0.1}
    k, d, w = (exact(p[name]) for name in ("stiffness", "damping", "scheduled"))
    z, impulse = mp.matrix([exact(p["start"]), 0, 0, 0]), mp.mpf(0)
    t, steps = 0.0, []
    for h, force, pace in (
        (0.25, [0.4, -0.8, 0.6, 0.9], [0.7, 0.5, -0.4, 0.3]),
        (0.5, [-1.5, 0.0, 2.0, 0.0], [0.9, 0.0, 0.0, 0.0]),
        (0.25, [0.5, 0.25, 0.0, -3.0], [0.0, 0.0, 0.0, 0.0]),
    ):
        half = exact(h) / 2
        s = sum(exact(u) * half**i / mp.factorial(i) for i, u in enumerate(pace)) ** 2
        spring, one, r = k + s * w, mp.mpf(1), d - s * s * w / 100
        a = mp.zeros(5)
        a[0, 2] = a[1, 3] = one
        a[2, 0], a[2, 1], a[2, 2], a[2, 4] = -k - spring, spring, -r, one / 10
        a[3, 0], a[3, 1], a[3, 3] = spring, -spring, -r
        b = mp.zeros(5, 1)
        b[2], b[4] = 1 + s / 5, one
        transition, gains = operators(a, b, exact(h), 3)
        after = transition * mp.matrix([*z, impulse])
        for i, gain in enumerate(gains):
            after += gain * exact(force[i]) / mp.factorial(i)
        z, impulse = mp.matrix(list(after)[:4]), after[4]
        steps.append(
            {"t": t, "h": h, "force": force, "pace": pace, "z": [float(v) for v in z], "impulse": float(impulse)}
        )
        t += h
    return {"what": scheduled.__doc__, "parameters": p, "steps": steps}


def oscillator() -> dict[str, Any]:
    """Steps of m z'' + c z' + k z = -(r0 + r1 s + r2 s^2 + r3 s^3): the response of a ship in heave. Damping from none to
    beyond critical."""
    cases = []
    for damping in (0.0, 2e5, 2.4e6, 2.5298221281347035e6, 5e6):
        m, c, k = exact(8e5), exact(damping), exact(2e6)
        a = mp.matrix([[0, 1], [-k / m, -c / m]])
        for h, x, r in ((0.1, [0.25, -0.5], [5e4, 2e4, -1e4, 3e3]), (2.0, [0.0, 0.0], [-3e4, 0.0, 5e3, -2e3])):
            transition, gains = operators(a, mp.matrix([[0], [-1 / m]]), exact(h), 3)
            after = transition * mp.matrix([exact(v) for v in x])
            for gain, value in zip(gains, r):
                after += gain * exact(value)
            cases.append({"damping": damping, "h": h, "x": x, "reaction": r, "end": [float(v) for v in after]})
    return {"what": oscillator.__doc__, "mass": 8e5, "stiffness": 2e6, "cases": cases}


def cradle() -> dict[str, Any]:
    """A cradle without drag under a tension that is a cubic of time: M y'' = T - W, so that y is a quintic."""
    mass, weight, x = 5e3, 2e4, [1.5, -0.5]
    cases = []
    for h, tension in ((0.5, [2.5e4, 4e3, -6e3, 9e3]), (2.0, [1.5e4, 0.0, 2e3, -1e3])):
        derivatives = [exact(v) for v in tension]
        derivatives[0] -= exact(weight)
        y, v = exact(x[0]) + exact(x[1]) * exact(h), exact(x[1])
        for i, value in enumerate(derivatives):
            v += value / exact(mass) * exact(h) ** (i + 1) / mp.factorial(i + 1)
            y += value / exact(mass) * exact(h) ** (i + 2) / mp.factorial(i + 2)
        cases.append({"h": h, "tension": tension, "heave": float(y), "velocity": float(v)})
    start = {
        "mass": mass, "added_mass": 0.0, "drag_area": 0.0, "weight_in_water": weight, "heave_start": x[0],
        "velocity_start": x[1],
    }  # fmt: skip
    return {"what": cradle.__doc__, "start": start, "cases": cases}


# a small linear system in the form of a tow's: two pairs of rows, two velocities and two forces as inputs
SYSTEM: dict[str, list[list[float]]] = {
    "a": [
        [0, 1, 0, 0, 0, 0], [-0.5, -0.2, 0.125, 0, 0, 0], [0, 0, 0, 1, 0, 0], [0.25, 0, -6, -0.6, 0.5, 0],
        [0, 0, 0, 0, 0, 1], [0, 0, 0.5, 0, -40, -2.5],
    ],
    "b": [[0, 0, 0, 0], [1, 0.25, 0.5, 0], [0, 0, 0, 0], [0.5, 1, 0, 0.25], [0, 0, 0, 0], [0.25, -0.5, 0.125, 1]],
    "c": [[-1, 0, 0.5, 0.25, 2, 0], [0.5, 0.125, 3, 0, -1, 0.0625], [0, 1, 0, 0.25, 0, 0], [0, 0, 0, 1, 0, 0.5]],
    "d": [[0.5, 0, 0.125, 0], [0, 0.25, 0, 0], [0, 0, 0.0625, 0], [0, 0, 0, 0.125]],
    "e": [[-0.25, 0, 0, 0], [0, -0.125, 0, 0], [0, 0, 0, 0], [0, 0, 0, 0]],
}  # fmt: skip
BAND, FREQUENCIES, INPUTS = 2.0, 40, 4


def eigen(a: Matrix) -> tuple[Numbers, Matrix]:
    """Eigenvalues, and their vectors as columns."""
    values, vectors = mp.eig(a)
    return list(values), vectors


def gramian(a: Matrix, b: Matrix) -> Matrix:
    """X of A X + X A' + B B' = 0."""
    values, vectors = eigen(a)
    inverse = vectors**-1
    q = inverse * b * b.H * inverse.H
    n = a.rows
    y = mp.matrix(n, n)
    for i in range(n):
        for j in range(n):
            y[i, j] = -q[i, j] / (values[i] + mp.conj(values[j]))
    return vectors * y * vectors.H


def transfer(system: dict[str, Matrix], omega: Any) -> Matrix:
    """C (s - A)^-1 B + D + s E at s = -i omega."""
    s = -mp.j * omega
    n = system["a"].rows
    return system["c"] * ((s * mp.eye(n) - system["a"]) ** -1) * system["b"] + system["d"] + s * system["e"]


def balanced(full: dict[str, Matrix], gains: list[Matrix]) -> dict[int, Callable[[Any], Matrix]]:
    """Transfer functions of balanced models by their number of states, the weak states at their static response, where
    inputs and outputs are measured by what passes between them in the band."""
    n, out = full["a"].rows, [max(abs(g[i, j]) for g in gains for j in range(2)) for i in range(4)]
    force = max(abs(g[i, j]) for g in gains for i in range(2) for j in (2, 3))
    b = full["b"] * mp.diag([1, 1, out[0] / force, out[0] / force])
    c = mp.diag([1 / each for each in out]) * full["c"]
    squares, vectors = eigen(gramian(full["a"], b) * gramian(full["a"].T, c.T))
    order = sorted(range(n), key=lambda i: -mp.re(squares[i]))
    t = mp.matrix([[vectors[i, j] for j in order] for i in range(n)])
    a, b, c = t**-1 * full["a"] * t, t**-1 * full["b"], full["c"] * t

    def model(k: int) -> Callable[[Any], Matrix]:
        inverse = a[k:, k:] ** -1
        x, u = inverse * a[k:, :k], inverse * b[k:, :]
        small = {
            "a": a[:k, :k] - a[:k, k:] * x, "b": b[:k, :] - a[:k, k:] * u, "c": c[:, :k] - c[:, k:] * x,
            "d": full["d"] - c[:, k:] * u, "e": full["e"],
        }  # fmt: skip
        return lambda omega: transfer(small, omega)

    return {k: model(k) for k in range(1, n)}


def modal(full: dict[str, Matrix], gains: list[Matrix]) -> dict[int, Callable[[Any], Matrix]]:
    """Transfer functions of models of the modes that matter most, the others at their static response and its rate."""
    values, vectors = eigen(full["a"])
    left, right, n = vectors**-1 * full["b"], full["c"] * vectors, full["a"].rows
    bands = [exact_frequency(i) for i in range(FREQUENCIES)]

    def importance(i: int) -> Any:
        worst = mp.mpf(0)
        for omega, gain in zip(bands, gains):
            s = -mp.j * omega
            rest = abs((s / values[i]) ** 2 / (s - values[i]))
            strength = max(abs(right[row, i]) for row in range(4))
            for j in range(INPUTS):
                worst = max(worst, rest * strength * abs(left[i, j]) / max(abs(gain[row, j]) for row in range(4)))
        return worst * (2 if mp.im(values[i]) else 1)

    upper = sorted((i for i in range(n) if mp.im(values[i]) >= 0), key=importance, reverse=True)

    def model(kept: list[int]) -> Callable[[Any], Matrix]:
        def response(omega: Any) -> Matrix:
            s = -mp.j * omega
            whole = full["d"] + s * full["e"]
            for i in range(n):
                near = any(
                    abs(values[i] - v) < mp.mpf(10) ** -30 for k in kept for v in (values[k], mp.conj(values[k]))
                )
                factor = 1 / (s - values[i]) if near else -1 / values[i] - s / values[i] ** 2
                whole += right[:, i] * left[i, :] * factor
            return whole

        return response

    models, states = {}, 0
    for count, i in enumerate(upper, 1):
        states += 2 if mp.im(values[i]) else 1
        if states < n:
            models[states] = model(upper[:count])
    return models


def exact_frequency(i: int) -> Any:
    """Evenly spaced in their logarithm from 0.02 rad/s to the band."""
    start = min(exact(0.02), exact(BAND) / 10)
    return start * (exact(BAND) / start) ** (mp.mpf(i) / (FREQUENCIES - 1))


def error_of(gains: list[Matrix], reference: list[Matrix]) -> Any:
    """The largest difference in a pair of rows over the largest gain of the pair, of all frequencies and inputs."""
    return max(
        max(abs(g[row + i, j] - r[row + i, j]) for i in range(2)) / max(abs(r[row + i, j]) for i in range(2))
        for g, r in zip(gains, reference) for row in (0, 2) for j in range(INPUTS)
    )  # fmt: skip


def reduction() -> dict[str, Any]:
    """Reduced models of a system of six states: number of states, error up to ``band`` and gains at some frequencies of the
    smallest whose error is below a tolerance."""
    full = {name: matrix(rows) for name, rows in SYSTEM.items()}
    bands = [exact_frequency(i) for i in range(FREQUENCIES)]
    gains = [transfer(full, omega) for omega in bands]
    shown = range(0, FREQUENCIES, 13)

    def listed(values: list[Matrix]) -> list[Any]:
        return [[[pair(values[f][i, j]) for j in range(INPUTS)] for i in range(4)] for f in shown]

    cases = []
    for method in (balanced, modal):
        for states, response in sorted(method(full, gains).items()):
            small = [response(omega) for omega in bands]
            error = error_of(small, gains)
            cases.append({
                "method": method.__name__, "states": states, "error": float(error), "gains": listed(small),
            })  # fmt: skip
    return {
        "what": reduction.__doc__, "system": SYSTEM, "band": BAND, "frequencies": [float(bands[f]) for f in shown],
        "places": list(shown), "gains": listed(gains), "cases": cases,
    }  # fmt: skip


VECTORS = (runge_kutta, events, dense, exact_step, scheduled, oscillator, cradle, reduction)


def text(make: Callable[[], dict[str, Any]]) -> str:
    """One file."""
    with mp.workdps(DIGITS):
        content = make()
    content["what"] = " ".join(content["what"].split())
    content["made"] = f"by tests/fmus/vectors/make.py with mpmath in {DIGITS} digits, rounded once"
    return json.dumps(content, indent=1) + "\n"


if __name__ == "__main__":
    for vector in VECTORS:
        (HERE / f"{vector.__name__}.json").write_text(text(vector))
