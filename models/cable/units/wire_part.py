"""The unit ``wire`` as a part of a composition: its elements are those of given parameters, its states have rates.

    r' = u,   u' = -M^-1 R(r, u, 0)    at free nodes;   length paid out and displacement of the towpoint follow from inputs

The same elements, forces and outputs as in ``wire.py``, without its implicit steps: whoever integrates takes steps that
resolve the waves along the wire, h < 2.8 l/(2 c) with c = sqrt(EA/m) and l the distance of its closest nodes.

Assumption, besides those of ``wire.py``: the speed of the winch changes slowly: its rate acts in outputs, not in x'.
"""

from __future__ import annotations

from collections import namedtuple
from collections.abc import Sequence
from typing import Any, NamedTuple

from ...numeric.ops import FLOATS, Ops, Value
from ...protocol.model import AnyModel, Model
from ..wire.point import Vector, bent
from ..wire.written import Drive, Look, Vectors, Written, combined
from .wire_parameters import Parameters
from .wire_ports import LEAST_ROOM, Modes
from .wire_seen import Seen, observed, prepare, thickness, vectors

AXES = ("x", "y", "z")
MAKE: Any = namedtuple
"""Of as many fields as the elements make."""
HELD = ("payout_speed",)
"""Inputs whose rates x' would need, and that nothing in a composition may feed."""


class Now(NamedTuple):
    """A moment: positions, velocities, accelerations of the nodes, and forces without accelerations."""

    written: Written
    r: Vectors
    v: Vectors
    a: Vectors
    drive: Drive
    still: Look


class WirePart:
    """A wire with the parameters ``p``, of numbers."""

    def __init__(self, model: AnyModel, p: Parameters) -> None:
        self._unit, self.p, self.prepared = model, p, prepare(p)
        chain = self.prepared.chain
        # nodes with a place, and the first of them with a velocity: a driven lower end has none
        self._d, self._nodes, self._first = chain.dimensions, chain.mesh.nodes - 1, chain.free.start
        self._thickness = [thickness(p)[k] for k in chain.mesh.section]
        axes = AXES if self._d == 3 else (AXES[0], AXES[2])
        nodes = [
            f"node{k + 1}_{kind}{axis}"
            for kind, first in (("", 0), ("v", self._first)) for k in range(first, self._nodes) for axis in axes
        ]  # fmt: skip
        self.State: Any = MAKE("State", [*nodes, "paid", *(f"top_{axis}" for axis in axes)])

    def model(self) -> AnyModel:
        """The part as a model; its parameters are ignored."""
        unit = self._unit
        return Model(
            unit.name, unit.description, unit.Parameters, self.State, Modes, unit.Inputs, unit.Outputs, unit.Calculated,
            initial=self.initial, derivatives=self.derivatives, outputs=self.outputs, calculated=self.calculated,
            by_position=True, held=HELD, over=lambda spelling: self.model(),
        )  # fmt: skip

    def initial(self, p: Any, ops: Ops) -> tuple[Any, Any]:
        """The steady tow."""
        nodes = self.prepared.nodes[:-1].ravel().tolist()
        return self.State._make([*nodes, *([0.0] * (len(self.State._fields) - len(nodes)))]), Modes()

    def calculated(self, p: Any, ops: Ops) -> Any:
        """What follows from the parameters."""
        assert self._unit.calculated is not None
        return self._unit.calculated(self.p, FLOATS)

    def derivatives(self, t: Value, x: Any, m: Any, u: Any, p: Any, ops: Ops) -> Any:
        """x'."""
        now = self._now(x, u, (0.0,) * len(u), ops)
        moved = [c for vector in (*now.v[:-1], *now.a[self._first : -1]) for c in vector]
        return self.State._make([*moved, now.drive.paid[1], *now.drive.velocity])

    def outputs(self, t: Value, x: Any, m: Any, u: Any, du: Any, p: Any, ops: Ops) -> Any:
        """All observables."""
        now = self._now(x, u, du, ops)
        look, paid = now.written.accelerated(now.still, now.a), now.drive.paid[0]
        sizes = now.written.sizes(look)
        least, most = sizes[0], sizes[0]
        for size in sizes[1:]:
            least, most = ops.minimum(least, size), ops.maximum(most, size)
        bending, flow = 0.0, 0.0
        each = ((point, thick) for points, thick in zip(look.points, self._thickness) for point in points)
        for (point, (stiff, diameter)), size in zip(each, sizes):
            curvature2, across = bent(point.g, point.bend, point.through, ops)
            bending = ops.maximum(bending, stiff * curvature2 / (size + LEAST_ROOM))
            flow = ops.maximum(flow, diameter * across)
        seen = Seen(
            look.needed[-1], look.needed[0], (least, most, sizes[0]), now.r[0], now.v[0], now.r[-1], paid,
            now.written.shape_error(look, paid), bending, flow, [combined(row, now.r) for row in self.prepared.stations.tolist()],
        )  # fmt: skip
        return observed(seen, self.prepared, self.p, ops)

    def _now(self, x: Any, u: Any, du: Any, ops: Ops) -> Now:
        d = self._d
        places, speeds = self._nodes * d, (self._nodes - self._first) * d
        velocity, winch, force, lower = vectors(u, d)
        change, winch_change, _, lower_change = vectors(du, d)
        paid, *top = x[places + speeds :]
        drive = Drive(tuple(velocity), tuple(change), (paid, winch, winch_change), tuple(force))
        written = Written(self.prepared.chain, ops)
        r = [*self._vectors(x[:places]), tuple(top)]
        v = [*([tuple(lower)] if self._first else []), *self._vectors(x[places : places + speeds]), drive.velocity]
        look = written.look(r, v, [(0.0,) * d] * len(r), drive)
        return Now(written, r, v, written.accelerations(look, tuple(change), tuple(lower_change)), drive, look)

    def _vectors(self, x: Sequence[Value]) -> list[Vector]:
        d = self._d
        return [tuple(x[k : k + d]) for k in range(0, len(x), d)]
