"""Unit `ship_in_waves`, for tests: the shipped `ship` in a sea of `COUNT` components of any amplitude, frequency and phase.

    x(t) = r(t) sum a_i cos(omega_i t + e_i) + z(t)

The response z and the rest are those of `towage.models.heave.ship`. It is built natively, so that a scene of many periods
takes a second; `ship_in_sea`, whose components are a rule's and which has no native flavour, takes four.
"""

from __future__ import annotations

from dataclasses import fields, make_dataclass
from pathlib import Path
from typing import Annotated, Any, NamedTuple

from towage.fmus.declare.unit import Unit
from towage.fmus.native.build import build_unit
from towage.models.heave import ship
from towage.models.numeric.ops import Ops, Value
from towage.models.numeric.oscillator import acceleration
from towage.models.numeric.ramp import ramp
from towage.models.protocol.model import Model
from towage.models.protocol.variables import Rate, parameter

COUNT = 16
NAMES = [name for i in range(COUNT) for name in (f"amplitude_{i}", f"frequency_{i}", f"phase_{i}")]
UNITS = ("m", "rad/s", "rad")
Parameters: Any = make_dataclass(
    "Parameters",
    [(name, Annotated[Value, parameter(UNITS[k % 3], 0.0, "Of a component of the sea")]) for k, name in enumerate(NAMES)],
    bases=(ship.Oscillator,), frozen=True,
)  # fmt: skip


class Outputs(NamedTuple):
    """As those of `ship`, without the margin."""

    heave: ship.Heave
    velocity: ship.Velocity
    free_heave: ship.FreeHeave
    heave_rate: Rate
    velocity_rate: Rate
    free_heave_rate: Rate


def outputs(t: Value, x: ship.State, m: ship.Modes, u: ship.Inputs, du: ship.Inputs, p: Any, ops: Ops) -> Outputs:
    """All observables."""
    value = rate = bend = 0.0
    for i in range(COUNT):
        a, w = getattr(p, f"amplitude_{i}"), getattr(p, f"frequency_{i}")
        angle = w * t + getattr(p, f"phase_{i}")
        along = a * ops.cos(angle)
        value, rate, bend = value + along, rate - a * w * ops.sin(angle), bend - w * w * along
    r, r1, r2 = ramp(t, p.ramp_time, ops)
    free, free_rate, free_rate2 = r * value, r * rate + r1 * value, r * bend + 2.0 * r1 * rate + r2 * value
    z, z_rate = x
    velocity = free_rate + z_rate
    z_rate2 = acceleration(z, z_rate, u.reaction, p.mass, p.damping, p.stiffness)
    return Outputs(free + z, velocity, free, velocity, free_rate2 + z_rate2, free_rate)


def initial(p: Any, ops: Ops) -> tuple[ship.State, ship.Modes]:
    """At rest."""
    return ship.State(0.0, 0.0), ship.Modes()


SHIP_IN_WAVES = Model(
    "ship_in_waves", "Ship in a sea of given components, for tests", Parameters, ship.State, ship.Modes, ship.Inputs, Outputs,
    ship.Calculated, initial=initial, derivatives=ship.derivatives, advance=ship.advance, outputs=outputs,
    calculated=ship.calculated,
)  # fmt: skip


def build(directory: Path) -> Path:
    """The native FMU in ``directory``."""
    return build_unit(Unit.of(SHIP_IN_WAVES), directory)[0]


def values(*waves: tuple[float, ...]) -> dict[str, float]:
    """Parameters of a sea of (amplitude, frequency, phase), at most `COUNT`."""
    assert len(waves) <= COUNT and fields(Parameters)
    return dict(zip(NAMES, (number for wave in waves for number in wave)))
