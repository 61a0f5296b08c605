"""What a unit of another make is found not to do, although its description says that it does, and what is done instead.

`towage vet` finds such things before a run (`towage.units.vetted`), the master in the run. ``scheme = "auto"`` does without them,
for that unit alone.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Literal, get_args

from msgspec.structs import replace

from towage.errors import RunError
from towage.units.description import Description

What = Literal["state", "rates", "slopes", "feedthrough"]
THEREFORE: dict[What, str] = {
    "state": "it is never taken back: it makes every step once, with extrapolated inputs",
    "rates": "differences take the place of its rates",
    "slopes": "its inputs are held at their mean over a step",
    "feedthrough": "each of its outputs counts as depending on each of its inputs",
}
"""What the master does, by what cannot be relied on."""
Doubts = dict[tuple[str, What], str]
"""Why, by unit and what."""


class Doubt(RunError):
    """Raised in a run where ``unit`` is found not to do ``what``, ``why`` in words."""

    def __init__(
        self, message: str, what: What, why: str, unit: str, variable: str = "", time: float | None = None
    ) -> None:
        super().__init__(message, unit=unit, variable=variable, time=time)
        self.what, self.why = what, why


def said(unit: str, why: str, what: What) -> str:
    """A doubt in words."""
    return f"unit {unit}: {why}, therefore {THEREFORE[what]}"


def without(description: Description, doubts: Iterable[What]) -> Description:
    """The description without what cannot be relied on."""
    doubts = sorted(set(doubts) & set(get_args(What)))
    if "feedthrough" in doubts:
        description = replace(description, dependencies=dict.fromkeys(description.dependencies))
    if "rates" in doubts:
        description = replace(description, max_output_derivative_order=0)
    if "slopes" in doubts:
        description = replace(description, can_interpolate_inputs=False)
    return replace(description, distrusted=tuple(dict.fromkeys((*description.distrusted, *doubts)))) if doubts else description
