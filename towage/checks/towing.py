"""The tows in a scene: their frequency response, and which model a scene of theirs needs.

Three fidelities are offered: the linear unit reduced (`tow_system`, reduced = 1), the linear unit full (reduced = 0) and
the nonlinear one (`wire`). `before_run` names the cheapest whose measured error is below the scene's
tolerance: errors of segments and reduction against the frequency domain, error of linearity by the nonlinear equations
(``models/cable/lumped/linearity.py``). The ladder runs the simplest model of all, a body on a spring.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from towage.checks.tow_names import LINEAR
from towage.models.cable.case import CableError, Tow
from towage.models.cable.lumped.fidelity import Chosen, choose
from towage.models.cable.lumped.linearity import regular
from towage.models.cable.parameters import TowParameters, tow_of
from towage.models.cable.steady.perturbation import Excitation
from towage.models.cable.steady.response import mesh, responses
from towage.models.cable.units import tow_cable, tow_system
from towage.result.records import Finding
from towage.scene.resolve import ResolvedScene, ResolvedUnit, described
from towage.scene.scene import Scene
from towage.units.description import Value
from towage.units.store import locator

DEFAULT_TOLERANCE = 0.05


@dataclass(frozen=True)
class SceneTow:
    """A towing unit of a scene: its name, kind, all SI parameters and the tow; ``drive``: (amplitude of the velocity of
    the towpoint, m/s, angular frequency, rad/s), if a ship of known heave moves it."""

    name: str
    unit: str
    parameters: dict[str, float]
    tow: Tow
    drive: tuple[float, float] | None


def tows(resolved: ResolvedScene) -> list[SceneTow]:
    """The towing units of a resolved scene. Raises `CableError` where one makes no sense."""
    tows = []
    for name, unit in resolved.units.items():
        kind = unit.description.model_name
        if kind not in LINEAR:
            continue
        values = _values(unit)
        shared = TowParameters(**{f: values[f] for f in TowParameters.__dataclass_fields__})
        tows.append(SceneTow(name, kind, values, tow_of(shared), _drive(resolved, name)))
    return tows


def _values(unit: ResolvedUnit) -> dict[str, float]:
    start = {v.name: v.start for v in unit.description.variables if v.causality == "parameter" and v.start is not None}
    merged: dict[str, Value] = {**start, **unit.parameters}
    return {name: float(value) for name, value in merged.items() if isinstance(value, (int, float))}


def _drive(resolved: ResolvedScene, name: str) -> tuple[float, float] | None:
    for c in resolved.connections:
        if not c.changed and c.target_unit == name and c.target in ("velocity_heave", "top_velocity_heave"):
            values = _values(resolved.units[c.source_unit])
            amplitude, period = values.get("heave_amplitude"), values.get("heave_period")
            if amplitude and period:
                omega = 2.0 * math.pi / period
                return omega * abs(amplitude), omega
    return None


def scene_tows(scene: Scene, fmus: Path | None = None) -> list[SceneTow]:
    """`tows` of a scene whose FMUs are in ``fmus`` or built when needed."""
    return tows(described(scene, locator(fmus), open_ends=True))


@dataclass(frozen=True)
class Gain:
    """Complex amplitudes for one metre of heave of the towpoint (Quadrant I) or 1 N of lift on the body (Quadrant II), as
    Re(q exp(-i omega t)): tensions, N, and displacement of the body, m; ``spring``: its heave on a spring EA/L alone."""

    omega: float
    tension_top: complex
    tension_body: complex
    body_surge: complex
    body_heave: complex
    spring: float | None


def gains(tow: Tow, omegas: list[float], excitation: Excitation | None = None) -> list[Gain]:
    """Gains over frequency, rad/s, on one mesh; ``excitation``: another than that of a `Gain`."""
    state = mesh(tow, max(omegas))
    excitation = excitation or (Excitation(heave=1.0) if tow.quadrant == 1 else Excitation(lift=1.0))
    gains = []
    for omega in omegas:
        r = responses(tow, omega, [excitation], state)[0]
        x, y = r.displacement
        gains.append(
            Gain(
                omega,
                complex(r.tension[-1, -1]),
                complex(r.tension[0, 0]),
                complex(x[0, 0]),
                complex(y[0, 0]),
                spring_gain(tow, omega),
            )
        )
    return gains


def spring_gain(tow: Tow, omega: float) -> float | None:
    """|heave| of the body per heave of the towpoint by the single-degree-of-freedom model, K = EA/L, no drag; None in
    Quadrant II or where EA is not known. 1 - omega^2 M/K may vanish: then it is infinite."""
    if tow.quadrant == 2 or not math.isfinite(tow.cable.axial_stiffness):
        return None
    stiffness = tow.cable.axial_stiffness / tow.cable.length
    rest = abs(1.0 - omega**2 * (tow.body.mass + tow.body.added_mass_heave) / stiffness)
    return 1.0 / rest if rest else math.inf


def linearity_error(tow: Tow, velocity: float, omega: float, quadratic_drag: bool) -> float:
    """Error of the linear model's tensions and body motion, the largest over its amplitude, for a towpoint that always heaves
    with this velocity amplitude, m/s. Raises `CableError` where it cannot be found."""
    return regular(tow, quadratic_drag, np.array([0.0, velocity, 0.0, 0.0]), omega).error


def tolerance_of(scene: Scene) -> float:
    """The relative error that a scene allows."""
    sdof = scene.checks.get("sdof")
    return float(sdof.tolerance) if sdof else DEFAULT_TOLERANCE


def before_run(resolved: ResolvedScene) -> list[Finding]:
    """Which fidelity every tow of a scene needs, with the measured errors of the cheaper ones; where only the run will tell what
    drives it, that."""
    tolerance = tolerance_of(resolved.scene)
    found = tows(resolved)
    return [finding for t in found if (finding := _segments(t))] + [
        _fidelity(t, t.drive, tolerance) if t.drive and t.unit != "tow_cable" else _later(t, tolerance)
        for t in found
    ]


def _chosen(tow: SceneTow) -> Chosen:
    """The model of a tow. Raises `CableError`."""
    p = tow.parameters
    if tow.unit == "tow_cable":
        return tow_cable.chosen(tow_cable.Parameters(**{k: p[k] for k in tow_cable.Parameters.__dataclass_fields__}))
    return tow_system.chosen(tow_system.Parameters(**{k: p[k] for k in tow_system.Parameters.__dataclass_fields__}))


def _segments(tow: SceneTow) -> Finding | None:
    """How many segments would do, where as many as are chosen by themselves do not reach the tolerance of the unit."""
    wanted = tow.parameters["tolerance"]
    if tow.parameters["segments"]:
        return None
    try:
        found = _chosen(tow)
    except CableError:
        return None  # said by `_fidelity`, and by the unit itself
    if found.error <= wanted:
        return None
    need = math.ceil(found.nodes * math.sqrt(found.error / wanted))
    return Finding(
        f"segments of {tow.name}", "warning", found.error, wanted,
        f"{found.nodes} segments, the most that are chosen, leave {found.error:.2g}; {tow.name}.tolerance is {wanted:g}: about "
        f"{need} would reach it, with {tow.name}.grading = {found.grading:g}; or take the unit wire",
    )  # fmt: skip


def _later(tow: SceneTow, tolerance: float) -> Finding:
    message = "the error of the linear model is found after the run, for the drive that the run has"
    return Finding(f"fidelity of {tow.name}", "info", None, tolerance, message)


def _fidelity(tow: SceneTow, drive: tuple[float, float], wanted: float) -> Finding:
    velocity, omega = drive
    p = tow.parameters
    name = f"fidelity of {tow.name}"
    try:
        nonlinear = linearity_error(tow.tow, velocity, omega, p["body_quadratic_drag"] > 0.5)
        reduced = _chosen(tow)
    except CableError as error:
        return Finding(name, "warning", None, wanted, f"not judged: {error}")
    full = unreduced_error(tow.tow, reduced, omega)
    errors = {"linear reduced": nonlinear + reduced.error, "linear full": nonlinear + full, "nonlinear": 0.0}
    need = next(k for k, e in errors.items() if e <= wanted)
    listed = ", ".join(f"{k} {e:.2g}" for k, e in errors.items() if k != "nonlinear")
    used = "linear full" if p["reduced"] < 0.5 else "linear reduced"
    order = list(errors)
    enough = order.index(used) >= order.index(need)
    return Finding(
        name, "ok" if enough else "warning", errors[used], wanted,
        f"v/c = {velocity / tow.tow.speed:.2g}; relative errors: {listed} (of these {nonlinear:.2g} of linearity); "
        f"tolerance {wanted:g}: {need} is enough, the scene has {used}",
    )  # fmt: skip


def unreduced_error(tow: Tow, reduced: Chosen, band: float) -> float:
    """Error of the unreduced model with the segments of ``reduced``."""
    extensible = math.isfinite(tow.cable.axial_stiffness)
    return choose(tow, extensible, max(band * 1.5, 1e-3), 0.5, reduced.nodes, reduced=False).error
