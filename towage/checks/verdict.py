"""The verdict on a run, put together from what its checks say."""

from __future__ import annotations

from collections.abc import Iterable

from towage.checks.check import Item
from towage.result.records import Verdict

GRAVITY = ("invalid", "not judged", "marginal", "valid")
"""Words of the checks, the gravest first."""


def verdict(items: Iterable[Item | None]) -> Verdict:
    """The gravest of what the checks say, the first of equals; "not judged" if none says anything."""
    said = [item for item in items if item]
    if not said:
        return Verdict("not judged", "no check and no margin decides", None, None)
    gravest = min(said, key=lambda item: GRAVITY.index(item.word))
    return Verdict(gravest.word, gravest.reason, gravest.number, gravest.limit)
