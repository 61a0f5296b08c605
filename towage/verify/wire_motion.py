"""The reference cases of the nonlinear wire in motion: turns, seas, payout, deep lifts, snap loads, impacts.

In the frame of the water, from the steady state; inputs as ``wire.py``. Times of a case's corners (the ends of a turn and of
ramps) are ends of steps, since a step across a jump of curvature has no order.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from towage.models.cable.case import CableError
from towage.models.cable.wire.chain import Chain, Drive, uniform_mesh
from towage.models.cable.wire.parts import Wire, uniform_flow
from towage.models.cable.wire.stepper import State, Stepper, consistent
from towage.models.cable.wire.tableaus import FOURTH
from towage.models.numeric.arrays import Array
from towage.verify.wire import along, dimensions_of, steady_chain, vector, whole, wire_of

Values = Mapping[str, Any]
TOLERANCE = 5e-6
"""Error of the velocities a step, over the largest speed of the case."""
PERIOD_STEPS = 60
SNAP_ELEMENTS, SNAP_DAMPING, SNAP_STEP = 40, 0.1, 0.02
IMPACT_ELEMENTS, IMPACT_DAMPING = 100, 0.05


def smooth(x: float) -> tuple[float, float, float]:
    """S = x^3 (10 - 15 x + 6 x^2) between 0 and 1, and its two derivatives."""
    if not 0.0 < x < 1.0:
        return (0.0 if x <= 0.0 else 1.0), 0.0, 0.0
    return x**3 * (10.0 - 15.0 * x + 6.0 * x * x), 30.0 * x * x * (1.0 - x) ** 2, 60.0 * x * (1.0 - x) * (1.0 - 2.0 * x)


def smooth_integral(x: float) -> float:
    """Of S from 0 to x."""
    y = min(max(x, 0.0), 1.0)
    return y**4 * (2.5 - 3.0 * y + y * y) + max(x - 1.0, 0.0)


@dataclass(frozen=True)
class Path:
    """What a case does to its wire, by its ``inputs``."""

    inputs: Values
    dimensions: int

    def _steady(self, t: float) -> tuple[Array, Array, Array]:
        top, zero = self.inputs["top"], np.zeros(3)
        c, r, u, a = float(top["speed"]), zero.copy(), zero.copy(), zero.copy()
        r[0], u[0] = c * t, c
        if "turn" in top and t > 0.0:
            radius, whole_angle = top["turn"]["radius"], top["turn"]["angle"]
            angle = min(c * t / radius, whole_angle)
            r[:2] = radius * math.sin(angle), radius * (1.0 - math.cos(angle))
            u[:2] = c * math.cos(angle), c * math.sin(angle)
            r += u * max(0.0, t - whole_angle * radius / c)
            if c * t / radius < whole_angle:
                a[:2] = -c * u[1] / radius, c * u[0] / radius
        elif "final_speed" in top:
            more, rise = top["final_speed"] - c, top["rise_time"]
            r[0] += more * rise * smooth_integral(t / rise)
            s, slope, _ = smooth(t / rise)
            u[0], a[0] = c + more * s, more * slope / rise
        return r, u, a

    def _oscillation(self, t: float) -> tuple[float, float, float]:
        """Of S(t/ramp) sin(omega t), and its derivatives."""
        top = self.inputs["top"]
        ramp, omega = float(top.get("ramp_time", 0.0)), float(top["omega"])
        s, s1, s2 = smooth(t / ramp) if ramp > 0.0 else (1.0, 0.0, 0.0)
        s1, s2 = (s1 / ramp, s2 / ramp**2) if ramp > 0.0 else (0.0, 0.0)
        sine, cosine = math.sin(omega * t), math.cos(omega * t)
        return (
            s * sine, s1 * sine + s * omega * cosine, s2 * sine + 2.0 * s1 * omega * cosine - s * omega**2 * sine,
        )  # fmt: skip

    def paid(self, t: float) -> tuple[float, float, float]:
        """Wire paid out, its rate and change."""
        plan = self.inputs.get("payout")
        if plan is None:
            return 0.0, 0.0, 0.0
        rate, ramp = plan["rate"], plan["ramp_time"]
        on, off = t / ramp, (t - (plan["total_time"] - ramp)) / ramp
        length = rate * ramp * (smooth_integral(on) - smooth_integral(off))
        first, last = smooth(on), smooth(off)
        return length, rate * (first[0] - last[0]), rate / ramp * (first[1] - last[1])

    def __call__(self, t: float) -> Drive:
        """At time t, s."""
        top, d = self.inputs["top"], self.dimensions
        r, u, a = self._steady(t)
        if "amplitude" in top:
            size = np.array(top["amplitude"], float)
            r, u, a = (x + size * y for x, y in zip((r, u, a), self._oscillation(t)))
        r = r + np.array(top["position"], float)
        lower = None
        if "lower_end" in self.inputs:
            held = np.array(self.inputs["lower_end"]["position"], float)
            c = np.array([float(top["speed"]), 0.0, 0.0])
            lower = vector(held + c * t, d), vector(c, d), np.zeros(d)
        return Drive(vector(r, d), vector(u, d), vector(a, d), self.paid(t), None, lower)

    @property
    def corners(self) -> list[float]:
        """Times at which a derivative of the path jumps, s."""
        top, plan = self.inputs["top"], self.inputs.get("payout")
        found = [float(top[key]) for key in ("ramp_time", "rise_time") if key in top]
        if "turn" in top:
            found.append(top["turn"]["angle"] * top["turn"]["radius"] / top["speed"])
        if plan is not None:
            found += [plan["ramp_time"], plan["total_time"] - plan["ramp_time"], plan["total_time"]]
        return found

    @property
    def speed(self) -> float:
        """The largest of the case, m/s."""
        top, plan = self.inputs["top"], self.inputs.get("payout") or {"rate": 0.0}
        swing = float(np.abs(top.get("amplitude", (0.0,))).max()) * float(top.get("omega", 0.0))
        return max(float(top["speed"]), float(top.get("final_speed", 0.0)), swing, abs(plan["rate"]))


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
    shape, free = state.position.shape, chain.free
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
    assert shape == states[0].position.shape
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


def _damping(wire: Wire, elements: int, share: float) -> float:
    part = wire.sections[0]
    return share * math.sqrt(part.axial_stiffness * part.mass) * wire.length / elements


def snap(inputs: Values) -> dict[str, Any]:
    """A load that goes slack and is caught again; the front that runs up the wire is spread by internal damping."""
    damping = _damping(wire_of(inputs), SNAP_ELEMENTS, SNAP_DAMPING)
    chain, frame, r = steady_chain(inputs, SNAP_ELEMENTS, damping)
    path, until, t = Path(inputs, chain.dimensions), float(inputs["snap"]["until"]), 0.0
    u, a = frame.motion(r)
    state, stepper = State(r + path(0.0).position, u, a), Stepper(chain, 1e-3 * path.speed, SNAP_STEP)
    rows = []
    while t < until - 1e-9:
        state, h = stepper.step(t, min(SNAP_STEP, until - t, state.step or SNAP_STEP), state, path)
        t += h
        drive = path(t)
        lower = chain.pulls(state.position, state.velocity, state.acceleration, drive)[0, 0]
        up = state.position[1] - state.position[0]
        top = chain.needed(state.position, state.velocity, state.acceleration, drive)[-1]
        rows.append((t, float(lower @ up) / float(np.linalg.norm(up)), float(np.linalg.norm(top)), state.position[0, -1]))
    times, load, tension, z = np.array(rows).T
    slack = _crossing(times, load, 0)
    end = _crossing(times, -load, int(np.searchsorted(times, slack)))
    caught = (times >= end) & (times <= end + 3.0)
    return {
        "first_slack_time": slack, "end_of_first_slack": end, "load_z_least": float(z.min()),
        "peak_tension_top_first_snap": float(tension[caught].max()),
    }  # fmt: skip


def _crossing(times: Array, values: Array, start: int) -> float:
    """First time from ``start`` on at which ``values`` fall to zero, between samples by a straight line."""
    below = np.flatnonzero(values[start:] <= 0.0)
    if not len(below):
        return math.inf
    k = max(int(below[0]) + start, 1)
    a, b = float(values[k - 1]), float(values[k])
    return float(times[k]) if a <= b else float(times[k] - (times[k] - times[k - 1]) * b / (b - a))


def impact(inputs: Values) -> dict[str, Any]:
    """A body on a straight wire is struck: waves along the bar, until a place goes slack after all have been reached."""
    d, plain = dimensions_of(inputs), wire_of(inputs)
    wire = wire_of(inputs, _damping(plain, IMPACT_ELEMENTS, IMPACT_DAMPING))
    chain = Chain(wire, uniform_mesh(wire, IMPACT_ELEMENTS, 2), uniform_flow(np.zeros(d)), d)
    speed, form = float(inputs["impact"]["speed"]), inputs["impact"]["wire"]
    s = chain.mesh.places
    r, u = np.zeros((len(s), d)), np.zeros((len(s), d))
    r[:, -1] = s - wire.length
    share = 1.0 - s / wire.length if form == "linear" else (s == 0.0).astype(float)
    u[:, -1] = -speed * share
    path = Path({"top": {**inputs["top"], "speed": 0.0}}, d)
    part = wire.sections[0]
    celerity = math.sqrt(part.axial_stiffness / part.mass)
    h = wire.length / IMPACT_ELEMENTS / celerity / 4.0
    state, stepper = consistent(chain, r, u, path(0.0)), Stepper(chain, math.inf, h)
    rows, t, scale = [], 0.0, part.axial_stiffness * speed / celerity
    reached = wire.length / celerity
    while t < 8.0 * max(*inputs["times"] or [0.0], 3.0 * reached):
        state, length = stepper.step(t, h, state, path)
        t += length
        drive = path(t)
        pulls = chain.pulls(state.position, state.velocity, state.acceleration, drive)[..., -1]
        rows.append((t, -float(chain.needed(state.position, state.velocity, state.acceleration, drive)[-1, -1]) * -1.0,
                     float(pulls[0, 0]), float(pulls.min())))  # fmt: skip
        if t > 2.0 * reached and rows[-1][3] < -0.02 * scale:
            break
    times, top, body, least = np.array(rows).T
    end = _crossing(times, least, int(np.searchsorted(times, 2.0 * reached)))
    taut = times <= end
    wanted = np.array(inputs["times"] or [])
    k, m = int(top[taut].argmax()), int(body[taut].argmax())
    return {
        "end_of_taut_time": end, "tension_top": np.interp(wanted, times, top).tolist(),
        "tension_body": np.interp(wanted, times, body).tolist(), "peak_tension_top": float(top[k]),
        "time_of_peak_top": float(times[k]), "peak_tension_body": float(body[m]), "time_of_peak_body": float(times[m]),
    }  # fmt: skip


def wire_motion(inputs: Values, expected: Values) -> Values:
    """A motion: at given times, periodic, a snap load or an impact."""
    for key, solve in (("periodic", periodic), ("snap", snap), ("impact", impact)):
        if key in inputs:
            return solve(inputs)
    return at_times(inputs)


SOLVERS: dict[str, Callable[[Values, Values], Values]] = {"wire_motion": wire_motion}
