"""What the two linear towing units share: the rows that they observe, the numbers behind them, their margins.

    y = (forces and motions of ``cable/lumped/linear.py``, T1/T0 and the turn over its room of every segment)

The acceleration u' comes with the inputs; u'' is remembered from the step before, so rates of forces are limits from
the left.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import reduce
from typing import Any, NamedTuple, TypeVar

from ...numeric.matrix_ops import MatrixOps
from ...numeric.ops import FLOATS, Ops, Value
from ...protocol.model import Requirement
from ...protocol.state_space import Comparison, Setup
from ...protocol.variables import local
from ..lumped.fidelity import Chosen
from ..lumped.linear import PROFILE, StateSpace
from ..lumped.lumped import BALANCE, OUTSIDE, flow, steady_towpoint_force
from ..parameters import Choice

P = TypeVar("P", bound=Choice)
FLOOR = 1e-3
"""rad; least distance to the stream's direction by which a turn is measured."""

EXTRA = "segment_tension", local("N", "Tension of a segment, the first at the body")
"""What `observe` of both units gives beside the outputs."""


class Constants(NamedTuple):
    """What follows from the parameters: steady tensions of the segments and at the ends, N, position of the body from the
    towpoint, m, ``direct``:
    the unit's own matrix (2, 2) of the force at once, row by row; then what `Study` counts and finds; and what equilibrium
    demands: least tension, N, largest force across a segment over the forces on it."""

    steady_tension: tuple[Value, ...]
    tension_body: Value
    tension_top: Value
    body_surge: Value
    body_heave: Value
    direct: tuple[Value, ...]
    measured_inputs: Value
    segments: Value
    states: Value
    model_error: Value
    inextensible_error: Value
    least_tension: Value
    imbalance: Value


def setup_of(model: StateSpace, direct: Any, measured: Value, ops: MatrixOps) -> Setup:
    """The set-up of a state space. ``direct`` (2, 2) and ``measured`` as in `Constants`."""
    chain, tow, n, f = model.chain, model.chain.tow, model.chain.count, flow(model.chain)
    room = ops.vectors.maximum(FLOOR, ops.vectors.atan2(f.sine, f.cosine))
    strain, turn = ops.diagonal(1.0 / chain.tension), ops.diagonal(-tow.sign / room)
    c, d, e = (
        ops.vstack([m[:PROFILE, :], strain @ m[PROFILE : PROFILE + n, :], turn @ m[PROFILE + n :, :]])
        for m in (model.c, model.d, model.e)
    )
    x, y = steady_towpoint_force(chain)
    top = ops.scalars.sqrt(x * x + y * y)
    offset = ops.elements(chain.nodes[n, :])
    constants = Constants(
        ops.elements(chain.tension), tow.end_tension, top, -offset[0], -offset[1],
        (*ops.elements(direct[0, :]), *ops.elements(direct[1, :])), measured, float(n), float(model.a.shape[0]), 0.0, 0.0,
        chain.least[n - 1], chain.imbalance[n - 1],
    )  # fmt: skip
    return Setup((model.a,), (model.b,), c, d, e, constants)


def divided(p: P, chosen: Callable[[P], Chosen]) -> tuple[float, float]:
    """(Number of segments, their grading): as the parameters say or, where they leave it open, as were chosen."""
    if p.segments:
        return p.segments, p.grading or 1.0
    found = chosen(p)
    return float(found.nodes), found.grading


def chosen_setup(setup: Setup, chosen: Chosen) -> Setup:
    """A set-up with what was found out in choosing its model; plain floats, which are the fastest. The Python flavour
    shows no tensions of segments, and computes none without the steady ones."""

    def plain(value: Any) -> Any:
        return tuple(map(float, value)) if isinstance(value, tuple) else float(value)

    constants = setup.constants._replace(
        model_error=chosen.error, inextensible_error=chosen.inextensible_error, steady_tension=()
    )
    return setup._replace(constants=Constants(*map(plain, constants)))


def halved(size: Any, least: int) -> tuple[Comparison, ...]:
    """Error of the segments, of second order, by a model with half of them, ``least`` or more."""
    count = int(size.segments)
    half = count // 2
    if half < least:
        return ()
    return (Comparison(size._replace(segments=half), 1.0 / ((count / half) ** 2 - 1.0), "model_error"),)


def setup_requirements(p: Any, constants: Constants, ops: Ops) -> tuple[Requirement, ...]:
    """What a tow in equilibrium fulfils."""
    return ((ops.minimum(constants.least_tension, BALANCE - constants.imbalance), f"a segment {OUTSIDE}"),)


def tuning_refusal(p: Choice) -> str:
    """Why parameters may not change while the unit runs; empty if they may, and the state is kept."""
    if p.reduced > 0.5:
        return "the states of another reduced model mean something else, this needs reduced = 0"
    return "another number of segments might be chosen, this needs a fixed one" if p.segments < 0.5 else ""


def profile(y: Sequence[Value], c: Constants, ops: Ops) -> tuple[Value, Value, tuple[Value, ...]]:
    """(margin of slack, margin of the quadrant, tensions of the segments, N)."""
    middle = (PROFILE + len(y)) // 2
    change, turned = y[PROFILE:middle], y[middle:]
    slack = 1.0 - ops.maximum(extreme(change, max, ops), -extreme(change, min, ops))
    tensions = tuple(t * (1.0 + v) for t, v in zip(c.steady_tension, change))
    return slack, 1.0 - ops.maximum(0.0, extreme(turned, max, ops)), tensions


def extreme(values: Sequence[Value], which: Callable[..., Any], ops: Ops) -> Value:
    """The ``max`` or ``min`` of ``values``."""
    # for floats what `reduce` gives, at a tenth of the time
    return which(values) if ops is FLOATS else reduce(ops.maximum if which is max else ops.minimum, values)


def speed_margin(surge: Value, heave: Value, speed: Value, limit: Value, ops: Ops) -> Value:
    """1 - v/(limit c), v the speed of an end, (surge, heave), m/s."""
    return 1.0 - ops.sqrt(surge * surge + heave * heave) / (limit * speed)
