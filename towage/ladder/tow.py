"""The axis of a tow: a massless spring, the linear cable with states reduced or with all, the nonlinear wire.

The towing units share their parameters (`models.cable.parameters.TowParameters`), so that a `tow_cable` with its
`towed_body` becomes one unit with its body. A `wire` takes their place, and they that of one that is towed, where it is the
same tow (`wire`). The spring is EA/L between the ship and a cradle of the body's
mass, with the linear part of the body's drag.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields

from towage.checks.tow_names import LINEAR, WHOLE
from towage.ladder.axis import Axis, Level, Trial, Unfit, entry
from towage.ladder.spring import on_spring
from towage.ladder.wire import cabled, coarse, has_wire, wired, wires
from towage.models.cable.parameters import TowParameters

SHARED = tuple(field.name for field in fields(TowParameters))
INPUTS = {"top_velocity_surge": "velocity_surge", "top_velocity_heave": "velocity_heave"}
"""What inputs of `tow_cable` are called in the units with a body."""
BODY = {"surge": "body_surge", "heave": "body_heave", "velocity_surge": "body_velocity_surge",
        "velocity_heave": "body_velocity_heave"}  # fmt: skip
"""What outputs of `towed_body` are called there."""


def _no_tow(trial: Trial) -> str:
    return "" if trial.units(*LINEAR) or wires(trial, towed=True) else "nothing is towed on a cable"


def _tow(trial: Trial) -> tuple[str, str]:
    """(name, kind) of the one towing unit. Raises `Unfit`."""
    found = trial.units(*LINEAR)
    if len(found) != 1:
        raise Unfit(f"the scene has {len(found)} tows: models are changed of one")
    return found[0].name, found[0].description.model_name


def _whole(trial: Trial, name: str) -> Trial:
    """A `tow_cable` and its body as one `tow_system`. Raises `Unfit`."""
    given = trial.scene.units[name]
    bodies = [unit.name for unit in trial.units("towed_body")]
    if len(bodies) != 1:
        raise Unfit(f"{name} tows no towed_body, whose mass and drag another model would have to know")
    parameters = {key: value for key, value in given.parameters.items() if key in SHARED}
    inputs = {INPUTS.get(key, key): value for key, value in given.values.items() if trial.is_input(name, key)}
    units = {n: u for n, u in trial.scene.units.items() if n not in bodies} | {name: entry(WHOLE, parameters, inputs)}
    called = {f"{body}.{here}": f"{name}.{there}" for body in bodies for here, there in BODY.items()}
    connections = []
    for _, source, target in trial.wiring:
        unit, _, variable = target.partition(".")
        if unit in bodies and variable in ("drag_change", "lift_change"):
            target = f"{name}.body_{variable}"
        elif unit in bodies or (source.partition(".")[0] in bodies and unit == name):
            continue
        elif unit == name:
            target = f"{name}.{INPUTS.get(variable, variable)}"
        connections.append(f"{called.get(source, source)} -> {target}")
    return trial.rebuilt(units, connections, called)


def _linear(reduced: float) -> Callable[[Trial], Trial]:
    """A level's ``make``."""

    def make(trial: Trial) -> Trial:
        trial = cabled(trial)
        return trial.setting({f"{_tow(trial)[0]}.reduced": reduced})

    return make


def wire(trial: Trial) -> Trial:
    """The nonlinear wire. Raises `Unfit`."""
    if wires(trial, towed=True):
        return trial
    name, kind = _tow(trial)
    return wired(trial if kind == WHOLE else _whole(trial, name), name)


def spring(trial: Trial) -> Trial:
    """A body on a spring EA/L in heave. Raises `Unfit`."""
    trial = cabled(trial)
    name, kind = _tow(trial)
    stiffness = trial.value(name, "axial_stiffness")
    if trial.value(name, "quadrant") != 1.0:
        raise Unfit("a float that a submarine tows does not hang on a spring")
    if not stiffness:
        raise Unfit(f"{name}.axial_stiffness is not known, which makes the spring EA/L: give EA")
    slope = trial.value(name, "body_drag") / trial.value(name, "tow_speed")
    weight = trial.value(name, "body_weight_in_water") - trial.value(name, "body_lift")
    line = {"axial_stiffness": stiffness, "length": trial.value(name, "cable_length"), "static_tension": weight}
    load = {
        "mass": trial.value(name, "body_mass"), "added_mass": trial.value(name, "body_added_mass_heave"),
        "weight_in_water": weight, "water_density": trial.value(name, "water_density"),
        "linear_damping": slope if trial.value(name, "body_quadratic_drag") > 0.5 else 0.0,
    }  # fmt: skip
    bodies = [unit.name for unit in trial.units("towed_body")]
    called = {f"{name}.{BODY['heave']}": "heave", f"{name}.{BODY['velocity_heave']}": "velocity"}
    called |= {f"{body}.{n}": called[f"{name}.{BODY[n]}"] for body in bodies for n in ("heave", "velocity_heave")}
    heaves = f"{name}.{'top_' if kind == 'tow_cable' else ''}velocity_heave"
    return on_spring(trial, name, heaves, line, load, called)


CABLE = Axis(
    "cable", "What does the tow cable know?", _no_tow,
    (
        Level("massless spring EA/L", "mass, drag, shape and waves of the cable; surge", spring),
        Level("linear cable, reduced", "large motions about the steady tow; fast modes", _linear(1.0)),
        Level("linear cable", "large motions about the steady tow", _linear(0.0)),
        Level("nonlinear wire, half as fine", "short waves and bends of the wire", coarse, has_wire),
        Level("nonlinear wire", "", wire),
    ),
)  # fmt: skip
