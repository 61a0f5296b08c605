"""The reference cases of sea, heave response and route, computed with the models of towage.

Route cases come in nautical miles, knots, hours and feet, as their source; a heave case in SI. Each function takes the
``inputs`` of a case and its ``expected`` values and returns what it computed; an unknown field, map or polar raises
``ValueError``.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from towage.models.numeric.ops import FLOATS
from towage.models.route import plan as route
from towage.models.route import shooting as route_shooting
from towage.models.route.areas import Area, Disc
from towage.models.route.fields import Field, LinearCurrent, LinearField, StormField, UniformField
from towage.models.route.maps import FlatMap, RouteMap, StereographicMap
from towage.models.route.medium import Medium
from towage.models.route.polar import FOOT, KNOT, ConstantPolar, JamesPolar, Polar, ProportionalPolar, follow_beam_head
from towage.models.route.problem import Problem
from towage.models.sea import heave_response, waves

MILE, HOUR = 1852.0, 3600.0
Values = Mapping[str, Any]


def polar(inputs: Values, expected: Values) -> Values:
    """Ellipse and principal speeds of the default polar, kn."""
    height = inputs["wave_height_ft"] * FOOT
    a, b, c = JamesPolar().axes(height, FLOATS)[:3]
    follow, beam, head = follow_beam_head(JamesPolar(), height, FLOATS)
    centre = c / KNOT
    if isinstance(expected.get("c_kn"), int):  # an exact nought stands for the 1e-11 that the constants leave
        centre = round(centre, 9) if round(centre, 9) else 0
    return {
        "a_kn": a / KNOT, "b_kn": b / KNOT, "c_kn": centre, "v_following_kn": follow / KNOT,
        "v_beam_kn": beam / KNOT, "v_head_kn": head / KNOT,
    }  # fmt: skip


def _field(given: Any) -> Field:
    if given == "calm":
        return UniformField()
    kind = given["type"]
    if kind == "uniform":
        return UniformField(given["wave_height_ft"] * FOOT, math.radians(given["wave_angle_deg"]))
    if kind == "linear_speed":
        gx, gy = given["gradient_kn_per_nm"]
        return LinearField(given["speed0_kn"] * KNOT, (gx / HOUR, gy / HOUR), math.radians(given["wave_angle_deg"]))
    if kind == "gaussian_storm":
        (x, y), (u, v) = given["centre_nm"], given["velocity_kn"]
        return StormField(
            given["background_ft"] * FOOT, given["peak_ft"] * FOOT, (x * MILE, y * MILE), given["sigma_nm"] * MILE,
            (u * KNOT, v * KNOT), given["wave_angle_rad"], bool(given["swirl"]),
        )  # fmt: skip
    raise ValueError(f"field {kind!r}: expected calm, uniform, linear_speed or gaussian_storm")


def _polar(inputs: Values) -> Polar:
    field = inputs["field"]
    if isinstance(field, Mapping) and field["type"] == "linear_speed":
        return ProportionalPolar(field["a_factor"], field["b_factor"])
    if "speed_kn" in inputs:
        return ConstantPolar(inputs["speed_kn"] * KNOT)
    if inputs["polar"] != "P2-S2-R2":
        raise ValueError(f"polar {inputs['polar']!r}: expected P2-S2-R2")
    return JamesPolar()


def problem(inputs: Values) -> Problem:
    """The route problem of a case in SI. Raises ``ValueError`` and ``KeyError``."""
    kind = inputs["map"]
    plane: RouteMap
    if kind == "stereographic":
        plane = StereographicMap(inputs["earth_radius_km"] * 1e3)
        ends = [
            tuple(float(v) for v in plane.to_plane(*map(math.radians, inputs[f"{end}_lat_lon_deg"])))
            for end in ("start", "end")
        ]
    elif kind == "flat_nm":
        plane = FlatMap()
        ends = [tuple(v * MILE for v in inputs[end]) for end in ("start", "end")]
    else:
        raise ValueError(f"map {kind!r}: expected stereographic, flat_nm or unit")
    areas: tuple[Area, ...] = ()
    if "forbidden_disc" in inputs:
        (x, y), r = inputs["forbidden_disc"]["centre_nm"], inputs["forbidden_disc"]["radius_nm"]
        areas = (Disc(x * MILE, y * MILE, r * MILE),)
    (x0, y0), (x1, y1) = ends
    return Problem(Medium(plane, _field(inputs["field"]), _polar(inputs)), (x0, y0), (x1, y1), areas)


def _zermelo(inputs: Values) -> Values:
    """Unit speed in the shear current u = -y: the extremal from ``theta0_deg``."""
    if inputs["current"].replace(" ", "") != "u=-y,v=0":
        raise ValueError(f"current {inputs['current']!r}: expected u = -y, v = 0")
    medium = Medium(FlatMap(), UniformField(), ConstantPolar(inputs["speed"]), LinearCurrent(gradient=((0.0, -1.0), (0.0, 0.0))))
    (x0, y0), (x1, y1) = inputs["start"], inputs["end"]
    start, end = (float(x0), float(y0)), (float(x1), float(y1))
    alpha = math.radians(inputs["theta0_deg"]) + np.linspace(-0.3, 0.3, 3)
    shots = route_shooting.shoot(medium, start, end, alpha, np.full(3, 2.0 * math.dist(start, end)),
                                 iterations=30)  # fmt: skip
    if not shots.converged.any():
        raise ValueError("no start converged")
    return {"time": float(np.min(shots.time[shots.converged]))}


def saddles(given: Problem, guess: float) -> list[float]:
    """Times, s, of extremals with a conjugate point, by damped Newton steps with the true Jacobian from 15 courses,
    finished with full ones."""
    (x0, y0), (x1, y1) = given.start, given.end
    alpha = math.atan2(y1 - y0, x1 - x0) + np.linspace(-1.2, 1.2, 15)
    first = route_shooting.shoot(
        given.medium, given.start, given.end, alpha, np.full(15, guess), method="exact", fraction=0.5, steps=16,
        iterations=40, tolerance=1e-4,
    )  # fmt: skip
    near = first.converged & (first.j_exact < 0.0)
    shots = route_shooting.shoot(given.medium, given.start, given.end, first.alpha[near], first.time[near], method="exact")
    return _distinct(shots.time[shots.converged & (shots.j_exact < 0.0)])


def _distinct(times: Any) -> list[float]:
    minima: list[float] = []
    for time in np.sort(times):
        if not minima or time > minima[-1] * (1.0 + 1e-6):
            minima.append(float(time))
    return minima


def route_times(inputs: Values, expected: Values) -> Values:
    """Times, h, and the length of the geodesic, nm."""
    if inputs["map"] == "unit":
        return _zermelo(inputs)
    given = problem(inputs)
    plan = route.plan(given)
    values: dict[str, Any] = {
        "time_h": plan.best.duration / HOUR,
        "distance_nm": given.medium.map.distance(given.start, given.end) / MILE,
        "local_minima_h": [r.duration / HOUR for r in (plan.best, *plan.others)],
    }
    if "straight_h" in expected and plan.straight is not None:
        values["straight_h"] = plan.straight.duration / HOUR
    if "saddles_h" in expected:
        values["saddles_h"] = [t / HOUR for t in saddles(given, plan.best.duration)]
    return values


def wave_statistics(inputs: Values, expected: Values) -> Values:
    """Closed moments of a Pierson-Moskowitz sea of given height, m2 s^-k, its peak frequency, rad/s, and its periods, s."""
    height = inputs["Hs_m"]
    omega_p = waves.peak_frequency(height, inputs.get("Tp_s", 0.0))
    m0, m1, m2 = waves.closed_moments(height, omega_p)
    return {
        "wp": omega_p, "Tp": 2.0 * math.pi / omega_p, "m0": m0, "m1": m1, "m2": m2,
        "Tz": 2.0 * math.pi * math.sqrt(m0 / m2), "T1": 2.0 * math.pi * m0 / m1,
    }  # fmt: skip


def wave_spectrum(inputs: Values, expected: Values) -> Values:
    """JONSWAP at given frequencies, rad/s: m2 s."""
    omega_p = 2.0 * math.pi / inputs["Tp_s"]
    return {"S": [waves.spectrum(w, inputs["Hs_m"], omega_p, inputs["gamma"]) for w in inputs["omega"]]}


def _hull(inputs: Values, oblique: float = 0.0) -> heave_response.Hull:
    return heave_response.Hull(inputs["L_m"], inputs["B_eff_m"], inputs["T_m"], oblique)


def heave_rao(inputs: Values, expected: Values) -> Values:
    """Encounter frequency, rad/s, and the magnitude of the response, m a m, with both Smith factors."""
    omega, speed, g = inputs["omega"], inputs["V_m_s"], inputs.get("g", waves.GRAVITY)
    cos_beta = math.cos(math.radians(inputs["beta_deg_180_head"]))
    rao = [abs(heave_response.heave_rao(omega, speed, cos_beta, _hull(inputs, s), FLOATS, g)) for s in (0.0, 1.0)]
    omega_e = heave_response.encounter_frequency(omega, speed, cos_beta, g)
    return {"omega_e": omega_e, "rao_smith_k": rao[0], "rao_smith_ke": rao[1]}


def heave_moments(inputs: Values, expected: Values) -> Values:
    """Variances of heave, velocity and acceleration, SI, with both Smith factors."""
    height, beta = inputs["Hs_m"], math.radians(inputs["beta_deg_180_head"])
    omega_p = waves.peak_frequency(height)
    return {
        f"m0_m2_m4_smith_{name}": list(
            heave_response.heave_moments(height, omega_p, inputs["V_m_s"], beta, _hull(inputs, oblique))
        )
        for name, oblique in (("k", 0.0), ("ke", 1.0))
    }


def gauss_frequencies(inputs: Values, expected: Values) -> Values:
    """Moments 0 to 4 of the Gauss rule of a truncated spectrum, m2 s^-k."""
    omega_p = waves.peak_frequency(inputs["Hs_m"])
    band = (inputs["lo"] / omega_p, inputs["hi"] / omega_p)
    m0 = inputs["Hs_m"] ** 2 / 16.0
    rule = waves.gauss_rule(inputs["n"], 1.0, band)
    moments = [m0 * math.fsum(w * (x * omega_p) ** k for x, w in rule) for k in range(5)]
    return {"moments_0_to_4": moments, "sum_energy": m0 * math.fsum(w for _, w in rule)}


def heave_series(inputs: Values, expected: Values) -> Values:
    """A record of irregular heave, m, at the times of the case, s, its variance, m2, and the first phases, rad."""
    low, high = inputs["band"]
    sea = heave_response.components(inputs["n"], inputs["seed"], band=(low, high))
    omega_p = waves.peak_frequency(inputs["Hs_m"])
    beta, speed = math.radians(inputs["beta_deg_180_head"]), inputs["V_m_s"]
    amplitude = heave_response.heave_amplitudes(inputs["Hs_m"], omega_p, speed, beta, _hull(inputs), sea)
    rates = [heave_response.encounter_frequency(omega_p * x, speed, math.cos(beta)) for x in sea.x]
    times = expected["t"]
    heave = [math.fsum(a * math.cos(w * t + e) for a, w, e in zip(amplitude, rates, sea.phase)) for t in times]
    variance = 0.5 * math.fsum(a * a for a in amplitude)
    return {"t": times, "heave": heave, "variance": variance, "phases_first3": list(sea.phase[:3])}


def heave_short_crested(inputs: Values, expected: Values) -> Values:
    """Variance of heave, m2, in a cos^2s sea, over 96 directions."""
    omega_p = waves.peak_frequency(inputs["Hs_m"])
    fan = waves.spreading(inputs["s"], 96)
    return {
        "heave_variance": [
            math.fsum(
                share * heave_response.heave_moments(
                    inputs["Hs_m"], omega_p, inputs["V_m_s"], math.radians(beta) + mu, _hull(inputs), powers=(0,)
                )[0]
                for mu, share in fan if share > 1e-15
            )
            for beta in inputs["beta0_deg"]
        ]
    }  # fmt: skip


SOLVERS: dict[str, Callable[[Values, Values], Values]] = {
    "polar": polar,
    "route": route_times,
    "wave_statistics": wave_statistics,
    "wave_spectrum": wave_spectrum,
    "heave_rao": heave_rao,
    "heave_moments": heave_moments,
    "gauss_frequencies": gauss_frequencies,
    "heave_series": heave_series,
    "heave_short_crested": heave_short_crested,
}
"""The function that computes a kind of case: (inputs, expected) -> values."""
