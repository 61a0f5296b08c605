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
    from towage.errors import FmuError, RunError, SceneError, TowageError
    from towage.master.master import Master, run, run_all
    from towage.result.result import Result
    from towage.scene.scene import Scene

for _link in ("models", "fmus"):
    if not os.path.isdir(os.path.join(os.path.dirname(__file__), _link)):
        raise ImportError(
            f"towage/{_link} is no link to ../{_link}: this checkout was made without symbolic links. Clone it again with "
            "'git -c core.symlinks=true clone', or install the wheel"
        )

__version__ = "0.1.0"
__all__ = [
    "FmuError",
    "Master",
    "Result",
    "RunError",
    "Scene",
    "SceneError",
    "TowageError",
    "__version__",
    "run",
    "run_all",
]

_HOME = {
    "FmuError": "errors",
    "Master": "master.master",
    "Result": "result.result",
    "RunError": "errors",
    "Scene": "scene.scene",
    "SceneError": "errors",
    "TowageError": "errors",
    "run": "master.master",
    "run_all": "master.master",
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
