"""Traces what a wire needs to C: pull and load of a point with their derivatives; tableaus and limits of its steps.

    point_loads(g, g', v, a, material) -> n, q
    point_derivatives(same) -> dn/dg, dn/dg', dq/dg, dq/dv, dq/da         matrices column by column
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import casadi as ca

from ...models.cable.wire import rest, stepper
from ...models.cable.wire.point import SMALL_SPEED2, Material, load, pull
from ...models.cable.wire.tableaus import FOURTH, SECOND, THIRD, Tableau
from .traced import OPS, dense, parts

MOST_STAGES = 6


def point_source(dimensions: int) -> str:
    """C text of the two functions for a wire in the plane (2) or in space (3)."""
    g, rate, v, a = (ca.SX.sym(name, dimensions) for name in ("g", "rate", "v", "a"))
    k = ca.SX.sym("k", len(Material._fields))
    material = Material(*parts(k))
    n = dense(pull(tuple(parts(g)), tuple(parts(rate)), material, OPS)[0])
    q = dense(load(tuple(parts(g)), tuple(parts(v)), tuple(parts(a)), material, OPS))
    columns = [ca.densify(ca.jacobian(y, x)) for y, x in ((n, g), (n, rate), (q, g), (q, v), (q, a))]
    generator = ca.CodeGenerator("point.c", {"casadi_int": "long long"})
    generator.add(ca.Function("point_loads", [g, rate, v, a, k], [n, q]))
    generator.add(ca.Function("point_derivatives", [g, rate, v, a, k], columns))
    with tempfile.TemporaryDirectory() as folder:
        generator.generate(folder + "/")
        return (Path(folder) / "point.c").read_text("utf-8")


def _numbers(values: tuple[float, ...]) -> str:
    return ", ".join(repr(float(x)) for x in values)


def _tableau(table: Tableau) -> str:
    """Arrays of one tableau."""
    rows = (_numbers((*row, *([0.0] * (MOST_STAGES - len(row))))) for row in table.rows)
    name = f"ORDER_{table.order}"
    return (
        f"static const double {name}_PLACES[] = {{{_numbers(table.places)}}};\n"
        f"static const double {name}_ROWS[] = {{{', '.join(rows)}}};\n"
        f"static const double {name}_ERROR[] = {{{_numbers(table.error)}}};\n"
    )


def tableaus_source() -> str:
    """``chain_tableaus.h``: `CHAIN_TABLEAUS`, of orders 2, 3 and 4."""
    tables = (SECOND, THIRD, FOURTH)
    entries = ",\n".join(
        f"    {{{len(t.rows)}, {t.order}, {t.diagonal!r}, ORDER_{t.order}_PLACES, ORDER_{t.order}_ROWS, ORDER_{t.order}_ERROR}}"
        for t in tables
    )
    text = '#include "chain_step.h"\n\n' + "".join(map(_tableau, tables))
    return _header("tableaus", text + f"static const ChainTableau CHAIN_TABLEAUS[] = {{\n{entries}\n}};\n")


def limits_source() -> str:
    """``chain_limits.h``: the limits of ``stepper.py`` and ``rest.py``, and what ``point.py`` adds under its roots."""
    names = (
        "SLOW", "NEWTON", "SAFETY", "LEAST", "MOST", "LESS", "NO_ERROR", "ROUNDING", "END", "WORTH", "RUNAWAY", "DIVERGING",
        "MAX_ITERATIONS", "MAX_HALVINGS",
    )  # fmt: skip
    at_rest = ("TOLERANCE", "MARCHED", "FAR", "ARRIVED", "FIRST_TIME", "SHORTER", "MAX_NEWTON", "MAX_MARCHES")
    numbers = {
        **{name: getattr(stepper, name) for name in names}, **{name: getattr(rest, name) for name in at_rest},
        "SMALL_SPEED2": SMALL_SPEED2,
    }  # fmt: skip
    return _header("limits", "".join(f"#define CHAIN_{name} {value!r}\n" for name, value in numbers.items()))


def _header(name: str, text: str) -> str:
    guard = f"TOWAGE_CHAIN_{name.upper()}_H"
    return f"/* Made from models/cable/wire. */\n#ifndef {guard}\n#define {guard}\n\n{text}\n#endif\n"


def chain_sources(dimensions: int) -> dict[str, str]:
    """What the chain layer of the runtime needs beside its own files, by name."""
    return {
        "point.c": point_source(dimensions), "chain_tableaus.h": tableaus_source(), "chain_limits.h": limits_source(),
    }  # fmt: skip
