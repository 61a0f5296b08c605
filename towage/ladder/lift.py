"""The axes of a lift: drag, and the line.

Linear drag has the energy loss of the quadratic drag over the run of the scene (`models.heave.linear.equal_loss`; for a
harmonic motion Lorentz's 8 b omega A/(3 pi)).

An elastic wire is a `tow_cable` that hangs nearly still: it carries waves, and weighs. Its mass per length follows from
EA/c^2, c the speed of waves along the line; its density is taken for that of steel. N segments shift omega L/c by about
(omega L/(c N))^2/24, so that six a radian leave 1e-3. Its margins that compare with the tow speed, or count transverse modes,
which heave does not excite, are shown and do not decide.
"""

from __future__ import annotations

import math

from towage.ladder.axis import Axis, Level, Trial, Unfit, ends, entry
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


def _no_body(trial: Trial) -> str:
    return "" if trial.units(*BODIES) else "no cradle hangs in it"


def linear_drag(trial: Trial) -> Trial:
    """Linear drag of equal loss on every body."""
    values: dict[str, float] = {}
    for body in trial.units(*BODIES):
        drag = 0.5 * trial.value(body.name, "water_density") * trial.value(body.name, "drag_area")
        drag *= trial.value(body.name, "drag_coefficient")
        if not drag:
            raise Unfit(f"{body.name} has no quadratic drag")
        if trial.value(body.name, "docked_drag_area"):
            raise Unfit(f"the drag of {body.name} changes when it docks, and one damping cannot stand for both")
        damping = equal_loss(drag, trial.seen.settled(f"{body.name}.velocity").tolist())
        values |= {f"{body.name}.drag_coefficient": 0.0, f"{body.name}.linear_damping": damping}
    return trial.setting(values)


def _no_line(trial: Trial) -> str:
    return "" if trial.units(*LINES) else "no spring_line or cradle_on_line in it"


def taut(trial: Trial) -> Trial:
    """Every line a spring that pushes too."""
    return trial.setting({f"{line.name}.never_slack": 1.0 for line in trial.units(*LINES)})


def wire(trial: Trial) -> Trial:
    """The spring as an elastic wire with mass, between the ship and the cradle. Raises `Unfit`."""
    line, body = _hanging(trial)
    ship = _feeds(trial, f"{line}.heave_top")
    length, speed = trial.value(line, "length"), trial.value(line, "wave_speed")
    stiffness = trial.value(line, "stiffness")
    extension = stiffness * length if stiffness else trial.value(line, "axial_stiffness")
    mass = extension / speed**2
    area = mass / STEEL
    density = trial.value(body, "water_density")
    parameters = {
        "tow_speed": HANGING, "water_density": density, "cable_length": length, "cable_mass": mass,
        "cable_weight": (mass - density * area) * GRAVITY, "cable_thickness": math.sqrt(4.0 * area / math.pi),
        "axial_stiffness": extension, "body_mass": trial.value(body, "mass"),
        "body_added_mass_surge": trial.value(body, "added_mass"), "body_added_mass_heave": trial.value(body, "added_mass"),
        "body_weight_in_water": trial.value(body, "weight_in_water"), "body_drag": 0.0, "reduced": 0.0,
        "segments": _segments(trial, ship, length / speed),
    }  # fmt: skip
    units = dict(trial.scene.units)
    units[line] = entry("tow_cable", parameters, {"top_velocity_surge": 0.0, "body_velocity_surge": 0.0})
    sources = {f"{line}.tension": "tension_body", f"{line}.reaction": "reaction_heave"}
    connections = [
        f"{line}.{sources[source]} -> {target}" if source in sources else c
        for c in trial.scene.connections for source, target in [ends(c)]
        if not target.startswith(f"{line}.")
    ]  # fmt: skip
    connections += [f"{ship}.velocity -> {line}.top_velocity_heave", f"{body}.velocity -> {line}.body_velocity_heave"]
    made = trial.rebuilt(units, connections, {f"{line}.tension": f"{line}.tension_top"})
    return made.showing(tuple(f"{line}.{margin}" for margin in NOT_OF_A_WIRE))


def _segments(trial: Trial, ship: str, travel: float) -> float:
    """How many for waves that take ``travel``, s, along the wire, at the mean frequency of the ship's heave."""
    heave, rate = trial.seen.spread(f"{ship}.heave")
    return max(SEGMENTS, math.ceil(A_RADIAN * rate / heave * travel)) if heave else SEGMENTS


def _hanging(trial: Trial) -> tuple[str, str]:
    """(line, body) of a scene with one spring_line that stays taut and whose waves have a speed."""
    lines = trial.units("spring_line")
    if len(lines) != 1:
        raise Unfit("a wire takes the place of one spring_line between a ship and a cradle, and there is no such")
    line = lines[0].name
    if not trial.value(line, "wave_speed") or not trial.value(line, "length"):
        raise Unfit(f"the mass of the wire is not known: give {line} its length and wave_speed")
    if not trial.seen.settled(f"{line}.tension").min() > 0.0:
        raise Unfit(f"{line} goes slack, and no unit of a wire with mass does")
    body = _feeds(trial, f"{line}.heave_bottom")
    if body not in {unit.name for unit in trial.units("cradle")}:
        raise Unfit(f"what hangs on {line} is no cradle")
    if trial.value(body, "docking_time") >= 0.0:
        raise Unfit(f"what hangs on {line} changes its weight by docking, and the wire is made for one weight")
    return line, body


def _feeds(trial: Trial, target: str) -> str:
    """The unit that feeds an input. Raises `Unfit`."""
    for connection in trial.scene.connections:
        if ends(connection)[1] == target:
            return ends(connection)[0].partition(".")[0]
    raise Unfit(f"nothing is connected to {target}")


DRAG = Axis(
    "drag", "How does the water resist?", _no_body,
    (Level("linear drag", "how drag grows with the square of the speed", linear_drag), Level("quadratic drag")),
)  # fmt: skip
LINE = Axis(
    "line", "What does the line know?", _no_line,
    (
        Level("always taut", "slack; mass and waves of the line", taut),
        Level("with slack", "mass and waves of the line"),
        Level("elastic wire", "", wire),
    ),
)  # fmt: skip
