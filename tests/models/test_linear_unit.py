"""The generic runner of linear models, on a scalar that can be solved by hand."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pytest

from towage.models.protocol.linear_model import LinearModel, LinearUnit
from towage.models.protocol.model import remembered
from towage.models.protocol.state_space import Setup, Study


@dataclass(frozen=True)
class Parameters:
    decay: float


class Constants(NamedTuple):
    gain: float
    fast: float = 10.0


class Inputs(NamedTuple):
    force: float
    pace: float


class Own(NamedTuple):
    impulse: float


class Size(NamedTuple):
    """Nothing fixes it."""


def unit(p: Parameters, study: Study | None = None) -> LinearUnit:
    """z' = -(decay s) z + (1 + s) v, y = gain z + 2 v + 3 v', one own state: the integral of u."""
    one = np.ones((1, 1))
    setup = Setup((0.0 * one, -p.decay * one), (one, one), 5.0 * one, 2.0 * one, 3.0 * one, Constants(5.0))
    model = LinearModel(
        "scalar", "", Parameters, Inputs, tuple, tuple, Size, Own,
        setup=lambda p, size, ops: setup,
        prepare=lambda p: setup,
        describe=lambda p, c, ops: (),
        drive=lambda own, cubics, p, c, ops: (cubics.force,),
        own_after=lambda h, own, cubics, p, c, ops: (own.impulse + h * cubics.force[0],),
        core=lambda own, u, du, p, c, ops: ((u.force,), (du.force,), (0.0,)),
        observe=lambda t, own, y, rate, u, du, growth, p, c, ops: ((*y, *rate, growth, *own), ()),
        schedule=lambda u, p, c, ops: u.pace,
        study=(lambda size: study) if study else None,
    )
    return model.prepared(p)


def test_step_with_the_schedule_of_its_middle() -> None:
    # s goes from 1 to 3 over the step: 2 in its middle
    z, own = unit(Parameters(0.7)).advance(0.5, (1.0, 4.0), [(6.0, 0.0, 0.0, 0.0), (1.0, 4.0, 0.0, 0.0)])
    rate, force = 0.7 * 2.0, 3.0 * 6.0
    assert z == pytest.approx(force / rate + (1.0 - force / rate) * math.exp(-rate * 0.5), rel=1e-14)
    assert own == 7.0


def test_outputs_and_rates() -> None:
    found, _ = unit(Parameters(0.7), Study(growth_below="fast")).outputs(0.0, (1.0, 4.0), (6.0, 2.0), (0.5, 0.0))
    z_rate = -1.4 * 1.0 + 3.0 * 6.0
    # y = 5 z + 2 v + 3 v', y' = 5 z' + 2 v' + 3 v'', growth -1.4
    assert found == pytest.approx((5.0 + 12.0 + 1.5, 5.0 * z_rate + 1.0, -1.4, 4.0), rel=1e-14)


def test_what_is_made_is_made_once() -> None:
    calls = []

    @remembered
    def make(p: Parameters) -> float:
        calls.append(p)
        return p.decay

    one = Parameters(1.0)
    assert make(one) == make(one) == make(Parameters(1.0)) == 1.0
    assert make(Parameters(2.0)) == 2.0
    assert len(calls) == 2
    # what is kept takes no part in comparing
    assert one == Parameters(1.0)
