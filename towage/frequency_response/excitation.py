"""What drives a tow, as a user writes it: surge and heave of the towpoint, drag and lift on the body.

    heave=1    surge="2 ft @ 40 deg"    lift="80 lbf @ 0.7"

An amplitude, m or N or in a known unit, and after "@" a phase, rad or in degrees: amplitude cos(omega t - phase), as
programs OMWAY (surge and heave, Quadrant I) and OMFLO (drag and lift, Quadrant II) read them.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Mapping

from towage.errors import SceneError
from towage.fmus.declare.quantities import QuantityError, parse_quantity
from towage.models.cable.steady.perturbation import Excitation

MEASURED = {"surge": "m", "heave": "m", "drag": "N", "lift": "N"}
"""Every excitation and what it is measured in."""
AT_TOWPOINT = ("surge", "heave")


def excitation_of(given: Mapping[str, float | complex | str], quadrant: int) -> Excitation:
    """The excitation of a tow in Quadrant 1 or 2; without any, 1 m of heave or 1 N of lift. Raises `SceneError` for an
    unknown name, a value that is none, or an end of the cable that stands still in this quadrant."""
    if not given:
        return Excitation(heave=1.0) if quadrant == 1 else Excitation(lift=1.0)
    values = {}
    for name, value in given.items():
        if name not in MEASURED:
            raise SceneError(f"excitation {name!r}: expected one of {', '.join(MEASURED)}")
        if quadrant == 2 and name in AT_TOWPOINT:
            raise SceneError(
                f"excitation {name}: in Quadrant II the towpoint moves steadily (the source's [43] and [44]): "
                "expected drag or lift on the body"
            )
        values[name] = _amplitude(name, value)
    if not any(values.values()):
        raise SceneError("excitation: all amplitudes are 0, so nothing responds: expected one above 0")
    return Excitation(**values)


def _amplitude(name: str, value: float | complex | str) -> complex:
    """The complex amplitude, SI."""
    if not isinstance(value, str):
        found = complex(value)
    else:
        size, at, phase = value.partition("@")
        found = cmath.rect(_number(name, size, MEASURED[name]), _number(name, phase, "rad") if at else 0.0)
    if not (math.isfinite(found.real) and math.isfinite(found.imag)):
        raise SceneError(f"excitation {name} = {value!r}: expected a finite amplitude")
    return found


def _number(name: str, text: str, unit: str) -> float:
    text = text.strip()
    try:
        return float(text)
    except ValueError:
        pass
    try:
        return parse_quantity(text, unit)
    except QuantityError as error:
        raise SceneError(f"excitation {name}: {error}: expected as in 2, '2 ft' or '2 ft @ 40 deg'") from None


def in_words(excitation: Excitation) -> str:
    """As a table's heading says it: "1 m of heave of the towpoint"."""
    parts = []
    for name, unit in MEASURED.items():
        value = complex(getattr(excitation, name))
        if value:
            where = "of the towpoint" if name in AT_TOWPOINT else "on the body"
            phase = f" @ {cmath.phase(value):.4g} rad" if cmath.phase(value) else ""
            parts.append(f"{abs(value):.6g} {unit} of {name} {where}{phase}")
    return " and ".join(parts)
