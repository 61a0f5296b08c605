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
from ..wire.point import Vector
from ..wire.written import Drive, Look, Vectors, Written
from .wire import Modes, Seen, observed, prepare
from .wire_ports import Parameters

AXES = ("x", "y", "z")
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
        self._d, self._free = chain.dimensions, chain.mesh.nodes - 1
        axes = AXES if self._d == 3 else (AXES[0], AXES[2])
        nodes = [f"node{k + 1}_{kind}{axis}" for kind in ("", "v") for k in range(self._free) for axis in axes]
        self.State = namedtuple("State", [*nodes, "paid", *(f"top_{axis}" for axis in axes)])

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
        return self.State._make([*nodes, *([0.0] * (len(nodes) + 1 + self._d))]), Modes()

    def calculated(self, p: Any, ops: Ops) -> Any:
        """What follows from the parameters."""
        assert self._unit.calculated is not None
        return self._unit.calculated(self.p, FLOATS)

    def derivatives(self, t: Value, x: Any, m: Any, u: Any, p: Any, ops: Ops) -> Any:
        """x'."""
        now = self._now(x, u, (0.0,) * len(u), ops)
        moved = [c for vector in (*now.v[:-1], *now.a[:-1]) for c in vector]
        return self.State._make([*moved, now.drive.paid[1], *now.drive.velocity])

    def outputs(self, t: Value, x: Any, m: Any, u: Any, du: Any, p: Any, ops: Ops) -> Any:
        """All observables."""
        now = self._now(x, u, du, ops)
        look, paid = now.written.accelerated(now.still, now.a), now.drive.paid[0]
        sizes = now.written.sizes(look)
        least, most = sizes[0], sizes[0]
        for size in sizes[1:]:
            least, most = ops.minimum(least, size), ops.maximum(most, size)
        seen = Seen(
            look.needed[-1], (least, most, sizes[0]), now.r[0], now.v[0], now.r[-1], paid,
            now.written.shape_error(look, paid),
        )  # fmt: skip
        return observed(seen, self.prepared, self.p, ops)

    def _now(self, x: Any, u: Any, du: Any, ops: Ops) -> Now:
        count, d = self._free * self._d, self._d
        r, v = (self._vectors(x[k * count : (k + 1) * count]) for k in range(2))
        paid, *top = x[2 * count :]

        def own(three: Sequence[Value]) -> Vector:
            """Components that the wire has."""
            return tuple(three) if d == 3 else (three[0], three[2])

        drive = Drive(own(u[:3]), own(du[:3]), (paid, u[3], du[3]), own(u[4:]))
        written = Written(self.prepared.chain, ops)
        r, v = [*r, tuple(top)], [*v, drive.velocity]
        look = written.look(r, v, [(0.0,) * d] * len(r), drive)
        return Now(written, r, v, written.accelerations(r, look, drive.acceleration), drive, look)

    def _vectors(self, x: Sequence[Value]) -> list[Vector]:
        d = self._d
        return [tuple(x[k * d : (k + 1) * d]) for k in range(self._free)]
