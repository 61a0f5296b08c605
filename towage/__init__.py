"""towage couples FMI co-simulation units of marine dynamics and judges every run against the assumptions behind it.

    import towage

    result = towage.run("sea_cliff", "8 s wave")
    result.verdict

The names below load what they need when they are first used: ``import towage`` loads neither numpy nor fmpy.
"""

from __future__ import annotations

import importlib
import os
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from towage.api import run, run_all
    from towage.ensemble.ensemble import Ensemble
    from towage.errors import FmuError, RunError, SceneError, TowageError
    from towage.frequency_response.lift import lift_response
    from towage.frequency_response.response import response
    from towage.ladder.simplest import simplest
    from towage.master.master import Master
    from towage.report.page import write_report
    from towage.result.result import Result
    from towage.routing.route import route
    from towage.scene.scene import Scene
    from towage.sweeps.sweep import Sweep, sweep
    from towage.tow_stability.stability import stability

for _link in ("models", "fmus"):
    if not os.path.isdir(os.path.join(os.path.dirname(__file__), _link)):
        raise ImportError(
            f"towage/{_link} is no link to ../{_link}: this checkout was made without symbolic links. Clone it again with "
            "'git -c core.symlinks=true clone', or install the wheel"
        )

__version__ = "0.1.0"
__all__ = [
    "Ensemble",
    "FmuError",
    "Master",
    "Result",
    "RunError",
    "Scene",
    "SceneError",
    "Sweep",
    "TowageError",
    "__version__",
    "lift_response",
    "response",
    "route",
    "run",
    "run_all",
    "simplest",
    "stability",
    "sweep",
    "write_report",
]

_HOME = {
    "Ensemble": "ensemble.ensemble",
    "FmuError": "errors",
    "Master": "master.master",
    "Result": "result.result",
    "RunError": "errors",
    "Scene": "scene.scene",
    "SceneError": "errors",
    "Sweep": "sweeps.sweep",
    "TowageError": "errors",
    "lift_response": "frequency_response.lift",
    "response": "frequency_response.response",
    "route": "routing.route",
    "run": "api",
    "run_all": "api",
    "simplest": "ladder.simplest",
    "stability": "tow_stability.stability",
    "sweep": "sweeps.sweep",
    "write_report": "report.page",
}
"""The module of each public name."""


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(importlib.import_module(f".{_HOME[name]}", __name__), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *_HOME})
