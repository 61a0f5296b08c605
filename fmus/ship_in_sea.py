"""Unit `ship_in_sea`: the ship in an irregular sea that may change along a voyage, reaction of the line in."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from ..models.protocol.model import AnyModel
from ..models.sea import ship_in_sea
from ..models.sea.response_table import ResponseTable
from ..models.sea.seas import SeaTable
from .declare.unit import Unit

FILES = {
    "responses": "motions of the ship per wave amplitude, in place of the closed form",
    "spectrum": "a measured spectrum, in place of one or two peaks",
}


def _unit(model: AnyModel, start: Mapping[str, float]) -> Unit:
    unit = Unit.of(
        model,
        start={"mass": 8e5, "damping": 1e5, "stiffness": 2e6, "ramp_time": 4.0, "speed": 5.0, **start},
        inputs={"reaction": (5.0e4, 0.9)},
        terminals={
            "line": {"force": "reaction", "displacement": "heave"},
            "sea": {
                "wave_height": "wave_height",
                "wave_period": "wave_period",
                "wave_direction": "wave_direction",
                "speed": "speed",
            },
        },
        files=FILES,
        given=_given,
    )
    inputs = tuple(replace(v, start=start[v.name]) if v.name in start and len(start) > 1 else v for v in unit.inputs)
    return replace(unit, inputs=inputs)


def _given(data: Mapping[str, Any]) -> Unit:
    """The unit with what files say."""
    responses = ResponseTable(**data["responses"]) if "responses" in data else None
    spectrum = SeaTable(**data["spectrum"]) if "spectrum" in data else None
    start = {"wave_height": 3.0}
    if spectrum:
        start = {"wave_height": spectrum.height, "wave_period": 2.0 * math.pi / spectrum.frequency}
    return _unit(ship_in_sea.given(responses, spectrum), start)


UNIT = _unit(ship_in_sea.SHIP_IN_SEA, {"wave_height": 3.0})
