"""Two masses on springs as a small linear unit: everything that the protocol of ``docs/native.md`` offers, in two lines
of mechanics each.

    m q1'' = -k q1 - d q1' + k (q2 - q1) + s w (q2 - q1) + f,   m q2'' = -k (q2 - q1) - d q2',   u = (f, s)

s is the schedule, and w makes it matter; own state: integral of f. The chain may be longer: ``masses``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

from towage.fmus.declare.unit import Unit, calculated, entry, output, parameter
from towage.models.numeric.matrix_ops import MatrixOps
from towage.models.numeric.ops import Ops, Value
from towage.models.protocol.state_space import Comparison, Resolution, Setup, Study


@dataclass(frozen=True)
class Parameters:
    """SI; w: stiffness of the coupling a unit of the schedule."""

    stiffness: Value
    damping: Value
    scheduled: Value
    start: Value
    masses: Value
    band: Value


class Size(NamedTuple):
    """Number of masses."""

    masses: float = 2.0


STRUCTURE = Size._fields


class Own(NamedTuple):
    """Integral of the force, N s."""

    impulse: Value


class Inputs(NamedTuple):
    """Force on the first mass, N; schedule."""

    force: Value
    pace: Value


class Outputs(NamedTuple):
    """Positions of the first and last mass, growth, product of impulse and position, and rates."""

    first: Value
    last: Value
    growth: Value
    product: Value
    first_rate: Value
    last_rate: Value


class Calculated(NamedTuple):
    """What the study found."""

    error: Value
    resolved: Value


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


def schedule(u: Sequence[Value], p: Parameters, constants: Constants, ops: Ops) -> Value:
    """The pace squared, so that its derivative is not constant."""
    return u[1] * u[1]


def drive(own: Sequence[Value], cubics: Sequence[Sequence[Value]], p: Parameters, constants: Any, ops: Ops) -> Any:
    """The force, and its integral, of degree 4."""
    a, b, c, d = cubics[0]
    return (a, b, c, d), (own[0], a, b / 2.0, c / 3.0, d / 4.0)


def own_after(
    h: Value, own: Sequence[Value], cubics: Sequence[Sequence[Value]], p: Parameters, constants: Any, ops: Ops
) -> tuple[Value, ...]:
    """The impulse at the end of the step."""
    a, b, c, d = cubics[0]
    return (own[0] + h * (a + h * (b / 2.0 + h * (c / 3.0 + h * d / 4.0))),)


def own_rates(own: Sequence[Value], u: Sequence[Value], du: Any, p: Parameters, constants: Any, ops: Ops) -> Any:
    """The force."""
    return (u[0],)


def core(own: Sequence[Value], u: Sequence[Value], du: Sequence[Value], p: Parameters, constants: Any, ops: Ops) -> Any:
    """Force and impulse with their derivatives."""
    return (u[0], own[0]), (du[0], u[0]), (0.0, du[0])


def observe(
    t: Value, own: Sequence[Value], y: Sequence[Value], y_rate: Sequence[Value], u: Sequence[Value],
    du: Sequence[Value], growth: Value, p: Parameters, constants: Any, ops: Ops,
) -> tuple[Outputs, tuple[Value, ...]]:  # fmt: skip
    """All observables, and y as extras."""
    return Outputs(y[0], y[1], growth, own[0] * y[3] * ops.sin(u[0]), y_rate[0], y_rate[1]), tuple(y)


EXTRA = ("row", "1", "Row of y")


def unit(model: Any) -> Unit:
    """The unit of this module, ``model``."""
    return Unit(
        name="linear_example",
        description="Chain of masses",
        model=model,
        parameters=(
            replace(parameter("stiffness", "N/m", 4.0, "Stiffness"), variability="tunable"),
            parameter("damping", "N.s/m", 0.3, "Damping"),
            parameter("scheduled", "N/m", 1.5, "Stiffness a unit of the schedule"),
            parameter("start", "m", 0.1, "Position of the first mass"),
            parameter("masses", "1", 2.0, "Number of masses"),
            parameter("band", "rad/s", 3.0, "Band"),
        ),
        calculated=tuple(calculated(name, "1", "Found") for name in Calculated._fields),
        inputs=(entry("force", "N", 0.0, "Force"), entry("pace", "1", 0.0, "Schedule", min=0.0)),
        outputs=(
            output("first", "m", "First", rate=True, depends=("force", "pace")),
            output("last", "m", "Last", rate=True, depends=("force", "pace")),
            output("growth", "1/s", "Growth", depends=("pace",)),
            output("product", "N.s.m", "Nonlinear", depends=("force",)),
        ),
    )  # fmt: skip
