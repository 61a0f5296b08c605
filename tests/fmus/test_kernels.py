"""Units with kernels: their C functions against their Python text, through whole instances."""

from __future__ import annotations

import math
import random
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from towage.fmus.declare.unit import Unit, load
from towage.fmus.native.trace import trace
from towage.fmus.python.instance import Instance
from towage.fmus.python.values import StepError
from towage.models.route.playback import Series

from .conftest import compiler_found
from .native_instance import DONE, NO_STEP, NativeInstance, unit_library

pytestmark = pytest.mark.skipif(not compiler_found(), reason="no C compiler")
HEADINGS = tuple(np.radians(np.arange(0.0, 360.0, 30.0)).tolist())


def table(speeds: tuple[float, ...] = (0.0, 6.0), count: int = 12) -> dict[str, tuple[object, ...]]:
    """Responses of some ship: numbers without a pattern."""
    chance = np.random.default_rng(3)
    omega = tuple(np.linspace(0.25, 2.2, count).tolist())
    values = chance.normal(size=(6 * len(speeds) * len(HEADINGS) * count, 2)) @ [1.0, 1.0j]
    return {"speeds": speeds, "headings": HEADINGS, "frequencies": omega, "values": tuple(values.tolist())}


SPECTRUM = {
    "frequencies": tuple(np.linspace(0.3, 2.0, 30).tolist()), "directions": ((-0.4, 0.4), (0.0, 0.4), (0.5, 0.5)),
    "densities": tuple(tuple((k + 1.0) * x for x in (math.sin(0.1 * i) ** 2 for i in range(30))) for k in range(3)),
    "height": 2.5, "frequency": 0.8,
}  # fmt: skip
SEAS: dict[str, tuple[dict[str, object], dict[str, float]]] = {
    "closed form": ({}, {"components": 24.0, "point_x": -30.0}),
    "two peaks": ({}, {
        "components": 30.0, "spreading": 2.0, "directions": 5.0, "order": 2.5, "second_share": 0.4, "second_peakedness": 3.0,
        "second_frequency": 0.6, "second_direction": 1.0,
    }),
    "table": ({"responses": table()}, {"components": 20.0, "point_x": -30.0, "point_y": 8.0, "point_z": 12.0}),
    "spectrum": ({"spectrum": SPECTRUM, "responses": table((2.0,), 2)}, {"components": 20.0, "point_y": 5.0}),
}  # fmt: skip


QUICK = ("table",)


def made(name: str, data: dict[str, object]) -> Unit:
    unit = load(name)
    return unit.given(data) if unit.given and data else unit


def python(unit: Unit, start: dict[str, float]) -> Instance:
    instance = Instance(unit)
    instance.set_values([unit.index[n] for n in start], list(start.values()))
    instance.set_up(0.0, None)
    instance.enter_initialization()
    instance.exit_initialization()
    return instance


@pytest.mark.parametrize("name", [pytest.param(n, marks=[pytest.mark.slow] * (n not in QUICK)) for n in SEAS])
def test_the_native_ship_moves_as_the_python_one(name: str, tmp_path: Path) -> None:
    """In a steady sea, then in one that changes, with steps shorter and longer than the looks; 1e-10 of each quantity."""
    data, start = SEAS[name]
    unit = made("ship_in_sea", data)
    traced = trace(unit, {n: v for n, v in start.items() if n in unit.model.structure})
    start |= {"seed": 77.0, "update_interval": 4.0, "ramp_time": 3.0, "speed": 4.0, "mass": 8e5, "stiffness": 2e6}
    own, other = python(unit, start), NativeInstance(unit_library(traced, tmp_path), traced, **start)
    assert other.initialized == DONE
    names, chance = [v.name for v in unit.observed], random.Random(5)
    rows = []
    for k in range(150):
        t, h = own.time, chance.choice((0.1, 0.7, 3.0, 9.0))
        if k > 50:
            inputs = {
                "wave_height": 3.0 + math.sin(t / 30.0), "wave_period": 8.0 + math.cos(t / 40.0), "reaction": 4e4 * math.sin(t),
                "wave_direction": t / 50.0, "wave_direction_d1": 1.0 / 50.0, "speed": 4.0 + math.sin(t / 90.0),
            }  # fmt: skip
            own.set_values([unit.index[n] for n in inputs], list(inputs.values()))
            assert other.set(**inputs) == DONE
        own.do_step(t, h)
        assert other.step(t, h) == DONE, other.message
        rows.append((own.get_values(list(unit.layout.observed)), other.get(*names)))
    ours, theirs = np.array(rows).transpose(1, 0, 2)
    scale = np.abs(ours).max(axis=0)
    assert (np.abs(ours - theirs).max(axis=0) <= 1e-10 * scale).all()
    moving = dict(zip(names, scale))
    assert moving["free_heave"] > 0.1 and (moving["roll"] > 0.0) == ("responses" in data) and moving["pitch"] > 0.0


def test_a_structural_parameter_of_a_native_ship_is_fixed_and_its_memory_is_no_state(tmp_path: Path) -> None:
    """What a kernel remembers changes nothing: two instances that were asked at other times give the same."""
    traced = trace(load("ship_in_sea"), {"components": 5.0})
    library = unit_library(traced, tmp_path)
    assert NativeInstance(library, traced, components=6.0).initialized != DONE
    assert NativeInstance(library, traced, seed=3.0).initialized == DONE
    one, two = NativeInstance(library, traced, wave_height=2.0), NativeInstance(library, traced, wave_height=2.0)
    for k in range(300):
        one.step(k * 0.1, 0.1)
        if k % 10 == 9:
            two.step(k * 0.1 - 0.9, 1.0)
            assert one.get("free_heave", "pitch_rate") == pytest.approx(
                two.get("free_heave", "pitch_rate"), rel=1e-12, abs=1e-14
            )


SERIES = Series((0.0, 1.0, 1.5, 4.0), ("a", "b"), ("m", "1"), ((1.0, 3.0, 2.0, 1.0), (5.0,) * 4),
                ((0.5, -0.2, 1.0, 0.5), (0.0,) * 4), True)  # fmt: skip


@pytest.fixture(scope="module")
def player(tmp_path_factory: pytest.TempPathFactory) -> tuple[Unit, Any, Any]:
    """The unit that plays `SERIES`, traced and compiled."""
    unit = made("playback", {"series": vars(SERIES)})
    traced = trace(unit)
    return unit, traced, unit_library(traced, tmp_path_factory.mktemp("player"))


@pytest.mark.parametrize(("beyond", "end"), [(0.0, 4.0), (1.0, 9.0), (2.0, 9.0)])
def test_a_file_is_played_alike(beyond: float, end: float, player: tuple[Unit, Any, Any]) -> None:
    unit, traced, library = player
    start = {"beyond": beyond, "pace": 0.5, "offset": 0.25}
    own, other = python(unit, start), NativeInstance(library, traced, **start)
    names = [v.name for v in unit.observed]
    while 0.25 + 0.5 * (own.time + 0.3) <= end:
        t = own.time
        own.do_step(t, 0.3)
        assert other.step(t, 0.3) == DONE
        assert other.get(*names) == pytest.approx(own.get_values(list(unit.layout.observed)), rel=1e-14, abs=1e-14)
    assert own.time > 7.0
    if beyond == 0.0:
        with pytest.raises(StepError, match="the file holds 0 to 4 s, and 5.5 s is asked for: beyond = 1"):
            own.do_step(own.time, 3.0)
        assert other.step(own.time, 3.0) == NO_STEP and "became nan" in other.message
