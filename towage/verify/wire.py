"""The reference cases of the nonlinear wire at rest: towed, hanging, held at both ends, on a steady circle.

Inputs are SI, z up and zero at the towpoint, as ``models/cable/wire``; ``sections``, ``clumps``, ``body`` or ``lower_end``,
``current`` and ``top`` as the models name them. A mesh is graded to `SHAPE` of the steady shape, so that what is compared is
the wire and not its elements. Each function takes the ``inputs`` of a case and its ``expected`` values (of which it reads the
places alone) and returns what it computed.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from towage.models.cable.loading import eames
from towage.models.cable.wire.chain import Chain, Drive
from towage.models.cable.wire.elements import lagrange
from towage.models.cable.wire.grading import graded_mesh
from towage.models.cable.wire.parts import Flow, Mass, Section, Wire, cross_flow_section, uniform_flow
from towage.models.cable.wire.rest import Frame, circled, equilibrium, march
from towage.models.numeric.arrays import Array

Values = Mapping[str, Any]
SHAPE, DEGREE, LEAST_ELEMENTS = 1e-8, 6, 6
"""Error of the steady shape on the mesh over the length; degree of the elements and their least number."""


def vector(components: Any, dimensions: int) -> Array:
    """(x, y, z) in space or in the plane (x, z)."""
    x, y, z = (float(c) for c in components)
    return np.array([x, y, z] if dimensions == 3 else [x, z])


def whole(components: Array) -> list[float]:
    """(x, y, z) of a vector in space or in the plane."""
    x, z = float(components[0]), float(components[-1])
    return [x, float(components[1]) if len(components) == 3 else 0.0, z]


def dimensions_of(inputs: Values) -> int:
    """3, or 2 where nothing leaves the vertical plane."""
    top = inputs["top"]
    sideways = [row[1] for row in (inputs.get("current") or {"u": []})["u"]] + [top.get("amplitude", (0.0, 0.0, 0.0))[1]]
    return 3 if "turn" in top or "radius" in top or any(sideways) else 2


def _mass(values: Values) -> Mass:
    return Mass(values["mass"], values["added_mass"], values["weight"], values["drag_area"])


def _section(values: Values, damping: float) -> Section:
    form = values["loading"]
    if form not in ("eames", "cross_flow"):
        raise ValueError(f'loading: expected "eames" or "cross_flow", not {form!r}')
    if form == "eames":
        drag, loading = values["normal_drag"], eames(values["friction"])
    else:
        drag, loading = cross_flow_section(values["normal_drag"], values["tangential_drag"])
    return Section(
        values["length"], values["mass"], values["weight"], values["diameter"], values["axial_stiffness"], drag, loading,
        values["added_mass_coefficient"], damping,
    )  # fmt: skip


def wire_of(inputs: Values, damping: float = 0.0) -> Wire:
    """The wire of a case, with internal ``damping``, N s. Raises `CableError`."""
    body = _mass(inputs["body"]) if "body" in inputs else None
    clumps = tuple((c["s"], _mass(c)) for c in inputs.get("clumps", ()))
    return Wire(tuple(_section(s, damping) for s in inputs["sections"]), body, inputs["water_density"], clumps)


def flow_of(inputs: Values, dimensions: int) -> Flow:
    """Its current."""
    table = inputs.get("current")
    if table is None:
        return uniform_flow(np.zeros(dimensions))
    return Flow(np.array(table["z"], float), np.array([vector((*u, 0.0), dimensions) for u in table["u"]]))


def steady_chain(inputs: Values, elements: int = LEAST_ELEMENTS, damping: float = 0.0) -> tuple[Chain, Frame, Array]:
    """(Chain, its frame, nodes relative to the top, (n, d)) of the straight tow, or of rest."""
    d = dimensions_of(inputs)
    wire, flow = wire_of(inputs, damping), flow_of(inputs, d)
    lower = vector(inputs["lower_end"]["position"], d) if "lower_end" in inputs else None
    frame = Frame(vector((inputs["top"]["speed"], 0.0, 0.0), d), 0.0, lower)
    shape = march(wire, flow, frame, d)
    mesh = graded_mesh(wire, shape, DEGREE, 0, SHAPE).mesh
    if len(mesh.lengths) < elements:
        mesh = graded_mesh(wire, shape, DEGREE, elements).mesh
    chain = Chain(wire, mesh, flow, d)
    return chain, frame, equilibrium(chain, frame, shape.position(mesh.places))


def along(chain: Chain, points: Array, s: float) -> Array:
    """Value at ``s``, m, of what is known at points, (E, p+1, d)."""
    ends = np.concatenate([[0.0], np.cumsum(chain.mesh.lengths)])
    k = min(int(np.searchsorted(ends, s, side="right")) - 1, len(ends) - 2)
    x = np.array([2.0 * (s - ends[k]) / chain.mesh.lengths[k] - 1.0])
    value: Array = (lagrange(chain.mesh.degree, x) @ points[k])[0]
    return value


def wire_steady(inputs: Values, expected: Values) -> dict[str, Any]:
    """A tow at constant speed, or rest."""
    chain, frame, r = steady_chain(inputs, 12)
    zero = np.zeros(chain.dimensions)
    drive = Drive(zero, frame.velocity, zero)
    u, a = frame.motion(r)
    top, pulls, places = chain.needed(r, u, a, drive)[-1], chain.pulls(r, u, a, drive), chain.gather(r)
    lower = pulls[0, 0]
    values = {
        "tension_top": float(np.linalg.norm(top)), "pull_on_top": whole(-top),
        "stations": [
            {"s": s, "position": whole(along(chain, places, s)), "tension": float(np.linalg.norm(along(chain, pulls, s)))}
            for s in (row["s"] for row in expected.get("stations", ()))
        ],
    }  # fmt: skip
    if chain.wire.body is not None:
        return {**values, "body_position": whole(r[0]), "tension_body": float(np.linalg.norm(lower))}
    return {
        **values, "tension_lower": float(np.linalg.norm(lower)), "pull_on_lower": whole(lower),
        "lowest_z": _least(chain, places[..., -1]), "tension_least": _least(chain, np.linalg.norm(pulls, axis=2)),
    }  # fmt: skip


def _least(chain: Chain, points: Array) -> float:
    """Least of what is known at points (E, p+1), between them too: by their polynomials, and a parabola at its samples."""
    values = (points @ lagrange(chain.mesh.degree, np.linspace(-1.0, 1.0, 401)[:-1]).T).ravel()
    k = min(max(int(values.argmin()), 1), len(values) - 2)
    a, b, c = (float(v) for v in values[k - 1 : k + 2])
    bend = a - 2.0 * b + c
    return b if bend <= 0.0 else b - (a - c) ** 2 / (8.0 * bend)


def wire_circle(inputs: Values, expected: Values) -> dict[str, Any]:
    """A steady circle of the towpoint, from the straight tow by turning more and more."""
    chain, frame, r = steady_chain(inputs, 20)
    radius, speed = float(inputs["top"]["radius"]), float(inputs["top"]["speed"])
    if not radius > 0.0:
        raise ValueError(f"radius: expected a positive number of metres, not {radius:g}")
    frame, r = circled(chain, frame, r, speed / radius)
    # the wire bends elsewhere than in the straight tow
    shape = march(chain.wire, chain.flow, frame, 3, start=r[0])
    chain = Chain(chain.wire, graded_mesh(chain.wire, shape, DEGREE, 20).mesh, chain.flow, 3)
    r = equilibrium(chain, frame, shape.position(chain.mesh.places))
    zero = np.zeros(3)
    u, a = frame.motion(r)
    drive = Drive(zero, frame.velocity, zero)
    needed = chain.needed(r, u, a, drive)
    # the top moves along x, its centre is at port
    x, y = float(r[0, 0]), float(r[0, 1]) - radius
    forward, port, up = (float(c) for c in -needed[-1])
    tension_body = float(np.linalg.norm(chain.pulls(r, u, a, drive)[0, 0]))
    lag = math.atan2(x, -y)
    return {
        "body_radius": math.hypot(x, y), "body_lag_angle": -lag if lag <= 0.0 else 2.0 * math.pi - lag,
        "body_z": float(r[0, 2]), "tension_top": float(np.linalg.norm(needed[-1])),
        "pull_on_top_radial_tangential_up": [-port, forward, up], "tension_body": tension_body,
    }  # fmt: skip


SOLVERS: dict[str, Callable[[Values, Values], Values]] = {"wire_steady": wire_steady, "wire_circle": wire_circle}
