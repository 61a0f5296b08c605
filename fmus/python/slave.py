"""The object that PythonFMU's bridge drives inside a host process: an `Instance` behind the bridge's calling protocol.

What the bridge can say is OK, Discard (``do_step`` returns False) and Fatal (an exception); it has no Error. Hence: a
step that is refused or fails numerically is Discard, and the instance is as it was before; any other value or call
that makes no sense is Fatal, and so is all that follows, until a reset. Each comes with a message, which the bridge
passes on only if the host instantiates with ``loggingOn``.

What the bridge keeps to itself, so that no unit can refuse it: a wrong guid, a type other than co-simulation, fmi2Reset
and fmi2FreeInstance at any time. It does not survive a null pointer for a state. A state cannot be refused while it is
deserialised, so bytes of another unit are refused when they are set. A host that calls several instances from several
threads gets them one after the other, as Python has one lock.

Three faults of PythonFMU 0.7 are mended here, all of memory (`slave`, `Fmi2Slave._fatal`, `_release_at_exit`).
"""

from __future__ import annotations

import atexit
import ctypes
import importlib
import json
import os
import sys
import traceback
import zlib
from functools import cache
from pathlib import Path
from typing import Any

from ..declare.unit import Unit
from .instance import Instance
from .values import FAILED, CallError, StepError

DISCARD, ERROR = 2, 3
BUILD = (__package__ or "").partition(".")[0]
"""The private package of this FMU, whose name tells its code from that of every other version."""


class Message:
    """A message of the log as the bridge reads it."""

    def __init__(self, status: int, category: str, msg: str) -> None:
        self.status, self.category, self.msg = status, category, msg


def _add_reference(owned: object) -> None:
    ctypes.pythonapi.Py_IncRef(ctypes.py_object(owned))


class Fmi2Slave:
    """One FMU instance. The bridge takes the class furthest derived from one of this name."""

    unit: Unit

    def __init__(self, **options: Any) -> None:
        self.instance_name = options.get("instance_name", self.unit.name)
        self.instance = Instance(self.unit)
        self.log_queue: list[Message] = []
        resources = options.get("resources", "")
        if resources in sys.path:
            sys.path.remove(resources)  # the bridge puts it there for the import, once an instance
        _release_at_exit(resources, self.unit.name)

    def _get_log_queue(self) -> list[Message]:
        return self.log_queue

    def _fatal(self, error: BaseException) -> RuntimeError:
        """The exception to raise. On its way out the bridge drops the instance, its class and its messages as if
        they were never used again, and goes on to use them (PythonFMU 0.7: ``handle_py_exception``); what it will
        drop is added here."""
        self.instance.fail()
        for owned in (self, type(self), self.log_queue):
            _add_reference(owned)
        known = isinstance(error, CallError)
        return RuntimeError(self._message(str(error) if known else "".join(traceback.format_exception(error)).strip()))

    def _message(self, text: str) -> str:
        """With its sender; hosts take what the bridge hands them for a format of printf."""
        return f"{self.instance_name} ({self.unit.name}): {text}".replace("%", "%%")

    def _refused(self, status: int, category: str, error: Exception) -> bool:
        self.log_queue.append(Message(status, category, self._message(str(error))))
        return False

    def setup_experiment(self, start: float, stop: float | None = None, tolerance: float | None = None) -> None:
        """Times of the experiment, s."""
        try:
            self.instance.set_up(start, stop)
        except BaseException as error:
            raise self._fatal(error) from None

    def enter_initialization_mode(self) -> None:
        """Parameters and start values may still be set."""
        try:
            self.instance.enter_initialization()
        except BaseException as error:
            raise self._fatal(error) from None

    def exit_initialization_mode(self) -> None:
        """Fix the parameters and compute the initial state."""
        try:
            self.instance.exit_initialization()
        except BaseException as error:
            raise self._fatal(error) from None

    def terminate(self) -> None:
        """No step after this."""
        try:
            self.instance.terminate()
        except BaseException as error:
            raise self._fatal(error) from None

    def get_real(self, references: list[int]) -> list[float]:
        """Current values by value reference, SI."""
        try:
            return self.instance.get_values(references)
        except BaseException as error:
            raise self._fatal(error) from None

    def set_real(self, references: list[int], values: list[float]) -> None:
        """Set parameters and inputs by value reference, SI."""
        try:
            self.instance.set_values(references, values)
        except BaseException as error:
            raise self._fatal(error) from None

    def do_step(self, time: float, step: float) -> bool:
        """Advance from ``time`` by ``step``, s; False where the step is refused and nothing happened."""
        try:
            self.instance.do_step(time, step)
            return True
        except StepError as error:
            return self._refused(DISCARD, "logStatusDiscard", error)
        except CallError as error:
            if self.instance.phase != FAILED:
                return self._refused(ERROR, "logStatusError", error)
            raise self._fatal(error) from None
        except BaseException as error:
            raise self._fatal(error) from None

    def _other_type(self, references: list[int], values: list[Any] | None = None) -> list[Any]:
        if references:
            error = CallError(f"all variables are of type Real, there is none with references {references}")
            raise self._fatal(error)
        return []

    get_integer = set_integer = get_boolean = set_boolean = get_string = set_string = _other_type

    def _get_fmu_state(self) -> tuple[Any, ...]:
        try:
            return self.instance.state()
        except BaseException as error:
            raise self._fatal(error) from None

    def _set_fmu_state(self, state: tuple[Any, ...]) -> None:
        try:
            if self.instance.phase == FAILED:
                raise CallError("the instance failed before: reset it, or free it")
            self.instance.restore(state)
        except BaseException as error:
            raise self._fatal(error) from None

    @classmethod
    def _fmu_state_to_bytes(cls, state: tuple[Any, ...]) -> bytes:
        text = json.dumps([BUILD, cls.unit.name, state]).encode()
        return b"%08x %b" % (zlib.crc32(text), text)

    @classmethod
    def _fmu_state_from_bytes(cls, state: bytes) -> tuple[Any, ...]:
        """The state, or an empty one (which `restore` refuses) for bytes that no FMU of this build wrote, or that were
        changed since."""
        try:
            text = state[9:]
            if state[:9] != b"%08x " % zlib.crc32(text):
                return ()
            build, name, content = json.loads(text)
            head, tuples = content[:7], [tuple(map(float, part)) for part in content[7:]]
        except (ValueError, TypeError, RecursionError):
            return ()
        return (*head, *tuples) if (build, name) == (BUILD, cls.unit.name) else ()


@cache
def _slave_class(place: str) -> type:
    module, _, attribute = place.partition(":")
    unit: Unit = getattr(importlib.import_module(f"{BUILD}.{module}"), attribute)
    return type(unit.name, (Fmi2Slave,), {"unit": unit})


def slave(place: str, script: dict[str, Any]) -> type:
    """The class that the FMU's script names, of the unit declared at ``place``, "module:attribute" below the private
    package. ``script`` is the namespace of the script.

    The bridge runs the script once at import and once an instance, and drops a reference to its namespace each time
    that it does not own (PythonFMU 0.7: ``Py_DECREF`` of ``PyModule_GetDict``); a second instance would find the
    module gone. Each run therefore adds the reference that will be dropped. All runs get one class, as the bridge never
    lets go of a class it has seen.
    """
    _add_reference(script)
    return _slave_class(place)


_bridges: set[str] = set()


def _release_at_exit(resources: str, unit_name: str) -> None:
    """Keep the bridge from corrupting the heap when the host ends.

    Its destructor runs after the static object that it releases was destroyed (PythonFMU 0.7: ``onLibraryUnload``,
    ``pyState``), which in one run of many ends in an abort of the host. Released before, there is nothing left to
    destroy twice. Only where Python is the host: elsewhere that object may own the interpreter.
    """
    library = str(Path(resources).parent / "binaries" / "linux64" / f"{unit_name}.so")
    if sys.platform == "linux" and sys.orig_argv and library not in _bridges:
        _bridges.add(library)
        atexit.register(_release, library)


def _release(library: str) -> None:
    try:
        bridge = ctypes.CDLL(library, os.RTLD_NOW | os.RTLD_NOLOAD)  # type: ignore[attr-defined,unused-ignore]
        bridge.finalizePythonInterpreter()
    except (OSError, AttributeError):
        pass  # unloaded before, or of another version
