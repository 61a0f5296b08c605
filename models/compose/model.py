"""Models joined into one: the outputs of some are inputs of others, without an interface and so without its error.

    x_i' = f_i(t, x_i, m_i, u_i),   y_i = g_i(t, x_i, m_i, u_i, u_i'),   u_i = factor * y_j for what is connected

`compose` returns a model, for all ops alike. States, modes, parameters, inputs
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

from collections.abc import Mapping, Sequence
from dataclasses import fields
from typing import Any, NamedTuple

from ..numeric.dual_ops import Dual, duals, lift, output_rates
from ..numeric.ops import NEVER, Ops, Value
from ..protocol.model import AnyModel, Model, Requirement, Spelling
from .plan import HELD, KINDS, Call, Connection, Loop, Named, Plan, Signals, Target, named


class Composition:
    """Models joined; `compose` makes the model of it. ``clocks`` are the parts with a next event time. The parts compute with
    the functions that ``spelling`` gives them, of the same values."""

    def __init__(
        self, name: str, parts: Mapping[str, AnyModel], connections: Sequence[Connection], spelling: Spelling
    ) -> None:
        self.name, self.parts, self.connections = name, dict(parts), tuple(connections)
        self._models = models = [spelling(model) for model in parts.values()]
        signals = Signals(self.parts, self.connections)
        self.State = named("State", signals.names("State"))
        self.Modes = named("Modes", signals.names("Modes"))
        self.Inputs = named("Inputs", (f"{part}.{name}" for part, name in signals.open))
        self.clocks = [i for i, model in enumerate(models) if model.next_event_time]
        self.Outputs = named("Outputs", (*signals.names("Outputs"), *(("next_event_time",) if self.clocks else ())))
        self.Calculated = named("Calculated", signals.names("Calculated"))
        self._signals = signals
        self._x, self._m = signals.slices("State"), signals.slices("Modes")
        self._changing = [i for i, model in enumerate(models) if model.transition]
        self._for_rates = signals.plan(signals.used_by("derivatives"))
        self._for_events = signals.plan(signals.used_by("indicators") | signals.used_by_events())
        self._for_outputs = signals.plan(signals.used_by("outputs"))
        self._for_change = [signals.plan(signals.used_by("transition", i)) for i in self._changing]

    def model(self) -> AnyModel:
        """The composition as a model."""
        return Model(
            self.name, "", self.parameters, self.State, self.Modes, self.Inputs, self.Outputs, self.Calculated,
            initial=self.initial, derivatives=self.derivatives, outputs=self.outputs, indicators=self.indicators,
            transition=self.transition if self._changing else None,
            next_event_time=self.next_event_time if self.clocks else None,
            calculated=self.calculated, requirements=self.requirements, by_position=True, over=self._over,
        )  # fmt: skip

    def _over(self, spelling: Spelling) -> AnyModel:
        return Composition(self.name, self.parts, self.connections, spelling).model()

    def parameters(self, *values: Value, **named: Value) -> tuple[Any, ...]:
        """The parts' parameters, from values in the order of the parts (without ``freeze_branches``) or by name."""
        given, made = iter(values), []
        for part, model in self.parts.items():
            own = {}
            for field in fields(model.Parameters):  # type: ignore[arg-type]
                name = field.name
                own[name] = 1.0 if name == HELD else named[f"{part}.{name}"] if named else next(given)
            made.append(model.Parameters(**own))
        return tuple(made)

    def initial(self, p: Sequence[Any], ops: Ops) -> tuple[Named, Named]:
        """Every part at its start."""
        starts = [model.initial(own, ops) for model, own in zip(self._models, p)]
        return self.State(v for x, _ in starts for v in x), self.Modes(v for _, m in starts for v in m)

    def requirements(self, p: Sequence[Any], ops: Ops) -> tuple[Requirement, ...]:
        """What the parts require, with the name of the part."""
        return tuple(
            (value, f"{part}: {message}")
            for (part, model), own in zip(self.parts.items(), p) if model.requirements
            for value, message in model.requirements(own, ops)
        )  # fmt: skip

    def calculated(self, p: Sequence[Any], ops: Ops) -> Named:
        """Calculated parameters of all parts."""
        return self.Calculated(
            v for model, own in zip(self._models, p) if model.calculated for v in model.calculated(own, ops)
        )

    def derivatives(self, t: Value, x: Any, m: Any, u: Any, p: Any, ops: Ops) -> Named:
        """x' of all parts."""
        now = self._at(self._for_rates, t, x, m, u, (), p, ops)
        return self.State(
            v for i, model in enumerate(self._models) if model.derivatives and self._x[i].start < self._x[i].stop
            for v in model.derivatives(*self._arguments(i, now)[:4], p[i], ops)
        )  # fmt: skip

    def outputs(self, t: Value, x: Any, m: Any, u: Any, du: Any, p: Any, ops: Ops) -> Named:
        """All observables of all parts."""
        now = self._at(self._for_outputs, t, x, m, u, du, p, ops)
        seen = [v for i in range(len(self._models)) for v in self._outputs(i, now, ops)]
        return self.Outputs(seen + ([self.next_event_time(t, m, p, ops)] if self.clocks else []))

    def indicators(self, t: Value, x: Any, m: Any, u: Any, p: Any, ops: Ops) -> tuple[Value, ...]:
        """Zero-crossing functions of all parts, their ``event_*`` included."""
        now = self._at(self._for_events, t, x, m, u, (), p, ops)
        zeros: list[Value] = []
        for i, model in enumerate(self._models):
            if model.indicators:
                zeros += model.indicators(*self._arguments(i, now)[:4], p[i], ops)
            if events := self._signals.events[i]:
                seen = self._outputs(i, now, ops)
                zeros += [seen[k] for k in events]
        return tuple(zeros)

    def transition(self, t: Value, x: Any, m: Any, u: Any, p: Any, ops: Ops) -> tuple[Named, Named]:
        """The discrete changes of all parts."""
        x, m = list(x), list(m)
        for _ in self._changing:
            for i, plan in zip(self._changing, self._for_change):
                now, change = self._at(plan, t, x, m, u, (), p, ops), self._models[i].transition
                assert change is not None
                x[self._x[i]], m[self._m[i]] = change(*self._arguments(i, now)[:4], p[i], ops)
        return self.State(x), self.Modes(m)

    def next_event_time(self, t: Value, m: Any, p: Any, ops: Ops) -> Value:
        """The earliest of all parts."""
        first: Value = NEVER
        for i in self.clocks:
            model, own = self._models[i], m[self._m[i]]
            assert model.next_event_time is not None
            due = model.next_event_time(t, own if model.by_position else model.Modes._make(own), p[i], ops)
            first = ops.minimum(first, due)
        return first

    def _arguments(self, i: int, now: _Point) -> tuple[Value, Any, Any, Any, Any, Any]:
        """(t, x, m, u, u', u'') of a part, named unless its functions go by position."""
        model, x, m, u, du, ddu = self._models[i], now.x[i], now.m[i], now.u[i], now.du[i], now.ddu[i]
        if model.by_position:
            return now.t, x, m, u, du, ddu
        named = model.Inputs._make
        return now.t, model.State._make(x), model.Modes._make(m), named(u), named(du), named(ddu)

    def _outputs(self, i: int, now: _Point, ops: Ops) -> Any:
        """The outputs of a part."""
        model, at = self._models[i], self._arguments(i, now)
        return model.outputs(*(at if model.takes_second else at[:5]), now.p[i], ops)

    # ---- signals ----------------------------------------------------------------------------------------------------

    def _at(self, plan: Plan, t: Value, x: Any, m: Any, u: Any, du: Any, p: Any, ops: Ops) -> _Point:
        """The parts' states and the inputs that ``plan`` finds; the others are 0."""
        x, m = tuple(x), tuple(m)
        sizes = [len(model.Inputs._fields) for model in self._models]
        sides: dict[str, list[list[Value]]] = {kind: [[0.0] * n for n in sizes] for kind in KINDS}
        now = _Point(t, [x[s] for s in self._x], [m[s] for s in self._m], sides["u"], sides["du"], sides["ddu"], sides, p)
        for k, (part, place) in enumerate(self._signals.open_places):
            now.u[part][place] = u[k]
            now.du[part][place] = du[k] if du else 0.0
        for stage in plan:
            if isinstance(stage, Loop):
                self._solve(stage, now, ops)
            else:
                for (kind, part, place), value in self._call(stage, now, ops):
                    now.sides[kind][part][place] = value
        return now

    def _call(self, call: Call, now: _Point, ops: Ops) -> list[tuple[Target, Value]]:
        """(input, value) for the inputs that one part feeds."""
        i = call.part
        seen = self._outputs(i, now, ops)
        derives = any(feed.derived for feed in call.feeds)
        rates = output_rates(self._models[i], *self._arguments(i, now), now.p[i], ops) if derives else ()
        return [(f.target, f.factor * (rates if f.derived else seen)[f.output]) for f in call.feeds]

    def _solve(self, loop: Loop, now: _Point, ops: Ops) -> None:
        """The signals of a linear loop: the map w -> g + G w at w = 0 and along each signal, then elimination."""
        n = len(loop.signals)
        place = {signal: k for k, signal in enumerate(loop.signals)}
        matrix: list[list[Value]] = [[0.0] * n for _ in range(n)]
        right: list[Value] = [0.0] * n
        for column, (kind, part, where) in enumerate(loop.signals):
            side = now.sides[kind]
            side[part][where] = Dual(0.0, 1.0)
            for call in loop.calls:
                for signal, value in self._call(call, now, duals(ops)):
                    matrix[place[signal]][column] = -lift(value).slope
                    right[place[signal]] = lift(value).value
            side[part][where] = 0.0
        for k in range(n):
            matrix[k][k] = 1.0 + matrix[k][k]
        for (kind, part, where), value in zip(loop.signals, eliminated(matrix, right)):
            now.sides[kind][part][where] = value


class _Point(NamedTuple):
    """Time, states, modes, inputs and their derivatives of every part (``sides``: by kind), and the parameters."""

    t: Value
    x: list[Any]
    m: list[Any]
    u: list[list[Value]]
    du: list[list[Value]]
    ddu: list[list[Value]]
    sides: Mapping[str, list[list[Value]]]
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


def compose(parts: Mapping[str, AnyModel], connections: Sequence[Connection], name: str = "composed") -> AnyModel:
    """The model of ``parts`` joined by ``connections``. Raises `CompositionError` for a loop that it cannot solve, and
    for a part whose equations it cannot join."""
    return Composition(name, parts, connections, lambda model: model).model()
