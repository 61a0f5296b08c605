"""Signals of a composition: which inputs are fed by what, and in which order they can be computed."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import fields
from functools import cache
from typing import Any, NamedTuple

from ..numeric.dependence import OTHERWISE, TRACED, Traced, degrees_of
from ..numeric.dual_ops import output_rates
from ..numeric.ops import Value
from ..protocol.model import AnyModel

HELD = "freeze_branches"
"""The parameter that makes a part hold its branches; a composition sets it."""
KINDS = ("u", "du", "ddu")
"""Inputs and their first and second time derivatives. Second ones are asked for by linear parts alone."""
Target = tuple[str, int, int]
"""(one of `KINDS`, part, input)"""


class Named(tuple[Value, ...]):
    """A tuple whose components have names that need not be identifiers, in ``_fields``."""

    _fields: tuple[str, ...] = ()

    @classmethod
    def _make(cls, values: Iterable[Value]) -> Named:
        return cls(values)


def named(kind: str, names: Iterable[str]) -> type[Named]:
    """A class of such tuples."""
    return type(kind, (Named,), {"_fields": tuple(names)})


class CompositionError(ValueError):
    """Models that cannot be joined; the message names parts and signals."""


class Connection(NamedTuple):
    """``target``, an input, is ``factor`` times ``source``, an output; each is (part, name)."""

    source: tuple[str, str]
    target: tuple[str, str]
    factor: float = 1.0

    def __str__(self) -> str:
        return f"{'.'.join(self.source)} -> {'.'.join(self.target)}"


class Feed(NamedTuple):
    """``target`` is ``factor`` times ``output`` of the part, or its rate where that has to be ``derived``; a second
    derivative is that of the output's own rate."""

    target: Target
    output: int
    derived: bool
    factor: float


class Call(NamedTuple):
    """One evaluation of a part's outputs."""

    part: int
    feeds: tuple[Feed, ...]


class Loop(NamedTuple):
    """Signals that depend on each other, and the calls that give each from the others."""

    signals: tuple[Target, ...]
    calls: tuple[Call, ...]


Plan = tuple[Call | Loop, ...]


class Signals:
    """The signals between ``parts``. ``open`` are the inputs that are not connected, ``open_places`` the same by
    position; ``events`` the positions of each part's ``event_*``."""

    def __init__(self, parts: Mapping[str, AnyModel], connections: Sequence[Connection]) -> None:
        self.parts, self.models = tuple(parts), tuple(parts.values())
        for part, model in parts.items():
            if model.State is None or (model.State._fields and not model.derivatives):
                raise CompositionError(
                    f"{part} cannot be composed: {model.name} gives no rates x' = f(t, x, u) of a "
                    "fixed number of states, only steps of its own"
                )
        self.fed: dict[Target, tuple[int, Feed]] = {}
        self.written: dict[Target, str] = {}
        for connection in connections:
            self._connect(connection)
        every = [(i, k) for i, model in enumerate(self.models) for k in range(len(model.Inputs._fields))]
        self.open_places = [(i, k) for i, k in every if ("u", i, k) not in self.fed]
        self.open = [(self.parts[i], self.models[i].Inputs._fields[k]) for i, k in self.open_places]
        names = [model.Outputs._fields for model in self.models]
        self.events = [
            [k for k, n in enumerate(own) if n.startswith("event_") and not n.endswith("_rate")] for own in names
        ]

    def _connect(self, c: Connection) -> None:
        i, j = (self.parts.index(part) for part, _ in (c.source, c.target))
        outputs, place = self.models[i].Outputs._fields, self.models[j].Inputs._fields.index(c.target[1])
        value, stated = c.source[1], f"{c.source[1]}_rate" in outputs
        rate = f"{value}_rate" if stated else value
        for kind, output, derived in (("u", value, False), ("du", rate, not stated), ("ddu", rate, True)):
            self.fed[kind, j, place] = i, Feed((kind, j, place), outputs.index(output), derived, c.factor)
            self.written[kind, j, place] = str(c)

    def names(self, kind: str) -> Iterable[str]:
        """``<part>.<name>`` of the components of ``State``, ``Outputs``, ... of all parts."""
        return (f"{part}.{name}" for part, model in zip(self.parts, self.models) for name in fields_of(model, kind))

    def slices(self, kind: str) -> list[slice]:
        """Where the components of each part are."""
        sizes = [len(fields_of(model, kind)) for model in self.models]
        return [slice(sum(sizes[:i]), sum(sizes[: i + 1])) for i in range(len(sizes))]

    # ---- what depends on what ---------------------------------------------------------------------------------------

    def used_by(self, function: str, part: int | None = None) -> set[Target]:
        """Connected inputs that ``function`` of one part, or of all, depends on."""
        chosen = range(len(self.parts)) if part is None else (part,)
        return {
            (kind, i, k)
            for i in chosen if FUNCTIONS[function](self.models[i])
            for value in dependence(self.models[i], function)
            for kind, k in value if (kind, i, k) in self.fed
        }  # fmt: skip

    def used_by_events(self) -> set[Target]:
        """Connected inputs that ``event_*`` depend on."""
        seen = [(i, dependence(self.models[i], "outputs")[k]) for i, own in enumerate(self.events) for k in own]
        return {(kind, i, k) for i, value in seen for kind, k in value if (kind, i, k) in self.fed}

    def depends(self, target: Target) -> dict[Target, int]:
        """The connected inputs from which ``target`` follows at once, with the degree."""
        i, feed = self.fed[target]
        name = self.models[i].Outputs._fields[feed.output]
        degrees = dependence(self.models[i], "outputs")[feed.output]
        if feed.derived:
            unstated = target[0] == "ddu" and not name.endswith("_rate")
            if unstated or any(kind == "ddu" for kind, _ in degrees):
                raise CompositionError(
                    f"{self.written[target]}: a rate is needed that {self.parts[i]} does not state: give it an output "
                    f"{name}_rate"
                )
            degrees = dependence(self.models[i], "output_rates")[feed.output]
        return {(kind, i, k): degree for (kind, k), degree in degrees.items() if (kind, i, k) in self.fed}

    def plan(self, wanted: set[Target]) -> Plan:
        """How to compute ``wanted``, and what it takes. Raises `CompositionError` for a loop that is not linear."""
        after: dict[Target, dict[Target, int]] = {}
        todo = sorted(wanted)
        while todo:
            target = todo.pop()
            if target not in after:
                after[target] = self.depends(target)
                todo += after[target]
        left, stages = set(after), list[Call | Loop]()
        while left:
            ready = {target for target in left if not left & set(after[target])}
            if ready:
                first = self._calls(ready)[0]
                stages.append(first)
                left -= {feed.target for feed in first.feeds}
            else:
                loop = self._loop(left, after)
                stages.append(loop)
                left -= set(loop.signals)
        return tuple(stages)

    def _calls(self, targets: set[Target]) -> list[Call]:
        sources = sorted({self.fed[target][0] for target in targets})
        ordered = sorted(targets)
        return [Call(i, tuple(self.fed[t][1] for t in ordered if self.fed[t][0] == i)) for i in sources]

    def _loop(self, left: set[Target], after: Mapping[Target, Mapping[Target, int]]) -> Loop:
        """The first loop that depends on no other."""

        def reach(target: Target) -> set[Target]:
            reached, todo = set[Target](), [target]
            while todo:
                new = (left & set(after[todo.pop()])) - reached
                reached |= new
                todo += new
            return reached

        closed = sorted((sorted(reach(target)) for target in left), key=lambda loop: (len(loop), loop))
        signals = tuple(closed[0])
        if any(after[a].get(b) == OTHERWISE for a in signals for b in signals):
            names = ", ".join(dict.fromkeys(self.written[target] for target in signals))
            raise CompositionError(
                f"algebraic loop through {names}: it is not linear in its signals, so that it cannot be solved in place; "
                "break it with a unit that has a state"
            )
        return Loop(signals, tuple(self._calls(set(signals))))


def fields_of(model: AnyModel, kind: str) -> tuple[str, ...]:
    """Names of the components of ``State``, ``Outputs``, ... of a model; none where it has no such kind."""
    kinds = {"State": model.State, "Modes": model.Modes, "Outputs": model.Outputs, "Calculated": model.Calculated}
    return kinds[kind]._fields if kinds[kind] else ()


FUNCTIONS: dict[str, Callable[[AnyModel], Callable[..., Any] | None]] = {
    "outputs": lambda model: model.outputs,
    "derivatives": lambda model: model.derivatives,
    "indicators": lambda model: model.indicators,
    "transition": lambda model: model.transition,
}
"""The functions that see inputs, by name."""


@cache
def dependence(model: AnyModel, function: str) -> tuple[dict[Any, int], ...]:
    """For each value that ``function`` of ``model`` returns: the inputs (kind, k) that it depends on, with the degree; of a
    transition, states and modes together. ``output_rates``: see `dual_ops`."""
    u, du, ddu = (
        model.Inputs._make(Traced({(kind, k): 1}) for k in range(len(model.Inputs._fields))) for kind in KINDS
    )
    p = model.Parameters(**{f.name: 1.0 if f.name == HELD else Traced() for f in fields(model.Parameters)})  # type: ignore[arg-type]
    x, m = (kind._make(Traced() for _ in kind._fields) for kind in (model.State, model.Modes))
    if function == "outputs":
        values = model.outputs(Traced(), x, m, u, du, *((ddu,) if model.takes_second else ()), p, TRACED)
    elif function == "output_rates":
        values = output_rates(model, Traced(), x, m, u, du, ddu, p, TRACED)
    else:
        called = FUNCTIONS[function](model)
        assert called is not None, f"{model.name} has no {function}"
        values = called(Traced(), x, m, u, p, TRACED)
        if function == "transition":
            values = (*values[0], *values[1])
    return tuple(degrees_of(value) for value in values)
