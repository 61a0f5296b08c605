"""Responses of a ship to waves from files, in the conventions of `models.sea.response_table`.

| file | what is in it | what it leaves open |
|---|---|---|
| .4 of WAMIT | period, s; heading, deg; mode 1 to 6; modulus, phase, deg; real and imaginary part; one speed | ``ulen``, m: rotations are per amplitude over ULEN; ``speed``, 0 |
| netCDF of capytaine | RAO over omega, wave_direction and radiating_dof, forward_speed where there is one | nothing: Re(X e^(-i w t)), directions of travel, rad/m |
| CSV, as of OrcaFlex | columns frequency or period, direction, speed; ``heave_amplitude`` and ``heave_phase``, or ``heave_re`` and ``heave_im`` | ``phase``: "lead" or "lag" of the crest; ``time``: "exp(+iwt)" or "exp(-iwt)"; ``direction``: "to" or "from" |

A column of a CSV file has its unit in its name: frequency [rad/s] or [Hz], period [s], direction [deg] or [rad], speed [m/s] or
[kn], translations [m/m], rotations [rad/m], [deg/m] or [slope] (per wave slope k a), phases [deg] or [rad]. A line "Direction 45"
stands for a column. Axes: x ahead, y to port, z up; roll lowers starboard, pitch the bow. Waves are deep: k = w^2/g.

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
from towage.data.columns import Column, Table, csv, options
from towage.models.sea.response_table import DOFS, MIRRORED, TURN
from towage.models.sea.waves import GRAVITY
from towage.reading import Refused

WIDEST = math.radians(60.0)
"""Largest distance of neighbouring headings."""
KNOT = 1852.0 / 3600.0
MAX_VALUES = 400_000
"""Complex numbers of a table: it is carried in the FMU."""
Key = tuple[float, float, float]
"""Speed, m/s, heading, rad within 0 ... 2 pi, frequency, rad/s; rounded, so that equal ones are equal."""
Values = dict[Key, dict[int, complex]]


def read(path: Path, given: Mapping[str, Any], notes: list[str]) -> dict[str, tuple[Any, ...]]:
    """The fields of a `ResponseTable`. Raises `Refused` with the place in the file, and OSError."""
    kind = path.suffix.lower()
    if kind == ".4":
        values = _wamit(path, given)
    elif kind in (".nc", ".nc4", ".cdf"):
        options(given, ())
        values = _capytaine(path)
    else:
        values = _csv(path, given)
    return _table(values, notes)


def _key(speed: float, heading: float, omega: float, where: str) -> Key:
    if not 0.0 < omega < 1e3:
        raise Refused(f"{where}: a wave frequency of {omega:g} rad/s: expected a number above 0")
    turned = round(heading % TURN, 9)
    return round(speed, 9), 0.0 if turned >= round(TURN, 9) else turned, round(omega, 9)


def _put(values: Values, key: Key, dof: int, value: complex, where: str) -> None:
    row = values.setdefault(key, {})
    if dof in row and abs(row[dof] - value) > 1e-6 * max(abs(value), 1e-9):
        speed, heading, omega = key
        raise Refused(
            f"{where}: {DOFS[dof]} at {omega:g} rad/s, {math.degrees(heading):g} deg, {speed:g} m/s stands there twice, and differs"
        )
    row[dof] = value


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
            raise Refused(f"{where}: modulus {modulus:g} and phase {phase:g} deg are not those of {re_part:g}, {im_part:g}")
        dof = int(mode) - 1
        scale = 1.0 / ulen if dof > 2 else 1.0
        key = _key(float(speed), math.radians(heading), TURN / period, where)
        _put(values, key, dof, scale * value, where)
    return values


def _capytaine(path: Path) -> Values:
    from netCDF4 import Dataset

    with reading.foreign(path, "netCDF file"), Dataset(path) as data:
        if "RAO" not in data.variables:
            raise Refused(f"has no variable RAO, but {', '.join(data.variables) or 'none'}: write what capytaine.post_pro.rao gives")
        variable = data.variables["RAO"]
        reading.limited(variable.size, 2 * 6 * MAX_VALUES, "values of RAO")
        raw = np.ma.filled(np.ma.asarray(variable[:], float), np.nan)
        dims = variable.dimensions
        coordinates = {name: _coordinate(data.variables[name]) for name in dims if name in data.variables}
        speeds = _coordinate(data.variables["forward_speed"]) if "forward_speed" in data.variables else np.zeros(1)
    for name in ("complex", "omega", "wave_direction", "radiating_dof"):
        if name not in dims:
            raise Refused(f"RAO has the dimensions {', '.join(dims)}: expected complex, omega, wave_direction, radiating_dof")
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
            key = _key(float(np.ravel(speeds)[i]), float(coordinates["wave_direction"][j]), float(coordinates["omega"][w]), "omega")
            _put(values, key, DOFS.index(base), value, base)
    return values


def _coordinate(variable: Any) -> Any:
    data = np.ma.asarray(variable[:])
    if data.dtype.kind == "S" and data.ndim == 2:
        from netCDF4 import chartostring

        return np.atleast_1d(chartostring(data))
    return np.atleast_1d(data)


def _csv(path: Path, given: Mapping[str, Any]) -> Values:
    options(given, ("phase", "time", "direction"))
    for name, words in {"phase": ("lead", "lag"), "time": ("exp(+iwt)", "exp(-iwt)"), "direction": ("to", "from")}.items():
        if name in given and given[name] not in words:
            raise Refused(f"{name} = {given[name]!r}: expected {' or '.join(map(repr, words))}")
    if "direction" not in given:
        raise Refused("direction is not given: 'to' where 0 deg is a following sea, 'from' where 0 deg is a head sea")
    table = csv(_directions_as_column(reading.content(path, reading.MAX_FILE).decode("utf-8", errors="replace")))
    axes, motions = _heads(table)
    values: Values = {}
    speed = axes.get("speed", np.zeros(len(axes["omega"])))
    heading = axes["direction"] + (math.pi if given["direction"] == "from" else 0.0)
    for name, (first, second) in motions.items():
        dof = DOFS.index(name)
        what = _complex(name, first, second, axes["omega"], given)
        for row, value in enumerate(what):
            place = table.place(row)
            _put(values, _key(float(speed[row]), float(heading[row]), float(axes["omega"][row]), place), dof, complex(value), place)
    return values


def _directions_as_column(text: str) -> str:
    """Lines "Direction 45", as OrcaFlex writes them above each block, as a column."""
    if not re.search(r"^\W*direction\W+[-+.\d]+\W*$", text, re.IGNORECASE | re.MULTILINE):
        return text
    lines, now, head = [], "", ""
    for line in text.splitlines():
        if found := re.match(r"^\W*direction\W+([-+.\d]+)\W*$", line, re.IGNORECASE):
            now = found[1]
            lines.append("")
        elif not line.partition("#")[0].strip():
            lines.append("")
        elif re.match(r"^\W*[-+.\d]", line):
            if not now:
                raise Refused(f"line {len(lines) + 1}: numbers above the first line 'Direction ...'")
            mark = next((mark for mark in (";", "\t", ",") if mark in line), " ")
            lines.append(f"{line}{mark}{now}")
        elif head and line.strip() != head:
            raise Refused(f"line {len(lines) + 1}: other columns than before")
        else:
            mark = next((mark for mark in (";", "\t", ",") if mark in line), " ")
            lines.append("" if head else f"{line}{mark}direction [deg]")
            head = line.strip()
    return "\n".join(lines)


ANGLE = {"deg": math.pi / 180.0, "rad": 1.0}
AXES = {
    "frequency": {"rad/s": 1.0, "hz": TURN}, "omega": {"rad/s": 1.0}, "period": {"s": 1.0},
    "direction": ANGLE, "heading": ANGLE, "speed": {"m/s": 1.0, "kn": KNOT},
}  # fmt: skip
_MOTION = re.compile(r"^(surge|sway|heave|roll|pitch|yaw)[\s_.-]*(ampl\w*\.?|modulus|phase|re(?:al)?|im(?:ag\w*)?)$")


def _heads(table: Table) -> tuple[dict[str, Any], dict[str, tuple[Column, Column]]]:
    """The axes in SI, and two columns for every motion."""
    axes: dict[str, Any] = {}
    found: dict[str, dict[str, Column]] = {}
    for column in table.columns:
        name = column.name.lower()
        if motion := _MOTION.match(name):
            found.setdefault(motion[1], {})[motion[2][:2]] = column
            continue
        if name not in AXES:
            raise Refused(f"column {column.name!r}: expected {', '.join(AXES)}, or a motion as heave_amplitude and heave_phase")
        units = AXES[name]
        if column.unit.lower() not in units:
            raise Refused(f"column {column.name!r}: its unit is {column.unit or 'not given'}: expected [{'] or ['.join(units)}]")
        values = units[column.unit.lower()] * column.values
        if name == "period":
            if (values <= 0.0).any():
                raise Refused(f"{table.place(int(np.argmin(values)))}: a period of {values.min():g} s")
            values = TURN / values
        key = {"frequency": "omega", "period": "omega", "heading": "direction"}.get(name, name)
        if key in axes:
            raise Refused(f"column {column.name!r}: frequency, direction and speed are given once")
        axes[key] = values
    for name in ("omega", "direction"):
        if name not in axes:
            raise Refused(f"no column of the {'wave frequency or period' if name == 'omega' else name}")
    motions = {}
    for name, parts in found.items():
        pair = ("am", "ph") if "am" in parts else ("mo", "ph") if "mo" in parts else ("re", "im")
        if set(parts) != set(pair):
            raise Refused(f"{name}: expected amplitude and phase, or real and imaginary part, got {', '.join(c.name for c in parts.values())}")
        motions[name] = (parts[pair[0]], parts[pair[1]])
    if not motions:
        raise Refused("no column of a motion: expected as heave_amplitude [m/m] and heave_phase [deg]")
    return axes, motions


def _complex(name: str, first: Column, second: Column, omega: Any, given: Mapping[str, Any]) -> Any:
    """H of one motion."""
    rotation = DOFS.index(name) > 2
    units = {"rad/m": 1.0, "deg/m": math.pi / 180.0, "slope": omega * omega / GRAVITY} if rotation else {"m/m": 1.0}
    for column in (first, second) if second.name.lower().endswith(("im", "imag")) else (first,):
        if column.unit.lower() not in units:
            raise Refused(f"column {column.name!r}: its unit is {column.unit or 'not given'}: expected [{'] or ['.join(units)}]")
    scale = units[first.unit.lower()]
    if re.search(r"phase$", second.name.lower()):
        if second.unit.lower() not in ANGLE:
            raise Refused(f"column {second.name!r}: its unit is {second.unit or 'not given'}: expected [deg] or [rad]")
        if "phase" not in given:
            raise Refused("phase is not given: 'lead' or 'lag', of a motion relative to the crest at the reference point")
        sign = 1.0 if given["phase"] == "lead" else -1.0
        return scale * first.values * np.exp(1j * sign * ANGLE[second.unit.lower()] * second.values)
    if "time" not in given:
        raise Refused("time is not given: 'exp(+iwt)' or 'exp(-iwt)', by which real and imaginary parts are meant")
    return scale * (first.values + (1j if given["time"] == "exp(+iwt)" else -1j) * second.values)


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


