"""Responses of a ship from a CSV file, as of OrcaFlex.

Columns of frequency or period, direction and speed; of every motion ``heave_amplitude`` and ``heave_phase``, or ``heave_re`` and
``heave_im``. A column has its unit in its name: frequency [rad/s] or [Hz], period [s], direction [deg] or [rad], speed [m/s] or
[kn], translations [m/m], rotations [rad/m], [deg/m] or [slope] (per wave slope k a, k = w^2/g), phases [deg] or [rad]. A line
"Direction 45" stands for a column.

What such a file leaves open its options say: ``phase``, "lead" or "lag" of the crest at the reference point; ``time``,
"exp(+iwt)" or "exp(-iwt)", of real and imaginary parts; ``direction``, "to" (0 deg is a following sea) or "from" (0 deg is a head
sea).
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
from towage.data.entries import Values, key_of, put
from towage.models.sea.response_table import DOFS, TURN
from towage.models.sea.waves import GRAVITY
from towage.reading import Refused

KNOT = 1852.0 / 3600.0


def read(path: Path, given: Mapping[str, Any]) -> Values:
    """The entries. Raises `Refused` with the place in the file, and OSError."""
    options(given, ("phase", "time", "direction"))
    for name, words in {
        "phase": ("lead", "lag"),
        "time": ("exp(+iwt)", "exp(-iwt)"),
        "direction": ("to", "from"),
    }.items():
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
            key = key_of(float(speed[row]), float(heading[row]), float(axes["omega"][row]), place)
            put(values, key, dof, complex(value), place)
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
            raise Refused(
                f"column {column.name!r}: expected {', '.join(AXES)}, or a motion as heave_amplitude and heave_phase"
            )
        units = AXES[name]
        if column.unit.lower() not in units:
            raise Refused(
                f"column {column.name!r}: its unit is {column.unit or 'not given'}: expected [{'] or ['.join(units)}]"
            )
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
            got = ", ".join(c.name for c in parts.values())
            raise Refused(f"{name}: expected amplitude and phase, or real and imaginary part, got {got}")
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
            raise Refused(
                f"column {column.name!r}: its unit is {column.unit or 'not given'}: expected [{'] or ['.join(units)}]"
            )
    scale = units[first.unit.lower()]
    if re.search(r"phase$", second.name.lower()):
        if second.unit.lower() not in ANGLE:
            raise Refused(f"column {second.name!r}: its unit is {second.unit or 'not given'}: expected [deg] or [rad]")
        if "phase" not in given:
            raise Refused(
                "phase is not given: 'lead' or 'lag', of a motion relative to the crest at the reference point"
            )
        sign = 1.0 if given["phase"] == "lead" else -1.0
        return scale * first.values * np.exp(1j * sign * ANGLE[second.unit.lower()] * second.values)
    if "time" not in given:
        raise Refused("time is not given: 'exp(+iwt)' or 'exp(-iwt)', by which real and imaginary parts are meant")
    return scale * (first.values + (1j if given["time"] == "exp(+iwt)" else -1j) * second.values)
