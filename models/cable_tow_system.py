"""Tow cable and towed body in one linear model: towpoint velocity in, its force and the body's motion out.

    x' = A x + B u,  y = C x + D u + E u',  u = (v_surge, v_heave, drag, lift)          (``cable_linear.py``)

Steady tow plus small perturbation. The velocity of the towpoint is integrated inside; an input position beside it
would contradict it. The force contains the apparent mass -m_app a: a host that gives no derivatives of the inputs
(``*_d1``) must add m_app to the ship instead. Steps are exact for inputs that are cubics of time, of any length.

States: x (balanced or modal coordinates where reduced), displacement of the towpoint (surge, heave), m, and u''.

Assumptions: (1) small perturbations, margins tell how small; (2) of ``cable_case.py``; (3) inextensible unless asked.

Source: small-perturbation report on towed cables, in the time domain by ``cable_lumped.py``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from .cable_case import CableError
from .cable_fidelity import choose
from .cable_linear_unit import Prepared, flow_margin, observe, speed_margin, step_of
from .cable_parameters import TowParameters, tow_of
from .ops import Ops

INPUTS = 4


@dataclass(frozen=True)
class Parameters(TowParameters):
    """SI. ``segments`` 0: as many as ``tolerance`` needs up to ``band``, rad/s; ``extensible`` 1: with EA."""

    extensible: float
    segments: float
    tolerance: float
    band: float
    reduced: float


class Modes(NamedTuple):
    """No branches."""


class Inputs(NamedTuple):
    """Velocity of the towpoint in the towing frame, m/s, forward and up; change of body drag (aft) and lift, N."""

    velocity_surge: float
    velocity_heave: float
    body_drag_change: float
    body_lift_change: float


class Outputs(NamedTuple):
    """Reactions: excess of the cable's pull over its steady value, aft and down on the towpoint, N."""

    reaction_surge: float
    reaction_heave: float
    tension_top: float
    tension_body: float
    body_surge: float
    body_heave: float
    body_velocity_surge: float
    body_velocity_heave: float
    margin_small_perturbation: float
    margin_slack: float
    margin_flow: float
    margin_quadrant: float
    margin_resolution: float
    margin_inextensible: float
    reaction_surge_rate: float
    reaction_heave_rate: float
    tension_top_rate: float
    body_surge_rate: float
    body_heave_rate: float
    body_velocity_surge_rate: float
    body_velocity_heave_rate: float


class Calculated(NamedTuple):
    """What was chosen and found at the start."""

    port_mass: float
    apparent_mass_surge: float
    apparent_mass_coupling: float
    apparent_mass_heave: float
    steady_tension_top: float
    steady_tension_body: float
    steady_body_surge: float
    steady_body_heave: float
    states: float
    segments_used: float
    model_error: float
    inextensible_error: float


@lru_cache(maxsize=16)
def prepare(p: Parameters) -> Prepared:
    """The model for the parameters. Raises `CableError`."""
    tow = tow_of(p)
    chosen = choose(tow, p.extensible > 0.5, p.band, p.tolerance, int(p.segments), p.reduced > 0.5)
    return Prepared(tow, chosen, 3)


def problem(p: Parameters) -> str:
    """Why the parameters make no sense; empty if they do."""
    if p.extensible > 0.5 and not p.axial_stiffness > 0.0:
        return "extensible is 1 and axial_stiffness 0: expected a positive axial stiffness EA"
    try:
        prepare(p)
    except CableError as error:
        return str(error)
    return ""


def initial(p: Parameters, ops: Ops) -> tuple[tuple[float, ...], Modes]:
    """The steady tow."""
    return (0.0,) * (len(prepare(p).model.a) + 2 + INPUTS), Modes()


def advance(
    t: float, h: float, x: Sequence[float], m: Modes, coefficients: Sequence[Sequence[float]], p: Parameters, ops: Ops
) -> tuple[float, ...]:
    """Exact step of length ``h``, s."""
    prepared = prepare(p)
    n = len(prepared.model.a)
    c = np.array(coefficients).T
    # drag acts aft: the model's force is forward
    c[:, 2] *= -1.0
    after = step_of(prepared, h).advance(np.array(x[:n]), c)
    moved = [
        x[n + i] + h * (a[0] + h * (a[1] / 2.0 + h * (a[2] / 3.0 + h * a[3] / 4.0)))
        for i, a in enumerate(coefficients[:2])
    ]
    second = [2.0 * a[2] + 6.0 * a[3] * h for a in coefficients]
    return (*after.tolist(), *moved, *second)


def outputs(
    t: float, x: Sequence[float], m: Modes, u: Sequence[float], du: Sequence[float], p: Parameters, ops: Ops
) -> Outputs:
    """All observables."""
    prepared = prepare(p)
    n = len(prepared.model.a)
    second = x[n + 2 :]
    signed = [(v[0], v[1], -v[2], v[3]) for v in (u, du, second)]
    y, rate, slack, quadrant = observe(prepared, x[:n], *signed)
    body, top = prepared.end_tension
    chosen = prepared.chosen
    # the cable at the towpoint turns with the last segment
    turn = float(prepared.values[-1] @ np.array([*x[:n], *signed[0], *signed[1]]))
    return Outputs(
        -y[0], -y[1], top + y[7], body + y[6], x[n] + y[4], x[n + 1] + y[5], y[2], y[3],
        speed_margin(p.tow_speed, p.perturbation_limit, u), slack, flow_margin(prepared, u, turn), quadrant,
        1.0 - chosen.error / p.tolerance, 1.0 - chosen.inextensible_error / p.tolerance,
        -rate[0], -rate[1], rate[7],
        rate[4] + u[0],
        rate[5] + u[1],
        rate[2], rate[3],
    )  # fmt: skip


def calculated(p: Parameters, ops: Ops) -> Calculated:
    """What was chosen and found at the start."""
    prepared = prepare(p)
    chosen, chain = prepared.chosen, prepared.model.chain
    mass = prepared.model.apparent_mass
    body = chain.nodes[0] - chain.nodes[-1]
    return Calculated(
        float(mass[1, 1]), float(mass[0, 0]), float(mass[0, 1]), float(mass[1, 1]), prepared.end_tension[1],
        prepared.end_tension[0], float(body[0]), float(body[1]), float(len(prepared.model.a)), float(chosen.nodes),
        chosen.error, chosen.inextensible_error,
    )  # fmt: skip
