"""Every unit begins with its own start values: a host that sets nothing gets a unit that runs."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from pathlib import Path

from .cases import NATIVE, UNITS
from .conftest import Program


def test_every_unit_of_every_flavour_runs_with_nothing_set(
    fmus: Path, native: Callable[[str, int], Path], program: Program
) -> None:
    paths = [fmus / f"{name}.fmu" for name in UNITS] + [native(name, fmi) for name in NATIVE for fmi in (2, 3)]
    found = [json.loads(line) for line in program("starts", *paths).splitlines() if line.startswith('{"path"')]
    assert [Path(each["path"]) for each in found] == paths
    for each in found:
        assert each["steps"] == 10 and each["last"]["time"] == 1.0, each["path"]
        assert all(math.isfinite(value) for value in each["last"].values()), each["path"]
        # no unit is outside its own assumptions before anything has happened
        margins = {name: value for name, value in each["last"].items() if name.startswith("margin_")}
        assert all(value > 0.0 for value in margins.values()), (each["path"], margins)
