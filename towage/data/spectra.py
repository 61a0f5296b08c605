"""Measured spectra from files, as `models.sea.seas.SeaTable`.

* CSV: ``frequency`` [Hz] or [rad/s], ``density`` [m2/Hz] or [m2 s/rad]; of a directional one ``direction`` [deg] or [rad] too,
  and ``density`` [m2/Hz/deg], [m2/Hz/rad] or [m2 s/rad2]; the option ``direction`` = "clockwise" (compass) or "anticlockwise".
* netCDF: ``efth`` over freq, Hz, and dir, deg, as wavespectra writes it (m2/Hz/deg, compass); of several times or places the
  option ``select`` = { time = 3, site = 0 } takes an entry each, counted from 0.

What other formats hold (ERA5, WW3, SWAN, buoys) the package wavespectra brings into that netCDF: its readers give a data set
with ``to_netcdf``. Directions count from the mean one, which the unit's ``wave_direction`` gives. Significant height and peak
period are those of the file, and the unit's inputs start with them.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from towage import reading
from towage.data import columns
from towage.data.columns import options
from towage.data.response_csv import ANGLE
from towage.models.sea.response_table import TURN
from towage.reading import Refused

Array = NDArray[np.float64]
MAX_DENSITIES = 20_000
"""Densities of a spectrum: it is carried in the FMU."""
PER_FREQUENCY = {"m2/hz": 1.0 / TURN, "m2.s": 1.0 / TURN, "m2 s/rad": 1.0, "m2.s/rad": 1.0}
PER_BOTH = {
    "m2/hz/deg": 180.0 / math.pi / TURN, "m2/hz/rad": 1.0 / TURN, "m2 s/rad2": 1.0, "m2.s/rad2": 1.0,
}  # fmt: skip
FREQUENCY = {"hz": TURN, "rad/s": 1.0}


def read(path: Path, given: Mapping[str, Any], notes: list[str]) -> dict[str, Any]:
    """The fields of a `SeaTable`. Raises `Refused` with the place in the file, and OSError."""
    if path.suffix.lower() in (".nc", ".nc4", ".cdf"):
        options(given, ("select",))
        return _table(*_efth(path, given.get("select", {})), notes)
    options(given, ("direction",))
    table = {c.name.lower(): c for c in columns.read(path).columns}
    directional = "direction" in table
    if missing := [name for name in ("frequency", "density") if name not in table]:
        raise Refused(f"no column {missing[0]}: there are {', '.join(table)}")
    omega = _scaled(table["frequency"], FREQUENCY)
    density = _scaled(table["density"], PER_BOTH if directional else PER_FREQUENCY)
    if not directional:
        order = np.argsort(omega)
        return _table(omega[order], np.zeros(1), density[order][None], notes)
    if given.get("direction") not in ("clockwise", "anticlockwise"):
        raise Refused("direction is not given: 'clockwise' (compass) or 'anticlockwise'")
    angle = _scaled(table["direction"], ANGLE) * (-1.0 if given["direction"] == "clockwise" else 1.0)
    omegas, angles = np.unique(omega.round(9)), np.unique((angle % TURN).round(9))
    grid = np.full((len(angles), len(omegas)), np.nan)
    grid[np.searchsorted(angles, (angle % TURN).round(9)), np.searchsorted(omegas, omega.round(9))] = density
    if np.isnan(grid).any():
        j, i = np.argwhere(np.isnan(grid))[0]
        raise Refused(f"no density at {omegas[i]:g} rad/s and {math.degrees(angles[j]):g} deg: expected a whole grid")
    return _table(omegas, angles, grid, notes)


def _scaled(column: columns.Column, units: Mapping[str, float]) -> Array:
    if column.unit.lower() not in units:
        raise Refused(
            f"column {column.name!r}: its unit is {column.unit or 'not given'}: expected [{'] or ['.join(units)}]"
        )
    return units[column.unit.lower()] * column.values


def _efth(path: Path, select: object) -> tuple[Array, Array, Array]:
    """Frequencies, rad/s, directions, rad anticlockwise, and densities of `wavespectra`'s netCDF."""
    from netCDF4 import Dataset

    with reading.foreign(path, "netCDF file"), Dataset(path) as data:
        for name in ("efth", "freq"):
            if name not in data.variables:
                raise Refused(
                    f"has no variable {name}: expected a spectrum as wavespectra writes it, efth over freq and dir"
                )
        variable = data.variables["efth"]
        entry = _entry(dict(zip(variable.dimensions, variable.shape)), select)
        dims = tuple(n for n, at in zip(variable.dimensions, entry) if isinstance(at, slice))
        reading.limited(math.prod(data.dimensions[n].size for n in dims), MAX_DENSITIES, "densities of efth")
        values: Array = np.ma.filled(np.ma.asarray(variable[entry], float), np.nan)
        omega = TURN * np.asarray(data.variables["freq"][:], float)
        angle = -np.radians(np.asarray(data.variables["dir"][:], float)) if "dir" in data.variables else np.zeros(1)
    both = values.transpose([dims.index(n) for n in ("dir", "freq") if n in dims])
    scale = PER_BOTH["m2/hz/deg"] if "dir" in dims else PER_FREQUENCY["m2/hz"]
    density = scale * both.reshape(len(angle) if "dir" in dims else 1, len(omega))
    return omega, angle if "dir" in dims else np.zeros(1), density


def _entry(sizes: Mapping[str, int], select: object) -> tuple[int | slice, ...]:
    """Where one spectrum lies. Raises `Refused`."""
    others = {n: size for n, size in sizes.items() if n not in ("freq", "dir")}
    if not isinstance(select, Mapping) or set(select) - set(others):
        raise Refused(f"select = {select!r}: expected numbers of entries, from 0, of {', '.join(others) or 'nothing'}")
    for name, size in others.items():
        at = select.get(name, 0 if size == 1 else None)
        if at is None:
            raise Refused(f"efth has {size} entries of {name}: choose one: select = {{ {name} = 0 }}")
        if type(at) is not int or not 0 <= at < size:
            raise Refused(f"select: {name} = {at!r}: expected a whole number from 0 to {size - 1}")
    return tuple(int(select.get(n, 0)) if n in others else slice(None) for n in sizes)


def _table(omega: Array, angle: Array, density: Array, notes: list[str]) -> dict[str, Any]:
    """The fields; frequencies ascending, densities by direction."""
    if len(omega) < 3 or not (omega > 0.0).all() or (np.diff(np.sort(omega)) <= 0.0).any():
        raise Refused("expected three frequencies at least, above 0 and each once")
    if not np.isfinite(density).all() or (density < 0.0).any():
        raise Refused("expected finite densities, none below 0")
    reading.limited(density.size, MAX_DENSITIES, "densities")
    order, around = np.argsort(omega), np.argsort(angle % TURN)
    omega, angle, density = omega[order], (angle % TURN)[around], density[around][:, order]
    widths = _widths(angle)
    along = density.T @ widths
    m0 = float(np.trapezoid(along, omega))
    if not m0 > 0.0:
        raise Refused("a spectrum without energy")
    energies = np.trapezoid(density, omega, axis=1) * widths
    mean = math.atan2(float(energies @ np.sin(angle)), float(energies @ np.cos(angle)))
    height, peak = 4.0 * math.sqrt(m0), float(omega[np.argmax(along)])
    spread = "" if len(angle) == 1 else f", from {len(angle)} directions"
    notes.append(
        f"Hs = {height:.4g} m and Tp = {TURN / peak:.4g} s are those of the spectrum{spread}; other inputs scale it"
    )
    return {
        "frequencies": tuple(omega.tolist()),
        "directions": tuple(
            ((a - mean + math.pi) % TURN - math.pi, w) for a, w in zip(angle.tolist(), widths.tolist())
        ),
        "densities": tuple(map(tuple, density.tolist())),
        "height": height,
        "frequency": peak,
    }


def _widths(angle: Array) -> Array:
    """Half the way to both neighbours round the circle; 1 for a single direction."""
    if len(angle) == 1:
        return np.ones(1)
    ahead = np.diff([*angle, angle[0] + TURN])
    return 0.5 * (ahead + np.roll(ahead, 1))
