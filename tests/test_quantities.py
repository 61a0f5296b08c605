"""The table of units against published factors, and the parser against text of every kind."""

from __future__ import annotations

import contextlib
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from towage.fmus.declare import quantities as q

SYMBOLS = [*q.BASES, *q.UNITS]
expressions = st.lists(
    st.tuples(st.sampled_from(SYMBOLS), st.sampled_from(["", "2", "^2", "-1", "**3"])), min_size=1, max_size=3
).map(lambda terms: ".".join(symbol + power for symbol, power in terms))
values = st.floats(-1e12, 1e12, allow_nan=False)


@pytest.mark.parametrize(
    ("unit", "si", "factor"),
    [  # NIST SP 811 (2008), appendix B.8; digits as printed there
        ("ft", "m", 0.3048), ("in", "m", 0.0254), ("yd", "m", 0.9144), ("nmi", "m", 1852.0), ("mi", "m", 1609.344),
        ("fathom", "m", 1.8288), ("kn", "m/s", 0.5144444), ("km/h", "m/s", 0.2777778), ("lb", "kg", 0.45359237),
        ("slug", "kg", 14.59390), ("long_ton", "kg", 1016.047), ("short_ton", "kg", 907.1847), ("t", "kg", 1000.0),
        ("lbf", "N", 4.448222), ("kip", "N", 4448.222), ("lbf/ft", "N/m", 14.59390), ("psi", "Pa", 6894.757),
        ("psf", "Pa", 47.88026), ("slug/ft3", "kg/m3", 515.3788), ("ft2", "m2", 0.09290304), ("in2", "m2", 6.4516e-4),
        ("ft2/s", "m2/s", 0.09290304), ("slug/ft", "kg/m", 47.88026), ("lb/ft", "kg/m", 1.488164),
        ("deg", "rad", 0.01745329), ("rpm", "rad/s", 0.1047198), ("d", "s", 86400.0), ("lbf.s/ft", "N.s/m", 14.59390),
        ("tonf_short", "N", 8896.443), ("tonf_metric", "N", 9806.65), ("%", "1", 0.01), ("tonf_long", "lbf", 2240.0),
    ],
)  # fmt: skip
def test_consistency_with_nist_sp_811(unit: str, si: str, factor: float) -> None:
    # 5e-7: half a unit of the seventh digit
    assert q.convert(1.0, unit, si) == pytest.approx(factor, rel=5e-7)


def test_derived_factors_are_exact_to_rounding() -> None:
    assert q.convert(1.0, "lbf", "lb.m/s2") == pytest.approx(9.80665, rel=4e-16)
    assert q.convert(1.0, "slug", "lbf.s2/ft") == pytest.approx(1.0, rel=4e-16)
    assert q.convert(1.0, "Hz", "rad/s") == 2.0 * math.pi
    assert q.parse_quantity("100 ft", "m") == 30.48


@pytest.mark.parametrize(
    "text", ["lbf/ft", "lbf / ft", "lbf.ft-1", "lbf*ft^-1", "(lbf)/(ft)", "lbf.ft/ft2", "lbf.ft**-1"]
)
def test_spellings_of_one_unit(text: str) -> None:
    assert q.convert(1.0, text, "N/m") == pytest.approx(14.593902937206364, rel=1e-15)


@pytest.mark.parametrize(
    ("text", "expected", "value"),
    [("8 s", "s", 8.0), ("-2.5e3lbf", "lbf", -2500.0), (" +.5  m ", "m", 0.5), ("50 %", "1", 0.5), ("0.5", "1", 0.5),
     ("2 1/s", "1/s", 2.0), ("3 kg.m/s2", "N", 3.0), ("4 N*s/m", "kg/s", 4.0), ("1 J/(kg.K)", "m2/(s2.K)", 1.0)],
)  # fmt: skip
def test_parse_quantity(text: str, expected: str, value: float) -> None:
    assert q.parse_quantity(text, expected) == value


@pytest.mark.parametrize(
    ("text", "expected", "error", "says"),
    [
        ("3 kg", "m", q.DimensionError, r"'kg' is \[kg\], but 'm' is \[m\]"),
        ("3 1/s", "rad/s", q.DimensionError, r"s-1\.rad"),
        ("3 Hz", "1/s", q.DimensionError, "Hz"),
        ("3 kN", "kn", q.DimensionError, r"\[m\.s-1\]"),
        ("3", "m", q.QuantityError, "'3 m'"),
        ("3 knots", "m/s", q.UnknownUnitError, "did you mean kn"),
        ("3 fathoms", "m", q.UnknownUnitError, "did you mean fathom"),
        ("3 ton", "kg", q.UnknownUnitError, "long_ton, short_ton or t"),
        ("3 lbs/ft", "kg/m", q.UnknownUnitError, r"'lbs' in 'lbs/ft'"),
        ("3 xyzzy", "m", q.UnknownUnitError, "unknown unit 'xyzzy'$"),
        ("fast", "m/s", q.QuantityError, "not a number"),
        ("nan m", "m", q.QuantityError, "not a number"),
        ("inf m", "m", q.QuantityError, "not a number"),
        ("1e999 m", "m", q.QuantityError, "beyond the range"),
        ("1.2.3 m", "m", q.QuantityError, "not a unit"),
        ("1,5 m", "m", q.QuantityError, "not a unit"),
        ("1_000 m", "m", q.QuantityError, "_"),
        ("٣ m", "m", q.QuantityError, "not a number"),
        ("1 N/m.s", "N", q.QuantityError, "ambiguous"),
        ("1 N m", "N.m", q.QuantityError, "not a unit"),
        ("1 kip99.kip99", "m", q.QuantityError, "out of range"),
        ("1 (m", "m", q.QuantityError, "not closed"),
        ("1 m)", "m", q.QuantityError, "unbalanced"),
        ("1 m(s)", "m", q.QuantityError, "product"),
        ("1 m/", "m", q.QuantityError, "missing"),
        ("1 m0", "m", q.QuantityError, "not a unit"),
        ("1 m123", "m", q.QuantityError, "not a unit"),
        ("1 1/(" + ".".join(["mm9"] * 14) + ")", "m", q.QuantityError, "out of range"),
        ("1 " + "(" * 200, "m", q.QuantityError, "not a unit"),
        ("", "m", q.QuantityError, "not a number"),
    ],
)  # fmt: skip
def test_refused(text: str, expected: str, error: type[Exception], says: str) -> None:
    with pytest.raises(error, match=says):
        q.parse_quantity(text, expected)


def test_errors_are_value_errors() -> None:
    assert issubclass(q.UnknownUnitError, q.QuantityError) and issubclass(q.DimensionError, q.QuantityError)
    assert issubclass(q.QuantityError, ValueError)


@given(st.text(max_size=60), st.sampled_from(["m", "1", "N.s/m"]))
def test_any_text_is_a_number_or_a_quantity_error(text: str, expected: str) -> None:
    with contextlib.suppress(q.QuantityError):
        assert math.isfinite(q.parse_quantity(text, expected))


@given(st.text(alphabet="mstN1238.*/()^- ", max_size=30))
def test_any_expression_is_a_unit_or_a_quantity_error(text: str) -> None:
    with contextlib.suppress(q.QuantityError):
        assert len(q.dimension(text)) == len(q.BASES)


@given(values, expressions)
def test_round_trip_through_base_units(value: float, unit: str) -> None:
    base = q.base_expression(q.dimension(unit))
    assert q.same_dimension(unit, base)
    # two divisions and two products round: 4 half ulps
    assert q.convert(q.convert(value, unit, base), base, unit) == pytest.approx(value, rel=1e-15, abs=1e-300)


@given(st.floats(allow_nan=False, allow_infinity=False), expressions)
def test_text_round_trip_is_exact_in_the_same_unit(value: float, unit: str) -> None:
    assert q.parse_quantity(f"{value!r} {unit}", unit) == value


@given(expressions, expressions)
def test_dimensions_add_in_a_product_and_cancel_in_a_quotient(first: str, second: str) -> None:
    product = q.dimension(f"({first}).({second})")
    assert product == tuple(a + b for a, b in zip(q.dimension(first), q.dimension(second), strict=True))
    assert q.base_expression(q.dimension(f"({first})/({first})")) == "1"


def test_unit_definition_of_fmi() -> None:
    base, factor, displays = q.unit_definition("N.s/m")
    assert (base, factor) == ({"kg": 1, "s": -1}, 1.0)
    assert dict(displays)["lbf.s/ft"] == pytest.approx(1 / 14.593902937206364, rel=1e-15)
    assert q.unit_definition("1") == ({}, 1.0, (("%", 100.0),))
    assert q.unit_definition("ft")[:2] == ({"m": 1}, 0.3048)


@pytest.mark.parametrize("unit", q.DISPLAY)
def test_display_units_measure_the_same_and_are_si_coherent(unit: str) -> None:
    _, factor, displays = q.unit_definition(unit)
    assert factor == 1.0 and displays
    for name, display_factor in displays:
        # FMI 2.0, 2.2.2: displayed value = factor * value
        assert q.convert(1.0, unit, name) == pytest.approx(display_factor, rel=1e-15)
