"""The closed-form heave of `ship_in_sea` beside panels (capytaine): `python benchmarks/strip_theory.py [OUT.json]`.

    pip install capytaine                                   # no dependency of towage

Three hulls without speed in deep water, waves of a metre from ahead, the bow quarter and abeam. The hulls are free to heave,
roll and pitch, with the centre of mass in the water plane, radii of gyration 0.35 B in roll and 0.25 L in pitch, and no
damping but the waves'. What it writes is `towage/reference/strip_theory.json`, by which `margin_strip` was chosen.
"""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Callable
from itertools import pairwise

import capytaine as cpt
import numpy as np
import xarray as xr

from towage.models.numeric.ops import FLOATS
from towage.models.sea.heave_response import Hull, heave_rao

GRAVITY, WATER = 9.80665, 1025.0
HEADINGS = (180.0, 135.0, 90.0)
LENGTHS = (0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.15, 1.3, 1.5, 1.75, 2.0, 2.5, 3.0, 4.0)
"""Wave length over ship length."""


def surface(
    length: float, breadth: float, draught: float, offset: Callable[[float, float], float], nx: int, nz: int
) -> cpt.Mesh:
    """Panels of a hull with half-breadth ``offset(x, z)`` over B/2, x in -1 ... 1, z in -1 ... 0; its ends and bottom are closed
    where the offset does not vanish."""
    girth = [*np.linspace(0.0, 1.0, nz + 1)]
    stations = -np.cos(np.linspace(0.0, np.pi, nx + 1))

    def point(x: float, s: float, side: float) -> list[float]:
        # along the section from the water line down the side, then in over the bottom
        z = -min(1.0, 2.0 * s)
        y = offset(x, z) * min(1.0, 2.0 * (1.0 - s))
        return [0.5 * length * x, side * 0.5 * breadth * y, draught * z]

    vertices, faces = [], []

    def panel(corners: list[list[float]]) -> None:
        faces.append(list(range(len(vertices), len(vertices) + 4)))
        vertices.extend(corners)

    for side in (1.0, -1.0):
        for a, b in pairwise(stations):
            for s, e in pairwise(girth):
                corners = [point(a, s, side), point(a, e, side), point(b, e, side), point(b, s, side)]
                panel(corners[::-1] if side > 0 else corners)
        for x in (-1.0, 1.0):
            if offset(x, -0.5) < 1e-9:
                continue
            for s, e in pairwise(girth[: nz // 2 + 1]):
                for u, v in pairwise(np.linspace(0.0, 1.0, 5)):
                    ends = [point(x, s, side), point(x, e, side)]
                    corners = [
                        [p[0], w * p[1], p[2]] for p, w in ((ends[0], u), (ends[1], u), (ends[1], v), (ends[0], v))
                    ]
                    panel(corners if (side > 0) == (x > 0) else corners[::-1])
    return cpt.Mesh(vertices=np.array(vertices), faces=np.array(faces))


HULLS = {
    "box": (100.0, 20.0, 5.0, lambda x, z: 1.0),
    "wigley": (100.0, 14.0, 6.0, lambda x, z: (1.0 - x * x) * (1.0 - z * z)),
    "full": (80.0, 18.0, 5.0, lambda x, z: (1.0 - abs(x) ** 6) * (1.0 - abs(z) ** 10)),
}
"""L, B, T, m, and the offset. "full": a supply vessel's block, Cb near 0.78."""


def panels(name: str, nx: int = 24, nz: int = 8) -> dict[str, object]:
    """Heave by panels, by heading and wave length."""
    length, breadth, draught, offset = HULLS[name]
    mesh = surface(length, breadth, draught, offset, nx, nz)
    body = cpt.FloatingBody(
        mesh, dofs=cpt.rigid_body_dofs(rotation_center=(0.0, 0.0, 0.0)), center_of_mass=(0.0, 0.0, 0.0), name=name
    )
    volume = float(mesh.volume)
    mass = WATER * volume
    inertia = np.diag([mass] * 3 + [mass * (0.35 * breadth) ** 2] + [mass * (0.25 * length) ** 2] * 2)
    dofs = list(body.dofs)
    body.inertia_matrix = xr.DataArray(inertia, dims=("influenced_dof", "radiating_dof"),
                                       coords={"influenced_dof": dofs, "radiating_dof": dofs})  # fmt: skip
    body.hydrostatic_stiffness = body.compute_hydrostatic_stiffness(rho=WATER, g=GRAVITY)
    omega = np.sqrt(2.0 * np.pi * GRAVITY / (np.array(LENGTHS) * length))
    test = xr.Dataset(coords={
        "omega": omega, "wave_direction": np.radians(HEADINGS), "radiating_dof": dofs, "rho": [WATER], "g": [GRAVITY],
        "water_depth": [np.inf],
    })  # fmt: skip
    data = cpt.BEMSolver().fill_dataset(test, body, hydrostatics=True)
    rao = cpt.post_pro.rao(data).squeeze()
    return {"length": length, "breadth": breadth, "draught": draught, "volume": volume, "panels": mesh.nb_faces,
            "omega": omega.tolist(), "rao": rao}  # fmt: skip


def main() -> None:
    """Prints the comparison and writes it."""
    result: dict[str, object] = {"source": f"capytaine {cpt.__version__}, benchmarks/strip_theory.py", "hulls": []}
    for name in HULLS:
        found = panels(name)
        coefficient = found["volume"] / (found["length"] * found["breadth"] * found["draught"])
        hull = Hull(found["length"], found["breadth"] * coefficient, found["draught"])
        rows = []
        for heading in HEADINGS:
            for ratio, omega in zip(LENGTHS, found["omega"]):
                true = float(
                    abs(found["rao"].sel(radiating_dof="Heave", wave_direction=math.radians(heading), omega=omega))
                )
                ours = abs(heave_rao(omega, 0.0, math.cos(math.radians(heading)), hull, FLOATS))
                rows.append([heading, ratio, round(true, 5), round(ours, 5)])
                print(f"{name:8s} {heading:5.0f} {ratio:5.2f} {true:8.4f} {ours:8.4f} {ours - true:+8.4f}", flush=True)
        sizes = {k: found[k] for k in ("length", "breadth", "draught", "panels")}
        result["hulls"].append({"name": name, **sizes, "block_coefficient": round(coefficient, 4), "rows": rows})
    if len(sys.argv) > 1:
        with open(sys.argv[1], "w", encoding="utf-8") as file:
            json.dump(result, file, indent=1)


if __name__ == "__main__":
    main()
