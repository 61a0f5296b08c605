"""A process a unit, for ``towage run --isolate``: what a unit does to its memory, its files or its process reaches no other.

Every unit has a process with a folder of its own, which is its working directory and its place for temporary files, with the
limits of the run, and without the descriptors of the others. Where the system has landlock (`sandbox`) it may write nowhere
else. A unit that dies fails its call, and the run ends with all that was recorded. What comes back is taken for nothing but
numbers: no object is made of it.
"""

from __future__ import annotations

import contextlib
import json
import math
import os
import pickle
import signal
import socket
import subprocess
import sys
from array import array
from collections.abc import Mapping
from ctypes import c_double
from multiprocessing.connection import Connection
from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

from towage.errors import RunError
from towage.files import scratch
from towage.process.overseer import Limits
from towage.units.description import Description, Value
from towage.units.fmu import StepRefused, Unit
from towage.units.wiring import Wanted, Wiring

if TYPE_CHECKING:
    from towage.process.watched import Note

LONGEST = 1 << 28
"""Bytes of a reply."""
OK, FAILED, REFUSED = b"0", b"1", b"2"
"""First byte of a reply: doubles or bytes follow; JSON of a `RunError`; why a step was refused."""


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
        code = f"import sys; sys.path[:] = {sys.path!r}; from {__name__} import serve; serve({theirs.fileno()})"
        with theirs:
            self._process = subprocess.Popen(
                [sys.executable, "-c", code], stdin=subprocess.DEVNULL, stdout=2, pass_fds=[theirs.fileno()], cwd=folder,
                env={**os.environ, "TMPDIR": str(folder), "PYTHONDONTWRITEBYTECODE": "1"},
            )  # fmt: skip
        self._open.callback(self._end)
        self._channel = Connection(ours.detach())
        self.instance: Any = SimpleNamespace(meddled={}, dead=False)
        self.advance = self._advance
        self._ask("instantiation", math.nan, "make", name, description, directory, wanted, limits, folder)

    def _ask(self, stage: str, time: float, method: str, *arguments: object) -> bytes:
        """The reply to a call of the unit's ``method``. Raises `RunError` and `StepRefused`."""
        self._note(self._label, stage.encode(), time)
        try:
            self._channel.send_bytes(pickle.dumps((method, arguments, list(self.input_buffer))))
            reply = self._channel.recv_bytes(LONGEST)
        except (OSError, EOFError):
            raise RunError(self._fate(), unit=self.name, time=None if math.isnan(time) else time) from None
        if reply[:1] == REFUSED:
            raise StepRefused(f"{self.name}: {reply[1:].decode(errors='replace')}")
        if reply[:1] != OK:
            raise self._failure(reply[1:], time)
        return reply[1:]

    def _fate(self) -> str:
        self.instance.dead = True
        try:
            code = self._process.wait(5.0)
        except subprocess.TimeoutExpired:
            return "closed the connection to its process"
        how = f"exit code {code}" if code >= 0 else signal.Signals(-code).name
        return f"ended its process ({how})"

    def _failure(self, said: bytes, time: float) -> RunError:
        with contextlib.suppress(ValueError, TypeError, AttributeError):
            fields = json.loads(said)
            self.instance.dead = bool(fields["dead"])
            return RunError(str(fields["message"]), unit=self.name, variable=str(fields["variable"]), time=fields["time"])
        return RunError("its process sent what is no reply", unit=self.name, time=time)

    def _outputs(self, reply: bytes, time: float) -> list[float]:
        if len(reply) != 8 * len(self.outputs):
            raise RunError("its process sent what is no reply", unit=self.name, time=time)
        return self._accept(array("d", reply).tolist(), time)

    def start(self, start: Mapping[str, Value], start_time: float, stop_time: float) -> None:
        """As `Unit.start`."""
        reply = self._ask("initialisation", start_time, "start", dict(start), start_time, stop_time)
        self._outputs(reply, start_time)

    def constant(self, name: str) -> float | None:
        """As `Unit.constant`."""
        v = self.variables.get(name)
        if not v or v.type != "Real":
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


def serve(descriptor: int) -> None:
    """The process of a unit: does what it is asked until the connection ends."""
    channel = Connection(descriptor)
    unit: Unit | None = None
    while True:
        try:
            method, arguments, inputs = pickle.loads(channel.recv_bytes())
        except (OSError, EOFError):
            os._exit(0)
        try:
            if method == "make":
                unit = _made(*arguments)
                reply = b""
            else:
                assert unit
                unit.input_buffer[:] = inputs
                reply = _bytes(getattr(unit, method)(*arguments), unit)
            channel.send_bytes(OK + reply)
        except StepRefused as refusal:
            channel.send_bytes(REFUSED + str(refusal).encode())
        except Exception as error:
            known = error if isinstance(error, RunError) else RunError(f"{type(error).__name__}: {error}")
            dead = unit is not None and unit.instance.dead
            fields = {"message": known.args[0], "variable": known.variable, "time": known.time, "dead": dead}
            channel.send_bytes(FAILED + json.dumps(fields).encode())


def _made(
    name: str, description: Description, directory: Path, wanted: Wanted, limits: Limits, folder: Path
) -> Unit:
    from towage.process import sandbox
    from towage.process.overseer import limit

    limit(limits)
    sandbox.writes_only_below(folder)
    return Unit(name, description, directory, wanted)


def _bytes(value: object, unit: Unit) -> bytes:
    """What a method returned; outputs for those that return nothing but change them."""
    if isinstance(value, bytes):
        return value
    if isinstance(value, float):
        return bytes(c_double(value))
    return array("d", unit.values).tobytes()
