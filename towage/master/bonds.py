"""Bonds: two connections between two units, one each way, that carry a power together.

One carries an effort, a force or a moment, the other the motion that it works on: a velocity, or a displacement whose
rate is known. Units of measurement tell them apart. Where an effort may go with several motions, as at a cable that ends
in two directions, names decide: the pair with the most words in common, if it is the only one.

The energy that the coupling makes or loses at a bond in one step is at most half the gap between the effort that was
used at the end of the step and the one that was found there, times the way of the motion. Its sum over the run, relative
to the sum of |effort| times way, is the bond's power residual.
"""

from __future__ import annotations

import re
from collections import Counter
from typing import TYPE_CHECKING, NamedTuple

from towage.fmus.declare.quantities import dimension

if TYPE_CHECKING:
    from towage.master.signals import Signal
    from towage.master.system import System
    from towage.scene.resolve import ResolvedConnection, ResolvedScene

EFFORTS = {dimension("N"): False, dimension("N.m"): True}
"""Dimensions of efforts; the value says whether it turns."""
MOTIONS = {
    dimension("m/s"): (False, True), dimension("m"): (False, False),
    dimension("rad/s"): (True, True), dimension("rad"): (True, False),
}  # fmt: skip
"""Dimensions of motions: whether they turn, whether they are velocities."""
_WORD = re.compile("[^A-Za-z0-9]+")


class Bond(NamedTuple):
    """The connections of an effort and of its motion. ``velocity``: else a displacement; ``turns``: moment and angle."""

    effort: ResolvedConnection
    motion: ResolvedConnection
    velocity: bool
    turns: bool


def bonds(scene: ResolvedScene) -> list[Bond]:
    """All bonds of a scene."""
    motions = [(c, kind) for c in scene.connections if (kind := MOTIONS.get(_dimension(scene, c) or ()))]
    common: dict[Bond, int] = {}
    for effort in scene.connections:
        turns = EFFORTS.get(_dimension(scene, effort) or ())
        for motion, kind in motions:
            back = (effort.source_unit, effort.target_unit) == (motion.target_unit, motion.source_unit)
            if back and effort.source_unit != effort.target_unit and turns == kind[0]:
                common[Bond(effort, motion, kind[1], kind[0])] = len(_words(effort) & _words(motion))
    return [
        bond
        for bond, count in common.items()
        if all(
            count > other
            for rival, other in common.items()
            if rival != bond and (rival.effort == bond.effort or rival.motion == bond.motion)
        )
    ]


def _dimension(scene: ResolvedScene, connection: ResolvedConnection) -> tuple[int, ...] | None:
    """Exponents of the base units of what the source sends; None if its unit is not declared, or if the scene transforms it: both
    ends are then not the same quantity, and no power passes."""
    if connection.changed:
        return None
    description = scene.units[connection.source_unit].description
    definition = description.units.get(description.by_name()[connection.source].unit or "")
    return definition.exponents if definition else None


def _words(connection: ResolvedConnection) -> set[str]:
    return {word.lower() for word in _WORD.split(f"{connection.source} {connection.target}") if word}


class BondEnergy:
    """The energy account of one bond over a run, in the units of its connections: what the coupling made or lost
    (``residual``) and what went through (``throughput``)."""

    def __init__(self, name: str, effort: Signal, motion: Signal, velocity: bool) -> None:
        self.name = name
        self.residual = 0.0
        self.throughput = 0.0
        self._effort = effort
        self._motion = motion
        self._velocity = velocity

    def add(self, step: float) -> None:
        """Enter a step of ``step`` s, whose ends are found and not yet accepted."""
        effort, motion = self._effort, self._motion
        a0, a1, a2, a3 = effort.polynomial
        gap = a0 + step * (a1 + step * (a2 + step * a3)) - effort.end_value
        way = abs(motion.end_value if self._velocity else motion.end_rate) * step
        self.residual += 0.5 * abs(gap) * way
        self.throughput += abs(effort.end_value) * way


def accounts(system: System) -> list[BondEnergy]:
    """An account for every bond whose motion has a known velocity. It is called by its units, effort first, and by the
    effort too where several bonds join the same units."""
    signals = {s.connection: s for s in system.signals}
    known = [bond for bond in bonds(system.scene) if bond.velocity or signals[bond.motion].rated]
    names = [f"{bond.effort.source_unit} - {bond.effort.target_unit}" for bond in known]
    count = Counter(names)
    return [
        BondEnergy(
            name if count[name] == 1 else f"{name} ({bond.effort.source})",
            signals[bond.effort], signals[bond.motion], bond.velocity,
        )
        for name, bond in zip(names, known)
    ]  # fmt: skip
