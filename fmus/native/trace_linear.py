"""Traces a linear unit: its set-up with CasADi matrices, everything else with scalars, and the text of its ``Linear``.

The functions are those of ``docs/native.md``; structural parameters are numbers while tracing, because sizes depend on
them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import chain
from typing import Any

import casadi as ca

from ...models.numeric.matrix_ops import traces
from ...models.protocol.state_space import Comparison, Resolution, Setup, Study
from ..declare.interface import Interface
from ..declare.unit import Unit, Variable, local
from .source import array, entry, initializer
from .trace import OPS, NotNative, Traced, column, dense, forward, parts

MATRICES = ("a", "b", "c", "d", "e")
Sizes = dict[str, int]
Positions = tuple[tuple[int, ...], ...]


def trace(unit: Unit, structure: Mapping[str, float]) -> Traced:
    """The unit's functions for the structural parameters of ``structure``, the others as `structure_of` says. Raises
    `NotNative`."""
    return _LinearTrace(unit, structure_of(unit, structure)).traced()


def structure_of(unit: Unit, given: Mapping[str, float]) -> dict[str, float]:
    """Values of all structural parameters: as given, else the default of the model's ``Size``, else the declared start."""
    size = unit.model.Size
    for name in given:
        if name not in size._fields:
            raise NotNative(f"{unit.name}.{name} is no structural parameter: expected one of {', '.join(size._fields)}")
    declared = {v.name: v.start for v in unit.parameters}
    return {name: float(given.get(name, size._field_defaults.get(name, declared[name]))) for name in size._fields}


class _LinearTrace:
    def __init__(self, unit: Unit, structure: dict[str, float]) -> None:
        self.unit, self.model, self.structure = unit, unit.model, structure
        self.size = self.model.Size(**structure)
        self.study: Study = self.model.study(self.size) if hasattr(self.model, "study") else Study()
        self.functions: dict[str, ca.Function] = {}
        self.own = len(self.model.Own._fields) if hasattr(self.model, "Own") else 0
        self.p = column("p", len(unit.parameters))
        found, self.layout = self._setup("setup", self.size)
        self.c = column("c", self.layout["constants"])
        # constants follow the matrices
        self.places = _numbered(found.constants, self.layout["e"] + math.prod(found.e.shape))
        self.constants = _mapped(self.places, lambda place: self.c[place])
        self.parameters = self._parameters(self.p)

    def _parameters(self, p: Any) -> Any:
        values = {v.name: p[i] for i, v in enumerate(self.unit.parameters)}
        return self.model.Parameters(**values | self.structure)

    def _setup(self, field: str, size: Any, setup: Callable[[Any, Any, Any], Setup] | None = None) -> tuple[Setup, Sizes]:
        """Adds the function p -> c of the set-up of ``size``; the set-up and where its matrices are in c. ``setup``: that of
        another model for the parameters of this one."""
        p = ca.MX.sym("p", len(self.unit.parameters))
        values = {v.name: p[i] for i, v in enumerate(self.unit.parameters)}
        structure = {name: value for name, value in zip(size._fields, size) if name in values}
        found: Setup = (setup or self.model.setup)(self.model.Parameters(**values | structure), size, traces())
        columns, layout = [], {"states": found.a[0].shape[0], "inputs": found.d.shape[1], "rows": found.d.shape[0]}
        layout["powers"] = len(found.a)
        offset = 0
        for name, powers in zip(MATRICES, (found.a, found.b, (found.c,), (found.d,), (found.e,))):
            layout[name] = offset
            for matrix in powers:
                columns.append(ca.vec(ca.densify(ca.MX(matrix))))
                offset += columns[-1].numel()
        columns += [ca.MX(value) for value in _leaves(found.constants)]
        c = ca.vertcat(*columns)
        self.functions[field] = ca.Function(f"model_{field}", [p], [c])
        return found, layout | {"constants": c.numel()}

    def traced(self) -> Traced:
        p, c, k, h, t = self.p, self.c, column("k", 4 * len(self.unit.inputs)), column("h", 1), column("t", 1)
        own, u, du = column("own", self.own), column("u", len(self.unit.inputs)), column("du", len(self.unit.inputs))
        y, y_rate, growth = column("y", self.layout["rows"]), column("y_rate", self.layout["rows"]), column("growth", 1)
        cubics = [parts(k)[i : i + 4] for i in range(0, k.numel(), 4)]
        at = (parts(own), parts(u), parts(du))
        model, last = self.model, (self.parameters, self.constants, OPS)
        conditions = self._requirements()
        self._add("required", [p, c], [value for value, _ in conditions])
        if hasattr(model, "describe"):
            self._add("calculate", [p, c], model.describe(*last))
        self._add("initial", [p, c], chain(*model.start(*last)) if hasattr(model, "start") else [0.0] * self.states)
        if hasattr(model, "schedule"):
            self._add("linear_schedule", [u, p, c], [model.schedule(parts(u), *last)])
        driven = [list(each) for each in model.drive(parts(own), cubics, *last)]
        orders = max(map(len, driven))
        filled = chain(*(each + [0.0] * (orders - len(each)) for each in driven))
        self._add("linear_drive", [own, k, p, c], filled)
        if self.own:
            self._add("linear_own_after", [h, own, k, p, c], model.own_after(h, parts(own), cubics, *last))
            self._add("linear_own_rates", [own, u, du, p, c], model.own_rates(*at, *last))
        self._add("linear_core", [own, u, du, p, c], *model.core(*at, *last))
        seen, extras = model.observe(t, at[0], parts(y), parts(y_rate), *at[1:], growth, *last)
        shown = extras if hasattr(model, "EXTRA") else ()
        self._add("linear_observe", [t, own, y, y_rate, u, du, growth, p, c], seen, shown)
        for name in ("linear_schedule", "linear_own_rates", "linear_core", "linear_observe"):
            if name in self.functions:
                self.functions[f"{name}_forward"] = forward(self.functions[name])
        linear = self._text(orders - 1)
        return Traced(
            self._interface(len(shown)), self.functions, 0, tuple(text for _, text in conditions),
            self.layout["constants"], linear,
        )  # fmt: skip

    @property
    def states(self) -> int:
        """Of the unreduced model, own states included."""
        return self.layout["states"] + self.own

    def _requirements(self) -> list[tuple[Any, str]]:
        """What the parameters and what followed from them must fulfil."""
        found: list[tuple[Any, str]] = []
        if hasattr(self.model, "requirements"):
            found += self.model.requirements(self.parameters, OPS)
        if hasattr(self.model, "setup_requirements"):
            found += self.model.setup_requirements(self.parameters, self.constants, OPS)
        return found

    def _add(self, field: str, arguments: list[Any], *results: Iterable[Any]) -> None:
        self.functions[field] = ca.Function(f"model_{field}", arguments, [_column(each) for each in results])

    def _interface(self, extras: int) -> Interface:
        unit, n = self.unit, self.layout["states"]
        core, observe = self.functions["linear_core"], self.functions["linear_observe"]
        known = {v.name: v for v in unit.observed + unit.states}
        own = tuple(known.get(name, local(name, "1", "")) for name in self.model.Own._fields) if self.own else ()
        core_states = tuple(local(f"z[{i + 1}]", "1", f"Core state {i + 1} of {n}") for i in range(n))
        of_core = {n + i for result in range(3) for i in _columns(core, result, 0)}
        of_inputs = {i for result in range(3) for i in _columns(core, result, 1)}
        if "linear_schedule" in self.functions:
            of_inputs |= set(_columns(self.functions["linear_schedule"], 0, 0))
        derivative_inputs = [tuple(sorted(of_inputs))] * n
        derivative_states = [tuple(sorted({*range(n), *of_core}))] * n
        if self.own:
            rates = self.functions["linear_own_rates"]
            derivative_inputs += _rows(rates, 1)
            derivative_states += [tuple(n + i for i in row) for row in _rows(rates, 0)]
        by_core = [bool(y or rate) for y, rate in zip(_rows(observe, 2), _rows(observe, 3))]
        observed_states = tuple(
            tuple(sorted({n + i for i in row} | ({*range(n), *of_core} if through else set())))
            for row, through in zip(_rows(observe, 1), by_core)
        )
        return Interface(
            unit, core_states + own, self._extras(extras), reinit=(False,) * (n + self.own),
            derivative_inputs=tuple(derivative_inputs), derivative_states=tuple(derivative_states),
            observed_states=observed_states, structure=self.structure,
        )  # fmt: skip

    def _extras(self, count: int) -> tuple[Variable, ...]:
        if not count:
            return ()
        name, unit, description = self.model.EXTRA
        return tuple(local(f"{name}[{i + 1}]", unit, description) for i in range(count))

    # ---- text of the Linear -------------------------------------------------------------------------------------------

    def _text(self, degree: int) -> str:
        """C text that defines ``linear``, its comparisons and its resolution before it."""
        study, names = self.study, [v.name for v in self.unit.parameters]
        reduction, before = study.reduction, []
        functions = {f.removeprefix("linear_"): entry(function) for f, function in self.functions.items()
                     if f.startswith("linear_")}  # fmt: skip
        fields = {
            "layout": _layout(self.layout),
            "own": str(self.own),
            "degree": str(degree),
            "rate_rows": str(1 + max(_columns(self.functions["linear_observe"], 0, 3), default=-1)),
            **functions,
            "growth": self._place(study.growth_below),
            **{name: str(names.index(name) if reduction and name in names else -1) for name in ("reduced", "tolerance", "band")},
            "modal": "true" if reduction and reduction.modal else "false",
            "measured": self._place(reduction.measured if reduction else None),
            "states_used": self._place(reduction.states if reduction else None),
            "error": self._place(reduction.error if reduction else None),
            "direct": "-1",
        }
        if reduction and reduction.direct:
            name, row, col = reduction.direct
            fields |= {"direct": str(min(getattr(self.places, name))), "direct_row": str(row), "direct_column": str(col)}
        if reduction and self.layout["powers"] > 1:
            raise TypeError(f"{self.unit.name}: a scheduled model is not reduced")
        if study.comparisons:
            if "band" not in names:
                raise TypeError(f"{self.unit.name}: comparisons are made up to the parameter band, which it has not")
            fields["band"] = str(names.index("band"))
            before.append(array("Comparison", "comparison", map(self._comparison, *zip(*enumerate(study.comparisons)))))
            fields |= {"comparison": "comparison", "comparisons": str(len(study.comparisons))}
        if study.resolution:
            before.append(f"static const Resolution resolution = {self._resolution(study.resolution)};")
            fields["resolution"] = "&resolution"
        return "\n\n".join([*before, "static const Linear linear = {\n" + initializer(fields) + "};"])

    def _place(self, name: str | None) -> str:
        """Position of a component of the constants in c."""
        return "-1" if name is None else str(getattr(self.places, name))

    def _comparison(self, number: int, each: Comparison) -> str:
        field = f"linear_comparison_{number}"
        other = each.stand_in[0] if each.stand_in else None
        _, layout = self._setup(field, each.size, other)
        fields = {"setup": entry(self.functions[field]), "layout": _layout(layout), "weight": repr(each.weight),
                  "truer": "true" if each.truer else "false", "target": self._place(each.target)}  # fmt: skip
        if each.stand_in:
            _, stand_in = self._setup(f"{field}_stand_in", each.stand_in[1], other)
            fields |= {"stand_in": entry(self.functions[f"{field}_stand_in"]), "stand_in_layout": _layout(stand_in)}
        if each.when:
            self._add(f"{field}_when", [self.p], [each.when(self.parameters, OPS)])
            fields["when"] = entry(self.functions[f"{field}_when"])
        return "{\n" + initializer(fields) + "}"

    def _resolution(self, r: Resolution) -> str:
        _, layout = self._setup("linear_resolution", r.size)
        return "{\n" + initializer({
            "setup": entry(self.functions["linear_resolution"]), "layout": _layout(layout), "modes": str(r.modes),
            "below": self._place(r.below), "target": self._place(r.target), "error": repr(r.error),
            "grid": repr(r.grid), "end": repr(r.end),
        }) + "}"  # fmt: skip


def _column(values: Iterable[Any]) -> Any:
    found = list(values)
    return dense(found) if found else ca.SX.zeros(0, 1)


def _layout(sizes: Sizes) -> str:
    return "{" + ", ".join(f".{name} = {value}" for name, value in sizes.items()) + "}"


def _leaves(constants: Any) -> list[Any]:
    """The scalars of a named tuple of scalars and tuples of scalars, in order."""
    return [leaf for value in constants for leaf in (value if isinstance(value, tuple) else (value,))]


def _numbered(constants: Any, first: int) -> Any:
    """The same named tuple with the position of every scalar, counted from ``first``."""
    numbers = iter(range(first, first + len(_leaves(constants))))
    return _mapped(constants, lambda _: next(numbers))


def _mapped(constants: Any, change: Callable[[Any], Any]) -> Any:
    return type(constants)(*(tuple(map(change, v)) if isinstance(v, tuple) else change(v) for v in constants))


def _rows(function: ca.Function, argument: int) -> list[tuple[int, ...]]:
    """Positions in an argument on which each component of the first result depends."""
    pattern = function.jac_sparsity(0, argument)
    found: list[list[int]] = [[] for _ in range(pattern.size1())]
    for row, col in zip(*pattern.get_triplet()):
        found[row].append(col)
    return [tuple(sorted(row)) for row in found]


def _columns(function: ca.Function, result: int, argument: int) -> Sequence[int]:
    """Positions in an argument on which a result depends."""
    return sorted(set(function.jac_sparsity(result, argument).get_triplet()[1]))
