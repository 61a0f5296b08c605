"""Steady state and motion along a tow cable, as OMWAY and OMFLO tabulate them."""

from __future__ import annotations

import cmath
import math

import numpy as np

from towage.models.cable.case import Tow
from towage.models.cable.steady.perturbation import Excitation
from towage.models.cable.steady.response import respond

Row = dict[str, float]
STATIONS = 20
"""As many as the source's samples print."""


def along(tow: Tow, omega: float, excitation: Excitation, stations: int = STATIONS) -> list[Row]:
    """A row a station, from the body (the source's J = 1) to the towpoint, equally far apart.

    ``frequency_hz``, ``distance`` from the body, m; steady ``angle``, rad, ``tension``, N, ``normal_flow`` and
    ``tangential_flow`` U0 and V0, m/s, ``x`` and ``y`` forward of and above the body, m; magnitude and ``_phase`` (rad,
    q = magnitude cos(omega t - phase)) of the amplitudes ``angle1``, rad, ``tension1``, N, ``normal1`` and ``tangential1``
    (the physical U and V, m/s), ``x1`` and ``y1`` relative to the body, m. The printed program tabulates x1 and y1 of
    single segments instead of their sum."""
    r = respond(tow, omega, excitation)
    steady, x_of, y_of = r.steady, *r.configuration
    normal, tangential = r.velocity
    rows = []
    for distance in map(float, np.linspace(0.0, tow.cable.length, stations)):
        angle, tension, x, y = steady.at(distance)
        row = {
            "frequency_hz": omega / (2.0 * math.pi), "distance": distance, "angle": angle, "tension": tension,
            "normal_flow": tow.speed * math.sin(angle), "tangential_flow": tow.speed * math.cos(angle), "x": x, "y": y,
        }  # fmt: skip
        element, weights = steady.place(distance)
        amplitudes = (r.angle, r.tension, normal, tangential, x_of, y_of)
        for name, values in zip(("angle1", "tension1", "normal1", "tangential1", "x1", "y1"), amplitudes):
            amplitude = complex(weights @ values[element])
            row[name], row[f"{name}_phase"] = abs(amplitude), cmath.phase(amplitude)
        rows.append(row)
    return rows
