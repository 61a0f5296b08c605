"""Responses of a ship to waves from files, in the conventions of `models.sea.response_table`.

* ``.4`` of WAMIT: period, s; heading, deg; mode 1 to 6; modulus; phase, deg; real and imaginary part. It leaves open ``ulen``, m
  (rotations are per amplitude over ULEN) and ``speed``, 0 where it is not given. Directions of travel; phases lead the crest.
* netCDF of capytaine: RAO over omega, wave_direction and radiating_dof, and forward_speed where there is one. It leaves nothing
  open: motions are Re(X exp(-i w t)), directions those of travel, rotations in rad/m.
* CSV, as of OrcaFlex: `response_csv`. Axes everywhere: x ahead, y to port, z up; roll lowers starboard, pitch the bow.

Motions that a file lacks are still, which is said. A half circle of headings is completed by a mirror, which is said too; larger
holes than `WIDEST` are refused. A grid of speeds, headings and frequencies has to be whole.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from towage import reading
from towage.data import response_csv
from towage.data.columns import options
from towage.data.entries import Values, key_of, put
from towage.models.sea.response_table import DOFS, MIRRORED, TURN
from towage.reading import Refused

WIDEST = math.radians(60.0)
"""Largest distance of neighbouring headings."""
MAX_VALUES = 400_000
"""Complex numbers of a table: it is carried in the FMU."""


def read(path: Path, given: Mapping[str, Any], notes: list[str]) -> dict[str, tuple[Any, ...]]:
    """The fields of a `ResponseTable`. Raises `Refused` with the place in the file, and OSError."""
    kind = path.suffix.lower()
    if kind == ".4":
        values = _wamit(path, given)
    elif kind in (".nc", ".nc4", ".cdf"):
        options(given, ())
        values = _capytaine(path)
    else:
        values = response_csv.read(path, given)
    return _table(values, notes)


def _wamit(path: Path, given: Mapping[str, Any]) -> Values:
    options(given, ("ulen", "speed"))
    ulen, speed = given.get("ulen"), given.get("speed", 0.0)
    if not isinstance(ulen, (int, float)) or not ulen > 0:
        raise Refused("a .4 file divides rotations by the length ULEN of its .gdf file: give it as ulen, in m")
    values: Values = {}
    text = reading.content(path, reading.MAX_FILE).decode("utf-8", errors="replace")
    for number, line in enumerate(text.splitlines(), 1):
        cells, where = line.split(), f"line {number}"
        if not cells or (number == 1 and not re.match(r"[-+.\d]", cells[0])):
            continue
        try:
            row = [float(cell) for cell in cells]
        except ValueError:
            raise Refused(f"{where}: expected seven numbers, got {line.strip()[:60]!r}") from None
        if len(row) != 7 or row[2] not in (1, 2, 3, 4, 5, 6):
            raise Refused(f"{where}: expected period, heading, mode 1 to 6, modulus, phase, real and imaginary part")
        period, heading, mode, modulus, phase, re_part, im_part = row
        if not 0.0 < period < math.inf:
            raise Refused(f"{where}: a period of {period:g} s: zero and infinite frequencies are no waves")
        value = complex(re_part, im_part)
        if abs(value - modulus * complex(math.cos(math.radians(phase)), math.sin(math.radians(phase)))) > 1e-2 * max(
            abs(value), 1e-6
        ):
            raise Refused(
                f"{where}: modulus {modulus:g} and phase {phase:g} deg are not those of {re_part:g}, {im_part:g}"
            )
        dof = int(mode) - 1
        scale = 1.0 / ulen if dof > 2 else 1.0
        key = key_of(float(speed), math.radians(heading), TURN / period, where)
        put(values, key, dof, scale * value, where)
    return values


def _capytaine(path: Path) -> Values:
    from netCDF4 import Dataset

    with reading.foreign(path, "netCDF file"), Dataset(path) as data:
        if "RAO" not in data.variables:
            known = ", ".join(data.variables) or "none"
            raise Refused(f"has no variable RAO, but {known}: write what capytaine.post_pro.rao gives")
        variable = data.variables["RAO"]
        reading.limited(variable.size, 2 * 6 * MAX_VALUES, "values of RAO")
        raw: Any = np.ma.filled(np.ma.asarray(variable[:], float), np.nan)
        dims = variable.dimensions
        coordinates = {name: _coordinate(data.variables[name]) for name in dims if name in data.variables}
        speeds = _coordinate(data.variables["forward_speed"]) if "forward_speed" in data.variables else np.zeros(1)
    for name in ("complex", "omega", "wave_direction", "radiating_dof"):
        if name not in dims:
            raise Refused(
                f"RAO has the dimensions {', '.join(dims)}: expected complex, omega, wave_direction, radiating_dof"
            )
    extra = [n for n in dims if n not in ("complex", "omega", "wave_direction", "radiating_dof", "forward_speed")]
    wide = [n for n in extra if raw.shape[dims.index(n)] != 1]
    if wide:
        raise Refused(f"RAO depends on {', '.join(wide)} too: select one value of it")
    order = ("complex", "forward_speed", "wave_direction", "omega", "radiating_dof")
    raw = raw.transpose([dims.index(n) for n in (*extra, *(n for n in order if n in dims))])
    raw = raw.reshape(raw.shape[len(extra) :])
    if "forward_speed" not in dims:
        raw = raw[:, None]
    parts = [str(part) for part in coordinates.get("complex", np.array(["re", "im"]))]
    real, imaginary = raw[parts.index("re")], raw[parts.index("im")]
    values: Values = {}
    for k, name in enumerate(str(n).lower() for n in coordinates["radiating_dof"]):
        base = name.rpartition("__")[2]
        if base not in DOFS:
            raise Refused(f"radiating_dof {name!r}: expected {', '.join(DOFS)}")
        for (i, j, w), re_part in np.ndenumerate(real[..., k]):
            value = complex(re_part, -imaginary[i, j, w, k])  # its time goes as exp(-i w t)
            if not math.isfinite(abs(value)):
                raise Refused(f"RAO of {base}, entry {i}, {j}, {w}: no value")
            heading, omega = float(coordinates["wave_direction"][j]), float(coordinates["omega"][w])
            put(values, key_of(float(np.ravel(speeds)[i]), heading, omega, "omega"), DOFS.index(base), value, base)
    return values


def _coordinate(variable: Any) -> Any:
    data = np.ma.asarray(variable[:])
    if data.dtype.kind == "S" and data.ndim == 2:
        from netCDF4 import chartostring

        return np.atleast_1d(chartostring(data))
    return np.atleast_1d(data)


def _table(values: Values, notes: list[str]) -> dict[str, tuple[Any, ...]]:
    """The grid of all entries, which has to be whole."""
    if not values:
        raise Refused("holds no responses")
    speeds, headings, frequencies = (sorted({key[k] for key in values}) for k in range(3))
    present = sorted({dof for row in values.values() for dof in row})
    reading.limited(6 * len(speeds) * len(headings) * len(frequencies), MAX_VALUES, "responses")
    if len(frequencies) < 2:
        raise Refused("one wave frequency: expected two at least")
    for speed in speeds:
        for heading in headings:
            for omega in frequencies:
                row = values.get((speed, heading, omega), {})
                if missing := [DOFS[dof] for dof in present if dof not in row]:
                    raise Refused(
                        f"no {missing[0]} at {omega:g} rad/s, {math.degrees(heading):g} deg, {speed:g} m/s: expected every "
                        f"frequency ({len(frequencies)}) at every direction ({len(headings)}) and speed ({len(speeds)})"
                    )
    headings = _whole_circle(values, headings, notes)
    if absent := [name for k, name in enumerate(DOFS) if k not in present]:
        notes.append(f"the file has no {', '.join(absent)}: they stay zero")
    flat = tuple(
        values[speed, heading, omega].get(dof, 0j)
        for dof in range(6) for speed in speeds for heading in headings for omega in frequencies
    )  # fmt: skip
    return {"speeds": tuple(speeds), "headings": tuple(headings), "frequencies": tuple(frequencies), "values": flat}


def _whole_circle(values: Values, headings: list[float], notes: list[str]) -> list[float]:
    """Headings all round: as they are, or completed by a mirror where they are a half circle."""
    half = round(math.pi, 9)
    if headings[0] <= 1e-6 and abs(headings[-1] - half) <= 1e-6:
        for (speed, heading, omega), row in list(values.items()):
            if 1e-6 < heading < half - 1e-6:
                mirrored = {dof: MIRRORED[dof] * value for dof, value in row.items()}
                values[speed, round(TURN - heading, 9), omega] = mirrored
        notes.append("directions from 0 to 180 deg: the other side is taken for its mirror image")
        headings = sorted({key[1] for key in values})
    gaps = [(b - a, a) for a, b in zip(headings, [*headings[1:], headings[0] + TURN])]
    gap, after = max(gaps)
    if gap > WIDEST + 1e-6:
        raise Refused(
            f"no directions between {math.degrees(after):g} and {math.degrees(after + gap) % 360.0:g} deg: expected a circle, or "
            f"0 to 180 deg, with at most {math.degrees(WIDEST):g} deg between two"
        )
    return headings
