"""The shape of a wire over time, as a diagram of a result."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from towage.report import shapes


def result(offset: float) -> Any:
    """A straight wire of 60 m by 30 m that sinks, in two samples."""
    columns = {}
    for name, share in [*((f"wire.shape{k}_", 1.0 - k / 6.0) for k in range(1, 6)), ("wire.", 1.0)]:
        columns[f"{name}layback"] = np.full(2, 60.0 * share)
        columns[f"{name}offset"] = np.full(2, offset * share)
        columns[f"{name}depth"] = np.array([30.0, 40.0]) * share
    return SimpleNamespace(time=np.array([0.0, 5.0]), columns=columns)


def test_places_go_from_the_towpoint_to_the_body() -> None:
    at = shapes.places(result(0.0), "wire")
    assert at["depth"].shape == (7, 2)
    assert at["depth"][:, 1] == pytest.approx(np.linspace(0.0, 40.0, 7))
    assert at["layback"][:, 0] == pytest.approx(np.linspace(0.0, 60.0, 7))


@pytest.mark.parametrize(("offset", "panels"), [(0.0, 1), (20.0, 2)])
def test_a_wire_that_leaves_its_plane_is_shown_from_above_too(offset: float, panels: int) -> None:
    shown = result(offset)
    assert shapes.wires(shown) == ["wire"] and len(shapes.columns(shown)) == 15
    svg = shapes.shapes(shown, "wire", "key")
    assert svg is not None and ("to port of it" in svg) == (panels == 2) and "t = 5 s" in svg
    assert shapes.shapes(SimpleNamespace(time=np.zeros(0), columns=shown.columns), "wire", "key") is None  # type: ignore[arg-type]
