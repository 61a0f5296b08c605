"""Elastic tow cable alone: velocities of both ends in, forces on both ends out.

    x' = A x + B (u, d),  d' = v_body - v_top,  y = C x + D (u, d) + E (u, d)'        (``cable_linear.py``)

| symbol | meaning | unit |
|---|---|---|
| u | velocities of towpoint and body in the towing frame | m/s |
| d | displacement of the body relative to the towpoint, integrated inside | m |
| y | change of the force on the towpoint and on the body | N |

Steady tow plus small perturbation; the steady state is that of the cable with the body that the parameters describe.
Steps are exact for velocities that are cubics of time. A cable of constant length between two prescribed ends is not
offered: it is over-determined as it straightens, and finite EA governs there.

States: x (modal where reduced), d (2), and u''.

Assumptions: (1) small perturbations, margins tell how small; (2) of ``cable_case.py``.

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
    """SI. ``segments`` 0: as many as ``tolerance`` needs up to ``band``, rad/s."""

    segments: float
    tolerance: float
    band: float
    reduced: float


class Modes(NamedTuple):
    """No branches."""


class Inputs(NamedTuple):
    """Velocities in the towing frame, m/s, forward and up."""

    top_velocity_surge: float
    top_velocity_heave: float
    body_velocity_surge: float
    body_velocity_heave: float


class Outputs(NamedTuple):
    """Reactions: excess of the pull on the towpoint, aft and down; forces: change of the pull on the body, forward and
    up; N."""

    reaction_surge: float
    reaction_heave: float
    body_force_surge: float
    body_force_heave: float
    tension_top: float
    tension_body: float
    offset_surge: float
    offset_heave: float
    margin_small_perturbation: float
    margin_slack: float
    margin_flow: float
    margin_quadrant: float
    margin_resolution: float
    reaction_surge_rate: float
    reaction_heave_rate: float
    body_force_surge_rate: float
    body_force_heave_rate: float
    tension_top_rate: float


class Calculated(NamedTuple):
    """What was chosen and found at the start."""

    port_stiffness: float
    steady_tension_top: float
    steady_tension_body: float
    states: float
    segments_used: float
    model_error: float


@lru_cache(maxsize=16)
def prepare(p: Parameters) -> Prepared:
    """The model for the parameters. Raises `CableError`."""
    tow = tow_of(p)
    chosen = choose(tow, True, p.band, p.tolerance, int(p.segments), p.reduced > 0.5, with_body=False)
    return Prepared(tow, chosen, 4)


def problem(p: Parameters) -> str:
    """Why the parameters make no sense; empty if they do."""
    if not p.axial_stiffness > 0.0:
        return (
            "axial_stiffness is 0: a cable of constant length between two prescribed ends is over-determined as it "
            "straightens; expected a positive axial stiffness EA, or the unit tow_system"
        )
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
    """Exact step of length ``h``, s; the offset is a polynomial of degree 4 over it."""
    prepared = prepare(p)
    n = len(prepared.model.a)
    c = np.zeros((5, 6))
    c[:4, :4] = np.array(coefficients).T
    c[0, 4:] = x[n : n + 2]
    c[1:, 4:] = (c[:4, 2:4] - c[:4, 0:2]) / np.array([[1.0], [2.0], [3.0], [4.0]])
    after = step_of(prepared, h).advance(np.array(x[:n]), c)
    powers = np.array([1.0, h, h * h, h**3, h**4])
    second = [2.0 * a[2] + 6.0 * a[3] * h for a in coefficients]
    return (*after.tolist(), *(powers @ c[:, 4:]).tolist(), *second)


def outputs(
    t: float, x: Sequence[float], m: Modes, u: Sequence[float], du: Sequence[float], p: Parameters, ops: Ops
) -> Outputs:
    """All observables."""
    prepared = prepare(p)
    n = len(prepared.model.a)
    offset, second = x[n : n + 2], x[n + 2 :]
    all_u = (*u, *offset)
    all_du = (*du, u[2] - u[0], u[3] - u[1])
    y, rate, slack, quadrant = observe(prepared, x[:n], all_u, all_du, (*second, du[2] - du[0], du[3] - du[1]))
    body, top = prepared.end_tension
    turn = float(prepared.values[-1] @ np.array([*x[:n], *all_u, *all_du]))
    return Outputs(
        -y[0], -y[1], y[2], y[3], top + y[7], body + y[6], offset[0], offset[1],
        speed_margin(p.tow_speed, p.perturbation_limit, u[:2], u[2:]), slack, flow_margin(prepared, u, turn), quadrant,
        1.0 - prepared.chosen.error / p.tolerance, -rate[0], -rate[1], rate[2], rate[3], rate[7],
    )  # fmt: skip


def calculated(p: Parameters, ops: Ops) -> Calculated:
    """``port_stiffness``: the largest force on the body at once per displacement of it."""
    prepared = prepare(p)
    direct = prepared.model.d[2:4, 4:6]
    return Calculated(
        float(np.linalg.norm(direct, 2)), prepared.end_tension[1], prepared.end_tension[0],
        float(len(prepared.model.a)), float(prepared.chosen.nodes), prepared.chosen.error,
    )  # fmt: skip
