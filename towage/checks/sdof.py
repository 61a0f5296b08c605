"""The single-degree-of-freedom (SDOF) assumption: the ship drives the body, and the body does not drive the ship.

A scene that names the connections back to the ship (``checks.sdof.cut``) is run a second time without them, and the two
runs are compared:

| word | meaning |
|---|---|
| valid | amplitude, peak tension, rms of motion and tension within the tolerance e, and the estimate eps/(1 - eps) too |
| marginal | measured differences within e, but the estimate is not: a slightly different sea may break it |
| invalid | a measured difference exceeds e |
| not judged | chaos whose statistics are too uncertain, or less than a period after settling |

A motion that does not repeat after 1 to 8 periods of its driver gets a twin, started 1e-9 apart. Where the twin drifts away
the motion is chaotic, and the statistics alone decide (`statistics`); in an irregular sea they decide too.

eps: what the one-way reaction would move the ship, over the ship's motion; the larger of abs(D2/D1) at the dominant frequency
and of the ship's response to all harmonics. eps/(1 - eps) bounds the amplitude error of the describing function; of a motion
with harmonics, transients or slack it is an estimate. The numbers are in `comparison`.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from msgspec.structs import replace

from towage.checks.check import Cell, Check, Finished, Part, Start, System, window
from towage.checks.sdof_section import Sdof, SdofCheck, sdof_of
from towage.checks.verdict import NUMERICS
from towage.errors import RunError, suggest
from towage.result.records import Comparison, Finding, Item
from towage.scene.parts import Variant
from towage.scene.scene import Scene
from towage.scene.tables import Tables

if TYPE_CHECKING:
    from towage.checks.signals import Array
    from towage.result.result import Result
    from towage.scene.resolve import ResolvedScene
    from towage.scene.values import Names

RUN = "one-way run"
TWIN = "one-way twin"
NAME = "SDOF"
"""The item on the single degree of freedom."""
BOTH = 2.0
"""Coupling errors in a difference: the one-way run has the steps of the coupled one, and an error of its size, not measured."""


def read(scene: Scene, section: SdofCheck) -> SdofCheck:
    """The section with its connections in their one spelling. Raises `SceneError`."""
    window(scene, "sdof", section.tolerance, section.settle)
    tables = Tables(scene.file)
    cut = tuple(tables.connection(text, f"checks.sdof.cut[{k}]") for k, text in enumerate(section.cut))
    return replace(section, cut=cut)


def fit(names: Names, section: SdofCheck) -> None:
    """Refuses connections and variables that do not exist. Raises `SceneError`."""
    connections = names.scene.connections
    for index, cut in enumerate(section.cut):
        if cut not in connections:
            hint = suggest(cut, connections)
            raise names.fault(f"there is no connection {cut!r}{hint}", f"checks.sdof.cut[{index}]")
    for field in ("driver", "motion", "tension"):
        unit, variable = names.find(getattr(section, field), f"checks.sdof.{field}")
        if variable.type != "Real":
            raise names.fault(f"{unit}.{variable.name} is {variable.type}, expected Real", f"checks.sdof.{field}")


def variants(scene: Scene) -> list[Variant]:
    """The one-way run: the scene without the connections back to the ship; and its twin, made only where the motion does
    not repeat."""
    section = scene.checks.get("sdof")
    single = scene.without(section.cut)
    return [Variant(RUN, single), Variant(TWIN, single, nudged=section.motion.split(".")[0])]


def reads(scene: ResolvedScene) -> tuple[str, ...]:
    """What is compared, and the reaction, which is connected to nothing in the one-way run."""
    section = sdof_of(scene)
    return section.driver, section.motion, section.tension, section.reaction


def before(start: Start) -> list[Finding]:
    """The worst error over frequency, where the units tell enough."""
    from towage.checks.promise import promise

    return promise(start.system, sdof_of(start.scene))


def after(run: Finished) -> list[Finding]:
    """Sets the result's ``one_way``, ``comparison`` and ``response``; a warning where the one-way run fails."""
    from towage.checks.comparison import compare, drifts, response, runs
    from towage.checks.promise import promise

    section, result = sdof_of(run.scene), run.result
    try:
        time, one_way = run.again(RUN)
    except RunError as error:
        return [Finding(RUN, "warning", None, None, f"failed: {error}")]
    if len(time) < len(result.time):
        return [Finding(RUN, "warning", None, None, "ended early")]
    result.one_way = {name: one_way[name] for name in result.columns if name in one_way}
    if short := too_short(section, run.times, run.system):
        return [short]
    compared = runs(section, run.times, run.track, run.track_of(RUN))
    findings, chaotic = [], False
    if not compared.periods:
        try:
            chaotic = drifts(section, compared, run.track_of(TWIN))
        except RunError as error:
            findings = [Finding(TWIN, "warning", None, None, f"failed, so that chaos is not found: {error}")]
    result.comparison = compare(section, compared, run.times, run.system, chaotic)
    result.response = response(run.system, section, compared.omega, compared.single, compared.time)
    return [*promise(run.system, section), *findings]


def too_short(section: Sdof, times: Array, system: System) -> Finding | None:
    """Where less than a period of the driver lies after settling, or too few points for one: two runs look alike then whatever
    they do. ``times``, s: those of the whole run."""
    from towage.checks.signals import FEWEST
    from towage.checks.statistics import wave

    settled, step = int((times >= section.settle).sum()), float(times[1] - times[0]) if len(times) > 1 else 0.0
    period = wave(system, section.driver)[1] or 0.0
    needed = max(FEWEST, math.ceil(period / step) if step else 0)
    if settled >= needed:
        return None
    what = f"a comparison takes {needed}" + (", a period of the driver" if needed > FEWEST else "")
    message = f"only {settled} points of the run lie after settling, and {what}"
    remedy = f"a longer run: stop_time >= {section.settle + max(needed * step, period):.4g} s"
    return Finding(NAME, "warning", float(settled), float(needed), message, remedy)


def item(result: Result) -> Item | None:
    """The word of the comparison with the number that decided; chaos is left to the statistics."""
    if short := next((f for f in result.checks if f.name == NAME), None):
        return Item("not judged", short.message, short.value, short.limit, None, short.remedy, NAME)
    failed = next((f for f in result.checks if f.name == RUN), None)
    if not (c := result.comparison):
        return Item("not judged", f"the one-way run {failed.message}", None, None, name=NAME) if failed else None
    names = {
        "peak tension": abs(c.peak_tension), "amplitude": abs(c.amplitude), "rms difference": c.rms,
        "rms difference of the tension": c.tension_rms,
    }  # fmt: skip
    name = max(names, key=names.__getitem__)
    worst, reason = names[name], f"SDOF: {name} of the one-way run against the coupled run"
    if c.chaotic:
        reason, decides = "SDOF: chaotic, the statistics decide", not c.statistics
        return Item("not judged", reason, None, c.tolerance, name=NAME, decides=decides)
    if worst > c.tolerance:
        return Item("invalid", reason, worst, c.tolerance, None, "model both ways", NAME)
    if c.word == "marginal":
        return Item("marginal", "SDOF: the bound eps/(1 - eps) exceeds the tolerance", c.bound, c.tolerance, name=NAME)
    share = max((f.value for f in result.checks if f.name == NUMERICS and f.value is not None), default=0.0)
    numerical = BOTH * share
    if worst + numerical > c.tolerance:
        remedy = "a shorter step or a tighter tolerance of the coupling"
        said = f"{reason}, with the coupling errors of both"
        return Item("marginal", said, worst + numerical, c.tolerance, None, remedy, NAME)
    return Item("valid", reason, worst, c.tolerance, name=NAME)


def report(result: Result) -> list[Part]:
    """The coupled run against the one-way run, and the thesis's own indicators with what they are worth."""
    if not (c := result.comparison):
        return []
    head = ("Quantity", "Value", "Meaning")
    thesis = (
        ("Eigenvector test", Cell(c.eigenvector, "%"), "an identity, it can never fail"),
        ("Frequency shift", Cell(c.frequency_shift, "%"), "passes wrongly in known cases"),
    )
    note = "The thesis’s own two indicators, for reference; neither has a part in the verdict."
    return [
        Part("Coupled against one-way (single degree of freedom)", head, _measures(c), c.word, c.tolerance),
        Part("", head, thesis, note=note),
    ]


def _measures(c: Comparison) -> tuple[tuple[str | Cell, ...], ...]:
    """The rows of the comparison."""

    def against(value: float) -> str:
        return "above the tolerance" if abs(value) > c.tolerance else "within the tolerance"

    def known(value: float | None, meaning: str) -> str:
        return "not available for this scene" if value is None else meaning

    bound = "of the amplitude error: a bound for a harmonic motion, else an estimate; from the one-way run alone"
    indicator = "what the reaction, all its harmonics, would move the driver, over its motion; from the one-way run alone"
    return (
        ("Amplitude", Cell(c.amplitude, "%", True), against(c.amplitude)),
        ("Phase", Cell(math.degrees(c.phase), "°", True), "coupled against one-way motion"),
        ("Peak tension", Cell(c.peak_tension, "%", True), against(c.peak_tension)),
        ("rms of the difference", Cell(c.rms, "%"), "over the rms of the one-way motion"),
        ("rms of the tension’s", Cell(c.tension_rms, "%"), "over the rms of the one-way tension"),
        ("Indicator ε", Cell(c.indicator), known(c.indicator, indicator)),
        ("Bound ε/(1 − ε)", Cell(c.bound, "%"), known(c.bound, bound)),
        ("Closed form ε*", Cell(c.estimate), known(c.estimate, "estimate of ε without any run")),
    )


CHECK = Check(
    name="sdof",
    description="Does the ship drive the body and not the body the ship?",
    section=SdofCheck,
    read=read,
    fit=fit,
    variants=variants,
    reads=reads,
    before=before,
    after=after,
    item=item,
    report=report,
)
