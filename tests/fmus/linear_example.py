"""Two masses on springs as a small linear unit: everything that the protocol of ``docs/native.md`` offers, in two lines
of mechanics each.

    m q1'' = -k q1 - d q1' + k (q2 - q1) + s w (q2 - q1) + f,   m q2'' = -k (q2 - q1) - d q2',   u = (f, s)

s is the schedule, and w makes it matter; own state: integral of f. The chain may be longer: ``masses``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

from towage.fmus.declare.unit import Unit
from towage.models.numeric.matrix_ops import MatrixOps, numbers
from towage.models.numeric.ops import Ops, Value
from towage.models.protocol.linear_model import LinearModel
from towage.models.protocol.state_space import Comparison, Resolution, Setup, Study
from towage.models.protocol.variables import (
    Rate,
    calculated_parameter,
    input_variable,
    local,
    output,
    parameter,
    tunable,
)


@dataclass(frozen=True)
class Parameters:
    """SI; w: stiffness of the coupling a unit of the schedule."""

    stiffness: Annotated[Value, tunable("N/m", 4.0, "Stiffness")]
    damping: Annotated[Value, parameter("N.s/m", 0.3, "Damping")]
    scheduled: Annotated[Value, parameter("N/m", 1.5, "Stiffness a unit of the schedule")]
    start: Annotated[Value, parameter("m", 0.1, "Position of the first mass")]
    masses: Annotated[Value, parameter("1", 2.0, "Number of masses")]
    band: Annotated[Value, parameter("rad/s", 3.0, "Band")]


class Size(NamedTuple):
    """Number of masses."""

    masses: float = 2.0


class Own(NamedTuple):
    """Integral of the force, N s."""

    impulse: Value


class Inputs(NamedTuple):
    """Force on the first mass; schedule."""

    force: Annotated[Value, input_variable("N", "Force")]
    pace: Annotated[Value, input_variable("1", "Schedule", min=0.0)]


class Outputs(NamedTuple):
    """Positions of the first and last mass, growth, product of impulse and position, and rates."""

    first: Annotated[Value, output("m", "First")]
    last: Annotated[Value, output("m", "Last")]
    growth: Annotated[Value, output("1/s", "Growth")]
    product: Annotated[Value, output("N.s.m", "Nonlinear")]
    first_rate: Rate
    last_rate: Rate


class Calculated(NamedTuple):
    """What the study found."""

    error: Annotated[Value, calculated_parameter("1", "Found")]
    resolved: Annotated[Value, calculated_parameter("1", "Found")]


class Constants(NamedTuple):
    """``fast``: 1/s, above which modes do not count."""

    error: Value
    resolved: Value
    fast: Value


def setup(p: Parameters, size: Size, ops: MatrixOps) -> Setup:
    """A chain of masses of 1 kg; v = (f, impulse)."""
    n = int(size.masses)
    zero = ops.zeros(n, n)

    def coupling(k: Value, ground: Value) -> Any:
        rows: list[list[Value]] = [[0.0] * n for _ in range(n)]
        rows[0][0] = -ground
        for i in range(n - 1):
            for a, b, sign in ((i, i, -1.0), (i, i + 1, 1.0), (i + 1, i, 1.0), (i + 1, i + 1, -1.0)):
                rows[a][b] = rows[a][b] + sign * k
        return ops.matrix(rows)

    def block(lower: Any, right: Any, upper: Any) -> Any:
        return ops.vstack([ops.hstack([zero, upper]), ops.hstack([lower, right])])

    a0 = block(coupling(p.stiffness, p.stiffness), -p.damping * ops.eye(n), ops.eye(n))
    a1 = block(coupling(p.scheduled, 0.0), zero, zero)
    a2 = block(zero, 0.01 * p.scheduled * ops.eye(n), zero)
    push = ops.vstack([ops.zeros(n, 1), ops.eye(n)[:, :1]])
    b0 = ops.hstack([push, 0.1 * push])
    b1 = ops.hstack([0.2 * push, ops.zeros(2 * n, 1)])
    c = ops.vstack([ops.hstack([ops.eye(n)[:1, :], zero[:1, :]]), ops.hstack([ops.eye(n)[n - 1 :, :], zero[:1, :]]),
                    ops.hstack([zero[:1, :], ops.eye(n)[:1, :]]), ops.hstack([zero[:1, :], ops.eye(n)[n - 1 :, :]])])  # fmt: skip
    d = ops.vstack([ops.zeros(3, 2), 1e-3 * ops.hstack([p.damping * ops.eye(1), ops.eye(1)])])
    constants = Constants(0.0, 0.0, 10.0 * ops.scalars.sqrt(p.stiffness))
    return Setup((a0, a1, a2), (b0, b1, 0.0 * b0), c, d, 0.5 * d, constants)


def study(size: Size) -> Study:
    """Compared with a chain one mass longer, half of the difference; resolved as far as the slowest mode of that."""
    longer = Size(size.masses + 1.0)
    return Study(
        None, (Comparison(longer, 0.5, "error", truer=True, when=lambda p, ops: p.damping - 0.05),),
        Resolution(longer, 1, 0.5, 0.25, 2.0, "resolved", "fast"), "fast",
    )  # fmt: skip


def requirements(p: Parameters, ops: Ops) -> tuple[tuple[Value, str], ...]:
    """A spring that pulls."""
    return ((p.stiffness, "stiffness must be positive"),)


def start(p: Parameters, constants: Constants, ops: Ops) -> tuple[tuple[Value, ...], tuple[Value, ...]]:
    """The first mass is away from its place."""
    return (p.start, *(0.0,) * (2 * int(p.masses) - 1)), (0.0,)


def describe(p: Parameters, constants: Constants, ops: Ops) -> Calculated:
    """What the study found."""
    return Calculated(constants.error, constants.resolved)


def schedule(u: Inputs, p: Parameters, constants: Constants, ops: Ops) -> Value:
    """The pace squared, so that its derivative is not constant."""
    return u.pace * u.pace


def drive(own: Own, cubics: Inputs, p: Parameters, constants: Any, ops: Ops) -> Any:
    """The force, and its integral, of degree 4."""
    a, b, c, d = cubics.force
    return (a, b, c, d, 0.0), (own.impulse, a, b / 2.0, c / 3.0, d / 4.0)


def own_after(h: Value, own: Own, cubics: Inputs, p: Parameters, constants: Any, ops: Ops) -> tuple[Value, ...]:
    """The impulse at the end of the step."""
    a, b, c, d = cubics.force
    return (own.impulse + h * (a + h * (b / 2.0 + h * (c / 3.0 + h * d / 4.0))),)


def own_rates(own: Own, u: Inputs, du: Inputs, p: Parameters, constants: Any, ops: Ops) -> Any:
    """The force."""
    return (u.force,)


def core(own: Own, u: Inputs, du: Inputs, p: Parameters, constants: Any, ops: Ops) -> Any:
    """Force and impulse with their derivatives."""
    return (u.force, own.impulse), (du.force, u.force), (0.0, du.force)


def observe(
    t: Value, own: Own, y: Sequence[Value], y_rate: Sequence[Value], u: Inputs, du: Inputs, growth: Value,
    p: Parameters, constants: Any, ops: Ops,
) -> tuple[Outputs, tuple[Value, ...]]:  # fmt: skip
    """All observables, and y as extras."""
    first, last, _, fourth = y
    first_rate, last_rate, *_ = y_rate
    return Outputs(
        first, last, growth, own.impulse * fourth * ops.sin(u.force), first_rate, last_rate
    ), tuple(y)  # fmt: skip


def prepare(p: Parameters) -> Setup:
    """The matrices, of numbers; nothing is found out about them."""
    return setup(p, Size(p.masses), numbers())


LINEAR = LinearModel(
    "linear_example", "Chain of masses", Parameters, Inputs, Outputs, Calculated, Size, Own,
    setup=setup, prepare=prepare, drive=drive, core=core, observe=observe, describe=describe, own_after=own_after,
    own_rates=own_rates, start=start, schedule=schedule, study=study, requirements=requirements, order=4,
    extra=("row", local("1", "Row of y")),
)  # fmt: skip
UNIT = Unit.of(LINEAR.as_model())
