"""The single-degree-of-freedom (SDOF) assumption: the ship drives the body, and the body does not drive the ship.

A scene that names the connections back to the ship (``checks.sdof.cut``) is run a second time without them, and the two
runs are compared:

| word | meaning |
|---|---|
| valid | amplitude, peak tension and rms difference within the tolerance e, and the bound eps/(1 - eps) too |
| marginal | measured differences within e, but the bound is not: a slightly different sea may break it |
| invalid | a measured difference exceeds e |

The rms difference is left out where the one-way motion does not repeat after a period.

eps = |D2/D1|: amplitude of the line's reaction in the one-way run over that of the ship's dynamic stiffness times its
motion; eps/(1 - eps) bounds the amplitude error of a steady motion rigorously. The numbers are in `comparison`.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from msgspec.structs import replace

from towage.checks.check import Cell, Check, Finished, Item, Part, Start, System, window
from towage.checks.sdof_section import SdofCheck
from towage.errors import RunError, suggest
from towage.result.records import Comparison, Finding, Word
from towage.scene.parts import Variant
from towage.scene.scene import Scene
from towage.scene.tables import Tables

if TYPE_CHECKING:
    from towage.result.result import Result
    from towage.scene.values import Names

RUN = "one-way run"
RULE = 0.9
"""eps* <= 0.9 e promises an error below e (spec of the 1969 thesis, section 4)."""


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
    """The one-way run: the scene without the connections back to the ship."""
    return [Variant(RUN, scene.without(scene.checks.get("sdof").cut))]


def before(start: Start) -> list[Finding]:
    """The closed-form estimate eps*, where the units tell enough."""
    return _estimate(start.system, start.scene.scene.checks.get("sdof"))


def _estimate(system: System, section: SdofCheck) -> list[Finding]:
    from towage.checks.comparison import theory

    estimate, limit = theory(system, section).estimate, RULE * section.tolerance
    if estimate is None:
        return []
    small = estimate <= limit
    text = "the line moves the ship little at any frequency" if small else "the line may move the ship: measure it"
    message = f"closed form over all frequencies: eps* = {estimate:.3g}, limit {limit:.3g}; {text}"
    return [Finding("SDOF eps*", "ok" if small else "warning", estimate, limit, message)]


def after(run: Finished) -> list[Finding]:
    """Sets the result's ``one_way``, ``comparison`` and ``response``; a warning where the one-way run fails."""
    from towage.checks.comparison import compare, response
    from towage.checks.signals import dominant_frequency

    section, result = run.scene.scene.checks.get("sdof"), run.result
    try:
        time, one_way = run.again(RUN)
    except RunError as error:
        return [Finding(RUN, "warning", None, None, f"failed: {error}")]
    if len(time) < len(result.time):
        return [Finding(RUN, "warning", None, None, "ended early")]
    result.one_way = {name: one_way[name] for name in result.columns if name in one_way}
    settled = time >= section.settle
    omega = dominant_frequency(time[settled], one_way[section.driver][settled])
    result.comparison = compare(section, time, run.columns, one_way, run.system)
    result.response = response(run.system, section, omega, one_way, time)
    return _estimate(run.system, section)


def item(result: Result) -> Item | None:
    """The word of the comparison with the number that decided."""
    if not (c := result.comparison):
        return None
    if c.word == "marginal":
        return Item("marginal", "SDOF: the bound eps/(1 - eps) exceeds the tolerance", c.bound, c.tolerance)
    numbers = {"peak tension": abs(c.peak_tension), "amplitude": abs(c.amplitude)}
    if c.word == "invalid" or c.rms <= c.tolerance:
        numbers["rms difference"] = c.rms
    name = max(numbers, key=numbers.__getitem__)
    word: Word = "valid" if c.word == "valid" else "invalid"
    return Item(word, f"SDOF: {name} of the one-way run against the coupled run", numbers[name], c.tolerance)


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

    bound = "upper bound of the amplitude error, from the one-way run alone"
    indicator = "reaction over dynamic stiffness of the driver, from the one-way run alone"
    return (
        ("Amplitude", Cell(c.amplitude, "%", True), against(c.amplitude)),
        ("Phase", Cell(math.degrees(c.phase), "°", True), "coupled against one-way motion"),
        ("Peak tension", Cell(c.peak_tension, "%", True), against(c.peak_tension)),
        ("rms of the difference", Cell(c.rms, "%"), "over the rms of the one-way motion"),
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
    before=before,
    after=after,
    item=item,
    report=report,
)
