"""Responses of the vessel of scene `cage_300m` by panels (capytaine): `python benchmarks/vessel.py OUT.csv`.

    pip install capytaine                                   # no dependency of towage

The full hull of ``strip_theory.py``, 80 x 18 x 5 m, without speed in deep water, free in all degrees with the mass of its
displacement; no damping but the waves'. Irregular frequencies are kept away by a lid. Only surge, heave and pitch are written:
roll without viscous damping would be wrong, and a point on the centre line feels none of it in heave.
"""

from __future__ import annotations

import sys

import capytaine as cpt
import numpy as np
import xarray as xr

from benchmarks.strip_theory import GRAVITY, HULLS, WATER, surface

OMEGA = np.round(np.concatenate([np.arange(0.2, 1.6, 0.05), np.arange(1.6, 2.61, 0.1)]), 3)
HEADINGS = np.arange(0.0, 181.0, 15.0)


def responses() -> xr.DataArray:
    """Motions per metre of wave, Re(X exp(-i w t)), in m/m and rad/m."""
    length, breadth, draught, offset = HULLS["full"]
    mesh = surface(length, breadth, draught, offset, 40, 16)
    body = cpt.FloatingBody(
        mesh, lid_mesh=mesh.generate_lid(faces_max_radius=1.5), dofs=cpt.rigid_body_dofs(rotation_center=(0.0, 0.0, 0.0)),
        center_of_mass=(0.0, 0.0, 0.0), name="vessel",
    )  # fmt: skip
    mass = WATER * float(mesh.volume)
    inertia = np.diag([mass] * 3 + [mass * (0.35 * breadth) ** 2] + [mass * (0.25 * length) ** 2] * 2)
    dofs = list(body.dofs)
    body.inertia_matrix = xr.DataArray(inertia, dims=("influenced_dof", "radiating_dof"),
                                       coords={"influenced_dof": dofs, "radiating_dof": dofs})  # fmt: skip
    body.hydrostatic_stiffness = body.compute_hydrostatic_stiffness(rho=WATER, g=GRAVITY)
    test = xr.Dataset(coords={
        "omega": OMEGA, "wave_direction": np.radians(HEADINGS), "radiating_dof": dofs, "rho": [WATER], "g": [GRAVITY],
        "water_depth": [np.inf],
    })  # fmt: skip
    return cpt.post_pro.rao(cpt.BEMSolver().fill_dataset(test, body, hydrostatics=True, progress_bar=False)).squeeze()


def main() -> None:
    """Writes the CSV file."""
    rao = responses()
    units = {"Surge": "m/m", "Heave": "m/m", "Pitch": "rad/m"}
    heads = ",".join(f"{name.lower()}_{part} [{unit}]" for name, unit in units.items() for part in ("re", "im"))
    lines = [
        f"# Box-like supply vessel, 80 x 18 x 5 m, Cb 0.78, no speed: capytaine {cpt.__version__}, benchmarks/vessel.py",
        f"frequency [rad/s],direction [deg],{heads}",
    ]
    for heading in HEADINGS:
        for omega in OMEGA:
            at = rao.sel(omega=omega, wave_direction=np.radians(heading))
            values = [complex(at.sel(radiating_dof=name)) for name in units]
            cells = [f"{part:.5g}" for value in values for part in (value.real, value.imag)]
            lines.append(",".join([f"{omega:g}", f"{heading:g}", *cells]))
    with open(sys.argv[1], "w", encoding="utf-8") as file:
        file.write("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
