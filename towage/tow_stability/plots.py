"""Diagrams of a towed slender body's stability: modes in the Argand plane over tow speed, and a stability map."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from towage.models.slender.tracking import Path as ModePath
from towage.report.plots import BLUE, CYCLE, GREEN, RED
from towage.report.svg import save_figure
from towage.tow_stability.critical import RANGES, Array, Row

STYLE: Any = {"svg.fonttype": "path", "font.size": 9.0}
LARGEST = 150.0
"""|omega| beyond which modes are not drawn: the first five are below."""


def argand_plot(
    path: Path, title: str, speeds: Array, modes: Sequence[ModePath], speed_scale: float,
    names: Sequence[str] = (), unit: str = " m/s",
) -> None:
    """Omega = -i s of every mode, in 1/tau: rows over ten, since the modes lie far apart along the real axis. Unstable
    below the line. Speeds are marked
    in ``unit``, ``speed_scale`` being u = 1; ``names`` of the modes: mode 0, 1 ... by default."""
    import matplotlib

    with matplotlib.rc_context(STYLE):
        from matplotlib.figure import Figure

        figure = Figure(figsize=(9.6, 5.4), layout="constrained")
        axes = figure.subplots()
        axes.axhline(0.0, color="#1b2430", lw=0.8)
        marks = range(0, len(speeds), max(1, len(speeds) // 8))
        drawn = [k for k, mode in enumerate(modes) if np.all(np.abs(mode.roots) < LARGEST)]
        for k, mode in enumerate(modes):
            color = CYCLE[k % len(CYCLE)]
            omega = -1j * mode.roots
            omega = np.where(np.abs(omega) < LARGEST, omega, np.nan)
            axes.plot(omega[:, 0].real, omega[:, 0].imag, color=color, label=names[k] if names else f"mode {k}")
            real = ~mode.oscillates
            second = np.where(real, omega[:, 1], np.nan)
            axes.plot(second.real, second.imag, color=color, ls="--")
            for j in marks:
                axes.plot(omega[j, 0].real, omega[j, 0].imag, "o", ms=3, color=color)
                if k == max(drawn, default=-1):
                    axes.annotate(
                        f"{speeds[j] * speed_scale:.3g}{unit}", (omega[j, 0].real, omega[j, 0].imag), fontsize=7,
                        xytext=(4, 3), textcoords="offset points",
                    )  # fmt: skip
        axes.set(xlabel="Re omega tau", ylabel="Im omega tau (growing below 0)", title=title)
        axes.set_xscale("symlog", linthresh=1.0)
        axes.set_yscale("symlog", linthresh=1.0)
        axes.legend(loc="best", fontsize=8)
        axes.grid(alpha=0.3)
        save_figure(figure, path)


def map_plot(path: Path, title: str, parameter: str, rows: Sequence[Row], u_max: float, speed_scale: float) -> None:
    """Stable tow speeds (shaded) and critical ones over a parameter; u on the left, m/s on the right."""
    import matplotlib

    with matplotlib.rc_context(STYLE):
        from matplotlib.figure import Figure

        figure = Figure(figsize=(9.6, 5.4), layout="constrained")
        axes = figure.subplots()
        values = np.array([r.value for r in rows])
        logarithmic = parameter == "rope_length"
        axis = np.log(values) if logarithmic else values
        middle = 0.5 * (axis[1:] + axis[:-1])
        edges = np.concatenate([axis[:1], middle, axis[-1:]])
        edges = np.exp(edges) if logarithmic else edges
        for k, r in enumerate(rows):
            for low, high in r.stable:
                axes.fill_between(edges[k : k + 2], low, high, color=GREEN, alpha=0.18, lw=0)
        series = (
            ("yaw", RED, "o", [(r.value, u) for r in rows for u in r.yaw]),
            ("flutter begins", BLUE, "^", [(r.value, u) for r in rows for u, _, grows in r.flutter if grows]),
            ("flutter ends", BLUE, "v", [(r.value, u) for r in rows for u, _, grows in r.flutter if not grows]),
        )
        for label, color, marker, points in series:
            if points:
                x, y = zip(*points)
                axes.plot(x, y, marker, ms=3.5, color=color, label=label)
        axes.fill_between([], [], color=GREEN, alpha=0.18, label="stable")
        if logarithmic:
            axes.set_xscale("log")
        axes.set(xlabel=RANGES[parameter][2], ylabel="u = sqrt(M/EI) U L", ylim=(0.0, u_max), title=title)
        scales: Any = (lambda u: u * speed_scale, lambda v: v / speed_scale)
        axes.secondary_yaxis("right", functions=scales).set_ylabel("tow speed, m/s")
        axes.legend(loc="best", fontsize=8)
        axes.grid(alpha=0.3)
        save_figure(figure, path)
