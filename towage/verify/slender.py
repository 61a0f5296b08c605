"""The reference cases of the towed slender body, computed with the models of towage.

Inputs carry the symbols of the thesis (lam, Lam, al, eps, ecf, ecd, beta, nu, u; f1, f2, c1 of the old theory); frequencies
are omega = -i s with Re >= 0, as [re, im], unstable where im < 0. Each function takes the ``inputs`` of a case and its
``expected`` values and returns what it computed.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from scipy.optimize import linear_sum_assignment

from towage.models.numeric.ops import FLOATS
from towage.models.slender import body as slender_body
from towage.models.slender import critical as slender_critical
from towage.models.slender import rigid as slender_rigid
from towage.models.slender.coefficients import Body
from towage.models.slender.modes import matrices, spectrum
from towage.models.slender.setup import Parameters

Values = Mapping[str, Any]
SPEEDS = 14.0
"""Tow speed u up to which critical speeds are looked for, as in the thesis."""


def body(inputs: Values) -> Body:
    """The body of a case. ``published_signs`` = false means the corrected ones."""
    theory = inputs.get("theory", "present")
    if theory == "present" and not inputs.get("published_signs", True):
        theory = "corrected"
    return Body(
        end_length=inputs["lam"], rope_length=inputs["Lam"], tail_cut=inputs["al"], slenderness=inputs["eps"],
        friction=inputs["ecf"], normal_drag=inputs.get("ecd", 0.0), mass_ratio=inputs.get("beta", 0.5),
        damping=inputs.get("nu", 0.0), theory=theory, nose_factor=inputs.get("f1", 1.0),
        tail_factor=inputs.get("f2", 1.0), nose_drag=inputs.get("c1", 0.0),
    )  # fmt: skip


def _omega(s: complex) -> list[float]:
    return [float(s.imag), -float(s.real)]


def integrals(inputs: Values, expected: Values) -> Values:
    """Shape numbers, end integrals, tension and base drag, all dimensionless."""
    made = body(inputs).ends
    values = made.shape._asdict()
    for number, end in (("1", made.nose), ("2", made.tail)):
        values |= {f"{name}{number}0": value for name, value in end._asdict().items()}
    return {**values, "P_tension_over_half_rhoU2S": made.tension, "C_DB": made.base_drag}


def spectra(inputs: Values, expected: Values) -> Values:
    """The modes of smallest frequency, omega tau, at one tow speed u."""
    count = len(expected.get("omega", range(6)))
    return {"omega": [_omega(s) for s in spectrum(matrices(body(inputs)), inputs["u"], count)]}


def yaw_critical(inputs: Values, expected: Values) -> Values:
    """The lowest tow speeds, u, at which a body begins or ends to yaw away."""
    speeds = slender_critical.yaw(body(inputs), SPEEDS)
    return {"u": speeds[: len(expected.get("u", speeds))]}


def oscillatory_critical(inputs: Values, expected: Values) -> Values:
    """Oscillatory critical points [u, omega]. There are more than the cases list (regained stability beyond u = 10): of
    all, those that belong to the expected ones, in their order."""
    points = [[c.u, c.omega] for c in slender_critical.oscillatory(body(inputs), SPEEDS)]
    return {"u_omega": _in_order(points, expected.get("u_omega", []))}


def rigid(inputs: Values, expected: Values) -> Values:
    """Quartic and frequencies of the rigid body, time unit L/U; a set of frequencies has no order but the expected."""
    made = body(inputs)
    exponents = [_omega(s) for s in slender_rigid.exponents(made)]
    return {"quartic_s": slender_rigid.quartic(made).tolist(), "omega": _in_order(exponents, expected.get("omega", []))}


def _in_order(computed: list[list[float]], wanted: list[list[float]]) -> list[list[float]]:
    """The points of ``computed`` that lie nearest to those of ``wanted``, in their order; all where nothing is wanted."""
    if not wanted or len(computed) < len(wanted):
        return computed
    distance = np.linalg.norm(np.array(computed)[None, :, :] - np.array(wanted, dtype=float)[:, None, :], axis=2)
    return [computed[k] for k in linear_sum_assignment(distance)[1]]


def time_domain(inputs: Values, expected: Values) -> Values:
    """Forces, N, and motions, m and rad, of the unit after a lateral step of the craft at t = 0 and one exact step to t."""
    made = body(inputs)
    length, diameter, stiffness = inputs["L"], inputs["D"], inputs["EI"]
    fluid = inputs["rho"] * 0.25 * math.pi * diameter**2
    total = fluid / made.mass_ratio
    p = Parameters(
        length=length, diameter=diameter, bending_stiffness=stiffness,
        structural_damping=made.damping * math.sqrt(stiffness * total) * length**2, mass_per_length=total - fluid,
        water_density=inputs["rho"], end_length=made.end_length * length, tail_length=0.0,
        tail_cut=made.tail_cut,
        rope_length=made.rope_length * length, friction_coefficient=made.friction * diameter / length,
        normal_drag_coefficient=made.normal_drag * diameter / length,
        theory=float(("present", "corrected", "modified_old").index(made.theory)), nose_factor=made.nose_factor,
        tail_factor=made.tail_factor, nose_drag=made.nose_drag, flexible=float(inputs["n"] > 2),
        shape_functions=float(max(4, inputs["n"])), fast_mode_damping=inputs.get("fast_mode_damping", 0.0),
        lateral_start=0.0, yaw_start=0.0, slope_limit=0.2, buoyancy_limit=0.1,
    )  # fmt: skip
    speed, w, t = float(inputs["U"]), float(inputs["craft_lateral_step"]), float(inputs["t"])
    model = slender_body.SLENDER_BODY
    x, modes = model.initial(p, FLOATS)
    assert model.advance is not None
    x = model.advance(0.0, t, x, modes, model.Inputs((speed, 0.0, 0.0, 0.0), (w, 0.0, 0.0, 0.0)), p, FLOATS)
    outputs = model.outputs(
        t, x, modes, slender_body.Inputs(speed, w), slender_body.Inputs(0.0, 0.0), p, FLOATS
    )
    return {
        "T": outputs.tension, "Fx_on_craft": outputs.tension, "Fy_on_craft": outputs.lateral_force, "tip": outputs.tip,
        "tail": outputs.tail, "rope_angle": outputs.rope_angle, "yaw_angle": outputs.yaw_angle,
    }  # fmt: skip


SOLVERS: dict[str, Callable[[Values, Values], Values]] = {
    "integrals": integrals,
    "spectrum": spectra,
    "yaw_critical": yaw_critical,
    "oscillatory_critical": oscillatory_critical,
    "rigid": rigid,
    "time_domain": time_domain,
}
"""Function by kind of case."""
