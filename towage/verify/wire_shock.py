"""Reference cases of the nonlinear wire with fronts: loads that snap, bodies that strike.

A front is spread over an element or so by internal damping, which has to be given for that; the times of steps follow the
waves, not an error.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from towage.models.cable.wire.chain import Chain
from towage.models.cable.wire.mesh import uniform_mesh
from towage.models.cable.wire.parts import Wire, uniform_flow
from towage.models.cable.wire.stepper import State, Stepper, consistent
from towage.models.numeric.arrays import Array
from towage.verify.wire import dimensions_of, steady_chain, wire_of
from towage.verify.wire_path import Path

Values = Mapping[str, Any]
SNAP_ELEMENTS, SNAP_DAMPING, SNAP_STEP = 60, 0.02, 0.02
IMPACT_ELEMENTS, IMPACT_DAMPING = 100, 0.05
"""Internal damping: share of sqrt(EA m) l, l an element. The peak of a snap falls with the width of its front: 2.70, 2.90 and
2.94 MN with (40, 0.1), (40, 0.02) and (60, 0.02); the undamped limit is 3.14 MN (``tests/models/test_wire_snap.py``)."""


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
        top = chain.needed(state.position, state.velocity, state.acceleration, drive)[-1, -1]
        rows.append((t, float(top), float(pulls[0, 0]), float(pulls.min())))
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
