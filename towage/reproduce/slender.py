"""The thesis on the towed slender body: every table and figure of ``slender.toml``.

Roots and critical speeds are those of the Galerkin form (26 functions); each is found again as a zero of the determinant of the
power series about the middle (90 terms), from where `Answer.methods` is.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from math import sqrt

import numpy as np
from numpy.typing import NDArray

from towage.models.slender import rigid
from towage.models.slender.critical import double_roots, yaw
from towage.models.slender.modes import matrices, modes, spectrum
from towage.reproduce import plots
from towage.reproduce.items import Answer, Column
from towage.reproduce.slender_curves import (
    BY,
    ROPES,
    THESIS,
    by_mode,
    by_series,
    critical_over,
    loci,
    map_over,
    old_theory,
    row_of,
    rows_over,
    second_mode,
    two_modes,
)

Array = NDArray[np.float64]


def figure_6a() -> Answer:
    """The second mode with the tail cut at .7."""
    bodies = {"present theory": replace(THESIS, tail_cut=0.7)}
    for f1 in (0.56, 0.62):
        bodies[f"old theory, f1 = {f1:.2f}, f2 = .43".replace("0.", ".")] = old_theory(f1, 0.43)
    return second_mode(bodies, "Second mode, al = .7")


def figure_6b() -> Answer:
    """The second mode with the tail cut at .9."""
    return second_mode({"present theory": replace(THESIS, tail_cut=0.9)}, "Second mode, al = .9")


def figure_7() -> Answer:
    """f1 = i4 + eps cf i1/2 of the nose, f2 = i4 - eps cf i1/2 of the tail: what stands beside u^2 in g5, g9 and h5, h9."""
    lengths = np.linspace(0.0126, 0.1, 200)
    cuts = (1.0, 0.9, 0.7)
    ends = {cut: [replace(THESIS, end_length=float(lam), tail_cut=cut).ends for lam in lengths] for cut in cuts}
    columns = {"lam": lengths, "f1": np.array([e.nose.i4 + 0.5 * e.nose.i1 for e in ends[1.0]])}
    columns |= {f"f2, al = {cut:g}": np.array([e.tail.i4 - 0.5 * e.tail.i1 for e in ends[cut]]) for cut in cuts}
    here = {cut: replace(THESIS, tail_cut=cut).ends for cut in cuts}
    numbers = {"f1, lam = .015": here[1.0].nose.i4 + 0.5 * here[1.0].nose.i1}
    numbers |= {f"f2, lam = .015, al = .{cut * 10:g}": here[cut].tail.i4 - 0.5 * here[cut].tail.i1 for cut in (0.7, 0.9)}
    draw = partial(plots.curves, title="Factors of the old theory", across="end length / length", up="factor", columns=columns)
    note = "The integrals are compared with quadrature in tests/models/test_slender_ends.py."
    return Answer({k: complex(v) for k, v in numbers.items()}, columns, draw, note=note)


def figure_8() -> Answer:
    """Zeroth and first mode, a rope as long as the body."""
    answer = two_modes(1.0)
    meet = [d for d in double_roots(THESIS, 7.0) if d.u > 5.0]
    yaws = yaw(THESIS, 12.0)[0]
    return replace(answer, numbers={
        **answer.numbers, "zeroth mode: stable from u": complex(yaws), "zeroth mode: branches meet at u": complex(meet[0].u),
    })  # fmt: skip


def figure_9() -> Answer:
    """Second to fourth mode, a rope as long as the body."""
    return loci(THESIS, slice(2, 5), "Second to fourth mode, Lam = 1")


def figure_10() -> Answer:
    """Zeroth and first mode, a rope of five lengths."""
    return two_modes(5.0)


def figure_11() -> Answer:
    """Zeroth and first mode, a rope of ten lengths."""
    return two_modes(10.0)


def table_1() -> Answer:
    """The critical speeds by mode."""
    numbers: dict[str, complex] = {}
    worst = 0.0
    for rope in ROPES:
        body = replace(THESIS, rope_length=rope)
        first, again = yaw(body, 10.0)[:2]
        at = {"zeroth": first, "zeroth again": again} | {name: c.u for name, c in by_mode(rope).items()}
        numbers |= {f"{name}, Lam = {rope:g}": complex(u) for name, u in at.items()}
        points = [(first, 0.0), (again, 0.0), *[(c.u, c.omega) for c in by_mode(rope).values()]]
        worst = max(worst, by_series(body, points))
    columns: dict[str, Column] = {"critical speed": list(numbers), "u": [float(u.real) for u in numbers.values()]}
    return Answer(numbers, columns, methods=worst, by=BY)


def figure_12() -> Answer:
    """Critical speeds over the rope, by kind."""
    rows = rows_over("rope_length")
    return critical_over(rows, "u", "Critical speeds", "u = sqrt(M/EI) U L")


def figure_13() -> Answer:
    """Critical frequencies over the rope."""
    return critical_over(rows_over("rope_length"), "omega", "Critical frequencies", "omega tau")


def figure_14() -> Answer:
    """The map over the rope; where the critical speed of the first mode falls below that of the second."""
    half = row_of(0.5)
    low, high = 0.5, 1.0
    while high - low > 1e-3:
        middle = 0.5 * (low + high)
        modes_there = by_mode(middle)
        low, high = (low, middle) if modes_there["first begins"].u < modes_there["second"].u else (middle, high)
    numbers = {
        "Lam = 0.5: yaws up to u": complex(half.yaw[0]),
        "Lam = 0.5: stable up to u": complex(half.stable[0][1]),
        "Lam at which the first mode takes over from the second": complex(high),
    }
    return map_over("rope_length", THESIS, numbers)


def figure_15a() -> Answer:
    """The map over the cut of the tail, short ends."""
    rows = rows_over("tail_cut")
    window = [r.stable for r in rows if r.yaw]
    low = max(max((a for a, b in stable if a < 4.0 < b), default=np.inf) for stable in window)
    high = min(min((b for a, b in stable if a < 4.0 < b), default=-np.inf) for stable in window)
    numbers = {
        "stable at every speed up to al": complex(rigid.neutral_tail_cut(THESIS) or np.nan),
        "stable for every al from u": complex(low), "stable for every al up to u": complex(high),
    }  # fmt: skip
    note = "Up to u = 12. With al = .1 and .02 the body loses stability at u = 13.66 and 13.55, the end of the thesis' range."
    return replace(map_over("tail_cut", THESIS, numbers), note=note)


def figure_15b() -> Answer:
    """The map over the cut of the tail, longer ends."""
    body = replace(THESIS, end_length=0.05)
    return map_over("tail_cut", body, {"stable at every speed up to al": complex(rigid.neutral_tail_cut(body) or np.nan)})


def table_2() -> Answer:
    """Rigid roots in the time unit of the flexible body, and flexible ones, at the speed where the units agree."""
    numbers: dict[str, complex] = {}
    u, worst = 1.0 / sqrt(2.0), 0.0
    for rope in ROPES:
        body = replace(THESIS, rope_length=rope)
        exact = spectrum(matrices(body), u, 3)
        worst = max(worst, by_series(body, [(u, -1j * s) for s in exact]))
        for kind, roots in (("rigid", rigid.exponents(body)), ("flexible", exact)):
            omega = sorted((-1j * s for s in roots if s.imag >= -1e-12), key=lambda w: (abs(w.real) > 1e-9, w.imag))
            numbers |= {f"{kind} {k}, Lam = {rope:g}": complex(w) for k, w in enumerate(omega[:3], 1)}
    columns: dict[str, Column] = {
        "mode": list(numbers), "Re omega": [w.real for w in numbers.values()], "Im omega": [w.imag for w in numbers.values()],
    }  # fmt: skip
    return Answer(numbers, columns, methods=worst, by=BY)


def figure_16() -> Answer:
    """The tail at which a rigid body is neutral, over slenderness at a friction coefficient of .025; the rope drops out."""
    long_ends = replace(THESIS, end_length=0.05)
    slenderness = np.linspace(15.0, 110.0, 96)
    neutral = [rigid.neutral_tail_cut(replace(long_ends, slenderness=float(e), friction=0.025 * float(e))) for e in slenderness]
    columns = {"slenderness": slenderness, "al, eps cf = eps/40": np.array([np.nan if n is None else n for n in neutral])}
    here = rigid.neutral_tail_cut(long_ends)
    ropes = [replace(long_ends, tail_cut=0.56, rope_length=float(rope)) for rope in np.geomspace(0.1, 50.0, 40)]
    grown = max(rigid.exponents(body).real.max() for body in ropes)
    note = f"With al = .56 and ropes of 0.1 to 50 lengths the largest growth rate of the rigid body is {grown:.2e} U/L: stable."
    title = "A rigid body is neutral in yaw"
    draw = partial(plots.curves, title=title, across="length / diameter", up="cut of the tail al", columns=columns)
    return Answer({"neutral in yaw, eps = 40: al": complex(here or np.nan)}, columns, draw, note=note)


def modal_shapes() -> Answer:
    """Shapes y(xi) of the modes of a rope as long as the body at u = 4, where it is stable: real and imaginary part."""
    u, system = 4.0, matrices(THESIS)
    s, right, _ = modes(system, u)
    chosen = [int(k) for k in np.flatnonzero(s.imag > -1e-9)[:6]]
    xi = np.linspace(-0.5, 0.5, 101)
    basis = np.array([np.polynomial.legendre.Legendre.basis(k)(2.0 * xi) * sqrt(2.0 * k + 1.0) for k in range(system.n)])
    columns: dict[str, Column] = {"xi": xi}
    drawn = {}
    for k in chosen:
        y = right[:, k] @ basis
        y = y / y[np.argmax(np.abs(y))]
        name = f"s = {s[k].real:.4g}{s[k].imag:+.4g}i"
        columns |= {f"Re y, {name}": y.real, f"Im y, {name}": y.imag}
        drawn[name] = y
    note = "Each mode has its largest displacement 1 at phase 0; drawn at eight phases of a period, its growth or decay left out."
    draw = partial(plots.shapes, title=f"Modal shapes at u = {u:g}", across="xi = x/L, from nose to tail", x=xi, modes=drawn)
    return Answer({}, columns, draw, by_series(THESIS, [(u, -1j * s[k]) for k in chosen]), BY, note)
