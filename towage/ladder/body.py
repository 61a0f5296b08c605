"""The axis of a slender body: rigid, or flexible with fewer shape functions or with those of the scene."""

from __future__ import annotations

from collections.abc import Callable

from towage.ladder.axis import Axis, Level, Trial, Unfit


def _no_body(trial: Trial) -> str:
    return "" if trial.units("slender_body") else "no slender_body in it"


def rigid(trial: Trial) -> Trial:
    """Every slender body rigid."""
    return trial.setting({f"{body.name}.flexible": 0.0 for body in trial.units("slender_body")})


def truncated(functions: float) -> Callable[[Trial], Trial]:
    """With so many shape functions. Raises `Unfit` where the scene has no more, or a rigid body."""

    def make(trial: Trial) -> Trial:
        for body in trial.units("slender_body"):
            if trial.value(body.name, "flexible") < 0.5:
                raise Unfit(f"{body.name} is rigid in the scene")
            if trial.value(body.name, "shape_functions") <= functions:
                raise Unfit(f"{body.name} has no more shape functions than that in the scene")
        return trial.setting({f"{body.name}.shape_functions": functions for body in trial.units("slender_body")})

    return make


BODY = Axis(
    "body", "Does the body bend?", _no_body,
    (
        Level("rigid body", "bending", rigid),
        Level("4 shape functions", "all but the first bending modes", truncated(4.0)),
        Level("8 shape functions", "high bending modes", truncated(8.0)),
        Level("all shape functions"),
    ),
)  # fmt: skip
