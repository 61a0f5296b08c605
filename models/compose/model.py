"""Models joined into one: the outputs of some are inputs of others, without an interface and so without its error.

    x_i' = f_i(t, x_i, m_i, u_i),   y_i = g_i(t, x_i, m_i, u_i, u_i'),   u_i = factor * y_j for what is connected

`compose` returns an object with the interface of a model module, for all ops alike. States, modes, parameters, inputs
and outputs are those of the parts one after the other, named ``<part>.<name>``; connected inputs are no inputs any more.

1. Signals are computed in the order in which they depend on each other, found by `dependence` from the functions
   themselves; an output is computed as soon as the inputs are known that it goes straight through.
2. A rate u' is the source's ``<output>_rate``, else its exact directional derivative (`dual_ops`).
3. A closed loop that is linear in its signals w = g + G w, such as one through accelerations, is solved in place,
   (I - G) w = g. No pivots are sought: for the apparent masses of a tow I - G is I + M^-1 A with M diagonal, both
   positive definite, whose leading minors are positive. Any other loop is refused.
4. Parts hold their branches (``freeze_branches`` = 1): their ``event_*`` are indicators of the whole, located as its own.
5. Transitions are made part by part, each seeing what the others became, as often as there are parts that have any: a
   change runs through a chain of that length at most.
6. x' is a function of inputs, not of their rates: where an input left open acts by its rate (the apparent mass of a tow
   on an unconnected end), that rate counts as zero in x'; in outputs it counts as it is.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields
from types import ModuleType
from typing import Any, NamedTuple

from ..numeric.dual_ops import Dual, duals, lift, output_rates, second
from ..numeric.ops import NEVER, Ops, Value
from .plan import HELD, KINDS, Call, Connection, Loop, Named, Plan, Signals, Target, named


class Composed(ModuleType):
    """A model made of models; see `compose`. ``spelling`` may put other functions in place of those of the models, with
    the same values."""

    def __init__(
        self, name: str, parts: Mapping[str, ModuleType], connections: Sequence[Connection],
        spelling: Callable[[ModuleType], Any] = lambda model: model,
    ) -> None:  # fmt: skip
        super().__init__(name, __doc__)
        self.parts, self.connections = dict(parts), tuple(connections)
        self._models = models = [spelling(model) for model in parts.values()]
        signals = Signals(self.parts, self.connections)
        self.State = named("State", signals.names("State"))
        self.Modes = named("Modes", signals.names("Modes"))
        self.Inputs = named("Inputs", (f"{part}.{name}" for part, name in signals.open))
        self.clocks = [i for i, model in enumerate(models) if hasattr(model, "next_event_time")]
        self.Outputs = named("Outputs", (*signals.names("Outputs"), *(("next_event_time",) if self.clocks else ())))
        self.Calculated = named("Calculated", signals.names("Calculated"))
        self._signals = signals
        self._x, self._m = signals.slices("State"), signals.slices("Modes")
        self._changing = [i for i, model in enumerate(models) if hasattr(model, "transition")]
        self._for_rates = signals.plan(signals.used_by("derivatives"))
        self._for_events = signals.plan(signals.used_by("indicators") | signals.used_by_events())
        self._for_outputs = signals.plan(signals.used_by("outputs"))
        self._for_change = [signals.plan(signals.used_by("transition", i)) for i in self._changing]
        if self._changing:
            self.transition = self._transition
        if self.clocks:
            self.next_event_time = self._next_event_time

    def over(self, spelling: Callable[[ModuleType], Any]) -> Composed:
        """The same of parts in another spelling, as `fmus.inline.floats` makes them."""
        return Composed(self.__name__, self.parts, self.connections, spelling)

    def Parameters(self, *values: Value, **named: Value) -> tuple[Any, ...]:
        """The parts' parameters, from values in the order of the parts (without ``freeze_branches``) or by name."""
        given, found = iter(values), []
        for part, model in self.parts.items():
            own = {}
            for field in fields(model.Parameters):
                name = field.name
                own[name] = 1.0 if name == HELD else named[f"{part}.{name}"] if named else next(given)
            found.append(model.Parameters(**own))
        return tuple(found)

    def initial(self, p: Sequence[Any], ops: Ops) -> tuple[Named, Named]:
        """Every part at its start."""
        starts = [model.initial(own, ops) for model, own in zip(self._models, p)]
        return self.State(v for x, _ in starts for v in x), self.Modes(v for _, m in starts for v in m)

    def requirements(self, p: Sequence[Any], ops: Ops) -> tuple[tuple[Value, str], ...]:
        """What the parts require, with the name of the part."""
        return tuple(
            (value, f"{part}: {message}")
            for (part, model), own in zip(self.parts.items(), p) if hasattr(model, "requirements")
            for value, message in model.requirements(own, ops)
        )  # fmt: skip

    def calculated(self, p: Sequence[Any], ops: Ops) -> Named:
        """Calculated parameters of all parts."""
        having = [(model, own) for model, own in zip(self._models, p) if hasattr(model, "calculated")]
        return self.Calculated(v for model, own in having for v in model.calculated(own, ops))

    def derivatives(self, t: Value, x: Any, m: Any, u: Any, p: Any, ops: Ops) -> Named:
        """x' of all parts."""
        now = self._at(self._for_rates, t, x, m, u, (), p, ops)
        return self.State(
            v for i, model in enumerate(self._models) if self._x[i].start < self._x[i].stop
            for v in model.derivatives(t, now.x[i], now.m[i], now.u[i], p[i], ops)
        )  # fmt: skip

    def outputs(self, t: Value, x: Any, m: Any, u: Any, du: Any, p: Any, ops: Ops) -> Named:
        """All observables of all parts."""
        now = self._at(self._for_outputs, t, x, m, u, du, p, ops)
        found = [
            v for i, model in enumerate(self._models)
            for v in model.outputs(t, now.x[i], now.m[i], now.u[i], now.du[i], *second(model, now.ddu[i]), p[i], ops)
        ]  # fmt: skip
        return self.Outputs(found + ([self._next_event_time(t, m, p, ops)] if self.clocks else []))

    def indicators(self, t: Value, x: Any, m: Any, u: Any, p: Any, ops: Ops) -> tuple[Value, ...]:
        """Zero-crossing functions of all parts, their ``event_*`` included."""
        now = self._at(self._for_events, t, x, m, u, (), p, ops)
        found: list[Value] = []
        for i, model in enumerate(self._models):
            if hasattr(model, "indicators"):
                found += model.indicators(t, now.x[i], now.m[i], now.u[i], p[i], ops)
            if events := self._signals.events[i]:
                seen = model.outputs(t, now.x[i], now.m[i], now.u[i], now.du[i], *second(model, now.ddu[i]), p[i], ops)
                found += [seen[k] for k in events]
        return tuple(found)

    def _transition(self, t: Value, x: Any, m: Any, u: Any, p: Any, ops: Ops) -> tuple[Named, Named]:
        """The discrete changes of all parts."""
        x, m = list(x), list(m)
        for _ in self._changing:
            for i, plan in zip(self._changing, self._for_change):
                now = self._at(plan, t, x, m, u, (), p, ops)
                x[self._x[i]], m[self._m[i]] = self._models[i].transition(t, now.x[i], now.m[i], now.u[i], p[i], ops)
        return self.State(x), self.Modes(m)

    def _next_event_time(self, t: Value, m: Any, p: Any, ops: Ops) -> Value:
        """The earliest of all parts."""
        first: Value = NEVER
        for i in self.clocks:
            first = ops.minimum(first, self._models[i].next_event_time(t, m[self._m[i]], p[i], ops))
        return first

    # ---- signals ----------------------------------------------------------------------------------------------------

    def _at(self, plan: Plan, t: Value, x: Any, m: Any, u: Any, du: Any, p: Any, ops: Ops) -> _Point:
        """The parts' states and the inputs that ``plan`` finds; what no one asked for is 0."""
        x, m = tuple(x), tuple(m)
        sizes = [len(model.Inputs._fields) for model in self._models]
        u_all, du_all, ddu_all = ([[0.0] * n for n in sizes] for _ in KINDS)
        now = _Point(t, [x[s] for s in self._x], [m[s] for s in self._m], u_all, du_all, ddu_all, p)
        for k, (part, place) in enumerate(self._signals.open_places):
            now.u[part][place] = u[k]
            now.du[part][place] = du[k] if du else 0.0
        for stage in plan:
            if isinstance(stage, Loop):
                self._solve(stage, now, ops)
            else:
                for (kind, part, place), value in self._call(stage, now, ops):
                    getattr(now, kind)[part][place] = value
        return now

    def _call(self, call: Call, now: _Point, ops: Ops) -> list[tuple[Target, Value]]:
        """(input, value) for the inputs that one part feeds."""
        i = call.part
        model, at = self._models[i], (now.t, now.x[i], now.m[i], now.u[i], now.du[i])
        seen = model.outputs(*at, *second(model, now.ddu[i]), now.p[i], ops)
        rates = output_rates(model, *at, now.ddu[i], now.p[i], ops) if any(f.derived for f in call.feeds) else ()
        return [(f.target, f.factor * (rates if f.derived else seen)[f.output]) for f in call.feeds]

    def _solve(self, loop: Loop, now: _Point, ops: Ops) -> None:
        """The signals of a linear loop: the map w -> g + G w at w = 0 and along each signal, then elimination."""
        n = len(loop.signals)
        place = {signal: k for k, signal in enumerate(loop.signals)}
        matrix: list[list[Value]] = [[0.0] * n for _ in range(n)]
        right: list[Value] = [0.0] * n
        for column, (kind, part, entry) in enumerate(loop.signals):
            side = getattr(now, kind)
            side[part][entry] = Dual(0.0, 1.0)
            for call in loop.calls:
                for signal, value in self._call(call, now, duals(ops)):
                    matrix[place[signal]][column] = -lift(value).slope
                    right[place[signal]] = lift(value).value
            side[part][entry] = 0.0
        for k in range(n):
            matrix[k][k] = 1.0 + matrix[k][k]
        for (kind, part, entry), value in zip(loop.signals, eliminated(matrix, right)):
            getattr(now, kind)[part][entry] = value


class _Point(NamedTuple):
    """Time, states, modes, inputs and their derivatives of every part, and the parameters."""

    t: Value
    x: list[Any]
    m: list[Any]
    u: list[list[Value]]
    du: list[list[Value]]
    ddu: list[list[Value]]
    p: Sequence[Any]


def eliminated(a: list[list[Value]], b: list[Value]) -> list[Value]:
    """The solution of a x = b without pivoting; zeros that are plain numbers cost nothing."""
    n, a, x = len(b), [list(row) for row in a], list(b)
    for k in range(n):
        for i in range(k + 1, n):
            if isinstance(a[i][k], float) and a[i][k] == 0.0:
                continue
            share = a[i][k] / a[k][k]
            for j in range(k + 1, n):
                a[i][j] = a[i][j] - share * a[k][j]
            x[i] = x[i] - share * x[k]
    for k in reversed(range(n)):
        for j in range(k + 1, n):
            x[k] = x[k] - a[k][j] * x[j]
        x[k] = x[k] / a[k][k]
    return x


def compose(parts: Mapping[str, ModuleType], connections: Sequence[Connection], name: str = "composed") -> Composed:
    """The model of ``parts`` joined by ``connections``. Raises `CompositionError` for a loop that it cannot solve, and
    for a part whose equations it cannot join."""
    return Composed(name, parts, connections)
