"""Which variables FMI 3 describes as one array: those that stand one after the other as ``name[1]``, ``name[2]``, ..."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

from .unit import Variable

_ELEMENT = re.compile(r"(.+)\[([0-9]+)\](\)?)")
"""``state[3]`` or ``der(state[3])``."""


def array_name(element: str) -> str:
    """The name of the array that ``element`` belongs to: ``der(state)`` for ``der(state[3])``."""
    return _ELEMENT.sub(r"\1\3", element)


def lengths(variables: Iterable[Variable]) -> list[int]:
    """How many elements the FMI 3 reference of each variable delivers: 1 of a scalar, n of an array at its first element,
    0 at its others."""
    counts: list[int] = []
    first, array = 0, ""
    for i, v in enumerate(variables):
        element = _ELEMENT.fullmatch(v.name)
        if element and int(element[2]) == i - first + 1 and array_name(v.name) == array:
            counts[first] += 1
            counts.append(0)
        else:
            first, array = i, array_name(v.name) if element and int(element[2]) == 1 else ""
            counts.append(1)
    return counts


def array_of(counts: Sequence[int], reference: int) -> int:
    """The reference of the array that a variable belongs to, its own if it is a scalar. ``counts`` as of `lengths`."""
    while counts[reference] == 0:
        reference -= 1
    return reference
