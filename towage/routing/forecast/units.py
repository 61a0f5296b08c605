"""Units of measure as data files write them (UDUNITS, GRIB), turned into expressions of `towage.fmus.declare.quantities`."""

from __future__ import annotations

import re

from towage.fmus.declare.quantities import QuantityError, convert

_WORDS = {
    "metre": "m", "meter": "m", "metres": "m", "meters": "m", "centimetre": "cm", "centimeter": "cm", "centimetres": "cm",
    "centimeters": "cm", "millimetre": "mm", "millimeter": "mm", "millimetres": "mm", "millimeters": "mm",
    "kilometre": "km", "kilometer": "km", "kilometres": "km", "kilometers": "km", "foot": "ft", "feet": "ft",
    "fathoms": "fathom", "inch": "in", "inches": "in", "yard": "yd", "yards": "yd", "miles": "mi", "nautical_mile": "nmi",
    "nautical_miles": "nmi", "nauticalmile": "nmi", "second": "s", "seconds": "s", "sec": "s", "minute": "min",
    "minutes": "min", "hour": "h", "hours": "h", "hr": "h", "knot": "kn", "knots": "kn", "kt": "kn", "kts": "kn",
    "radian": "rad", "radians": "rad", "degree": "deg", "degrees": "deg", "degree_true": "deg", "degrees_true": "deg",
    "degree_north": "deg", "degrees_north": "deg", "degreen": "deg", "degree_n": "deg",
    "degrees_n": "deg", "degree_east": "deg", "degrees_east": "deg", "degreee": "deg", "degreese": "deg",
    "degree_e": "deg", "degrees_e": "deg", "°": "deg",
}  # fmt: skip
_FACTOR = re.compile(r"([A-Za-z_°]+)(?:\*\*|\^)?([+-]?\d+)?")


def expression(text: str) -> str:
    """``m s**-1`` as ``m.s-1``, ``Degree true`` as ``deg``; what is not known stays as it is."""
    whole = "_".join(text.strip().lower().split())
    if whole in _WORDS:
        return _WORDS[whole]
    parts = []
    for part in text.replace("*", " * ").replace(" *  * ", "**").replace(" * ", " ").replace(".", " ").split():
        match = _FACTOR.fullmatch(part)
        if match is None:
            return text.strip()
        parts.append(_WORDS.get(match[1].lower(), match[1]) + (match[2] or ""))
    return ".".join(parts)


def factor(text: str, unit: str) -> float:
    """What a value of unit ``text`` is multiplied with to be one of ``unit``. Raises `QuantityError`."""
    if not text.strip():
        raise QuantityError("the unit is empty")
    return convert(1.0, expression(text), unit)
