"""The verdict on a run, put together from what its checks say."""

from __future__ import annotations

from collections.abc import Iterable

from towage.result.records import Item, Verdict

NUMERICS = "numerics"
"""The item on the coupling error."""
INPUTS = "inputs"
"""The item on inputs that may have been forgotten."""
GRAVITY = ("invalid", "not judged", "marginal", "valid")
"""Words of the checks, the gravest first."""


def verdict(items: Iterable[Item | None]) -> Verdict:
    """The gravest of what the checks say, the first of equals; "not judged" if none judges the models, for good numerics and
    inputs alone make no run valid, and where the coupling error is known to exceed the tolerance: nothing else counts then."""
    guards = NUMERICS, INPUTS
    said = tuple(item for item in items if item)
    deciding = [item for item in said if item.decides]
    if not any(item.name not in guards for item in deciding):
        deciding.append(Item("not judged", "no check and no margin decides", None, None))
    wrong = [item for item in deciding if item.name == NUMERICS and item.word == "not judged" and item.number is not None]
    g = min(wrong or deciding, key=lambda item: (GRAVITY.index(item.word), item.word == "valid" and item.name in guards))
    return Verdict(g.word, g.reason, g.number, g.limit, g.time, g.remedy, said)
