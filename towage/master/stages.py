"""The share of long work that is done, where the work has stages of known weight.

    stages = Stages(report, {"coupled run": 1.0, "error estimate": 0.5})
    first = stages.progress("coupled run", stop_time)
    first(0.5 * stop_time)    # reports (1/3, "coupled run")
    stages.done()             # reports (1.0, "done")
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

Report = Callable[[float, str], None]
"""Hears (share of the work done, from 0 to 1; what is going on)."""


class Stages:
    """Reports progress over stages that follow one another in the order of ``weights``.

    A weight is the expected time of a stage in any unit. ``report`` may be None: nothing is reported.
    """

    def __init__(self, report: Report | None, weights: Mapping[str, float]) -> None:
        self._report = report
        total = sum(weights.values())
        self._spans: dict[str, tuple[float, float]] = {}
        begin = 0.0
        for name, weight in weights.items():
            self._spans[name] = begin / total, weight / total
            begin += weight

    def progress(self, stage: str, size: float) -> Callable[[float], None]:
        """A function that hears how much of ``size`` the stage has done. Raises `KeyError` for an unknown stage."""
        begin, span = self._spans[stage]
        report = self._report
        if report is None:
            return lambda done: None
        return lambda done: report(begin + span * done / size, stage)

    def done(self) -> None:
        """All stages are finished."""
        if self._report:
            self._report(1.0, "done")
