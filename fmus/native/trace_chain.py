"""Traces what a wire needs to C: pull and load of a point with their derivatives; tables, limits and ports of its steps.

    point_loads(g, g', v, a, material) -> n, q
    point_derivatives(same) -> dn/dg, dn/dg', dq/dg, dq/dv, dq/da         matrices column by column
    point_moment(slopes of r and u, second slope of r, u, b, water, paid, place, material) -> n, q times the half length
    point_moment_forward: the change of that, as CasADi's fwd1
    point_bent(as the moment, without b) -> curvature squared, speed across; point_bent_forward: its change

each in the plane and in space; of the moment its change alone is called. ``place`` is (half length at the start, share of the
last section below, 1 if in it, length of that section).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import casadi as ca
import numpy as np

from ...models.cable.units import wire_ports
from ...models.cable.wire import grading, rest, stepper
from ...models.cable.wire.chain import HAULED
from ...models.cable.wire.elements import LARGEST_DEGREE, lagrange, legendre, rule
from ...models.cable.wire.point import SMALL_SPEED2, Material, bent, load, pull
from ...models.cable.wire.tableaus import FOURTH, SECOND, THIRD, Tableau
from ...models.numeric.tableaus import DORMAND_PRINCE_5
from ..declare.interface import Interface
from ..declare.unit import Unit
from .source import model_source
from .traced import OPS, Traced, column, dense, forward, parts

MOST_STAGES = 6
DIMENSIONS = (2, 3)
LIMITS = ("STATIONS", "LEAST_ROOM", "BENDING_LIMIT", "MOST_BENDING", "REYNOLDS_LIMIT", "VISCOSITY")
"""Of ``wire_ports.py``, which C takes."""


def point_functions(d: int) -> dict[str, ca.Function]:
    """The functions that the runtime calls for a wire of ``d`` dimensions, in the order of ``point`` in ``unit.h``."""
    k = column("k", len(Material._fields))
    material = Material(*parts(k))
    g, rate, v, a = (column(name, d) for name in ("g", "rate", "v", "a"))
    n = dense(pull(tuple(parts(g)), tuple(parts(rate)), material, OPS)[0])
    q = dense(load(tuple(parts(g)), tuple(parts(rate)), tuple(parts(v)), tuple(parts(a)), material, OPS))
    columns = [ca.densify(ca.jacobian(y, x)) for y, x in ((n, g), (n, rate), (q, g), (q, v), (q, a))]
    return {
        f"point_loads_{d}d": ca.Function(f"point_loads_{d}d", [g, rate, v, a, k], [n, q]),
        f"point_derivatives_{d}d": ca.Function(f"point_derivatives_{d}d", [g, rate, v, a, k], columns),
        f"point_moment_{d}d_forward": forward(_moment(d, k, material)),
        f"point_bent_{d}d": _bent(d),
        f"point_bent_{d}d_forward": forward(_bent(d)),
    }


def _moment(d: int, k: Any, material: Material) -> ca.Function:
    """As ``chain.py`` has it, with payout."""
    dr, du, ddr, u, b, water = (column(name, d) for name in ("dr", "du", "ddr", "u", "b", "water"))
    paid, place = column("paid", 3), column("place", 4)
    start, share, grows, last = parts(place)
    half = start * (1.0 + grows * paid[0] / last)
    sigma, faster, stretch = paid[1] * share, paid[2] * share, grows * paid[1] / (last + paid[0])
    g, bend = dr / half, ddr / (half * half)
    rate = du / half - stretch * g
    a = b - 2.0 * sigma * rate + sigma * sigma * bend - faster * g
    v = u - sigma * g - water
    n = pull(tuple(parts(g)), tuple(parts(rate)), material, OPS)[0]
    q = load(tuple(parts(g)), tuple(parts(rate)), tuple(parts(v)), tuple(parts(a)), material, OPS)
    return ca.Function(
        f"point_moment_{d}d", [dr, du, ddr, u, b, water, paid, place, k], [dense(n), half * dense(q)]
    )  # fmt: skip


def _bent(d: int) -> ca.Function:
    """Of a moment, what bounds the model."""
    dr, ddr, u, water = (column(name, d) for name in ("dr", "ddr", "u", "water"))
    paid, place = column("paid", 3), column("place", 4)
    start, share, grows, last = parts(place)
    half = start * (1.0 + grows * paid[0] / last)
    g, bend = dr / half, ddr / (half * half)
    v = u - paid[1] * share * g - water
    results = bent(tuple(parts(g)), tuple(parts(bend)), tuple(parts(v)), OPS)
    return ca.Function(f"point_bent_{d}d", [dr, ddr, u, water, paid, place], [dense(results)])


def trace_chain(unit: Unit) -> Traced:
    """A unit of a wire: its numbers and requirements as functions of the parameters. Nothing is fixed by the build."""
    model = unit.model
    assert model.numbers is not None
    p = column("p", len(unit.parameters))
    parameters = model.Parameters(**{v.name: p[i] for i, v in enumerate(unit.parameters)})
    numbers = dense(flat(model.numbers(parameters, OPS)))
    requirements = model.requirements(parameters, OPS) if model.requirements else ()
    functions = {
        "setup": ca.Function("model_setup", [p], [numbers]),
        "required": ca.Function("model_required", [p, column("c", numbers.numel())], [dense(r[0] for r in requirements)]),
    }
    for d in DIMENSIONS:
        functions |= point_functions(d)
    return Traced(
        Interface(unit, exchange=False), functions, 0, tuple(text for _, text in requirements), numbers.numel(),
        headers=chain_headers() | {"wire_ports.h": ports_source(unit, model.numbers(parameters, OPS))},
    )  # fmt: skip


def flat(values: Iterable[Any]) -> Iterator[Any]:
    """The numbers of nested tuples."""
    for value in values:
        if isinstance(value, tuple):
            yield from flat(value)
        else:
            yield value


def ports_source(unit: Unit, numbers: Any) -> str:
    """``wire_ports.h``: what a wire takes and gives as structures of doubles, and the places of its inputs."""

    def structure(name: str, sizes: Mapping[str, int]) -> str:
        fields = "".join(f"    double {field}{f'[{n}]' if n > 1 else ''};\n" for field, n in sizes.items())
        return f"typedef struct {{\n{fields}}} {name};\n\n"

    sizes = {name: len(value) if isinstance(value, tuple) else 1 for name, value in numbers._asdict().items()}
    limits = "".join(f"#define WIRE_{name} {getattr(wire_ports, name)!r}\n" for name in LIMITS)
    inputs = ", ".join(f"IN_{v.name.upper()}" for v in unit.inputs)
    return _header(
        "wire_ports", f"enum {{ {inputs} }};\n\n{limits}\n" + structure("WireNumbers", sizes)
        + structure("WireCalculated", {v.name: 1 for v in unit.calculated})
        + structure("WireOutputs", {v.name: 1 for v in unit.observed}),
    )  # fmt: skip


def point_source() -> str:
    """C text of the functions of points alone, for a host without a unit."""
    functions: dict[str, ca.Function] = {}
    for d in DIMENSIONS:
        functions |= point_functions(d)
    return model_source(functions)


def _numbers(values: Iterable[float]) -> str:
    return ", ".join(repr(float(x)) for x in values)


def _table(name: str, values: Iterable[float]) -> str:
    return f"static const double {name}[] = {{{_numbers(values)}}};\n"


def _tableau(table: Tableau) -> str:
    """Arrays of one tableau."""
    name, rows = f"ORDER_{table.order}", (x for row in table.rows for x in (*row, *([0.0] * (MOST_STAGES - len(row)))))
    return _table(f"{name}_PLACES", table.places) + _table(f"{name}_ROWS", rows) + _table(f"{name}_ERROR", table.error)


def tableaus_source() -> str:
    """``chain_tableaus.h``: `CHAIN_TABLEAUS`, of orders 2, 3 and 4."""
    tables = (SECOND, THIRD, FOURTH)
    entries = ",\n".join(
        f"    {{{len(t.rows)}, {t.order}, {t.diagonal!r}, ORDER_{t.order}_PLACES, ORDER_{t.order}_ROWS, ORDER_{t.order}_ERROR}}"
        for t in tables
    )
    text = '#include "chain_step.h"\n\n' + "".join(map(_tableau, tables))
    return _header("chain_tableaus", text + f"static const ChainTableau CHAIN_TABLEAUS[] = {{\n{entries}\n}};\n")


def march_source() -> str:
    """``chain_marching.h``: the method that marches up the steady shape."""
    method = DORMAND_PRINCE_5
    stages = len(method.error[0])
    rows = ", ".join(f"{{{_numbers((*row, *([0.0] * (stages - 1 - len(row)))))}}}" for row in (*method.a[1:], method.b))
    return _header(
        "chain_marching", f"enum {{ MARCH_STAGES = {stages} }};\n\n"
        f"static const double MARCH_ROWS[][{stages - 1}] = {{{rows}}};\n" + _table("MARCH_ERROR", method.error[0]),
    )  # fmt: skip


def rules_source() -> str:
    """``chain_rules.h``: `CHAIN_RULES` of elements of degree 1 and up, and the places at which they are judged."""
    text, entries = '#include "chain.h"\n\n' + _table("CHAIN_INNER", grading.inner_places()), []
    for p in range(1, LARGEST_DEGREE + 1):
        points = rule(p)
        before = legendre(p - 2, p) if p > 1 else np.zeros(p + 1)
        tables = {
            "POINTS": points.points, "WEIGHTS": points.weights, "SLOPES": points.slopes, "INTEGRALS": points.integrals,
            "LAST": legendre(p - 1, p), "BEFORE": before, "SAMPLES": lagrange(p, grading.inner_places()),
        }  # fmt: skip
        text += "".join(_table(f"DEGREE_{p}_{name}", values.ravel()) for name, values in tables.items())
        entries.append("    {" + ", ".join(f"DEGREE_{p}_{name}" for name in tables) + "}")
    return _header("chain_rules", text + "static const ChainRule CHAIN_RULES[] = {\n" + ",\n".join(entries) + "\n};\n")


def limits_source() -> str:
    """``chain_limits.h``: the limits of ``stepper.py``, ``rest.py`` and ``grading.py``, what ``point.py`` adds under its roots,
    and places in a material."""
    names = {
        stepper: (
            "SLOW", "NEWTON", "SAFETY", "LEAST", "MOST", "LESS", "NO_ERROR", "ROUNDING", "END", "WORTH", "RUNAWAY",
            "DIVERGING", "MAX_ITERATIONS", "MAX_HALVINGS", "PATIENCE", "PROGRESS",
        ),
        rest: (
            "TOLERANCE", "MARCHED", "FAR", "ARRIVED", "FIRST_TIME", "SHORTER", "SHORTEST", "MAX_NEWTON", "MAX_MARCHES",
            "NO_TENSION",
        ),
        grading: ("MOST_ELEMENTS", "BEND", "SAMPLES", "INSIDE", "EQUAL"),
    }  # fmt: skip
    numbers = {name: getattr(module, name) for module, each in names.items() for name in each}
    numbers |= {"SMALL_SPEED2": SMALL_SPEED2, "HAULED": HAULED}
    numbers |= {f: Material._fields.index(f.lower()) for f in ("DAMPING", "WEIGHT")}
    return _header("chain_limits", "".join(f"#define CHAIN_{name} {value!r}\n" for name, value in numbers.items()))


def _header(name: str, text: str) -> str:
    guard = f"TOWAGE_{name.upper()}_H"
    return f"/* Made from models/cable/wire. */\n#ifndef {guard}\n#define {guard}\n\n{text}\n#endif\n"


def chain_headers() -> dict[str, str]:
    """What the chain layer of the runtime needs beside its own files, by name."""
    return {
        "chain_tableaus.h": tableaus_source(), "chain_marching.h": march_source(), "chain_rules.h": rules_source(),
        "chain_limits.h": limits_source(),
    }  # fmt: skip
