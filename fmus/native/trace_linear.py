"""Traces a linear unit: its set-up with CasADi matrices, everything else with scalars.

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
from ...models.protocol.linear_model import LinearModel
from ...models.protocol.state_space import Comparison, Setup, Study
from ...models.protocol.variables import local
from ..declare.interface import Interface
from ..declare.unit import Unit, Variable, named
from .traced import OPS, NotNative, Traced, TracedLinear, column, dense, forward, parts

MATRICES = ("a", "b", "c", "d", "e")
Sizes = dict[str, int]


def trace_linear(unit: Unit, structure: Mapping[str, float]) -> Traced:
    """The unit's functions for the structural parameters of ``structure``, the others as `structure_of` says. Raises
    `NotNative`."""
    return _LinearTrace(unit, structure_of(unit, structure)).traced()


def structure_of(unit: Unit, given: Mapping[str, float]) -> dict[str, float]:
    """Values of all structural parameters: as given, else the default of the model's ``Size``, else the declared start."""
    size = linear_of(unit).Size
    for name in given:
        if name not in size._fields:
            raise NotNative(f"{unit.name}.{name} is no structural parameter: expected one of {', '.join(size._fields)}")
    declared = {v.name: v.start for v in unit.parameters}
    return {name: float(given.get(name, size._field_defaults.get(name, declared[name]))) for name in size._fields}


def linear_of(unit: Unit) -> LinearModel:
    """The linear model of a unit that has one."""
    assert unit.model.linear is not None
    return unit.model.linear


class _LinearTrace:
    def __init__(self, unit: Unit, structure: dict[str, float]) -> None:
        self.unit, self.model, self.structure = unit, linear_of(unit), structure
        self.size = self.model.Size(**structure)
        self.study: Study = self.model.studied(self.size)
        self.functions: dict[str, ca.Function] = {}
        self.layouts: dict[str, Sizes] = {}
        self.own = len(self.model.Own._fields)
        self.p = column("p", len(unit.parameters))
        setup = self._setup("setup", self.size)
        self.layout = self.layouts["setup"]
        self.c = column("c", self.layout["constants"])
        # constants follow the matrices
        self.places = _numbered(setup.constants, self.layout["e"] + math.prod(setup.e.shape))
        self.constants = _mapped(self.places, lambda place: self.c[place])
        self.parameters = self._parameters(self.p)

    def _parameters(self, p: Any) -> Any:
        values = {v.name: p[i] for i, v in enumerate(self.unit.parameters)}
        return self.model.Parameters(**values | self.structure)

    def _setup(self, field: str, size: Any, setup: Callable[[Any, Any, Any], Setup] | None = None) -> Setup:
        """The set-up of ``size``; adds the function p -> c of it and where its matrices are in c. ``setup``: that of another
        model for the parameters of this one."""
        p = ca.MX.sym("p", len(self.unit.parameters))
        values = {v.name: p[i] for i, v in enumerate(self.unit.parameters)}
        structure = {name: value for name, value in zip(size._fields, size) if name in values}
        made: Setup = (setup or self.model.setup)(self.model.Parameters(**values | structure), size, traces())
        columns = []
        layout = {"states": made.a[0].shape[0], "inputs": made.d.shape[1], "rows": made.d.shape[0], "powers": len(made.a)}
        offset = 0
        for name, powers in zip(MATRICES, (made.a, made.b, (made.c,), (made.d,), (made.e,))):
            layout[name] = offset
            for matrix in powers:
                columns.append(ca.vec(ca.densify(ca.MX(matrix))))
                offset += columns[-1].numel()
        columns += [ca.MX(value) for value in _leaves(made.constants)]
        c = ca.vertcat(*columns)
        self.functions[field] = ca.Function(f"model_{field}", [p], [c])
        self.layouts[field] = layout | {"constants": c.numel()}
        return made

    def traced(self) -> Traced:
        p, c, k, h, t = self.p, self.c, column("k", 4 * len(self.unit.inputs)), column("h", 1), column("t", 1)
        own, u, du = column("own", self.own), column("u", len(self.unit.inputs)), column("du", len(self.unit.inputs))
        y, y_rate, growth = column("y", self.layout["rows"]), column("y_rate", self.layout["rows"]), column("growth", 1)
        model, last = self.model, (self.parameters, self.constants, OPS)
        inputs = model.Inputs._make
        cubics = inputs(parts(k)[i : i + 4] for i in range(0, k.numel(), 4))
        at = (model.Own._make(parts(own)), inputs(parts(u)), inputs(parts(du)))
        requirements = self._requirements()
        self._add("required", [p, c], [value for value, _ in requirements])
        self._add("calculate", [p, c], model.describe(*last))
        self._add("initial", [p, c], chain(*model.start(*last)) if model.start else [0.0] * self.states)
        if model.schedule:
            self._add("linear_schedule", [u, p, c], [model.schedule(at[1], *last)])
        driven = [list(each) for each in model.drive(at[0], cubics, *last)]
        orders = max(map(len, driven))
        filled = chain(*(each + [0.0] * (orders - len(each)) for each in driven))
        self._add("linear_drive", [own, k, p, c], filled)
        if model.own_after and model.own_rates:
            self._add("linear_own_after", [h, own, k, p, c], model.own_after(h, at[0], cubics, *last))
            self._add("linear_own_rates", [own, u, du, p, c], model.own_rates(*at, *last))
        self._add("linear_core", [own, u, du, p, c], *model.core(*at, *last))
        seen, extras = model.observe(t, at[0], parts(y), parts(y_rate), *at[1:], growth, *last)
        shown = extras if model.extra else ()
        self._add("linear_observe", [t, own, y, y_rate, u, du, growth, p, c], seen, shown)
        for name in ("linear_schedule", "linear_own_rates", "linear_core", "linear_observe"):
            if name in self.functions:
                self.functions[f"{name}_forward"] = forward(self.functions[name])
        self._study()
        rate_rows = 1 + max(_columns(self.functions["linear_observe"], 0, 3), default=-1)
        linear = TracedLinear(self.study, self.layouts, self.own, orders - 1, rate_rows, self.places)
        return Traced(
            self._interface(len(shown)), self.functions, 0, tuple(text for _, text in requirements),
            self.layout["constants"], linear,
        )  # fmt: skip

    def _study(self) -> None:
        """Adds the set-ups with which the unit is compared. Raises ``TypeError`` for a study that cannot be made."""
        study = self.study
        if study.reduction and self.layout["powers"] > 1:
            raise TypeError(f"{self.unit.name}: a scheduled model is not reduced")
        if study.comparisons and not any(v.name == "band" for v in self.unit.parameters):
            raise TypeError(f"{self.unit.name}: comparisons are made up to the parameter band, which it has not")
        for number, comparison in enumerate(study.comparisons):
            self._compare(f"linear_comparison_{number}", comparison)
        if study.resolution:
            self._setup("linear_resolution", study.resolution.size)

    def _compare(self, field: str, comparison: Comparison) -> None:
        other = comparison.stand_in[0] if comparison.stand_in else None
        self._setup(field, comparison.size, other)
        if comparison.stand_in:
            self._setup(f"{field}_stand_in", comparison.stand_in[1], other)
        if comparison.when:
            self._add(f"{field}_when", [self.p], [comparison.when(self.parameters, OPS)])

    @property
    def states(self) -> int:
        """Of the unreduced model, own states included."""
        return self.layout["states"] + self.own

    def _requirements(self) -> list[tuple[Any, str]]:
        """What the parameters and what followed from them must fulfil."""
        required = [*self.model.requirements(self.parameters, OPS)] if self.model.requirements else []
        if self.model.setup_requirements:
            required += self.model.setup_requirements(self.parameters, self.constants, OPS)
        return required

    def _add(self, field: str, arguments: list[Any], *results: Iterable[Any]) -> None:
        self.functions[field] = ca.Function(f"model_{field}", arguments, [_column(each) for each in results])

    def _interface(self, extras: int) -> Interface:
        unit, n = self.unit, self.layout["states"]
        core, observe = self.functions["linear_core"], self.functions["linear_observe"]
        known = {v.name: v for v in unit.observed + unit.states}
        own = tuple(known.get(name, named(name, local("1", ""))) for name in self.model.Own._fields)
        core_states = tuple(named(f"z[{i + 1}]", local("1", f"Core state {i + 1} of {n}")) for i in range(n))
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
        if not self.model.extra:
            return ()
        name, quantity = self.model.extra
        return tuple(named(f"{name}[{i + 1}]", quantity) for i in range(count))

def _column(values: Iterable[Any]) -> Any:
    components = list(values)
    return dense(components) if components else ca.SX.zeros(0, 1)


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
    rows: list[list[int]] = [[] for _ in range(pattern.size1())]
    for row, col in zip(*pattern.get_triplet()):
        rows[row].append(col)
    return [tuple(sorted(row)) for row in rows]


def _columns(function: ca.Function, result: int, argument: int) -> Sequence[int]:
    """Positions in an argument on which a result depends."""
    return sorted(set(function.jac_sparsity(result, argument).get_triplet()[1]))
