"""What a line without mass costs: the load and the tension of the run against an elastic bar of the wire's mass.

The line's upper end moves as it did in the run. Below it the load is followed twice, on the massless spring and on the bar
(`towage.models.heave.elastic_bar`), both by one method and with slack, drag and weight, so that their difference is the
wire's. The error is the largest of: swing of the motion, its rms, peak of the tension above its static value and its rms,
at both ends of the wire, each of the spring against the bar as in `comparison`; in chaos of the standard deviations alone.
The wave of the hardest snap is added to both. `ROOM` and `GROWS` cover what is left out: that the ship answers the other
tension, and frequencies beside the one at which the bar is exact. For a taut line that is a bound; for one that goes slack
it is where the waves of a snap have died down before the next (``tests/models/test_elastic_bar.py``: both against a chain
of masses).

A line of unknown mass is not judged. It is looked at as a wire rope of steel, which is the lightest common rope for its
stiffness: where even that errs beyond the tolerance, the run is not judged.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from towage.checks.check import Check, Component, Finished
from towage.result.records import Finding, Item, Margin

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from towage.models.heave.elastic_bar import Path
    from towage.result.result import Result

    Array = NDArray[np.float64]

NAME = "wire"
MARGIN = "margin_wire"
UNKNOWN = "wire, not judged"
"""Findings on lines whose mass, whose load or whose chaos leaves nothing to compare: "warning" if the run is not judged then."""
DEFAULT_TOLERANCE = 0.05
"""Where no check sets one."""
ROOM = 1.1
"""Bound over the error that is computed, to which `GROWS` times that error is added: harmonics of the drag and the frequencies
beside the one at which the bar is exact count the more, the more the wire does."""
GROWS = 0.5
STEEL = 3300.0
"""Speed of waves, m/s, in wire rope of steel: E of the rope near 85 GPa on 7850 kg/m3. Polyester and nylon have 600 to 1500:
their mass is larger for the same stiffness and length."""
PARTS = 0.1
"""omega h, h the step of the integration, for the load on its line."""
MOST_STEPS = 200_000
ENERGY = 0.98
"""The bar is exact at the frequency below which this share of the energy of the top's acceleration lies."""
LOBE = 3.0
"""Half the width of a single frequency in the spectrum, in lines: two of Hann's window, and its place between lines."""
AGREES = 0.1
"""rms over standard deviation up to which the load of the run moves as its mass, drag and line say."""


@dataclass(frozen=True)
class Cost:
    """Relative errors of the spring against the bar, ``time`` of the largest difference in tension, s, and omega L/c."""

    motion: float
    tension: float
    time: float
    angle: float

    @property
    def error(self) -> float:
        """The bound."""
        error = float(max(self.motion, self.tension))
        return error * (ROOM + GROWS * error)


@dataclass(frozen=True)
class Line:
    """A line of the scene: ``top``, the output that moves its upper end; ``heave``, that of the load, empty if it is not
    known; masses of the load during the run, kg; drag factor, kg/m; K, N/m; m L, kg, or 0; its length, m; W, N; start (m,
    m/s)."""

    name: str
    top: str
    heave: str
    masses: tuple[float, ...]
    drag: float
    stiffness: float
    wire: float
    length: float
    weight: float
    start: tuple[float, float]


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
        found.append(Line(name, top, heave, load, drag, stiffness, mass, length, weight or 0.0, start))
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
    cost = max(costs, key=lambda cost: cost.error)
    beyond = cost.error > tolerance
    load = min(line.masses)
    facts = (
        f"a spring without mass errs by {100 * cost.motion:.2g} % in motion and {100 * cost.tension:.2g} % in tension, limit "
        f"{100 * tolerance:.3g} % (omega L/c = {cost.angle:.2g}, wire of {wire:.3g} kg, load of {load:.3g} kg)"
    )
    if not known:
        text = (
            f"the mass of {line.name} is not given; as a wire rope of steel of {line.length:.4g} m (others are heavier for their "
            f"stiffness), {facts}"
        )
        remedy = f"give {line.name}.mass_per_length (and length)"
        return Finding(UNKNOWN, "warning" if beyond else "info", cost.error, tolerance, text, remedy)
    if chaotic and beyond:
        text = f"the motion is chaotic, and in this run of {line.name} {facts}: its statistics are not known well enough"
        return Finding(UNKNOWN, "warning", cost.error, tolerance, text, "run longer")
    remedy = f"take the wire unit: omega L/c = {cost.angle:.2g}" if beyond else ""
    variable = f"{line.name}.{MARGIN}"
    decides = variable not in run.scene.scene.checks.report_only
    run.result.margins.append(
        Margin(variable, 1.0 - cost.error / tolerance, cost.time, decides, error=cost.error, limit=tolerance, remedy=remedy)
    )
    return Finding(NAME, "warning" if beyond else "ok", cost.error, tolerance, f"{line.name}: {facts}", remedy)


def cost_of(
    line: Line, mass: float, wire: float, times: Array, motion: Array, settle: float, statistical: bool
) -> tuple[Cost, Array]:
    """The errors for a load of ``mass``, kg, and the heave of the load on the massless spring, m, at ``times``, s, equally
    spaced, under the ``motion`` of the top, m."""
    import numpy as np
    from scipy.interpolate import CubicSpline

    from towage.models.heave import elastic_bar

    if len(times) < 4 or not np.ptp(motion) + abs(line.start[0]) + abs(line.start[1]) > 0.0:
        return Cost(0.0, 0.0, 0.0, 0.0), np.full(len(times), line.start[0])
    settled = times >= settle
    omega = frequency(times[settled], motion[settled])
    theta = elastic_bar.angle(omega, line.stiffness, wire)
    between = float(times[1] - times[0])
    fastest = max(omega, math.sqrt(line.stiffness / mass))
    parts = max(1, min(math.ceil(between * fastest / PARTS), MOST_STEPS // len(times)))
    h = between / parts
    spline = CubicSpline(times, motion)
    halves = times[0] + 0.5 * h * np.arange(2 * parts * (len(times) - 1) + 1)
    top, acceleration = spline(halves).tolist(), spline(halves, 2).tolist()
    first = parts * int(np.argmax(settled))

    def path(m: float) -> Path:
        lift = elastic_bar.Lift(line.stiffness, m, mass, line.drag, line.weight, omega)
        return elastic_bar.follow(lift, h, top, acceleration, line.start, first)

    spring = path(0.0)
    heave = np.array(spring.load[::parts])
    if theta >= 0.5 * math.pi:
        return Cost(math.inf, math.inf, float(times[-1]), theta), heave
    bar = path(wire)
    impact = bar.impact * math.sqrt(line.stiffness * wire)
    own = np.array(spring.low)[first:]
    tension = snap = time = 0.0
    for values in (bar.top, bar.low):
        true = np.array(values)[first:]
        snap = share(impact, float(true.max()) - line.weight)
        tension = max(tension, snap + apart(own, true, line.weight, statistical))
        time = float(times[0]) + h * (first + int(np.argmax(np.abs(own - true))))
    motions = snap + apart(np.array(spring.load)[first:], np.array(bar.load)[first:], None, statistical)
    return Cost(motions, tension, time, theta), heave


def apart(spring: Array, bar: Array, mean: float | None, statistical: bool) -> float:
    """The largest of the errors of the spring: of the swing, or of the peak above ``mean`` where it is given, and rms of the
    difference over the standard deviation; ``statistical``, for motions that do not repeat: of the standard deviation and of the
    mean of the largest tenth of the values. Zero for signals at rest."""
    import numpy as np

    from towage.checks.signals import relative_change

    spread = float(bar.std())
    if max(spread, float(spring.std())) <= 1e-12 * max(float(np.abs(bar).max()), float(np.abs(spring).max())):
        return 0.0
    if statistical:
        high = [float(np.sort(values - values.mean())[-max(1, len(values) // 10) :].mean()) for values in (spring, bar)]
        return max(abs(relative_change(float(spring.std()), spread)), abs(relative_change(*high)))
    size = (float(np.ptp(spring)), float(np.ptp(bar))) if mean is None else (spring.max() - mean, bar.max() - mean)
    return max(abs(relative_change(*size)), share(float(np.sqrt(np.mean((spring - bar) ** 2))), spread))


def share(value: float, whole: float) -> float:
    """value / whole; infinite where only ``value`` is not zero."""
    return value / whole if whole > 0.0 else math.inf if value else 0.0


def frequency(times: Array, motion: Array) -> float:
    """Frequency at which the bar is taken, rad/s: that of the motion where it has one alone, else that below which `ENERGY`
    of the energy of its acceleration lies; 0 for too few samples."""
    import numpy as np

    from towage.checks.signals import FEWEST, dominant_frequency

    if len(times) < FEWEST:
        return 0.0
    omega = 2.0 * math.pi * np.fft.rfftfreq(len(times), float(times[1] - times[0]))
    power = np.cumsum((omega**2 * np.abs(np.fft.rfft((motion - motion.mean()) * np.hanning(len(times))))) ** 2)
    if not power[-1] > 0.0:
        return 0.0
    high = float(omega[int(np.searchsorted(power, ENERGY * power[-1]))])
    single = dominant_frequency(times, motion)
    return single if single and high - single <= LOBE * omega[1] else high


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
