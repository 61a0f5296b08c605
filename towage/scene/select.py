"""One scene out of what a caller gives: a file, a name or a scene; one of its cases; values in place of its own."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from msgspec.structs import replace

from towage.scene.scene import Scene


def select(scene: Scene | str | Path, case: str | None = None, values: Mapping[str, Any] | None = None) -> Scene:
    """A scene without cases.

    ``scene``: a scene, the path of its file, or the name of a shipped one. ``case``: the case whose values it gets; None:
    the scene as it stands. ``values``: by "unit.parameter" or key of the scene ("coupling.step"), they prevail over those
    of the case. Raises `SceneError` for a case or a value that does not fit.
    """
    given = scene if isinstance(scene, Scene) else Scene.load(scene)
    given = given.with_values(values) if values else given
    return given.case(case) if case else replace(given, cases=())


def one_case(scene: Scene | str | Path, case: str | None = None, values: Mapping[str, Any] | None = None) -> Scene:
    """`select`, for what needs a single case: the only one of a scene if none is named. Raises `SceneError` that lists the
    cases where there are several."""
    given = scene if isinstance(scene, Scene) else Scene.load(scene)
    if case is None and len(given.cases) > 1:
        names = ", ".join(repr(each.name) for each in given.cases)
        raise given.error(
            f"the scene has several cases: choose one of {names}, as run(scene, {given.cases[0].name!r}), or run them all by "
            "run_all(scene)",
            "cases",
        )
    return select(given, case or (given.cases[0].name if given.cases else None), values)
