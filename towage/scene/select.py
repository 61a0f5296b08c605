"""One scene out of what a caller gives: a file, a name or a scene; one of its cases; values in place of its own."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import msgspec

from towage.errors import SceneError
from towage.scene.scene import Case, Scene


def select(scene: Scene | str | Path, case: str | None = None, values: Mapping[str, Any] | None = None) -> Scene:
    """A scene without cases.

    ``scene``: a scene, the path of its file, or the name of a shipped one. ``case``: the case whose values it gets; None:
    the scene as it stands. ``values``: by "unit.parameter" or key of the scene ("coupling.step"), they prevail over those
    of the case. Raises `SceneError` for a case or a value that does not fit.
    """
    given = scene if isinstance(scene, Scene) else Scene.load(scene)
    chosen = msgspec.structs.replace(given.case(case) if case else given, cases=())
    return with_values(chosen, values, "set") if values else chosen


def one_case(scene: Scene | str | Path, case: str | None = None, values: Mapping[str, Any] | None = None) -> Scene:
    """`select`, for what needs a single case: the only one of a scene if none is named. Raises `SceneError` that lists the
    cases where there are several."""
    given = scene if isinstance(scene, Scene) else Scene.load(scene)
    if case is None and len(given.cases) > 1:
        names = ", ".join(repr(each.name) for each in given.cases)
        raise given.error(f"the scene has several cases: choose one of {names}", "cases")
    return select(given, case or (given.cases[0].name if given.cases else None), values)


def with_values(scene: Scene, values: Mapping[str, Any], option: str) -> Scene:
    """The scene with ``values`` set; it has no cases and no text. Raises `SceneError` whose key is ``option``."""
    try:
        changed = msgspec.structs.replace(scene, cases=(Case(option, dict(values)),)).case(option)
    except SceneError as error:
        raise scene.error(str(error.args[0]), option) from None
    return msgspec.structs.replace(changed, cases=(), source="")
