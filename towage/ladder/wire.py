"""The unit `wire` in the place of a line or a tow, and these in the place of a wire.

It is the fullest model of both families: large motions, slack, waves, elements of high order. It takes the place of what it
can describe alone: not ten coefficients of the loading. What it cannot is named, so that no rung differs from the fullest by
what the fullest does not know.
"""

from __future__ import annotations

import math
from dataclasses import fields, replace

from msgspec import structs

from towage.ladder.axis import Trial, Unfit, entry
from towage.ladder.spring import on_spring
from towage.models.cable.parameters import TowParameters
from towage.scene.parts import Transformation
from towage.units.description import Value

MOTIONS = ("velocity_surge", "velocity_heave")
TOWED = {"body_lift_change": "body_force_heave", "body_drag_change": "body_force_surge"}
"""Inputs of a towing unit that a wire has by another name."""
OPPOSITE = {"body_drag_change", "body_force_surge"}
"""Those of the other sign."""
SAME = {
    "tow_speed": "tow_speed", "water_density": "water_density", "wire_length": "cable_length", "wire_mass": "cable_mass",
    "wire_weight": "cable_weight", "wire_diameter": "cable_thickness", "wire_normal_drag": "cable_drag_coefficient",
    "loading_form": "loading_form", "added_mass_coefficient": "added_mass_coefficient",
    "momentum_added_mass": "momentum_added_mass", "wire_axial_stiffness": "axial_stiffness", "body_mass": "body_mass",
    "body_added_mass": "body_added_mass_surge", "body_added_mass_heave": "body_added_mass_heave",
    "body_weight": "body_weight_in_water", "body_lift": "body_lift",
}  # fmt: skip
"""Parameters of a wire and what a towing unit calls them."""
NONE = 1e-6
"""An added mass in heave, kg, that is none: a wire takes 0 for that in surge."""
PLANE = ("tail_length", "current_surge", "current_sway")
"""Parameters of a wire that only a wire has."""


def wires(trial: Trial, towed: bool) -> list[str]:
    """The wires of a scene that are towed, or that hang."""
    return [unit.name for unit in trial.units("wire") if (trial.value(unit.name, "tow_speed") > 0.0) == towed]


def plain(trial: Trial, towed: bool, inputs: tuple[str, ...]) -> str:
    """The one wire, of one section in still water, that nothing but ``inputs`` moves. Raises `Unfit`."""
    found = wires(trial, towed)
    if len(found) != 1:
        raise Unfit(f"the scene has {len(found)} wires: models are changed of one")
    (name,) = found
    if used := [key for key in PLANE if trial.value(name, key)]:
        raise Unfit(f"{name}.{used[0]} is not zero, which the wire alone knows")
    driven = set(fed(trial, name)) - set(inputs)
    if driven:
        raise Unfit(f"{name}.{min(driven)} is driven, which the wire alone knows")
    return name


def fed(trial: Trial, name: str) -> list[str]:
    """The inputs of a unit that are connected, or constant and not zero."""
    connected = [target.partition(".")[2] for _, _, target in trial.wiring if target.startswith(f"{name}.")]
    variables = trial.resolved.units[name].description.variables
    constant = [v.name for v in variables if v.causality == "input" and v.type == "Real" and trial.value(name, v.name)]
    return [*connected, *constant]


def sprung(trial: Trial) -> Trial:
    """A hanging wire as a spring with a cradle, without payout and side motion; any other scene as it is. Raises `Unfit`."""
    if not wires(trial, towed=False):
        return trial
    name = plain(trial, False, (*MOTIONS, "velocity_sway", "payout_speed"))
    weight, length = trial.value(name, "body_weight"), trial.value(name, "wire_length")
    per_length = trial.value(name, "wire_weight")
    line: dict[str, Value] = {
        "axial_stiffness": trial.value(name, "wire_axial_stiffness"), "length": length, "static_tension": weight,
        "mass_per_length": trial.value(name, "wire_mass"), "weight_per_length": max(0.0, per_length),
        "breaking_load": trial.value(name, "breaking_load"),
    }  # fmt: skip
    area = trial.value(name, "body_drag_area")
    load: dict[str, Value] = {
        "mass": trial.value(name, "body_mass"), "added_mass": trial.value(name, "body_added_mass"), "weight_in_water": weight,
        "drag_area": area, "drag_length": math.sqrt(area) or 1.0, "water_density": trial.value(name, "water_density"),
    }  # fmt: skip
    called = {f"{name}.body_heave": "heave", f"{name}.body_velocity_heave": "velocity"}
    return on_spring(trial, name, f"{name}.velocity_heave", line, load, called, per_length * length)


def cabled(trial: Trial) -> Trial:
    """A towed wire as a `tow_system` of the same cable and body; any other scene as it is. Raises `Unfit`."""
    if not wires(trial, towed=True):
        return trial
    name = plain(trial, True, (*MOTIONS, *TOWED.values()))
    parameters = {there: trial.value(name, here) for here, there in SAME.items()}
    normal = parameters["cable_drag_coefficient"]
    area, constant = (trial.value(name, key) for key in ("body_drag_area", "body_drag"))
    if not parameters["body_added_mass_heave"]:
        parameters["body_added_mass_heave"] = parameters["body_added_mass_surge"]
    if area and constant:
        raise Unfit(f"the body of {name} has a constant drag and one of its area: a tow cable knows either")
    along = trial.value(name, "wire_tangential_drag")
    if parameters["loading_form"] > 0.5:
        if not normal:
            raise Unfit(f"{name}.wire_normal_drag is zero, over which the loading of a tow cable is a ratio")
        along *= math.pi / normal
    dynamic = 0.5 * parameters["water_density"] * parameters["tow_speed"] ** 2
    parameters |= {
        "quadrant": 1.0 if parameters["body_weight_in_water"] > parameters["body_lift"] else 2.0, "loading_friction": along,
        "extensible": 1.0, "body_drag": dynamic * area + constant, "body_quadratic_drag": 0.0 if constant else 1.0,
    }  # fmt: skip
    return _renamed(trial, name, "tow_system", parameters, {there: here for here, there in TOWED.items()})


def wired(trial: Trial, name: str) -> Trial:
    """A `tow_system` as a wire. Raises `Unfit`."""
    value = {field.name: trial.value(name, field.name) for field in fields(TowParameters)}
    if not value["axial_stiffness"]:
        raise Unfit(f"{name}.axial_stiffness is not known, and the wire stretches: give EA")
    if value["loading_form"] > 1.5:
        raise Unfit("the wire does not know ten coefficients of the loading")
    along, dynamic = value["loading_friction"], 0.5 * value["water_density"] * value["tow_speed"] ** 2
    quadratic = value["body_quadratic_drag"] > 0.5
    parameters = {here: value[there] for here, there in SAME.items()} | {
        "wire_tangential_drag": along * value["cable_drag_coefficient"] / math.pi if value["loading_form"] > 0.5 else along,
        "body_drag_area": value["body_drag"] / dynamic if quadratic else 0.0,
        "body_drag": 0.0 if quadratic else value["body_drag"],
        "body_added_mass_heave": value["body_added_mass_heave"] or NONE,
    }
    return _renamed(trial, name, "wire", parameters, TOWED)


def _renamed(trial: Trial, name: str, fmu: str, parameters: dict[str, float], inputs: dict[str, str]) -> Trial:
    """The unit as another, whose ``inputs`` have other names where they are listed."""
    given = trial.scene.units[name]
    constants = {inputs.get(key, key): key for key in given.values if trial.is_input(name, key)}
    kept = {
        there: -trial.value(name, here) if here in OPPOSITE else given.values[here]
        for there, here in constants.items() if there in {*MOTIONS, *inputs.values()}
    }  # fmt: skip
    units = dict(trial.scene.units) | {name: entry(fmu, parameters, kept)}
    ends = {f"{name}.{here}": f"{name}.{there}" for here, there in inputs.items()}
    turned = {f"{name}.{here}" for here in inputs if here in OPPOSITE}
    wiring = [(f"{source} -> {ends.get(target, target)}", target in turned) for _, source, target in trial.wiring]
    made = trial.rebuilt(units, [text for text, _ in wiring], {})
    changes = {text: Transformation(factor=-1.0) for text, opposite in wiring if opposite}
    return replace(made, scene=structs.replace(made.scene, transformations=changes)) if changes else made


def has_wire(trial: Trial) -> bool:
    """Whether the scene is one of a wire."""
    return bool(trial.units("wire"))


def coarse(trial: Trial) -> Trial:
    """The one wire with half its elements; of one element, with half the degree. Raises `Unfit`."""
    from towage.models.cable.case import CableError
    from towage.models.cable.units import wire_parameters, wire_seen

    (name,) = (unit.name for unit in trial.units("wire"))
    p = wire_parameters.Parameters(**{field.name: trial.value(name, field.name) for field in fields(wire_parameters.Parameters)})
    try:
        count = len(wire_seen.prepare(p).chain.mesh.lengths)
    except CableError as error:
        raise Unfit(str(error)) from error
    if count > (2 if p.tail_length else 1):  # a section has an element at least
        return trial.setting({f"{name}.elements": float(count // 2)})
    if p.degree < 2.0:
        raise Unfit(f"{name} has as few elements as it can have, of degree 1")
    return trial.setting({f"{name}.elements": float(count), f"{name}.degree": float(p.degree // 2)})
