"""Recompute reference cases and compare: what ``towage verify`` does.

A file is ``{"cases": [{"kind", "name", "inputs", "expected", "rtol"}, ...]}``. A number passes when

    |computed - expected| <= rtol max(|expected|, scale)

with scale the largest magnitude among the numbers of the same list or of the same group (one level of ``expected``), so
that a zero crossing is not judged relatively; integers, booleans, texts and nulls must agree exactly. The name of a
case is a label and decides nothing.

A kind is computed by its function (inputs, expected) -> values in `SOLVERS`. It sees ``expected`` only to know how many
values are wanted and which point of a periodic orbit they refer to.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any

from towage import reading
from towage.errors import SceneError
from towage.verify import cable as verify_cable
from towage.verify import cradle as verify_cradle
from towage.verify import sea as verify_sea
from towage.verify import slender as verify_slender
from towage.verify import wire as verify_wire
from towage.verify import wire_motion as verify_wire_motion

DEFAULT_RTOL = 1e-8
OWN_FILES = ("cradle.json", "cable.json", "sea_and_route.json", "slender.json", "wire.json")
"""The project's own copies, in ``towage/reference``."""

SOLVERS: dict[str, Callable[[Mapping[str, Any], Mapping[str, Any]], Mapping[str, Any]]] = {
    **verify_cradle.SOLVERS, **verify_cable.SOLVERS, **verify_sea.SOLVERS,
    **verify_slender.SOLVERS, **verify_wire.SOLVERS, **verify_wire_motion.SOLVERS,
}  # fmt: skip
"""The function that computes a kind of case: (inputs, expected) -> values."""


@dataclass(frozen=True)
class CaseResult:
    """``worst_error``: the largest error over its scale (nan where nothing was computed), to compare with ``rtol``;
    ``message``: empty where ``ok``, else what is wrong."""

    name: str
    kind: str
    worst_error: float
    rtol: float
    ok: bool
    message: str


def verify(path: Path | None = None) -> list[CaseResult]:
    """Every case of ``path``, or of the project's own copies. Raises `SceneError` for a file that cannot be
    read or holds no cases."""
    if path is not None:
        return [check(case) for case in cases(Path(path))]
    results = []
    for name in OWN_FILES:
        text = (files("towage") / "reference" / name).read_text(encoding="utf-8")
        results += [check(case) for case in _cases(text, Path(name))]
    return results


def cases(path: Path) -> list[Mapping[str, Any]]:
    """The cases of a file, as they stand there. Raises `SceneError` for a file that cannot be read or holds no cases."""
    try:
        text = reading.content(path, reading.MAX_JSON).decode()
    except (OSError, UnicodeDecodeError, reading.Refused) as error:
        raise SceneError(f"cannot be read as text: {error}", file=path) from error
    return _cases(text, path)


def _cases(text: str, file: Path) -> list[Mapping[str, Any]]:
    try:
        content = reading.from_json(text.encode())
    except ValueError as error:
        raise SceneError(f"not JSON: {error}", file=file) from error
    if not isinstance(content, dict) or not isinstance(content.get("cases"), list):
        raise SceneError('expected an object with a list "cases"', file=file)
    for k, case in enumerate(content["cases"]):
        if not isinstance(case, dict):
            raise SceneError("expected an object", file=file, key=f"cases[{k}]")
        for key, kind, wanted in (
            ("kind", str, "a text"),
            ("inputs", dict, "an object"),
            ("expected", dict, "an object"),
        ):
            if not isinstance(case.get(key), kind):
                raise SceneError(f"expected {wanted}", file=file, key=f"cases[{k}].{key}")
        rtol = case.get("rtol", DEFAULT_RTOL)
        if not isinstance(rtol, (int, float)) or isinstance(rtol, bool) or not rtol >= 0.0:
            raise SceneError("expected a number >= 0", file=file, key=f"cases[{k}].rtol")
    cases: list[Mapping[str, Any]] = content["cases"]
    return cases


def check(case: Mapping[str, Any]) -> CaseResult:
    """Compute one case of a file and compare it; whatever goes wrong becomes a result that does not agree."""
    kind, rtol = case["kind"], float(case.get("rtol", DEFAULT_RTOL))
    name = str(case.get("name", ""))

    def failed(message: str) -> CaseResult:
        """A result without numbers."""
        return CaseResult(name, kind, math.nan, rtol, False, message)

    if kind not in SOLVERS:
        return failed(f"unknown kind {kind!r}; known: {', '.join(sorted(SOLVERS))}")
    try:
        computed = SOLVERS[kind](case["inputs"], case["expected"])
    except KeyError as error:
        return failed(f"input {error.args[0]!r} is missing")
    except (ArithmeticError, ValueError, TypeError, IndexError) as error:
        return failed(f"{type(error).__name__}: {error}")
    worst, faults = compare(computed, case["expected"], rtol)
    return CaseResult(name, kind, worst, rtol, not faults, "; ".join(faults))


def compare(computed: Any, expected: Any, rtol: float, where: str = "", scale: float = 0.0) -> tuple[float, list[str]]:
    """(largest error over its scale, what does not agree) by the rule of this module."""
    if isinstance(expected, Mapping):
        if not isinstance(computed, Mapping):
            return math.inf, [f"{where}: expected a group"]
        size = _largest(expected.values())
        parts = [
            compare(computed[key], value, rtol, f"{where}.{key}" if where else key, size)
            if key in computed
            else (math.inf, [f"no value is computed for {where + '.' if where else ''}{key}"])
            for key, value in expected.items()
        ]
    elif isinstance(expected, list):
        if not isinstance(computed, (list, tuple)) or len(computed) != len(expected):
            count = len(computed) if isinstance(computed, (list, tuple)) else "no list"
            return math.inf, [f"{where}: expected {len(expected)} values, computed {count}"]
        size = _largest(expected)
        parts = [
            compare(a, b, rtol, f"{where}[{k}]", size) for k, (a, b) in enumerate(zip(computed, expected, strict=True))
        ]
    elif isinstance(expected, float) and isinstance(computed, (int, float)) and not isinstance(computed, bool):
        unit = max(abs(expected), scale)
        error = abs(computed - expected)
        share = error / unit if unit > 0.0 else (0.0 if error == 0.0 else math.inf)
        if share <= rtol:
            return share, []
        return share, [f"{where}: computed {computed!r}, expected {expected!r}, error {share:.1e} of its scale"]
    else:
        same = computed == expected and isinstance(computed, bool) == isinstance(expected, bool)
        return (0.0, []) if same else (math.inf, [f"{where}: computed {computed!r}, expected exactly {expected!r}"])
    return max((share for share, _ in parts), default=0.0), [fault for _, faults in parts for fault in faults]


def _largest(values: Any) -> float:
    return max((abs(v) for v in values if isinstance(v, float) and math.isfinite(v)), default=0.0)
