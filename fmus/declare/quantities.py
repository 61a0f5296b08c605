"""Units of measurement: the one table of the project, a parser for expressions of them, and conversion.

    value in SI base units = factor * value,   dimension = exponents of kg, m, s, A, K, mol, cd, rad

An expression is a product, a quotient and integer powers of the symbols below: ``lbf/ft``, ``kg.m/s2``, ``N*s/m``,
``ft^2``, ``1/s``, ``J/(kg.K)``. Only one division stands outside parentheses before a product: ``N/m.s`` is refused,
because readers disagree about it.

Decisions: (1) rad counts as a dimension, as FMI 2.0 writes it, so a frequency in Hz and a rate in 1/s stay apart.
(2) Hz is a cycle a second, 2 pi rad/s, and rpm a turn a minute: all frequencies on ports are angular. (3) There is no
bare ton: ``t`` is 1000 kg, ``long_ton`` 2240 lb, ``short_ton`` 2000 lb, and ``tonf_*`` the forces. (4) A unit with an
offset (degC) has no place here.

Source of the factors: international yard and pound agreement of 1959 (ft = 0.3048 m, lb = 0.45359237 kg), standard
gravity 9.80665 m/s2 (3rd CGPM, 1901), international nautical mile 1852 m (1929), all as in NIST SP 811 (2008),
appendix B. All are exact; a fathom is 6 international feet.
"""

from __future__ import annotations

import difflib
import math
import re
from functools import lru_cache

BASES = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")
"""The base units of FMI 2.0, in the order of every tuple of exponents here."""

Exponents = tuple[int, ...]

UNITS: dict[str, tuple[float, str]] = {
    "N": (1.0, "kg.m/s2"), "Pa": (1.0, "N/m2"), "J": (1.0, "N.m"), "W": (1.0, "J/s"), "%": (0.01, "1"),
    "kN": (1e3, "N"), "MN": (1e6, "N"), "kPa": (1e3, "Pa"), "MPa": (1e6, "Pa"), "kW": (1e3, "W"), "kJ": (1e3, "J"),
    "mm": (1e-3, "m"), "cm": (1e-2, "m"), "km": (1e3, "m"), "in": (0.0254, "m"), "ft": (0.3048, "m"),
    "yd": (0.9144, "m"), "fathom": (1.8288, "m"), "mi": (1609.344, "m"), "nmi": (1852.0, "m"),
    "ms": (1e-3, "s"), "min": (60.0, "s"), "h": (3600.0, "s"), "d": (86400.0, "s"), "kn": (1.0, "nmi/h"),
    "t": (1e3, "kg"), "lb": (0.45359237, "kg"), "long_ton": (2240.0, "lb"), "short_ton": (2000.0, "lb"),
    "lbf": (4.4482216152605, "N"), "kip": (1e3, "lbf"), "slug": (1.0, "lbf.s2/ft"),
    "tonf_long": (2240.0, "lbf"), "tonf_short": (2000.0, "lbf"), "tonf_metric": (9806.65, "N"),
    "psi": (1.0, "lbf/in2"), "psf": (1.0, "lbf/ft2"),
    "deg": (math.pi / 180.0, "rad"), "rev": (2.0 * math.pi, "rad"), "rpm": (1.0, "rev/min"), "Hz": (1.0, "rev/s"),
}  # fmt: skip
"""Symbol -> (factor, expression it multiplies). With the base units, every symbol an expression may use."""

DISPLAY: dict[str, tuple[str, ...]] = {
    "1": ("%",),
    "m": ("ft", "in", "yd", "fathom", "km", "mi", "nmi", "cm", "mm"),
    "m2": ("ft2", "in2"),
    "m/s": ("ft/s", "kn", "km/h"),
    "m/s2": ("ft/s2",),
    "m2/s": ("ft2/s",),
    "s": ("min", "h", "d"),
    "kg": ("lb", "slug", "t", "long_ton", "short_ton"),
    "kg/m": ("lb/ft", "slug/ft"),
    "kg/m3": ("lb/ft3", "slug/ft3"),
    "N": ("lbf", "kip", "kN", "tonf_long", "tonf_short"),
    "N/m": ("lbf/ft", "kN/m"),
    "N/s": ("lbf/s", "kN/s"),
    "N.s/m": ("lbf.s/ft",),
    "N.m": ("lbf.ft", "kN.m"),
    "W": ("kW",),
    "Pa": ("psi", "psf", "kPa"),
    "rad": ("deg",),
    "rad/s": ("deg/s", "rpm", "Hz"),
}
"""SI unit -> the display units that a description offers for it."""

_HINTS = {
    "ton": "long_ton, short_ton or t", "tons": "long_ton, short_ton or t", "tonne": "t",
    "tonf": "tonf_long, tonf_short or tonf_metric", "pound": "lb (mass) or lbf (force)", "lbs": "lb or lbf",
    "knot": "kn", "knots": "kn", "kts": "kn", "foot": "ft", "feet": "ft", "inch": "in", "mile": "mi or nmi",
    "sec": "s", "second": "s", "hour": "h", "day": "d", "degree": "deg", "degrees": "deg", "radian": "rad", "g": "kg",
}  # fmt: skip
_TOKEN = re.compile(r"([A-Za-z_%]+|1(?![0-9]))(?:(?:\^|\*\*)?(-?[1-9][0-9]?)(?![0-9]))?|[.*/()]", re.ASCII)
_NUMBER = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")
_SPACED = re.compile(r" *([.*/()]) *")
_LONGEST = 100


class QuantityError(ValueError):
    """A text that is no quantity or no unit; the base of the two below."""


class UnknownUnitError(QuantityError):
    """A symbol that is not in the table."""


class DimensionError(QuantityError):
    """Two units that measure different things."""


def parse_quantity(text: str, expected_unit: str) -> float:
    """The value of ``text``, in ``expected_unit``.

    >>> parse_quantity("100 ft", "m")
    30.48

    A bare number is accepted only where ``expected_unit`` is "1". Raises ``QuantityError`` for a text that is not a
    finite number with a unit, ``UnknownUnitError`` and ``DimensionError``.
    """
    stripped = text.strip()
    number = _NUMBER.match(stripped)
    if number is None:
        raise QuantityError(f"{text!r} is not a number with a unit, as in '2.5 {expected_unit}'")
    unit = stripped[number.end() :].strip()
    if not unit and expected_unit != "1":
        raise QuantityError(f"{text!r} has no unit: write '{stripped} {expected_unit}', or the number without quotes")
    value = convert(float(number.group()), unit or "1", expected_unit)
    if not math.isfinite(value):
        raise QuantityError(f"{text!r} is beyond the range of numbers")
    return value


def convert(value: float, from_unit: str, to_unit: str) -> float:
    """``value`` of ``from_unit`` expressed in ``to_unit``; unchanged to the last bit where the factors agree.

    Raises ``UnknownUnitError``, ``DimensionError``, or ``QuantityError`` for an expression that cannot be read.
    """
    (factor, exponents), (to_factor, to_exponents) = _parse(from_unit), _parse(to_unit)
    if exponents != to_exponents:
        raise DimensionError(
            f"'{from_unit}' is [{base_expression(exponents)}], but '{to_unit}' is [{base_expression(to_exponents)}]"
        )
    return value * (factor / to_factor)


def dimension(unit: str) -> Exponents:
    """Exponents of ``BASES``. Raises ``QuantityError``."""
    return _parse(unit)[1]


def same_dimension(first: str, second: str) -> bool:
    """Whether values of the two units can be converted into each other. Raises ``QuantityError``."""
    return dimension(first) == dimension(second)


def unit_definition(unit: str) -> tuple[dict[str, int], float, tuple[tuple[str, float], ...]]:
    """What FMI 2.0 writes of ``unit``: the attributes of BaseUnit, its factor, and (name, factor) of each DisplayUnit.

    Both factors are in FMI's sense: base value = factor * value, but displayed value = factor * value: 1/0.3048 for
    ``ft`` beside ``m``. Raises ``QuantityError``.
    """
    factor, exponents = _parse(unit)
    displays = ((name, factor / _parse(name)[0]) for name in DISPLAY.get(unit, ()))
    return {base: power for base, power in zip(BASES, exponents, strict=True) if power}, factor, tuple(displays)


def base_expression(exponents: Exponents) -> str:
    """The exponents as text: ``kg.m.s-2``; ``1`` without a dimension."""
    powers = (base + ("" if power == 1 else str(power)) for base, power in zip(BASES, exponents, strict=True) if power)
    return ".".join(powers) or "1"


@lru_cache(maxsize=1024)
def _parse(unit: str) -> tuple[float, Exponents]:
    """(factor, exponents) of an expression."""
    text = _SPACED.sub(r"\1", unit.strip())
    tokens = list(_TOKEN.finditer(text))
    if not text or len(unit) > _LONGEST or "".join(token.group() for token in tokens) != text:
        raise QuantityError(f"{unit!r} is not a unit, as 'm', 'lbf/ft' or 'kg.m/s2'")
    try:
        factor, exponents, rest = _product(unit, tokens)
    except ArithmeticError:
        raise QuantityError(f"{unit!r} is not a unit: out of range") from None
    if rest or not (0.0 < factor < math.inf):
        raise QuantityError(f"{unit!r} is not a unit: {'unbalanced parentheses' if rest else 'out of range'}")
    return factor, exponents


def _product(unit: str, tokens: list[re.Match[str]]) -> tuple[float, Exponents, list[re.Match[str]]]:
    """The product that starts with the first token, and the tokens after it."""
    factor, exponents, operator, divided = 1.0, (0,) * len(BASES), "*", False
    while True:
        if not tokens or tokens[0].group() in ".*/)":
            raise QuantityError(f"{unit!r} is not a unit: a symbol is missing")
        token, tokens = tokens[0], tokens[1:]
        if token.group() == "(":
            term, powers, tokens = _product(unit, tokens)
            if not tokens or tokens[0].group() != ")":
                raise QuantityError(f"{unit!r} is not a unit: a parenthesis is not closed")
            tokens = tokens[1:]
        else:
            term, powers = _symbol(unit, token.group(1))
            power = int(token.group(2) or 1)
            term, powers = term**power, tuple(power * each for each in powers)
        sign = -1 if operator == "/" else 1
        factor = factor / term if operator == "/" else factor * term
        exponents = tuple(a + sign * b for a, b in zip(exponents, powers, strict=True))
        if not tokens or tokens[0].group() == ")":
            return factor, exponents, tokens
        operator, tokens, divided = tokens[0].group(), tokens[1:], divided or tokens[0].group() == "/"
        if operator not in ("*", ".", "/"):
            raise QuantityError(f"{unit!r} is not a unit: write a product as 'N.m'")
        if divided and operator != "/":
            raise QuantityError(f"{unit!r} is ambiguous: put the divisor in parentheses, or the product first")


def _symbol(unit: str, symbol: str) -> tuple[float, Exponents]:
    """(factor, exponents) of one symbol of the expression ``unit``."""
    if symbol == "1":
        return 1.0, (0,) * len(BASES)
    if symbol in BASES:
        return 1.0, tuple(int(symbol == base) for base in BASES)
    if symbol not in UNITS:
        close = difflib.get_close_matches(symbol, [*BASES, *UNITS], n=3, cutoff=0.5)
        hint = _HINTS.get(symbol.lower()) or ", ".join(close)
        within = f" in {unit!r}" if unit.strip() != symbol else ""
        raise UnknownUnitError(f"unknown unit {symbol!r}{within}" + (f"; did you mean {hint}?" if hint else ""))
    multiple, of = UNITS[symbol]
    factor, exponents = _parse(of)
    return multiple * factor, exponents
