"""The unit `ship_in_sea`: its model through `Instance`."""

from __future__ import annotations

import numpy as np
import pytest

from towage.fmus.declare.unit import load
from towage.fmus.python.build import staged_modules
from towage.fmus.python.instance import Instance
from towage.fmus.python.values import CallError

SEA = {"wave_height": 4.0, "speed": 6.0, "length": 120.0, "ramp_time": 0.0, "components": 30.0, "update_interval": 1.0}


def instance(name: str, **values: float) -> tuple[Instance, dict[str, int]]:
    unit = load(name)
    made = Instance(unit)
    made.set_values([unit.index[k] for k in values], list(values.values()))
    made.set_up(0.0, None)
    made.enter_initialization()
    made.exit_initialization()
    return made, unit.index


@pytest.mark.parametrize("name", ["ship_in_sea", "playback"])
def test_the_fmus_carry_no_numpy(name: str) -> None:
    """Only `ops.arrays`, which no FMU calls, imports it, when called."""
    for text in staged_modules(name).values():
        assert not any(line.startswith((b"import numpy", b"from numpy", b"import scipy")) for line in text.splitlines())


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
