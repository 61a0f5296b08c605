"""A load on a massless spring under a ship: what is left of a tow, or of a wire, in heave alone."""

from __future__ import annotations

from collections.abc import Mapping

from towage.ladder.axis import Trial, Unfit, entry
from towage.units.description import Value


def on_spring(
    trial: Trial, name: str, heaves: str, line: Mapping[str, Value], load: Mapping[str, Value], called: Mapping[str, str],
    weight: float = 0.0,
) -> Trial:  # fmt: skip
    """The unit ``name`` as a `spring_line` of that name with a `cradle`, of the parameters ``line`` and ``load``; ``heaves``:
    its input that takes the velocity of a ship. ``called``: what other outputs, "unit.variable", are of the cradle. ``weight``,
    N: of the wire, which the tension at its top bears and a spring does not. Other units than the ship go. Raises `Unfit`."""
    source = trial.source(heaves)
    ship, _, velocity = source.partition(".")
    if velocity != "velocity" or "heave" not in trial.resolved.units[ship].description.by_name():
        raise Unfit(f"no ship heaves {name}, and on the spring there is no other motion")
    body = f"{name}_body"
    units = {n: u for n, u in trial.scene.units.items() if n == ship}
    units |= {name: entry("spring_line", line), body: entry("cradle", load)}
    connections = [
        f"{ship}.heave -> {name}.heave_top", f"{body}.heave -> {name}.heave_bottom", f"{name}.tension -> {body}.line_tension",
    ]  # fmt: skip
    if any((source, target) == (f"{name}.reaction_heave", f"{ship}.reaction") for _, source, target in trial.wiring):
        connections.append(f"{name}.reaction -> {ship}.reaction")
    tensions = {f"{name}.tension_{end}": f"{name}.tension" for end in ("top", "body")}
    names = {there: f"{body}.{here}" for there, here in called.items()} | tensions
    names[f"{name}.reaction_heave"] = f"{name}.reaction"
    return trial.rebuilt(units, connections, names, {f"{name}.tension_top": weight})
