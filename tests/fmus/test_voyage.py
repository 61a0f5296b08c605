"""The units `voyage` and `ship_in_sea`: their models through `Instance`."""

from __future__ import annotations

import math

import numpy as np
import pytest

from towage.fmus.declare.unit import load
from towage.fmus.python.build import staged_modules
from towage.fmus.python.instance import Instance
from towage.fmus.python.values import CallError
from towage.models.route import voyage

NAMES = ("voyage", "ship_in_sea")
SEA = {"wave_height": 4.0, "speed": 6.0, "length": 120.0, "ramp_time": 0.0, "components": 30.0, "update_interval": 1.0}
TABLE = {f"{c}_{k}": 3.0 + math.sin(0.7 * k + i) for i, c in enumerate(voyage.COLUMNS) for k in range(voyage.POINTS)}
VOYAGE: dict[str, float] = {"duration": 30.0, **TABLE}

def instance(name: str, **values: float) -> tuple[Instance, dict[str, int]]:
    unit = load(name)
    made = Instance(unit)
    made.set_values([unit.index[k] for k in values], list(values.values()))
    made.set_up(0.0, None)
    made.enter_initialization()
    made.exit_initialization()
    return made, unit.index


@pytest.mark.parametrize("name", NAMES)
def test_the_fmus_carry_no_numpy(name: str) -> None:
    """Only `ops.arrays`, which no FMU calls, imports it, when called."""
    for text in staged_modules(name).values():
        assert not any(line.startswith((b"import numpy", b"from numpy", b"import scipy")) for line in text.splitlines())


def test_voyage_goes_through_its_table() -> None:
    made, index = instance("voyage", **VOYAGE)
    columns = [index[c] for c in voyage.COLUMNS]
    step = 30.0 / (voyage.POINTS - 1)
    for k in range(voyage.POINTS):
        wanted = [TABLE[f"{c}_{k}"] for c in voyage.COLUMNS]
        assert made.get_values(columns) == pytest.approx(wanted, abs=1e-12)  # rounding of the time of the point
        made.do_step(k * step, step)
    assert made.get_values(columns) == pytest.approx([TABLE[f"{c}_{voyage.POINTS - 1}"] for c in voyage.COLUMNS])
    assert made.get_values([index["progress"], index["x_rate"]]) == [1.0, 0.0]


def test_voyage_rates_are_exact_and_quadratics_are_met() -> None:
    values = {f"x_{k}": 2.0 + 0.5 * k + 0.25 * k * k for k in range(voyage.POINTS)}
    made, index = instance("voyage", duration=240.0, pace=2.0, horizon=100.0, **values)
    for k in range(23):
        made.do_step(k * 5.0, 5.0)
        u = 2.0 * made.time / 10.0
        x, rate, margin = made.get_values([index["x"], index["x_rate"], index["margin_forecast"]])
        assert x == pytest.approx(2.0 + 0.5 * u + 0.25 * u * u, rel=1e-12)
        assert rate == pytest.approx((0.5 + 0.5 * u) * 0.2, rel=1e-12)
        assert margin == pytest.approx(1.0 - 2.0 * made.time / 100.0, abs=1e-12)


def test_the_sea_at_the_start_is_that_of_the_first_inputs() -> None:
    late, index = instance("ship_in_sea", **{**SEA, "wave_height": 1.0})
    late.set_values([index["wave_height"]], [4.0])
    early, _ = instance("ship_in_sea", **SEA)
    observed = [index["heave"], index["velocity"], index["significant_heave"]]
    assert late.get_values(observed) == early.get_values(observed)
    late.do_step(0.0, 0.25)
    late.set_values([index["wave_height"]], [1.0])  # from now on a change goes over smoothly
    early.do_step(0.0, 0.25)
    assert late.get_values(observed) == early.get_values(observed)


def test_one_hour_of_the_unit_has_the_variance_it_reports() -> None:
    made, index = instance("ship_in_sea", **{**SEA, "components": 60.0})
    heave = []
    for k in range(3600):
        made.do_step(k * 1.0, 1.0)
        heave.append(made.get_values([index["heave"]])[0])
    significant = made.get_values([index["significant_heave"]])[0]
    # 3600 s of a record with a correlation time near 10 s: a standard error of 5 %
    assert 4.0 * float(np.std(heave)) == pytest.approx(significant, rel=0.12)


@pytest.mark.parametrize(
    ("values", "message"),
    [({"spreading": 7.0}, "directions"), ({"components": 0.0}, "components"), ({"peakedness": 0.5}, "peakedness"),
     ({"update_interval": 0.0}, "update_interval"), ({"block_coefficient": 2.0}, "block_coefficient")],
)  # fmt: skip
def test_bad_parameters_are_refused(values: dict[str, float], message: str) -> None:
    with pytest.raises(CallError, match=message):
        instance("ship_in_sea", **values)
