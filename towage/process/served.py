"""The process of a unit of `towage.process.isolated`: does what it is asked, and says what came of it."""

from __future__ import annotations

import math
import os
import pickle
from array import array
from collections.abc import Mapping, Sequence
from ctypes import c_double
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import msgspec

from towage.errors import RunError
from towage.process.overseer import Limits
from towage.units.description import Description
from towage.units.doubt import Doubt, What
from towage.units.fmu import StepRefused, Unit
from towage.units.wiring import Wanted

LENGTH = 8
"""Bytes of the length of `Said`, which a reply begins with; doubles or bytes follow it."""


class Failure(msgspec.Struct):
    """A `RunError`, or a `Doubt` of something, and why."""

    message: str
    variable: str = ""
    time: float | None = None
    doubt: What | None = None
    why: str = ""


class Refusal(msgspec.Struct):
    """A `StepRefused`."""

    text: str
    ends: bool
    reached: float | None
    event: float | None


class Said(msgspec.Struct):
    """What a call of a unit brought beside its values: ``log``: new messages as (status, category, text), and how many were
    ``lost``; ``warnings``: calls that returned Warning, first at ``warned_at``, s; ``meddled``: what it changed of its process;
    ``ended``: when it ended the simulation, s; ``texts`` and ``binaries`` (as hexadecimal digits) that it sends; ``handled``:
    whether there were events to handle; ``next_event``, s; ``lacks``, at first: what its process may still do
    (`towage.process.sandbox`)."""

    log: list[tuple[str, str, str]] = []
    lost: int = 0
    warnings: int = 0
    warned_at: float | None = None
    meddled: list[str] = []
    ended: list[float] = []
    texts: dict[str, str] = {}
    binaries: dict[str, str] = {}
    handled: bool = False
    next_event: float | None = None
    freezes: bool = False
    dead: bool = False
    lacks: list[str] = []
    failure: Failure | None = None
    refusal: Refusal | None = None


def serve(descriptor: int, lacks: list[str]) -> None:
    """The process of a unit: does what it is asked until the connection ends."""
    channel = Connection(descriptor)
    served: Served | None = None
    while True:
        try:
            method, arguments, inputs, words, locates = pickle.loads(channel.recv_bytes())
        except (OSError, EOFError):
            os._exit(0)
        said, value = Said(), b""
        try:
            if served is None:
                said.lacks = lacks
                served = Served(_made(*arguments))
            else:
                value = served.call(said, method, arguments, inputs, words, locates)
        except StepRefused as refusal:
            said.refusal = Refusal(str(refusal), refusal.ends, refusal.reached, refusal.event)
        except Exception as error:
            known = error if isinstance(error, RunError) else RunError(f"{type(error).__name__}: {error}")
            doubt = (known.what, known.why) if isinstance(known, Doubt) else ()
            said.failure = Failure(str(known.args[0]), known.variable, known.time, *doubt)
        if served:
            served.tell(said)
        data = msgspec.json.encode(said)
        channel.send_bytes(b"".join((len(data).to_bytes(LENGTH, "little"), data, value)))


class Served:
    """The unit of the process, and how much of what it said was told."""

    def __init__(self, unit: Unit) -> None:
        self.unit, self._told = unit, 0

    def call(
        self, said: Said, method: str, arguments: Sequence[Any], inputs: Sequence[float], words: Mapping[str, Any], locates: bool
    ) -> bytes:
        """The value of a call. Raises what the call raises."""
        unit = self.unit
        unit.input_buffer[:] = list[c_double | float](inputs)
        unit.wiring.others.words |= words
        unit.instance.locates = locates
        if method == "handle_events":
            said.handled = unit.instance.handle_events()
            return b""
        return _bytes(getattr(unit, method)(*arguments), unit)

    def tell(self, said: Said) -> None:
        """Add what the unit said and what became of it."""
        unit, instance = self.unit, self.unit.instance
        said.log = [(m.status, m.category, m.text) for m in instance.log.messages[self._told :]]
        self._told, said.lost = len(instance.log.messages), instance.log.lost
        said.warnings, said.warned_at = instance.log.warnings, instance.log.warned_at
        if said.refusal and not said.refusal.ends and said.refusal.event is None:
            instance.log.mark()  # as the master does before a shorter step
        said.meddled, said.ended = list(instance.meddled), [time for _, time in unit.endings]
        unit.endings.clear()
        sent = {n: unit.wiring.others.words[n] for group in unit.wiring.others.texts_out for n in group.names}
        said.texts = {name: text for name, text in sent.items() if isinstance(text, str)}
        said.binaries = {name: text.hex() for name, text in sent.items() if isinstance(text, bytes)}
        said.next_event = instance.next_event if math.isfinite(instance.next_event) else None
        said.freezes, said.dead = instance.freezes, instance.dead


def _made(
    name: str, description: Description, directory: Path, wanted: Wanted, limits: Limits
) -> Unit:
    from towage.process.overseer import limit

    limit(limits)
    return Unit(name, description, directory, wanted)


def _bytes(value: object, unit: Unit) -> bytes:
    """What a method returned; outputs for those that return nothing but change them."""
    if isinstance(value, bytes):
        return value
    if isinstance(value, float):
        return bytes(c_double(value))
    return array("d", unit.values).tobytes()
