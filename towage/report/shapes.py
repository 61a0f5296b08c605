"""The shape of a wire at several times: a diagram of a result whose unit shows places along it (unit ``wire``)."""

from __future__ import annotations

import re

import numpy as np

from towage.report.svg import canvas
from towage.result.result import Array, Result

TIMES = 6
"""Shapes in a diagram, evenly over the run."""


def columns(result: Result) -> list[str]:
    """Columns that are places along a wire."""
    return [name for name in result.columns if re.search(r"\.shape\d+_(layback|offset|depth)$", name)]


def wires(result: Result) -> list[str]:
    """Units that show the shape of a wire."""
    return [name.removesuffix(".shape1_depth") for name in result.columns if name.endswith(".shape1_depth")]


def places(result: Result, unit: str) -> dict[str, Array]:
    """``layback``, ``offset``, ``depth``, m, of the towpoint's mean place, the stations and the body over time, (k, times)."""
    stations = range(1, 1 + sum(name.startswith(f"{unit}.shape") for name in columns(result)) // 3)
    zero = np.zeros(len(result.time))

    def column(name: str) -> Array:
        return result.columns.get(f"{unit}.{name}", zero)

    return {
        kind: np.array([zero, *(column(f"shape{k}_{kind}") for k in reversed(stations)), column(kind)])
        for kind in ("layback", "offset", "depth")
    }


def shapes(result: Result, unit: str, key: str) -> str | None:
    """From the side, and from above where it leaves its plane; light at the start, dark at the end; None without samples."""
    if not len(result.time):
        return None
    at = places(result, unit)
    leaves = float(np.abs(at["offset"]).max()) > 1e-2 * max(float(np.abs(at["depth"]).max()), 1e-9)
    picked = np.unique(np.linspace(0, len(result.time) - 1, TIMES).round().astype(int))
    with canvas(f"Shape of {unit} over time", f"{key}-w", 9.6, [2.9, 2.9] if leaves else [2.9]) as (axes, svg):
        for axis, kind in zip(axes, ("depth", "offset"), strict=False):
            for order, k in enumerate(picked):
                shade = 0.75 * (1.0 - order / max(len(picked) - 1, 1))
                axis.plot(
                    at["layback"][:, k], at[kind][:, k], color=(shade, shade, 0.4 + 0.6 * shade), marker="o", ms=3,
                    label=f"t = {result.time[k]:.4g} s",
                )  # fmt: skip
            axis.set_ylabel("depth below the towpoint [m]" if kind == "depth" else "to port of it [m]")
        axes[0].invert_yaxis()
        axes[0].legend(loc="lower left", bbox_to_anchor=(-0.01, 1.0), ncols=TIMES, borderaxespad=0.2, handlelength=1.6)
        axes[-1].set_xlabel("behind the towpoint, along the first course [m]")
    return svg[0]
