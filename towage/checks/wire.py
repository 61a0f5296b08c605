"""What a line without mass costs: the load and the tension of the run against an elastic bar of the wire's mass.

The line's upper end moves as it did in the run. Below it the load is followed twice, on the massless spring and on the bar
(`towage.models.heave.elastic_bar`), both by one method and with slack, drag and weight, so that their difference is the
wire's. The error is the largest of: swing of the motion, its rms, peak of the tension above its static value and its rms,
at both ends of the wire, each of the spring against the bar as in `comparison`; in chaos of the standard deviations alone.
The wave of the hardest snap is added to both. `ROOM` and `GROWS` cover what is left out: that the ship answers the other
tension, and frequencies beside the one at which the bar is exact. For a taut line that is a bound. Where a line goes slack,
the waves of earlier snaps are still in the wire, as far as its damping (`wire_damping`) has left them: all of them in step
with the next make the bound (``tests/models/test_elastic_bar.py``: both against a chain of masses, damped or not). Where that
alone is beyond the tolerance, the word is marginal.

A line of unknown mass is not judged. It is looked at as a wire rope of steel, which is the lightest common rope for its
stiffness: where even that errs beyond the tolerance, the run is not judged.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from towage.checks.check import Check, Component, Finished
from towage.checks.wire_cost import Line, cost_of
from towage.result.records import Finding, Item, Margin

if TYPE_CHECKING:
    from towage.result.result import Result

NAME = "wire"
MARGIN = "margin_wire"
UNKNOWN = "wire, not judged"
"""Findings on lines whose mass, whose load or whose chaos leaves nothing to compare: "warning" if the run is not judged then."""
DEFAULT_TOLERANCE = 0.05
"""Where no check sets one."""
STEEL = 3300.0
"""Speed of waves, m/s, in wire rope of steel: E of the rope near 85 GPa on 7850 kg/m3. Polyester and nylon have 600 to 1500:
their mass is larger for the same stiffness and length."""
AGREES = 0.1
"""rms over standard deviation up to which the load of the run moves as its mass, drag and line say."""


def lines(run: Finished) -> list[Line | Finding]:
    """The lines of the scene, or why one cannot be judged."""
    units = {unit.name: unit for unit in run.system.units}
    sources = {
        (c.target_unit, c.target): (c.source_unit, f"{c.source_unit}.{c.source}") for c in run.scene.connections
    }
    found: list[Line | Finding] = []
    for name, unit in units.items():
        mass, stiffness = unit.constant("wire_mass"), unit.constant("port_stiffness")
        if mass is None or stiffness is None or (name, "heave_top") not in sources:
            continue
        if any(c.changed and name in (c.source_unit, c.target_unit) for c in run.scene.connections):
            text = f"a connection of {name} is transformed by the scene"
            found.append(Finding(UNKNOWN, "info", None, None, f"the mass of the wire is not judged: {text}"))
            continue
        body, heave = sources.get((name, "heave_bottom"), (name, f"{name}.heave"))
        load = masses(units[body], run.scene.scene.stop_time)
        if not load:
            text = f"{body}, which hangs on {name}, tells no mass (port_mass or virtual_mass)"
            found.append(Finding(UNKNOWN, "info", None, None, f"the mass of the wire is not judged: {text}"))
            continue
        static = unit.constant("static_tension")
        weight = unit.constant("weight_in_water") if static is None else static
        start = units[body].constant("heave_start") or 0.0, units[body].constant("velocity_start") or 0.0
        drag = units[body].constant("drag_factor") or 0.0
        top = sources[name, "heave_top"][1]
        length = unit.constant("length") or 0.0
        damping = unit.constant("wire_damping") or 0.0
        found.append(Line(name, top, heave, load, drag, stiffness, mass, length, weight or 0.0, start, damping))
    return found


def masses(body: Component, stop: float) -> tuple[float, ...]:
    """Virtual masses, kg, that a body has during a run of ``stop``, s: before and after docking; none if it tells none."""
    mass = body.constant("virtual_mass") or body.constant("port_mass")
    if not mass:
        return ()
    docking, more = body.constant("docking_time"), body.constant("submersible_mass")
    return (mass, mass + more) if docking is not None and more and 0.0 <= docking < stop else (mass,)


def after(run: Finished) -> list[Finding]:
    """Adds ``LINE.margin_wire`` = 1 - error/tolerance to the result's margins for every line of known mass."""
    section = run.scene.scene.checks.get("sdof")
    tolerance = section.tolerance if section else DEFAULT_TOLERANCE
    settle = section.settle if section else 0.0
    findings = []
    for line in lines(run):
        findings.append(line if isinstance(line, Finding) else judged(run, line, settle, tolerance))
    return findings


def judged(run: Finished, line: Line, settle: float, tolerance: float) -> Finding:
    """What is said of one line."""
    import numpy as np

    from towage.checks.signals import dominant_frequency, repeats_after

    known = line.wire > 0.0
    wire = line.wire if known else line.stiffness * (line.length / STEEL) ** 2
    chaotic = bool(run.result.comparison and run.result.comparison.chaotic)
    times = run.times
    motion = run.track.at(line.top, times)
    late = times >= settle
    omega = dominant_frequency(times[late], motion[late])
    statistical = chaotic or not repeats_after(times[late], motion[late], omega, tolerance)
    costs = []
    for mass in line.masses:
        cost, heave = cost_of(line, mass, wire, times, motion, settle, statistical)
        costs.append(cost)
        if not chaotic and len(line.masses) == 1 and line.heave in run.track.columns:
            own = run.track.at(line.heave, times)
            if float(np.sqrt(np.mean((heave - own) ** 2))) > AGREES * float(own.std()) + 1e-9 * float(np.ptp(motion)):
                text = "the load does not move as its mass, drag and line say: other forces act on it"
                return Finding(UNKNOWN, "info", None, tolerance, f"the mass of the wire of {line.name} is not judged: {text}")
    cost = max(costs, key=lambda cost: cost.bound)
    beyond, rings = cost.error > tolerance, cost.bound > tolerance
    load = min(line.masses)
    facts = (
        f"a spring without mass errs by {100 * cost.motion:.2g} % in motion and {100 * cost.tension:.2g} % in tension, limit "
        f"{100 * tolerance:.3g} % (omega L/c = {cost.angle:.2g}, wire of {wire:.3g} kg, load of {load:.3g} kg)"
    )
    if cost.snaps:
        facts += f", and with the waves of earlier snaps, at a wire_damping of {line.damping:.3g}, up to {100 * cost.bound:.2g} %"
    if not known:
        text = (
            f"the mass of {line.name} is not given; as a wire rope of steel of {line.length:.4g} m (others are heavier for their "
            f"stiffness), {facts}"
        )
        remedy = f"give {line.name}.mass_per_length (and length)"
        return Finding(UNKNOWN, "warning" if rings else "info", cost.bound, tolerance, text, remedy)
    if chaotic and beyond:
        text = f"the motion is chaotic, and in this run of {line.name} {facts}: its statistics are not known well enough"
        return Finding(UNKNOWN, "warning", cost.error, tolerance, text, "run longer")
    remedy = f"take the wire unit: omega L/c = {cost.angle:.2g}" if rings else ""
    variable = f"{line.name}.{MARGIN}"
    decides = variable not in run.scene.scene.checks.report_only
    word: Any = ""
    reason = ""
    if rings and not beyond:
        remedy, word = f"give {line.name}.wire_damping, if it is larger, or {remedy}", "marginal"
        reason = f"{line.name} goes slack, and the waves of its snaps have not died out before the next: {facts}"
    run.result.margins.append(
        Margin(variable, 1.0 - cost.bound / tolerance, cost.time, decides, word, reason, cost.bound, tolerance, remedy)
    )
    return Finding(NAME, "warning" if rings else "ok", cost.bound, tolerance, f"{line.name}: {facts}", remedy)


def item(result: Result) -> Item | None:
    """What is said of a line of unknown mass, or of an unknown load; a known one has its margin among the premises."""
    told = [f for f in result.checks if f.name == UNKNOWN]
    worst = next((f for f in told if f.level == "warning"), told[0] if told else None)
    if worst is None:
        return None
    return Item(
        "not judged", worst.message, worst.value, worst.limit, remedy=worst.remedy, decides=worst.level == "warning"
    )


CHECK = Check(
    name=NAME,
    description="Does the mass of the wire matter?",
    after=after,
    margins=(MARGIN,),
    item=item,
)
