"""Frequency response by shooting, as the source solves it: kept to show where that fails, not for use.

Two solutions of y' = A(s) y are integrated from the body to the towpoint: mode A starts with a normal, mode B with a
tangential velocity, both with the angle and tension that the body's conditions [39] [40] give them (in Quadrant II a
third, with the body's oscillating forces alone). They are superposed to meet the towpoint's conditions [45]-[50].

Both modes grow along the cable like the fastest solution and become parallel; with condition number k of the two at the
towpoint the answer carries a relative error of about 1e-16 k. `respond_by_shooting` warns once that error passes
`LOST`. Measured against collocation: 600 ft at 0.8 Hz 3e-10, 1200 ft 3e-5, 600 ft at 5 Hz 0.35, 5 km from 0.1 Hz no
digit. The source's own program stops far earlier, at its frozen coefficients (first order, 0.1 to 5 %).

Source: small-perturbation report on towed cables, Equations [45]-[50], programs OMWAY and OMFLO; coefficients here are
exact, the integrator is of order 8.
"""

from __future__ import annotations

import math
import warnings

import numpy as np
from scipy.integrate import solve_ivp

from ...numeric.arrays import Array, ComplexArray
from ..case import CableError, Tow
from .perturbation import Excitation, Response, body_rows, coefficients, towpoint_values
from .response import check_frequency, mesh
from .steady import Steady, slopes

LOST = 1e-6
"""Estimated relative error from which the modes count as dependent."""


class LostIndependence(UserWarning):
    """The shooting modes have become parallel; the response is not to be trusted."""


def respond_by_shooting(
    tow: Tow, omega: float, excitation: Excitation, state: Steady | None = None
) -> tuple[Response, float]:
    """(response at the nodes of ``state``, by default those of `mesh`; condition number of the modes at the towpoint).
    Warns `LostIndependence`."""
    check_frequency(omega)
    state = state or mesh(tow, omega)
    velocity = omega * tow.cable.length
    scale = np.array([1.0, tow.end_tension, velocity, velocity])
    rows, side = body_rows(tow, omega, excitation)
    start = np.zeros((4, 3), dtype=complex)
    start[2, 0] = start[3, 1] = velocity
    known = np.linalg.solve(rows[:, [0, 1]], np.column_stack([-rows[:, 2:] @ start[2:, :2], side]))
    start[:2] = known
    start = start / scale[:, None]

    def rates(s: float, z: Array) -> Array:
        steady_rates = slopes(tow, z[0], z[1])
        matrix = coefficients(tow, omega, z[0], z[1]) * scale / scale[:, None]
        modes = z[2:].view(complex).reshape(4, 3)
        return np.concatenate([steady_rates, (matrix @ modes).ravel().view(float)])

    initial = np.concatenate([[tow.end_angle, math.log(tow.end_tension)], start.ravel().view(float)])
    left, right = state.edges[:-1, None], state.edges[1:, None]
    nodes = -np.cos(np.pi * np.arange(state.angle.shape[1]) / (state.angle.shape[1] - 1))
    points = 0.5 * (left + right) + 0.5 * (right - left) * nodes
    points[:, 0], points[:, -1] = state.edges[:-1], state.edges[1:]
    times, index = np.unique(points.ravel(), return_inverse=True)
    solution = solve_ivp(rates, (0.0, tow.cable.length), initial, "DOP853", rtol=1e-12, atol=1e-14, t_eval=times)
    if not solution.success or not np.all(np.isfinite(solution.y)):
        raise CableError(f"shooting failed: {solution.message}")
    modes = np.ascontiguousarray(solution.y[2:].T).view(complex).reshape(-1, 4, 3)
    top = modes[-1]
    condition = float(np.linalg.cond(top[:, :2] / np.linalg.norm(top[:, :2], axis=0)))
    wanted = towpoint_values(omega, float(state.angle[-1, -1]), excitation) / velocity
    weights = np.linalg.lstsq(top[2:, :2], wanted - top[2:, 2], rcond=None)[0]
    error = 1e-16 * condition
    if error > LOST:
        warnings.warn(
            f"the two shooting modes have lost their independence (condition {condition:.1e}, expected error "
            f"{error:.0e}): use the default method",
            LostIndependence,
            stacklevel=2,
        )
    fields: ComplexArray = ((modes @ np.append(weights, 1.0)) * scale)[index.reshape(points.shape)]
    return Response(state, omega, fields[..., 0], fields[..., 1], fields[..., 2], fields[..., 3]), condition
