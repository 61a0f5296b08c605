"""Whether a result comes out again of the inputs that it names."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from towage.errors import FileError
from towage.process.worker import run_isolated
from towage.result.result import Result
from towage.scene.flavour import Flavour, resolve
from towage.scene.provenance import differences, provenance
from towage.scene.resolve import ResolvedScene
from towage.scene.scene import Scene


def inputs(result: Result, fmus: Path | None = None) -> tuple[ResolvedScene, list[str]]:
    """(the scene of a result with the FMUs that are here, what of its inputs is not as it was). Raises `FileError` where
    the result does not name its inputs, `SceneError` and `FmuError` where they are not to be had."""
    said = result.provenance
    try:
        scene = Scene.from_dict(said["scene"] | {"cases": ()}, Path(said["file"]) if said["file"] else None)
        named: dict[str, Any] = said["fmus"]
    except (KeyError, TypeError, AttributeError) as error:
        raise FileError(
            f"the result does not name its inputs ({error}): it is of an older version, or was cut"
        ) from error
    flavour: Flavour = "auto" if "native" in result.flavours.values() else "python"
    resolved = resolve(scene, fmus, flavour)
    now = json.loads(json.dumps(provenance(resolved)))
    kept = ("fmus", "versions", "machine")  # of the rest the scene here was made
    return resolved, differences(
        {key: ({**said, "fmus": named}).get(key) for key in kept}, {key: now[key] for key in kept}
    )


def compared(result: Result, resolved: ResolvedScene) -> list[str]:
    """What comes out otherwise when the scene is run again: a line a series."""
    again = run_isolated(resolved)
    differ = [] if again.status == result.status else [f"status: {result.status} there, {again.status} here"]
    for prefix, old, new in (("", result.columns, again.columns), ("one way ", result.one_way, again.one_way)):
        pairs = {name: (values, new.get(name)) for name, values in old.items()}
        differ += [f"{prefix}{name}: {said}" for name, (a, b) in pairs.items() if (said := _difference(a, b))]
    changed = [name for name, texts in result.texts.items() if not np.array_equal(texts, again.texts.get(name, ()))]
    differ += [f"{name}: other texts" for name in changed]
    if said := _difference(result.time, again.time):
        differ.append(f"time: {said}")
    if differences(_word(result), _word(again)):
        differ.append(f"verdict: {result.verdict.word} there, {again.verdict.word} here")
    return differ


def _word(result: Result) -> dict[str, Any]:
    return {"word": result.verdict.word, "events": [vars(event) for event in result.events]}


def _difference(old: NDArray[Any], new: NDArray[Any] | None) -> str:
    if new is None or old.shape != new.shape:
        return f"{len(old)} rows there, {'none' if new is None else len(new)} here"
    if old.tobytes() == new.tobytes():
        return ""
    return f"{np.count_nonzero(old != new)} of {len(old)} values, by up to {np.nanmax(np.abs(old - new)):.3g}"
