"""A process a unit, for ``towage run --isolate``: what a unit does to its memory, its files or its process reaches no other.

Every unit has a process with a folder of its own, which is its working directory and its place for temporary files, with the
limits of the run, and without the descriptors of the others. Where the system can (`sandbox`) it may write nowhere else, has
no network and reaches no other process; the run tells what the system cannot deny. A unit that dies fails its call, and the
run ends with all that was recorded. What comes back is taken for numbers and for texts of known kinds (`Said`), nothing else.
"""

from __future__ import annotations

import contextlib
import math
import os
import pickle
import signal
import socket
import subprocess
import sys
from array import array
from collections.abc import Mapping
from multiprocessing.connection import Connection
from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec

from towage.errors import RunError
from towage.files import scratch
from towage.process.overseer import Limits
from towage.process.sandbox import confine
from towage.process.served import LENGTH, Said, serve
from towage.units.description import Description, Value
from towage.units.doubt import Doubt
from towage.units.fmu import StepRefused, Unit
from towage.units.kinds import is_double
from towage.units.log import STATUS, Log
from towage.units.wiring import Wanted, Wiring

if TYPE_CHECKING:
    from towage.process.watched import Note

LONGEST = 1 << 28
"""Bytes of a reply."""

class RemoteInstance:
    """What the master asks of an instance beside the calls of its unit (`towage.units.library.Instance`)."""

    def __init__(self, unit: Remote) -> None:
        self._unit = unit
        self.log = Log(unit.name)
        self.meddled: dict[str, None] = {}
        self.dead = self.locates = self.freezes = False
        self.next_event = math.inf

    def handle_events(self) -> bool:
        """As `Instance.handle_events`."""
        return self._unit.handle_events()


class Remote(Unit):
    """A unit in a process of its own: a `Unit` to the master."""

    def __init__(
        self, note: Note, limits: Limits, name: str, description: Description, directory: Path, wanted: Wanted
    ) -> None:
        self.name, self.description = name, description
        self.wiring = Wiring(description, wanted)
        self.variables, self.inputs = self.wiring.variables, self.wiring.inputs
        self.input_buffer, self.outputs = self.wiring.input_buffer, self.wiring.outputs
        self.slot = {n: k for k, n in enumerate(self.outputs)}
        self.values = [0.0] * len(self.outputs)
        self._note, self._label = note, name.encode()
        self._open = contextlib.ExitStack()
        folder = self._open.enter_context(scratch())
        ours, theirs = socket.socketpair()
        code = (
            f"import sys; sys.path[:] = {sys.path!r}; from {confine.__module__} import confine; "
            f"lacks = confine({str(folder)!r}); from {serve.__module__} import serve; serve({theirs.fileno()}, lacks)"
        )  # confined before threads begin
        with theirs:
            self._process = subprocess.Popen(
                [sys.executable, "-c", code], stdin=subprocess.DEVNULL, stdout=2, pass_fds=[theirs.fileno()], cwd=folder,
                env={**os.environ, "TMPDIR": str(folder), "PYTHONDONTWRITEBYTECODE": "1"},
            )  # fmt: skip
        self._open.callback(self._end)
        self._channel = Connection(ours.detach())
        self.begun, self.endings, self.lacks = False, [], []
        self.can_roll_back = description.can_get_set_state
        self._handled = False
        self.instance: Any = RemoteInstance(self)
        self.advance = self._advance
        self._ask("instantiation", math.nan, "make", name, description, directory, wanted, limits)

    def _ask(self, stage: str, time: float, method: str, *arguments: object) -> bytes:
        """The reply to a call of the unit's ``method``. Raises `RunError` and `StepRefused`."""
        self._note(self._label, stage.encode(), time)
        try:
            words = {n: self.wiring.others.words[n] for group in self.wiring.others.texts_in for n in group.names}
            self._channel.send_bytes(
                pickle.dumps((method, arguments, list(self.input_buffer), words, self.instance.locates))
            )
            reply = self._channel.recv_bytes(LONGEST)
        except (OSError, EOFError):
            raise RunError(self._fate(), unit=self.name, time=None if math.isnan(time) else time) from None
        end = LENGTH + int.from_bytes(reply[:LENGTH], "little")
        try:
            said = msgspec.json.decode(reply[LENGTH:end], type=Said)
            self._take(said)
        except (msgspec.MsgspecError, ValueError, RecursionError):
            raise RunError("its process sent what is no reply", unit=self.name, time=time) from None
        if refusal := said.refusal:
            raise StepRefused(refusal.text, self.name, refusal.ends, refusal.reached, refusal.event)
        failure = said.failure
        if failure and failure.doubt:
            raise Doubt(failure.message, failure.doubt, failure.why, self.name, failure.variable, failure.time)
        if failure:
            raise RunError(failure.message, unit=self.name, variable=failure.variable, time=failure.time)
        return reply[end:]

    def _take(self, said: Said) -> None:
        """Keep what a call brought. Raises ``ValueError`` for a binary that is none."""
        instance, words = self.instance, self.wiring.others.words
        for status, category, text in said.log:
            instance.log.add(STATUS.index(status) if status in STATUS else -1, category, text)
        instance.log.lost, instance.log.warnings, instance.log.warned_at = said.lost, said.warnings, said.warned_at
        instance.meddled |= dict.fromkeys(said.meddled)
        self.lacks = [*(self.lacks or []), *said.lacks]
        instance.dead, instance.freezes, self._handled = said.dead, said.freezes, said.handled
        instance.next_event = math.inf if said.next_event is None else said.next_event
        self.endings += [(self.name, time) for time in said.ended]
        words |= {name: text for name, text in said.texts.items() if name in words}
        words |= {name: bytes.fromhex(text) for name, text in said.binaries.items() if name in words}

    def _fate(self) -> str:
        self.instance.dead = True
        try:
            code = self._process.wait(5.0)
        except subprocess.TimeoutExpired:
            return "closed the connection to its process"
        how = f"exit code {code}" if code >= 0 else signal.Signals(-code).name
        return f"ended its process ({how})"

    def _outputs(self, reply: bytes, time: float) -> list[float]:
        if len(reply) != 8 * len(self.outputs):
            raise RunError("its process sent what is no reply", unit=self.name, time=time)
        return self._accept(array("d", reply).tolist(), time)

    def enter(self, start: Mapping[str, Value], span: tuple[float, float], tolerance: float | None) -> None:
        """As `Unit.enter`."""
        self.wiring.fill(start)
        self._ask("initialisation", span[0], "enter", dict(start), span, tolerance)

    def begin(self, time: float) -> None:
        """As `Unit.begin`."""
        self._outputs(self._ask("initialisation", time, "begin", time), time)

    def handle_events(self) -> bool:
        """As `Instance.handle_events`."""
        self._ask("step", math.nan, "handle_events")
        return self._handled

    def constant(self, name: str) -> float | None:
        """As `Unit.constant`."""
        v = self.variables.get(name)
        if not v or not is_double(v):
            return None
        reply = self._ask("initialisation", math.nan, "constant", name)
        return array("d", reply)[0] if len(reply) == 8 else None

    def set(self, time: float) -> None:
        """As `Unit.set`."""
        self._ask("step", time, "set", time)

    def get(self, time: float) -> list[float]:
        """As `Unit.get`."""
        return self._outputs(self._ask("step", time, "get", time), time)

    def _advance(self, time: float, size: float) -> list[float]:
        return self._outputs(self._ask("step", time, "advance", time, size), time + size)

    def save(self, time: float) -> None:
        """As `Unit.save`."""
        self._ask("state", time, "save", time)

    def restore(self, time: float) -> None:
        """As `Unit.restore`."""
        self._ask("state", time, "restore", time)

    def frozen(self, time: float) -> bytes:
        """As `Unit.frozen`."""
        return self._ask("state", time, "frozen", time)

    def thaw(self, data: bytes, time: float) -> None:
        """As `Unit.thaw`."""
        self._ask("state", time, "thaw", data, time)

    def close(self) -> None:
        """As `Unit.close`; the process ends."""
        with contextlib.suppress(RunError):
            if not self.instance.dead:
                self._ask("termination", math.nan, "close")
        self._open.close()

    def _end(self) -> None:
        self._channel.close()
        self._process.kill()
        self._process.wait()
