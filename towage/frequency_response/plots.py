"""Plots of a tow: magnitude and phase over frequency, along the cable, and the steady shape; of a lift over frequency. SVG."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from towage.models.cable.steady.response import respond
from towage.report.svg import save_figure

if TYPE_CHECKING:
    from towage.checks.towing import Gain, SceneTow
    from towage.frequency_response.lift import LiftResponse
    from towage.models.cable.steady.perturbation import Excitation


def response_plot(path: Path, name: str, per: str, rows: list[Gain]) -> None:
    """Magnitude (N, m) and phase (rad) of tensions and body motion over frequency, Hz, of the tow ``name`` for ``per``;
    written to ``path``."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.0, 7.0), layout="constrained")
    hertz = [g.omega / (2.0 * math.pi) for g in rows]
    axes = figure.subplots(2, 2, sharex=True)
    groups = (("tension_top", "tension_body"), ("body_heave", "body_surge"))
    for column, (signals, label) in enumerate(zip(groups, ("N", "m"))):
        for signal in signals:
            values = np.array([getattr(g, signal) for g in rows])
            axes[0, column].loglog(hertz, np.abs(values), label=signal.replace("_", " "))
            axes[1, column].semilogx(hertz, np.angle(values))
        axes[0, column].set_ylabel(label)
        axes[1, column].set(xlabel="frequency, Hz", ylabel="phase, rad")
        axes[0, column].legend()
    figure.suptitle(f"{name}: response to {per}")
    save_figure(figure, path)


def cable_plot(path: Path, tow: SceneTow, omega: float, excitation: Excitation) -> None:
    """Steady shape, and magnitude and phase of tension and angle along the cable at ``omega``, rad/s; written
    to ``path``."""
    from matplotlib.figure import Figure

    r = respond(tow.tow, omega, excitation)
    edges, p = r.steady.edges, r.angle.shape[1] - 1
    nodes = -np.cos(np.pi * np.arange(p + 1) / p)
    s = (0.5 * (edges[:-1] + edges[1:])[:, None] + 0.5 * np.diff(edges)[:, None] * nodes).ravel()
    figure = Figure(figsize=(10.0, 7.0), layout="constrained")
    axes = figure.subplots(2, 2)
    axes[0, 0].plot((r.steady.x - r.steady.x[-1, -1]).ravel(), (r.steady.y - r.steady.y[-1, -1]).ravel())
    axes[0, 0].set(xlabel="forward of the towpoint, m", ylabel="above the towpoint, m", title="steady shape",
                   aspect="equal")  # fmt: skip
    axes[0, 1].plot(s, r.steady.tension.ravel())
    axes[0, 1].set(xlabel="distance from the body, m", ylabel="steady tension, N")
    for axis, values, name in ((axes[1, 0], np.abs, "magnitude"), (axes[1, 1], np.angle, "phase, rad")):
        axis.plot(s, values(r.tension.ravel()) / (r.steady.tension.ravel() if name == "magnitude" else 1.0),
                  label="tension over steady tension")  # fmt: skip
        axis.plot(s, values(r.angle.ravel()), label="angle, rad")
        axis.set(xlabel="distance from the body, m", ylabel=name)
        axis.legend()
    figure.suptitle(f"{tow.name} at {omega / (2.0 * math.pi):.4g} Hz")
    save_figure(figure, path)


def lift_plot(path: Path, response: LiftResponse) -> None:
    """Heave, lag, tension and slack of a lift over frequency, both branches, and the limits; written to ``path``."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.0, 7.0), layout="constrained")
    axes = figure.subplots(2, 2, sharex=True)
    panels = (
        ("transmissibility", "heave of the cradle over the ship's", 1.0), ("lag", "lag, rad", 1.0),
        ("tension_max", "largest tension, kN", 1e-3), ("slack_fraction", "slack, % of the time", 100.0),
    )  # fmt: skip
    for axis, (name, label, factor) in zip(axes.ravel(), panels):
        for branch, style in (("up", "o-"), ("down", "x--")):
            points = [p for p in response.points if p.branch == branch]
            if points:
                values = [factor * getattr(p, name) for p in points]
                axis.plot([p.frequency_hz for p in points], values, style, markersize=3, label=f"followed {branch}")
        axis.set_ylabel(label)
    for axis in axes[1]:
        axis.set_xlabel("frequency, Hz")
    axes[0, 0].legend()
    figure.suptitle(f"lift: response to {response.amplitude:.4g} m of heave of the ship")
    save_figure(figure, path)
