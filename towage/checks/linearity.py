"""How wrong a linear tow is in a run: its margin `margin_small_perturbation`, from what moved its towpoint and its body.

The run's own drive, regular or irregular, goes through the nonlinear equations (``models/cable/lumped/linearity.py``); the
difference to the linear motion is the error, to whose bound that of the unit's segments and reduction is added
(`model_error`). It takes the place of the unit's margin, which knows the present moment only.

| word | meaning |
|---|---|
| valid | tensions and motion of the body are within the tolerance, with the bound |
| marginal | the error is, the bound is not; or the body's mean depth shifts by more than the tolerance of its heave |
| invalid | the error exceeds the tolerance |
| not judged | the nonlinear motion was not found |
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from towage.checks.check import Component, Finished
from towage.checks.tow_names import OWN, SMALL, WHOLE
from towage.checks.towing import SceneTow, tolerance_of, tows
from towage.models.cable.case import CableError
from towage.models.cable.lumped.linearity import Linearity, recorded
from towage.result.records import Finding, Margin, Word
from towage.scene.resolve import ResolvedScene

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

REMEDY = "take wire"
RESOLUTION = "margin_resolution"
DRIVES = {
    "tow_system": (("velocity_surge", 1.0), ("velocity_heave", 1.0), ("body_drag_change", -1.0), ("body_lift_change", 1.0)),
    "tow_cable": (("top_velocity_surge", 1.0), ("top_velocity_heave", 1.0)),
    "towed_body": (("drag_change", -1.0), ("lift_change", 1.0)),
}
"""Inputs that drive a tow: velocity of the towpoint, forward and up, force on the body, forward and up, with their signs."""


def judge(run: Finished) -> list[Finding]:
    """Sets the margins of every linear tow; a finding each."""
    tolerance, findings = tolerance_of(run.scene.scene), []
    shown = run.scene.scene.checks.report_only
    for tow in tows(run.scene):
        if tow.unit not in DRIVES:
            continue
        unit = next(unit for unit in run.system.units if unit.name == tow.name)
        model = unit.constant("model_error") or 0.0
        try:
            errors = linearity(run, tow, unit)
            found: Linearity | str = replace(errors, bound=errors.bound + max(model, errors.model))
        except (CableError, ValueError) as error:
            found = str(error)
        margin = margin_of(tow.name, found, tolerance, shown)
        run.result.margins += [margin, resolution_of(tow.name, model, tolerance, shown)]
        level: Any = "ok" if margin.word == "valid" else "warning"
        findings.append(
            Finding(f"linearity of {tow.name}", level, margin.error, tolerance, margin.reason, margin.remedy)
        )
    return findings


def resolution_of(name: str, model: float, tolerance: float, report_only: tuple[str, ...]) -> Margin:
    """The margin of segments and reduction of the tow ``name``, by the scene's tolerance instead of the unit's own: a bound,
    which makes no run invalid."""
    variable = f"{name}.{RESOLUTION}"
    decides = variable not in report_only
    if model <= tolerance:
        return Margin(variable, 1.0 - model / tolerance, 0.0, decides, error=model, limit=tolerance)
    reason = f"what segments and reduction of {name} cost, at most, up to its band"
    remedy = f"lower {name}.band to what the sea has, or take wire"
    return Margin(variable, 1.0 - model / tolerance, 0.0, decides, "marginal", reason, model, tolerance, remedy)


def linearity(run: Finished, tow: SceneTow, unit: Component) -> Linearity:
    """The errors of a tow in a run, from `settle` of the SDOF check on, without one over the second half; ``unit`` is the tow at
    work. Raises `CableError`."""
    time, section = run.times, run.scene.scene.checks.get("sdof")
    drive = np.array([drive_of(run, unit, name) * sign for unit, name, sign in inputs_of(run.scene, tow)])
    drive = np.vstack([drive, np.zeros((4 - len(drive), len(time)))])
    quadratic = tow.parameters["body_quadratic_drag"] > 0.5
    settle = section.settle if section else 0.5 * float(time[-1])
    own = None
    if tow.unit == WHOLE:
        steady = [unit.constant(f"steady_{name}") or 0.0 for name in OWN[:2]]
        values = np.array([run.track.at(f"{tow.name}.{name}", run.times) for name in OWN])
        own = values - np.array([*steady, 0.0, 0.0])[:, None]
    return recorded(tow.tow, quadratic, time, drive, settle, own, int(unit.constant("segments_used") or 0))


def inputs_of(scene: ResolvedScene, tow: SceneTow) -> list[tuple[str, str, float]]:
    """(unit, input, sign) of what drives a tow; a cable alone has the forces on the body beside it."""
    found = [(tow.name, name, sign) for name, sign in DRIVES[tow.unit]]
    if tow.unit == "tow_cable":
        body = next((c.source_unit for c in scene.connections if c.target_unit == tow.name and c.target.startswith("body_")), "")
        if body and scene.units[body].description.model_name == "towed_body":
            found += [(body, name, sign) for name, sign in DRIVES["towed_body"]]
    return found


def drive_of(run: Finished, unit: str, name: str) -> Array:
    """An input over the run's comparison times: what is connected to it, else its constant. Raises `CableError`."""
    for c in run.scene.connections:
        if (c.target_unit, c.target) == (unit, name):
            source = f"{c.source_unit}.{c.source}"
            if source not in run.track.columns:
                raise CableError(f"{source}, which drives {unit}.{name}, was not observed: add it to record.variables")
            values: Array = c.factor * run.track.at(source, run.times) + c.offset
            return values
    entry = run.scene.units[unit]
    start = next((v.start for v in entry.description.variables if v.name == name), 0.0)
    return np.full(len(run.times), float(entry.parameters.get(name, start) or 0.0))


def margin_of(name: str, found: Linearity | str, tolerance: float, report_only: tuple[str, ...]) -> Margin:
    """The margin of the tow ``name``, 1 - bound/tolerance, with its word; ``found``: the errors, or why there are none."""
    variable = f"{name}.{SMALL}"
    decides = variable not in report_only
    if isinstance(found, str):
        reason = f"the error of the linear tow {name} could not be found: {found}"
        return Margin(variable, 0.0, 0.0, decides, "not judged", reason, None, tolerance, REMEDY)
    shift = abs(found.rise) / found.heave if found.heave else 0.0
    deep = f"; in the mean the body runs {abs(found.rise):.2g} m {'higher' if found.rise > 0.0 else 'deeper'}"
    word, number, reason = _word(found, tolerance, shift)
    reason = f"{reason} of {name}{deep if abs(found.rise) > 0.01 * tolerance * found.heave else ''}"
    worst = max(-1e6, 1.0 - max(found.bound, found.error) / tolerance)
    return Margin(
        variable, worst, found.time, decides, word, reason, number, tolerance, "" if word == "valid" else REMEDY
    )


def _word(found: Linearity, tolerance: float, shift: float) -> tuple[Word, float, str]:
    """Word, the number that decided, and what it is."""
    names = {
        "tension at the top": found.tension_top, "tension at the body": found.tension_body, "motion of the body": found.motion,
    }  # fmt: skip
    name = max(names, key=names.__getitem__)
    what = f"error of the linear model in the {name}"
    if found.error > tolerance:
        return "invalid", found.error, what if found.followed else f"{what}, at least,"
    if not found.followed or not math.isfinite(found.bound):
        return "not judged", found.error, f"{what}, which grows with each correction,"
    if found.bound > tolerance:
        return "marginal", found.bound, f"bound of the {what}"
    if shift > tolerance:
        return "marginal", shift, "shift of the mean depth, which the linear model leaves out, over the heave of the body"
    return "valid", found.error, what
