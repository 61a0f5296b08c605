"""The axes of a lift: drag, and the line.

Linear drag has the energy loss of the quadratic drag over the run of the scene (`models.heave.linear.equal_loss`; for a
harmonic motion Lorentz's 8 b omega A/(3 pi)).

A line with mass has that of the scene (``mass_per_length``, or EA/c^2, c the speed of waves along it); it weighs what the scene
says (``weight_per_length``), or as steel of that mass, whose diameter it has. The elastic wire is a `tow_cable` that hangs
nearly still: linear, and taut. N segments shift omega L/c by about (omega L/(c N))^2/24, so that six a radian leave 1e-3. Its
margins that compare with the tow speed, or count transverse modes, which heave does not excite, are shown and do not decide.
The nonlinear wire is the unit `wire`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from towage.ladder.axis import Axis, Level, Trial, Unfit, entry
from towage.ladder.wire import coarse, has_wire, sprung, wires
from towage.models.heave.linear import equal_loss
from towage.models.protocol.physical import GRAVITY

LINES, BODIES = ("spring_line", "cradle_on_line"), ("cradle", "cradle_on_line")
STEEL = 7850.0
"""kg/m3; matters for the weight of the wire alone."""
SEGMENTS, A_RADIAN = 20.0, 6.0
"""Segments of a wire, and of each radian of omega L/c, at least."""
NOT_OF_A_WIRE = ("margin_small_perturbation", "margin_resolution")
"""Margins that mean nothing for a wire that hangs."""
HANGING = 0.05
"""Tow speed of a cable that hangs, m/s: `tow_cable` refuses none at all."""
RADIANS, FEWEST = 2.0, 4.0
"""Elements of degree 4 a radian of omega L/c, where that is more than a straight wire has at rest. One then carries half a
radian at the ship's frequency, and five times that with an error of (4!/8!)^2 2.5^8/9 = 6e-5 in the wave number."""


def _no_body(trial: Trial) -> str:
    return "" if trial.units(*BODIES) or wires(trial, towed=False) else "no cradle hangs in it"


def linear_drag(trial: Trial) -> Trial:
    """Linear drag of equal loss on every body."""
    if trial.units("wire"):
        raise Unfit("the load on a wire has drag of the square of its speed alone")
    values: dict[str, float] = {}
    for body in trial.units(*BODIES):
        drag = 0.5 * trial.value(body.name, "water_density") * trial.value(body.name, "drag_area")
        drag *= trial.value(body.name, "drag_coefficient")
        if not drag:
            raise Unfit(f"{body.name} has no quadratic drag")
        if trial.value(body.name, "docked_drag_area"):
            raise Unfit(f"the drag of {body.name} changes when it docks, and one damping cannot stand for both")
        speeds = _given(trial, f"{body.name}.velocity")
        if not speeds:
            raise Unfit(f"the speed of {body.name} is not told")
        damping = equal_loss(drag, trial.seen.settled(speeds[0]).tolist())
        values |= {f"{body.name}.drag_coefficient": 0.0, f"{body.name}.linear_damping": damping}
    return trial.setting(values)


def _no_line(trial: Trial) -> str:
    return "" if trial.units(*LINES) or wires(trial, towed=False) else "no spring_line, cradle_on_line or hanging wire in it"


def taut(trial: Trial) -> Trial:
    """Every line a spring that pushes too."""
    trial = sprung(trial)
    return trial.setting({f"{line.name}.never_slack": 1.0 for line in trial.units(*LINES)})


def elastic(trial: Trial) -> Trial:
    """The spring as a taut elastic wire with mass, between the ship and the cradle. Raises `Unfit`."""
    trial = sprung(trial)
    line, body = _hanging(trial)
    ship = _ship(trial, line)
    rope = Rope.of(trial, line, body)
    parameters = {
        "tow_speed": HANGING, "water_density": trial.value(body, "water_density"), "cable_length": rope.length,
        "cable_mass": rope.mass, "cable_weight": rope.weight, "cable_thickness": rope.diameter,
        "axial_stiffness": rope.stiffness, "body_mass": trial.value(body, "mass"),
        "body_added_mass_surge": trial.value(body, "added_mass"), "body_added_mass_heave": trial.value(body, "added_mass"),
        "body_weight_in_water": trial.value(body, "weight_in_water"), "body_drag": 0.0, "reduced": 0.0,
        "segments": max(SEGMENTS, math.ceil(A_RADIAN * _angle(trial, ship, rope))),
    }  # fmt: skip
    units = dict(trial.scene.units)
    units[line] = entry("tow_cable", parameters, {"top_velocity_surge": 0.0, "body_velocity_surge": 0.0})
    sources = {f"{line}.tension": "tension_body", f"{line}.reaction": "reaction_heave"}
    connections = [
        f"{line}.{sources[source]} -> {target}" if source in sources else text
        for text, source, target in trial.wiring if not target.startswith(f"{line}.")
    ]  # fmt: skip
    connections += [f"{ship}.velocity -> {line}.top_velocity_heave", f"{body}.velocity -> {line}.body_velocity_heave"]
    called, more = _tension(line, rope)
    made = trial.rebuilt(units, connections, called, more)
    return made.showing(tuple(f"{line}.{margin}" for margin in NOT_OF_A_WIRE))


def nonlinear(trial: Trial) -> Trial:
    """The spring and the cradle as one `wire`; a wire as it is. Raises `Unfit`."""
    if wires(trial, towed=False):
        return trial
    line, body = _hanging(trial)
    ship = _ship(trial, line)
    for start in ("heave_start", "velocity_start"):
        if trial.value(body, start):
            raise Unfit(f"{body}.{start} is not zero, and a wire starts at rest")
    if trial.value(body, "linear_damping"):
        raise Unfit("the load on a wire has drag of the square of its speed alone")
    rope = Rope.of(trial, line, body)
    angle = _angle(trial, ship, rope)
    parameters = {
        "tow_speed": 0.0, "water_density": trial.value(body, "water_density"), "wire_length": rope.length,
        "wire_mass": rope.mass, "wire_weight": rope.weight, "wire_diameter": rope.diameter,
        "wire_axial_stiffness": rope.stiffness, "breaking_load": trial.value(line, "breaking_load"),
        "body_mass": trial.value(body, "mass"), "body_added_mass": trial.value(body, "added_mass"),
        "body_weight": trial.value(body, "weight_in_water"),
        "body_drag_area": trial.value(body, "drag_area") * trial.value(body, "drag_coefficient"),
        "elements": math.ceil(RADIANS * angle) if RADIANS * angle > FEWEST else 0.0,
    }  # fmt: skip
    units = {n: u for n, u in trial.scene.units.items() if n != body}
    units[line] = entry("wire", parameters, {"velocity_surge": 0.0})
    connections = []
    for text, source, target in trial.wiring:
        if target in (f"{line}.heave_top", f"{line}.heave_bottom", f"{body}.line_tension"):
            continue
        if source == f"{line}.reaction":
            text = f"{line}.reaction_heave -> {target}"
        elif {source.partition(".")[0], target.partition(".")[0]} & {line, body}:
            raise Unfit(f"{text} has no place on a wire")
        connections.append(text)
    connections.append(f"{ship}.velocity -> {line}.velocity_heave")
    called, more = _tension(line, rope)
    called |= {f"{body}.heave": f"{line}.body_heave", f"{body}.velocity": f"{line}.body_velocity_heave"}
    return trial.rebuilt(units, connections, called | {f"{line}.reaction": f"{line}.reaction_heave"}, more)


def _tension(line: str, rope: Rope) -> tuple[dict[str, str], dict[str, float]]:
    """What the tension of the line is called, at the top, and the constant that it is compared with: without the weight of the
    wire, which a spring does not bear."""
    return {f"{line}.tension": f"{line}.tension_top"}, {f"{line}.tension": -rope.weight * rope.length}


class Rope(NamedTuple):
    """A line with mass: length, m; mass, kg/m, and weight in water, N/m, per length; EA, N; diameter, m."""

    length: float
    mass: float
    weight: float
    stiffness: float
    diameter: float

    @classmethod
    def of(cls, trial: Trial, line: str, body: str) -> Rope:
        """Of a `spring_line` with its cradle. Raises `Unfit` where its mass is not known."""
        length, speed = trial.value(line, "length"), trial.value(line, "wave_speed")
        per_length = trial.value(line, "mass_per_length")
        if not length or not (per_length or speed):
            raise Unfit(f"the mass of the wire is not known: give {line} its length and mass_per_length, or wave_speed")
        stiffness = trial.value(line, "stiffness")
        extension = stiffness * length if stiffness else trial.value(line, "axial_stiffness")
        mass = per_length or extension / speed**2
        area = mass / STEEL
        in_water = (mass - trial.value(body, "water_density") * area) * GRAVITY
        weight = trial.value(line, "weight_per_length") or in_water
        return cls(length, mass, weight, extension, math.sqrt(4.0 * area / math.pi))


def _angle(trial: Trial, ship: str, rope: Rope) -> float:
    """omega L/c at the mean frequency of the ship's heave, rad; 0 for a ship at rest."""
    heave, rate = trial.seen.spread(f"{ship}.heave")
    return rate / heave * rope.length * math.sqrt(rope.mass / rope.stiffness) if heave else 0.0


def _given(trial: Trial, name: str) -> list[str]:
    """The outputs of the scene as it is given that this one of the trial stands for."""
    return [given for given, here in trial.names.items() if here == name]


def _ship(trial: Trial, line: str) -> str:
    """The unit that moves the top of the line."""
    return trial.source(f"{line}.heave_top").partition(".")[0]


def _hanging(trial: Trial) -> tuple[str, str]:
    """(line, body) of a scene with one spring_line that stays taut, and a cradle of one weight on it. Raises `Unfit`."""
    lines = trial.units("spring_line")
    if len(lines) != 1:
        raise Unfit("a wire takes the place of one spring_line between a ship and a cradle, and there is no such")
    line = lines[0].name
    body = trial.source(f"{line}.heave_bottom").partition(".")[0]
    if body not in {unit.name for unit in trial.units("cradle")}:
        raise Unfit(f"what hangs on {line} is no cradle")
    if trial.value(body, "docking_time") >= 0.0:
        raise Unfit(f"what hangs on {line} changes its weight by docking, and the wire is made for one weight")
    if not all(trial.seen.settled(given).min() > 0.0 for given in _given(trial, f"{line}.tension")):
        raise Unfit(f"{line} goes slack: a wire rings after every snap until its damping, which no spring tells, has ended it")
    return line, body


DRAG = Axis(
    "drag", "How does the water resist?", _no_body,
    (Level("linear drag", "how drag grows with the square of the speed", linear_drag), Level("quadratic drag")),
)  # fmt: skip
LINE = Axis(
    "line", "What does the line know?", _no_line,
    (
        Level("always taut", "slack; mass, waves and payout of the line", taut),
        Level("with slack", "mass, waves and payout of the line", sprung),
        Level("elastic wire", "slack, payout and drag of the line", elastic),
        Level("nonlinear wire, half as fine", "short waves of the line", coarse, has_wire),
        Level("nonlinear wire", "", nonlinear),
    ),
)  # fmt: skip
