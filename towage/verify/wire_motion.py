"""The reference cases of the nonlinear wire in motion: turns, seas, payout, deep lifts, snap loads, impacts.

In the frame of the water, from the steady state; inputs as ``wire.py``, fronts in ``wire_shock.py``.
Times of a case's corners (the ends of a turn and of ramps) are ends of steps, since a step across a jump of curvature has
no order.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from towage.models.cable.case import CableError
from towage.models.cable.wire.chain import Chain
from towage.models.cable.wire.stepper import State, Stepper, consistent
from towage.models.cable.wire.tableaus import FOURTH
from towage.models.numeric.arrays import Array
from towage.verify.wire import along, steady_chain, whole
from towage.verify.wire_path import Path
from towage.verify.wire_shock import impact, snap

Values = Mapping[str, Any]
TOLERANCE = 1e-5
"""Error of the velocities a step, over the largest speed of the case."""
PERIOD_STEPS = 60


def _begun(inputs: Values, elements: int = 12) -> tuple[Chain, State, Path, Stepper]:
    """(Chain, steady state, path, stepper) of a case."""
    chain, frame, r = steady_chain(inputs, elements)
    path = Path(inputs, chain.dimensions)
    u, a = frame.motion(r)
    state = State(r + path(0.0).position, u, a)
    return chain, state, path, Stepper(chain, TOLERANCE * path.speed, tableau=FOURTH)


def _observed(chain: Chain, state: State, path: Path, t: float) -> dict[str, Any]:
    drive = path(t)
    r, u, a = state.position, state.velocity, state.acceleration
    top, lower = chain.needed(r, u, a, drive)[-1], chain.pulls(r, u, a, drive)[0, 0]
    middle = 0.5 * (chain.wire.length + drive.paid[0])
    first = chain.wire.length - chain.wire.sections[-1].length
    if middle > first:
        # places on the last section are shares of it
        grown = chain.wire.sections[-1].length / (chain.wire.sections[-1].length + drive.paid[0])
        middle = first + (middle - first) * grown
    tension = float(np.linalg.norm(top))
    return {
        "top_position": whole(drive.position), "tension_top": tension, "pull_on_top": whole(-top),
        "body_relative_to_top": whole(r[0] - drive.position), "body_z": float(r[0, -1]),
        "midpoint_relative_to_top": whole(along(chain, chain.gather(r), middle) - drive.position),
        "tension_lower": float(np.linalg.norm(lower)), "tension_body": float(np.linalg.norm(lower)),
        "length": chain.wire.length + drive.paid[0],
    }  # fmt: skip


def at_times(inputs: Values) -> dict[str, Any]:
    """Lists at ``times``."""
    chain, state, path, stepper = _begun(inputs)
    times, t, rows = [float(x) for x in inputs["times"]], 0.0, {}
    for stop in sorted({*times, *(c for c in path.corners if c < max(times))}):
        if stop > t:
            state = stepper.advance(t, stop - t, state, path)
            t = stop
        if stop in times:
            rows[stop] = _observed(chain, state, path, stop)
    return {key: [rows[time][key] for time in times] for key in rows[times[0]]}


def periodic(inputs: Values) -> dict[str, Any]:
    """The periodic state: period after period, and Newton's method for what a period leaves as it was."""
    from scipy.sparse.linalg import LinearOperator, gmres  # loads slowly

    period = float(inputs["periodic"]["period"])
    chain, state, path, stepper = _begun(inputs, 3)
    h, begin = period / PERIOD_STEPS, period * math.ceil(max(path.corners, default=0.0) / period)
    free = chain.free
    stepper.tolerance, t = 1e-2 * path.speed, 0.0

    def stepped(t: float, state: State) -> State:
        state, length = stepper.step(t, h, state, path)
        if abs(length - h) > 1e-9 * h:
            raise CableError(f"no periodic state: a step of {h:g} s fails at t = {t:g} s")
        return state

    while t < begin - 0.5 * h:
        state, t = stepped(t, state), t + h

    def after(values: Array) -> tuple[Array, list[State]]:
        r, u = state.position.copy(), state.velocity.copy()
        r[free], u[free] = values.reshape(2, *r[free].shape)
        now = consistent(chain, r, u, path(begin))
        states = [now]
        for k in range(PERIOD_STEPS):
            now = stepped(begin + k * h, now)
            states.append(now)
        return np.concatenate([now.position[free].ravel(), now.velocity[free].ravel()]), states

    x = np.concatenate([state.position[free].ravel(), state.velocity[free].ravel()])
    for _ in range(6):
        image, states = after(x)
        miss = image - x
        size = float(np.abs(miss).max())
        if size < 1e-6 * max(1e-3, path.speed):
            break

        def left(direction: Array, x: Array = x, image: Array = image) -> Array:
            scale = 1e-3 / max(float(np.abs(direction).max()), 1e-300)
            value: Array = direction - (after(x + scale * direction)[0] - image) / scale
            return value

        operator = LinearOperator((len(x), len(x)), matvec=left, dtype=float)
        x = x + gmres(operator, miss, rtol=1e-3, restart=30, maxiter=1)[0]
    else:
        raise CableError(f"no periodic state: a period still changes it by {size:.2g}")
    return _harmonics(chain, states[1:], path, begin, h, period)


def _harmonics(chain: Chain, states: list[State], path: Path, begin: float, h: float, period: float) -> dict[str, Any]:
    times = begin + h * np.arange(1, len(states) + 1)
    rows = [_observed(chain, s, path, float(t)) for s, t in zip(states, times)]
    top, load = np.array([row["tension_top"] for row in rows]), np.array([row["tension_body"] for row in rows])
    z, drive = np.array([row["body_z"] for row in rows]), np.array([row["top_position"][2] for row in rows])
    wave = np.exp(-2j * math.pi * times / period)

    def first(values: Array) -> complex:
        return complex(2.0 * np.mean(values * wave))

    def extreme(values: Array, sign: float) -> float:
        # the trigonometric polynomial through the samples, finely
        fine = np.fft.irfft(np.fft.rfft(values) * 40.0, 40 * len(values))
        return sign * float((sign * fine).max())

    ratio = first(z) / first(drive)
    return {
        "load_amplitude": abs(first(z)), "load_over_top_signed": math.copysign(abs(ratio), ratio.real),
        "tension_top_amplitude": abs(first(top)), "tension_top_max": extreme(top, 1.0),
        "tension_top_min": extreme(top, -1.0), "tension_load_min": extreme(load, -1.0),
        "tension_load_max": extreme(load, 1.0), "load_mean_z": float(z.mean()),
    }  # fmt: skip


def wire_motion(inputs: Values, expected: Values) -> Values:
    """A motion: at given times, periodic, a snap load or an impact."""
    for key, solve in (("periodic", periodic), ("snap", snap), ("impact", impact)):
        if key in inputs:
            return solve(inputs)
    return at_times(inputs)


SOLVERS: dict[str, Callable[[Values, Values], Values]] = {"wire_motion": wire_motion}
