"""MAT 5: for MATLAB and Octave."""

from __future__ import annotations

import os
import re
from collections.abc import Container, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from towage.files import atomic_write

_LONGEST = 63
"""Characters of the longest name of a MATLAB variable."""
_KEYWORDS = (
    "break", "case", "catch", "classdef", "continue", "else", "elseif", "end", "for", "function", "global", "if", "otherwise",
    "parfor", "persistent", "return", "spmd", "switch", "try", "while",
)  # fmt: skip


def write_mat(path: str | os.PathLike[str], series: Mapping[str, NDArray[Any]], units: Mapping[str, str]) -> None:
    """Column vectors under valid MATLAB names (``line.tension`` becomes ``line_tension``), and the cell array
    ``variables`` with rows {MATLAB name, name, unit}. Raises `TowageError` and keeps the earlier file if it cannot be
    written."""
    from scipy.io import savemat  # type: ignore[import-untyped, unused-ignore]

    content: dict[str, NDArray[Any]] = {"variables": np.empty((len(series), 3), dtype=object)}
    for row, (name, values) in enumerate(series.items()):
        matlab = matlab_name(name, content)
        content[matlab] = values
        content["variables"][row] = matlab, name, units.get(name) or "-"
    with atomic_write(path) as stream:
        savemat(stream, content, oned_as="column")


def matlab_name(name: str, taken: Container[str]) -> str:
    """Letters, digits and underscores, a letter first, no keyword, at most 63 characters, not in ``taken``."""
    base = re.sub(r"[^A-Za-z0-9_]", "_", name)
    if not base[:1].isalpha() or base in _KEYWORDS:
        base = f"v_{base}"
    candidate, count = base[:_LONGEST], 1
    while candidate in taken:
        count += 1
        candidate = f"{base[: _LONGEST - len(str(count)) - 1]}_{count}"
    return candidate
