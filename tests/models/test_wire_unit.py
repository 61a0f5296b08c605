"""The unit ``wire``: its steady state, its ports in motion, what it refuses, its state."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest

from towage.models.cable.units.wire import WIRE, Inputs, Parameters
from towage.models.numeric.ops import FLOATS
from towage.models.protocol.variables import quantities

FISH = {"wire_weight": 4.747156, "tow_speed": 3.0}
"""`fish_150m_3ms` of the reference cases."""
STILL = Inputs(*[0.0] * 10)


def parameters(**changes: float) -> Parameters:
    start = {name: float(q.start or 0.0) for name, q in quantities(Parameters).items()}
    return Parameters(**{**start, **changes})


def constant(**inputs: float) -> Inputs:
    """Coefficients of inputs that are constant over a step."""
    return Inputs(*((inputs.get(name, 0.0), 0.0, 0.0, 0.0) for name in Inputs._fields))


def stepped(p: Parameters, count: int, h: float, **inputs: float) -> tuple[Any, Any]:
    x, m = WIRE.initial(p, FLOATS)
    assert WIRE.advance is not None
    for k in range(count):
        x = WIRE.advance(k * h, h, x, m, constant(**inputs), p, FLOATS)
    return x, WIRE.outputs(count * h, x, m, Inputs(*(inputs.get(n, 0.0) for n in Inputs._fields)), STILL, p, FLOATS)


@pytest.mark.parametrize("in_space", [0.0, 1.0])
def test_steady_tow_is_the_reference(in_space: float) -> None:
    """And stays there: nothing moves that nothing drives."""
    p = parameters(**FISH, in_space=in_space, tolerance=1e-8, degree=6.0)
    _, y = stepped(p, 4, 0.5)
    assert y.tension_top == pytest.approx(5786.183214, rel=1e-6)
    assert y.tension_body == pytest.approx(5187.944107, rel=1e-6)
    assert (y.layback, y.depth, y.offset) == pytest.approx((111.0760876, 94.38188384, 0.0), rel=1e-6, abs=1e-9)
    assert (y.reaction_surge, y.reaction_sway, y.reaction_heave) == pytest.approx((0.0, 0.0, 0.0), abs=1e-2)
    assert y.margin_slack == pytest.approx(1.0, abs=1e-6) and y.margin_breaking == 1.0 and y.margin_resolution > 0.0


def test_plane_and_space_agree() -> None:
    """A motion in the plane, to what the steps leave."""
    plane, space = (stepped(parameters(**FISH, in_space=s), 8, 0.25, velocity_heave=1.0)[1] for s in (0.0, 1.0))
    assert plane.tension_top == pytest.approx(space.tension_top, rel=1e-4)
    assert plane.body_heave == pytest.approx(space.body_heave, rel=1e-3) and space.offset == pytest.approx(0.0, abs=1e-9)


def test_sway_and_current_act_in_space_alone() -> None:
    """A current to port carries the body to port; in the plane it is refused with what to do."""
    _, y = stepped(parameters(**FISH, in_space=1.0, current_sway=0.5, current_depth=200.0), 1, 0.1)
    assert y.offset > 5.0
    assert "set in_space = 1" in WIRE.refused(parameters(**FISH, current_sway=0.5))


def test_payout_lengthens_the_wire() -> None:
    _, y = stepped(parameters(tow_speed=0.0, wire_weight=4.747156), 20, 0.5, payout_speed=0.2)
    assert y.length == pytest.approx(152.0) and y.depth > 151.0


def test_tail_and_clump_are_sections_of_the_reference() -> None:
    """`sections_clump_array`."""
    p = parameters(
        tow_speed=3.5, wire_length=200.0, wire_mass=1.1, wire_weight=8.766277, wire_diameter=0.016,
        wire_axial_stiffness=15e6, tail_length=300.0, tail_mass=1.288053, clump_mass=350.0, clump_added_mass=120.0,
        clump_weight=2600.0, clump_drag_area=0.15, body_mass=20.0, body_added_mass=20.0, body_weight=0.0,
        body_drag_area=0.1, tolerance=1e-8, degree=6.0,
    )  # fmt: skip
    _, y = stepped(p, 0, 1.0)
    assert (y.layback, y.depth, y.tension_top) == pytest.approx((486.8054886, 67.32846107, 4678.467711), rel=1e-6)


def test_a_state_set_back_goes_on_alike() -> None:
    p = parameters(**FISH)
    x, m = WIRE.initial(p, FLOATS)
    assert WIRE.advance is not None
    for k in range(3):
        x = WIRE.advance(0.3 * k, 0.3, x, m, constant(velocity_heave=0.5), p, FLOATS)
    first = WIRE.advance(0.9, 0.3, x, m, constant(velocity_heave=-0.5), p, FLOATS)
    WIRE.advance(0.9, 0.7, x, m, constant(velocity_heave=2.0), p, FLOATS)
    again = WIRE.advance(0.9, 0.3, x, m, constant(velocity_heave=-0.5), p, FLOATS)
    assert np.array_equal(np.array(first), np.array(again))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"wire_weight": 60.0}, "wire_weight is above"), ({"body_weight": 1e5}, "body_weight is above"),
        ({"loading_form": 0.5}, "loading_form"), ({"clump_weight": 10.0}, "clump_weight is above"),
        ({"tolerance": 1e-10, "degree": 1.0, "wire_length": 900.0}, "about .* would reach tolerance"),
    ],
)  # fmt: skip
def test_what_makes_no_wire_is_named(changes: dict[str, float], message: str) -> None:
    assert re.search(message, WIRE.refused(parameters(**changes)))


def test_a_breaking_wire_is_told() -> None:
    """The margin falls from 1 at rest to 0 where the tension reaches the breaking load."""
    p = parameters(**FISH, breaking_load=6000.0)
    assert stepped(p, 0, 1.0)[1].margin_breaking == pytest.approx(1.0)
    y = stepped(p, 4, 0.5, velocity_heave=1.5)[1]
    assert y.margin_breaking == pytest.approx((6000.0 - y.tension_most) / (6000.0 - stepped(p, 0, 1.0)[1].tension_most))
