"""What a check is: a value that the scene, the run, the verdict and the report ask. None of them knows one by name.

    CHECK = Check(name="sinkage", description="...", section=Sinkage, after=after)

`towage.registry.CHECKS` finds checks by name. A check without a section takes part in every run; one with a section, and
every check of another package, in the runs of scenes that have its table ``[checks.<name>]``. A check is imported when a
scene is read, so its module imports numpy and the models inside the functions that compute.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

from towage.registry import CHECKS
from towage.result.records import Finding, Item
from towage.scene.parts import Variant

if TYPE_CHECKING:
    import numpy as np
    from msgspec import Struct
    from numpy.typing import NDArray

    from towage.checks.track import Track
    from towage.result.result import Result
    from towage.scene.resolve import ResolvedScene
    from towage.scene.scene import Scene
    from towage.scene.values import Names
    from towage.units.description import Description

    Array = NDArray[np.float64]


# ---- what a check contributes ----------------------------------------------------------------------------------------


class Cell(NamedTuple):
    """A number in a table of the report: SI in ``unit``, or relative where ``unit`` is "%"; None where it is not known.
    ``signed``: a plus sign is shown too."""

    value: float | None
    unit: str = ""
    signed: bool = False


class Part(NamedTuple):
    """A table of a check in the report of a run: ``word`` (valid, ok, ...) and ``limit`` (relative tolerance) stand above
    it where they are given, and a ``note`` in words."""

    title: str
    head: tuple[str, ...]
    rows: tuple[tuple[str | Cell, ...], ...]
    word: str = ""
    limit: float | None = None
    note: str = ""


# ---- what a check is given -------------------------------------------------------------------------------------------


class Scheme(Protocol):
    """A coupling scheme, as checks see it (`towage.master.schemes.Scheme`)."""

    @property
    def name(self) -> str: ...
    @property
    def order(self) -> int: ...
    @property
    def holds(self) -> bool: ...
    def limit(self, masses: int) -> float: ...


class Component(Protocol):
    """A running unit, as checks see it (`towage.units.fmu.Unit`)."""

    name: str
    can_roll_back: bool
    description: Description

    def constant(self, name: str) -> float | None: ...


class Link(Protocol):
    """A connection at work: positions of source and target among the units (`towage.master.signals.Signal`)."""

    source: int
    target: int


class System(Protocol):
    """The initialised units of a scene and their connections (`towage.master.system.System`)."""

    @property
    def units(self) -> Sequence[Component]: ...
    @property
    def signals(self) -> Sequence[Link]: ...
    @property
    def into(self) -> Sequence[Sequence[Link]]: ...
    @property
    def out(self) -> Sequence[Sequence[Link]]: ...


class Start(NamedTuple):
    """A scene about to run: its units are initialised, ``scheme`` is chosen, ``step`` is the longest communication step,
    s."""

    scene: ResolvedScene
    system: System
    scheme: Scheme
    step: float


@dataclass
class Finished:
    """A run that came to its end, before its verdict.

    ``columns``: every observed output of every unit, shape (n,) on ``result.time`` (s), also those that ``result`` does
    not keep. ``again(name)``: (time, columns) of another run, which the check announced by `Check.variants`; each is made
    once, whoever asks. It raises `RunError` where that run fails. ``order``: order of the error in the step, 0 where an
    error control chooses the step. A check may set what ``result`` has room for.

    Comparisons are made on the solver's own points, at ``times`` (s, equally spaced): ``track`` has those of this run,
    ``track_of(name)`` those of another, and raises as ``again`` does. ``step``: the communication step, s, None under error
    control.
    """

    scene: ResolvedScene
    system: System
    order: int
    result: Result
    columns: Mapping[str, Array]
    again: Callable[[str], tuple[Array, dict[str, Array]]]
    step: float | None
    times: Array
    track: Track
    track_of: Callable[[str], Track]


# ---- the check -------------------------------------------------------------------------------------------------------


def _none(*given: Any) -> Any:
    """What a check does that has nothing to do at this point."""
    return ()


def _section(scene: Scene, section: Any) -> Any:
    return section


@dataclass(frozen=True, kw_only=True)
class Check:
    """A check by what it does at each point of a scene's way; everything but name and description may be left out.

    Raises `TypeError` for an argument that does not exist.
    """

    name: str
    description: str
    """What it asks, in one sentence."""

    section: type[Struct] | None = None
    """The table ``[checks.<name>]``. A field of type `towage.scene.parts.Seconds` may be written "80 s"."""

    read: Callable[[Scene, Any], Any] = _section
    """(scene, section) -> section: refuses values that cannot be right by `Scene.error`."""

    fit: Callable[[Names, Any], Any] = _none
    """(names, section): refuses, by `Names.find` and `Names.recorded`, what does not exist in the scene's units."""

    variants: Callable[[Scene], Sequence[Variant]] = _none
    """The other runs that ``after`` asks for."""

    reads: Callable[[ResolvedScene], Sequence[str]] = _none
    """The outputs, "unit.variable", that ``after`` compares: they are read in all runs, whether recorded or not."""

    before: Callable[[Start], Sequence[Finding]] = _none
    """What can be said before the run (`towage check`)."""

    refuses: bool = False
    """``before`` is cheap and may refuse a run: it is asked before every run and its findings stay with the result."""

    after: Callable[[Finished], Sequence[Finding]] = _none
    """What the run shows."""

    margins: tuple[str, ...] = ()
    """Margins that ``after`` adds to those of a unit, "margin_...", so that ``report_only`` may name them."""

    item: Callable[[Result], Item | None] = lambda result: None
    """What the check says to the verdict. Its name is that of the check where it gives none."""

    report: Callable[[Result], Sequence[Part]] = _none
    """The check's part of the report."""

    summary: Callable[[Result], Sequence[tuple[str, str]]] = _none
    """The check's lines, (label, text), of the few that a run ends with on a terminal."""


def every_check() -> list[Check]:
    """All checks, those of other packages last, for the report of a result that may come from a file."""
    return [CHECKS.get(name) for name in CHECKS.names()]


def checks_of(scene: Scene) -> list[Check]:
    """The checks that take part in the runs of a scene."""
    chosen: list[Check] = scene.active_checks()
    return chosen


def told(result: Result, name: str) -> list[tuple[str, str]]:
    """Findings called ``name`` as lines of the summary."""
    return [(finding.name, finding.message) for finding in result.checks if finding.name == name]


def window(scene: Scene, name: str, tolerance: float, settle: float) -> None:
    """Refuses a tolerance that is not above 0, or a settling time (s) that does not lie inside the run."""
    if not 0.0 < tolerance < math.inf:
        raise scene.error(f"{tolerance} is out of range: expected a finite number above 0", f"checks.{name}.tolerance")
    if not 0.0 <= settle < scene.stop_time:
        raise scene.error(
            f"{settle} s is out of range: expected 0 s to {scene.stop_time} s", f"checks.{name}.settle"
        )
