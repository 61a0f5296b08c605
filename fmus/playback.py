"""Unit `playback`: what a file recorded, with smooth values and exact rates; its outputs are the columns of the file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from ..models.route.playback import Series, playback, straight
from .declare.unit import Unit

SEA = ("wave_height", "wave_period", "wave_direction", "speed")
"""Columns that make the terminal ``sea`` of a ship."""
FILES = {"series": "columns over time: CSV, npz or netCDF"}


def _unit(series: Series, start: Mapping[str, float]) -> Unit:
    terminals = {"sea": {name: name for name in SEA}} if set(SEA) <= set(series.names) else {}
    return replace(Unit.of(playback(series), start=start, files=FILES, given=_given, terminals=terminals), needs_files=True)


def _given(data: Mapping[str, Any]) -> Unit:
    """The unit with the columns of a file."""
    return _unit(Series(**data["series"]), {"beyond": 1.0})


UNIT = _unit(straight((0.0, 10.0, 20.0), "value", (0.0, 1.0, 0.0)), {"beyond": 2.0})
