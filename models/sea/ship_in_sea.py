"""Ship in an irregular sea: heave in waves that change slowly, plus the response of her heave oscillator to a line.

    x(t) = r(t) sum_i A_i(t) cos(phi_i(t)) + z(t),     m1 z'' + c1 z' + K1 z = -R(t)
    phi_i = x_i P - x_i^2 (cos(mu_i) C - sin(mu_i) D) + e_i
    P' = omega_p,   C' = omega_p^2 V cos(beta)/g,   D' = omega_p^2 V sin(beta)/g
    A_i = RAO(x_i omega_p, V, beta + mu_i) sqrt(2 m0 w_i)             closed form, or a table of responses

| symbol | meaning | unit |
|---|---|---|
| x | heave of the point that holds the line, positive up | m |
| x_i, w_i, e_i, mu_i | frequency over omega_p, share of m0, phase and direction of component i (`waves`) | -, -, rad, rad |
| omega_p, m0 | peak frequency, Hs^2/16 | rad/s, m2 |
| V, beta | speed; angle between the course and the waves' travel, pi = head sea | m/s, rad |
| P, C, D | integrals that carry all the phases: the Doppler shift is in the phase, not in the spectrum | rad |
| r, z, m1, c1, K1, R | ramp, response, oscillator and reaction as in `ship`, whose functions these are | |

The spectrum is never transformed to encounter frequencies, where its Jacobian is singular at omega = g/(2 V cos beta).
As x_i stays when the sea changes, a change of height, period, direction or speed makes no jump: every
``update_interval`` the unit looks at its inputs, and over the next interval amplitudes, omega_p and the rates of C and
D go over to the new sea by the ramp of `ship`. Its heave thus lags the sea by up to two intervals, its velocity
is the exact derivative of its heave, and phases between two looks are closed forms: P, C and D advance once an
interval in which the sea changes, so that ten hours drift by less than 1e-9 rad. A look is an event: what was seen is held in
modes. The sums over the components are those of `motion`.

Assumptions: those of `waves`, `heave_response` and `ship`; (1) the sea changes little in one wave period
(`margin_slow_sea`: the limit is a tenth of height, period or a radian of direction a wave period); (2) Froude number
below 0.3 (`margin_froude`); (2a) waves long against draught and length, or a table of responses that holds the sea
(`margin_strip`, `margin_response`); (3) the line's reaction moves the ship in heave alone, wherever the point is that holds it.

Sources: as in `waves`, `heave_response`, `ship`. Tables of components follow from the parameters in `STRUCTURE`, which a native
build fixes; the seed is free there too.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Annotated, NamedTuple

from ..heave import ship
from ..numeric.ops import Ops, Value
from ..numeric.oscillator import acceleration
from ..numeric.ramp import ramp
from ..protocol.model import AnyModel, Model, Requirement
from ..protocol.variables import Rate, margin, output
from . import heave_response
from .kernel import BEYOND, sea_kernel
from .looks import CALM, Inputs, Modes, State, initial, next_event_time, transition
from .motion import POINT
from .response_table import ResponseTable
from .seas import SeaTable, Shape
from .ship_parameters import STRUCTURE, Parameters
from .waves import GRAVITY

SLOW = 0.1
"""Relative change a wave period at which a sea no longer changes slowly."""
TURN = 2.0 * math.pi
LEAST_DRAUGHTS, LEAST_LENGTHS = 28.0, 1.65
"""Length of the waves at the peak, in draughts, and in ship lengths along the ship, above which the closed form's heave is within
20 % of that of panels: regular waves and seas, three hulls, three headings (``benchmarks/strip_theory.py``)."""
BEYOND_SHARE, BEYOND_SPEED = 0.05, 0.5
"""Where a table of responses ends: share of the wave energy beyond its frequencies, and m/s beyond its speeds."""


class Outputs(NamedTuple):
    """As in `ship`; ``significant_heave`` is four times the standard deviation of the heave without the line. Surge and sway are
    those of the point that holds the line; axes and signs: `response_table`."""

    heave: ship.Heave
    velocity: ship.Velocity
    free_heave: ship.FreeHeave
    significant_heave: Annotated[
        Value, output("m", "Significant heave (double amplitude) without the line", display="ft")
    ]
    surge: Annotated[Value, output("m", "Surge of the point, ahead; 0 without a table of responses", display="ft")]
    sway: Annotated[Value, output("m", "Sway of the point, to port; 0 without a table of responses", display="ft")]
    surge_velocity: Annotated[Value, output("m/s", "Surge velocity of the point, ahead", display="ft/s")]
    sway_velocity: Annotated[Value, output("m/s", "Sway velocity of the point, to port", display="ft/s")]
    roll: Annotated[Value, output("rad", "Roll, starboard down; 0 without a table of responses", display="deg")]
    pitch: Annotated[Value, output("rad", "Pitch, bow down", display="deg")]
    yaw: Annotated[Value, output("rad", "Yaw, bow to port; 0 without a table of responses", display="deg")]
    margin_sdof: Annotated[
        Value, margin("1 - |z| / (sdof_tolerance a), z the response to the line and a the significant amplitude")
    ]
    margin_froude: Annotated[Value, margin("1 - V / (0.3 sqrt(g L))")]
    margin_slow_sea: Annotated[
        Value, margin("1 - change of the sea a wave period / 0.1, the worst of height, frequency and direction")
    ]
    margin_strip: Annotated[
        Value,
        margin("1 - max(28 T, 1.65 L |cos beta|) / wave length at the peak: beyond, the closed form errs by 20 % against panels; "
               "1 with a table of responses"),
    ]
    margin_response: Annotated[
        Value,
        margin("1 - share of the wave energy beyond the frequencies of the table of responses / 5 %, or 1 - speed beyond its "
               "speeds / 0.5 m/s, the worse; 1 without a table"),
    ]
    heave_rate: Rate
    velocity_rate: Rate
    free_heave_rate: Rate
    surge_rate: Rate
    sway_rate: Rate
    surge_velocity_rate: Rate
    sway_velocity_rate: Rate
    roll_rate: Rate
    pitch_rate: Rate
    yaw_rate: Rate


Calculated = ship.Calculated


def requirements(p: Parameters, ops: Ops) -> tuple[Requirement, ...]:
    """Enough directions for the spread (`waves`)."""
    text = "directions do not resolve cos^2s with s = spreading: give more than spreading + 2 directions"
    held = "point_y: the closed form has no roll, so that a point off the centre line needs a file of responses"
    return (
        (ops.where(p.spreading >= 0.0, p.directions - p.spreading - 2.0, 1.0), text),
        (1.0 if p.responses else ops.where(ops.abs(p.point_y) > 0.0, -1.0, 1.0), held),
    )


derivatives, advance = ship.derivatives, ship.advance


def free_motion(t: Value, m: Modes, p: Parameters, signal: int, ops: Ops) -> tuple[Value, ...]:
    """A motion of `motion.SIGNALS` without the line and without the ramp, m or rad, its first three time derivatives, and its
    variance, m2 or rad2."""
    shape = Shape(
        p.components, p.peakedness, p.spreading, p.directions, p.order, p.second_share, p.second_frequency,
        p.second_peakedness, p.second_order, p.second_direction,
    )  # fmt: skip
    return ops.kernel(
        sea_kernel(shape, p.responses, p.spectrum), t, signal, *m[3:], p.update_interval, p.seed, p.length,
        p.breadth * p.block_coefficient, p.draught, p.smith_oblique, p.point_x, p.point_y, p.point_z,
    )  # fmt: skip


def outputs(t: Value, x: State, m: Modes, u: Inputs, du: Inputs, p: Parameters, ops: Ops) -> Outputs:
    """All observables. ``margin_sdof`` = 1 - |z|/(e a), a the significant amplitude of the free heave."""
    (free, free_rate, free_rate2), variance = _free(t, m, p, POINT + 2, ops)
    (surge, surge_rate, surge_rate2), _ = _free(t, m, p, POINT, ops)
    (sway, sway_rate, sway_rate2), _ = _free(t, m, p, POINT + 1, ops)
    (roll, roll_rate, _), _ = _free(t, m, p, 3, ops)
    (pitch, pitch_rate, _), _ = _free(t, m, p, 4, ops)
    (yaw, yaw_rate, _), _ = _free(t, m, p, 5, ops)
    z, z_rate = x.response, x.response_rate
    z_rate2 = acceleration(z, z_rate, u.reaction, p.mass, p.damping, p.stiffness)
    deviation = ops.sqrt(variance)
    limit = 2.0 * p.sdof_tolerance * deviation
    sdof = ops.where(limit > 0.0, 1.0 - ops.abs(z) / ops.where(limit > 0.0, limit, 1.0), 1.0)
    speed = ops.maximum(ops.abs(m.old_speed), ops.abs(m.new_speed))
    froude = 1.0 - speed / ops.sqrt(GRAVITY * p.length) / heave_response.FROUDE_LIMIT
    return Outputs(
        free + z, free_rate + z_rate, free, 4.0 * deviation, surge, sway, surge_rate, sway_rate, roll, pitch, yaw,
        sdof, froude, _slow(m, p, ops), _strip(m, p, ops), _covered(t, m, p, speed, ops),
        free_rate + z_rate, free_rate2 + z_rate2, free_rate, surge_rate, sway_rate, surge_rate2, sway_rate2,
        roll_rate, pitch_rate, yaw_rate,
    )  # fmt: skip


def _free(t: Value, m: Modes, p: Parameters, signal: int, ops: Ops) -> tuple[tuple[Value, Value, Value], Value]:
    """A motion without the line, its rate and acceleration; its variance without the ramp."""
    value, rate, rate2, _, variance = free_motion(t, m, p, signal, ops)
    r, r1, r2 = ramp(t, p.ramp_time, ops)
    return (r * value, r * rate + r1 * value, r * rate2 + 2.0 * r1 * rate + r2 * value), variance


def _strip(m: Modes, p: Parameters, ops: Ops) -> Value:
    """How far the closed form is to be trusted, in the worse of both seas; 1 in a calm."""
    if p.responses is not None:
        return 1.0
    worst: Value = 1.0
    for height, frequency, direction in (
        (m.old_height, m.old_frequency, m.old_direction), (m.new_height, m.new_frequency, m.new_direction)
    ):  # fmt: skip
        least = ops.maximum(LEAST_DRAUGHTS * p.draught, LEAST_LENGTHS * p.length * ops.abs(ops.cos(direction)))
        margin = 1.0 - least * frequency * frequency / (TURN * GRAVITY)
        worst = ops.minimum(worst, ops.where(height > CALM, margin, 1.0))
    return worst


def _covered(t: Value, m: Modes, p: Parameters, speed: Value, ops: Ops) -> Value:
    """How far the table of responses reaches."""
    if p.responses is None:
        return 1.0
    share = free_motion(t, m, p, BEYOND, ops)[0]
    slowest, fastest = p.responses.speeds[0], p.responses.speeds[-1]
    lowest, highest = ops.minimum(m.old_speed, m.new_speed), ops.maximum(m.old_speed, m.new_speed)
    off = ops.maximum(0.0, ops.maximum(slowest - lowest, highest - fastest))
    return ops.minimum(1.0 - share / BEYOND_SHARE, 1.0 - off / BEYOND_SPEED)


def _slow(m: Modes, p: Parameters, ops: Ops) -> Value:
    """1 - (relative change of height, of frequency, and of direction in rad, a peak period)/0.1, the worst of them."""
    height, frequency = ops.maximum(m.old_height, m.new_height), ops.maximum(m.new_frequency, m.old_frequency)
    waves_there = height > CALM
    of_height = ops.where(waves_there, ops.abs(m.new_height - m.old_height) / ops.maximum(height, CALM), 0.0)
    turn = ops.where(waves_there, 2.0 * ops.abs(ops.sin(0.5 * (m.new_direction - m.old_direction))), 0.0)
    change = ops.maximum(ops.maximum(of_height, ops.abs(m.new_frequency - m.old_frequency) / frequency), turn)
    return 1.0 - change * TURN / frequency / p.update_interval / SLOW


def calculated(p: Parameters, ops: Ops) -> ship.Calculated:
    """Constants of the heave oscillator, as in `ship`."""
    return ship.calculated(p, ops)


def given(responses: ResponseTable | None = None, spectrum: SeaTable | None = None) -> AnyModel:
    """The model with what files say."""
    kind = type("Given", (Parameters,), {"responses": responses, "spectrum": spectrum, "__annotations__": {}})
    return replace(SHIP_IN_SEA, Parameters=dataclass(frozen=True)(kind))


SHIP_IN_SEA: AnyModel = Model(
    "ship_in_sea",
    "Ship in an irregular sea: heave by a closed form or six motions by a table, plus the response to the line",
    Parameters, State, Modes, Inputs, Outputs, Calculated,
    initial=initial, derivatives=derivatives, advance=advance, outputs=outputs, transition=transition,
    next_event_time=next_event_time, calculated=calculated, requirements=requirements, structure=STRUCTURE,
)  # fmt: skip
