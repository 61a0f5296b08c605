"""The reference cases of the tow cable, computed with the frequency response of towage.

The cases state their numbers in consistent units (most in feet, slugs, pounds of force): the theory does not mind.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable, Mapping
from typing import Any

from towage.models.cable.case import Body, Cable, Tow
from towage.models.cable.loading import Loading
from towage.models.cable.steady.perturbation import Excitation
from towage.models.cable.steady.response import respond

Values = Mapping[str, Any]


def tow_of(inputs: Values) -> Tow:
    """The tow that a case's inputs describe, in the units of the case. Raises ``ValueError`` and ``KeyError``."""
    if inputs["added"] not in ("report", "morison"):
        raise ValueError(f"added is {inputs['added']!r}; expected report or morison")
    cable = Cable(
        length=inputs["L"], mass=inputs["mu"], weight=inputs["w"], thickness=inputs["h"],
        drag_coefficient=inputs["CD"], loading=Loading(tuple(inputs["lam_c"]), tuple(inputs["gam_c"])),
        added_mass=inputs["nu"], momentum_form=inputs["added"] == "report",
        axial_stiffness=inputs.get("EA") or math.inf,
    )  # fmt: skip
    body = Body(
        mass=inputs["m"], added_mass_surge=inputs["ms"], added_mass_heave=inputs["mh"], weight=inputs["WB"],
        lift=inputs["LB0"], drag=inputs["DB0"], damping_surge=inputs["cDx"], damping_heave=inputs["cDy"],
    )  # fmt: skip
    return Tow(cable, body, inputs["c"], inputs["rho"], inputs["quad"])


def excitation_of(inputs: Values) -> Excitation:
    """Complex amplitudes of a case's excitation, Re(q exp(-i omega t)): motions of the towpoint, forces on the body."""
    e = inputs["excitation"]
    return Excitation(
        surge=e.get("aS", 0.0) * cmath.exp(1j * e.get("dS", 0.0)),
        heave=e.get("aH", 0.0) * cmath.exp(1j * e.get("dH", 0.0)),
        drag=complex(*e.get("D1", (0.0, 0.0))),
        lift=complex(*e.get("L1", (0.0, 0.0))),
    )


def cable_response(inputs: Values, expected: Values) -> Values:
    """Steady profile, and complex amplitudes [re, im] of angle, tension, velocities and place at both ends, in the units of
    the case."""
    tow = tow_of(inputs)
    omega = inputs.get("omega") or 2.0 * math.pi * inputs["excitation"]["f"]
    response = respond(tow, omega, excitation_of(inputs))
    profile = []
    for station in expected.get("steady", []):
        angle, tension, x, y = response.steady.at(abs(station["s_over_L"]) * tow.cable.length)
        profile.append({"s_over_L": station["s_over_L"], "T0": tension, "phi0": angle, "x0": x, "y0": y})
    fields = {
        "phi1": response.angle, "T1": response.tension, "Up": response.velocity[0], "Vp": response.velocity[1],
        "x1": response.configuration[0], "y1": response.configuration[1],
    }  # fmt: skip
    ends = {"body": (0, 0), "tow": (-1, -1)}
    return {"steady": profile} | {
        end: {name: [float(f[at].real), float(f[at].imag)] for name, f in fields.items()} for end, at in ends.items()
    }


SOLVERS: dict[str, Callable[[Values, Values], Values]] = {"cable_response": cable_response}
"""By kind."""
