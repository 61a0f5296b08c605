"""The library of an FMU and one instance in it: fmpy loads and instantiates, the functions of a step are called directly.

fmpy's own wrappers allocate arrays at each call. The functions here take addresses (`towage.units.wiring`): to check and
convert arrays costs as much as a native step.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Iterator, Mapping
from ctypes import CDLL, byref, c_char_p, c_double, c_int, c_size_t, c_void_p, create_string_buffer
from pathlib import Path
from typing import Any

from fmpy import calloc, free
from fmpy.fmi2 import (
    FMU2Slave,
    fmi2CallbackAllocateMemoryTYPE,
    fmi2CallbackFreeMemoryTYPE,
    fmi2CallbackFunctions,
    fmi2CallbackLoggerTYPE,
    fmi2StepFinishedTYPE,
)
from fmpy.logging import addLoggerProxy

from towage.errors import FmuError, RunError
from towage.units.archive import library_of
from towage.units.description import Description, Value, Variable, is_own
from towage.units.kinds import Group
from towage.units.log import Log
from towage.units.surroundings import Surroundings

_LOGS: dict[int, Log] = {}
"""The log of every living instance, by the environment that it hands to the logger."""
LAST_SUCCESSFUL_TIME, TERMINATED = 2, 3
"""Of fmi2StatusKind."""
NEVER_BEFORE = 1
"""fmi2DoStep's noSetFMUStatePriorToCurrentPoint: the master goes back to the start of a step, never before it."""


def _log(environment: int | None, instance: Any, status: int, category: bytes | None, message: bytes | None) -> None:
    kept = _LOGS.get(environment or 0)
    if kept is not None:
        kept.add(status, (category or b"").decode(errors="replace"), (message or b"").decode(errors="replace"))


_LOGGER = fmi2CallbackLoggerTYPE(_log)
"""One for all instances and for ever: fmpy's proxy, which formats the messages, knows only the last one it was given."""


class Instance:
    """An instance of the FMU unpacked in ``directory``, called ``name``.

    ``next_event``: the next event in time that it announces, s, FMI 3 alone. ``locates``: the host takes a step that ends for
    an event inside again.

    ``component`` is its address, the first argument of every function: ``set_real``, ``get_real``, ``set_derivatives``,
    ``get_derivatives``, ``do_step``, ``get_state``, ``set_state`` and ``free_state``, which return FMI's status. What the
    instance logs is in ``log``. ``dead``: it must not be called any more. ``freezes``: a state that it serialises at a
    communication point is all of its state. ``meddled``: what the instance, of another make, changed of the process, and was
    set back.

    Raises `FmuError` if the library cannot be loaded, `RunError` if the instance cannot be made.
    """

    prefix = "fmi2"
    """Of the functions of the library."""

    def __init__(self, name: str, description: Description, directory: Path) -> None:
        self.name = name
        self.log = Log(name)
        self.dead = False
        self._surround(description)
        self.freezes = True
        self.next_event = math.inf
        self.locates = False
        try:
            self._slave = FMU2Slave(
                guid=description.guid,
                unzipDirectory=str(directory),
                modelIdentifier=description.model_identifier,
                instanceName=name,
                libraryPath=str(library_of(description, directory)),
            )
        except Exception as error:  # fmpy's own kind, or AttributeError where a function is missing
            raise FmuError(
                f"its library cannot be loaded: {error}. Ask the supplier for one that exports every function of FMI 2.0 "
                "and brings what it needs", file=description.path,
            ) from error  # fmt: skip
        self._callbacks = self._functions_of_the_host()
        try:
            self._slave.instantiate(callbacks=self._callbacks, loggingOn=True)
        except Exception as error:
            raise RunError(f"could not be instantiated: {self.log.said or error}", unit=name) from error
        finally:
            self._set_back()
        self.component: int = self._slave.component
        dll = self._slave.dll
        self.set_real = self._function(dll, "SetReal", c_void_p, c_void_p, c_size_t, c_void_p)
        self.get_real = self._function(dll, "GetReal", c_void_p, c_void_p, c_size_t, c_void_p)
        derivatives = c_void_p, c_void_p, c_size_t, c_void_p, c_void_p
        self.set_derivatives = self._function(dll, "SetRealInputDerivatives", *derivatives)
        self.get_derivatives = self._function(dll, "GetRealOutputDerivatives", *derivatives)
        self.do_step = self._function(dll, "DoStep", c_void_p, c_double, c_double, c_int)
        self.get_state = self._function(dll, "GetFMUstate", c_void_p, c_void_p)
        self.set_state = self._function(dll, "SetFMUstate", c_void_p, c_void_p)
        self.free_state = self._function(dll, "FreeFMUstate", c_void_p, c_void_p)
        self._serialized_size = self._function(dll, "SerializedFMUstateSize", c_void_p, c_void_p, c_void_p)
        self._serialize = self._function(dll, "SerializeFMUstate", c_void_p, c_void_p, c_char_p, c_size_t)
        self.deserialize = self._function(dll, "DeSerializeFMUstate", c_void_p, c_char_p, c_size_t, c_void_p)
        self._boolean_status = self._function(dll, "GetBooleanStatus", c_void_p, c_int, c_void_p)
        self._real_status = self._function(dll, "GetRealStatus", c_void_p, c_int, c_void_p)

    def _surround(self, description: Description) -> None:
        """Look after what an instance of another make may change of the process."""
        self.meddled: dict[str, None] = {}
        self._surroundings = None if is_own(description) else Surroundings()

    def _function(self, dll: CDLL, name: str, *types: Any) -> Callable[..., int]:
        """A function of the library that takes addresses; what it changes of the process is set back after each call."""
        function: Callable[..., int] = dll[f"{self.prefix}{name}"]  # a new one, fmpy keeps its own
        function.argtypes, function.restype = types, c_int  # type: ignore[attr-defined]
        return self._surroundings.guarded(function, self._note) if self._surroundings else function

    def serialized(self, state: c_void_p) -> tuple[int, bytes]:
        """(FMI's status, the bytes of a saved state)."""
        size = c_size_t()
        if status := self._serialized_size(self.component, state, byref(size)):
            return status, b""
        buffer = create_string_buffer(size.value)
        return self._serialize(self.component, state, buffer, size.value), buffer.raw

    def _note(self, said: list[str]) -> None:
        self.meddled |= dict.fromkeys(said)

    def _set_back(self) -> None:
        if self._surroundings:
            self._note(self._surroundings.restore())

    def _functions_of_the_host(self) -> fmi2CallbackFunctions:
        """What the instance may call: logger and memory."""
        callbacks = fmi2CallbackFunctions()
        callbacks.logger = _LOGGER
        callbacks.allocateMemory = fmi2CallbackAllocateMemoryTYPE(calloc)
        callbacks.freeMemory = fmi2CallbackFreeMemoryTYPE(free)
        callbacks.stepFinished = fmi2StepFinishedTYPE(lambda environment, status: None)
        callbacks.componentEnvironment = id(self.log)
        _LOGS[id(self.log)] = self.log
        addLoggerProxy(byref(callbacks))
        return callbacks

    def enter(
        self,
        variables: Mapping[str, Variable],
        start: Mapping[str, Value],
        span: tuple[float, float],
        tolerance: float | None,
    ) -> None:
        """Set start values and enter initialisation mode. ``span``: start and stop, s; ``tolerance``: relative, for what the
        unit solves itself, None: its own. Units of 20-sim forget what was set before the experiment is. Raises `RunError`."""
        with self._stage("setting up the experiment", span[0]):
            self._slave.setupExperiment(tolerance=tolerance, startTime=span[0], stopTime=span[1])
        with self._stage("setting start values", span[0]):
            for name, value in start.items():
                v = variables[name]
                setter = getattr(self._slave, f"set{'Integer' if v.type == 'Enumeration' else v.type}")
                setter([v.value_reference], [value])
        with self._stage("initialisation", span[0]):
            self._slave.enterInitializationMode()

    def begin(self, time: float) -> None:
        """Leave initialisation mode. Raises `RunError`."""
        with self._stage("initialisation", time):
            self._slave.exitInitializationMode()

    @contextlib.contextmanager
    def _stage(self, stage: str, time: float) -> Iterator[None]:
        """What goes wrong in a stage as a `RunError`."""
        try:
            yield
        except Exception as error:
            self.dead = "fatal" in str(error)
            raise RunError(f"{stage} failed: {self.log.said or error}", unit=self.name, time=time) from error
        finally:
            self._set_back()

    def handle_events(self) -> bool:
        """Whether the unit had events to handle at the communication point, which it has now: FMI 3 alone knows them."""
        return False

    def event_inside(self) -> float | None:
        """Where the step that was refused last ended for an event, s; FMI 3 alone tells."""
        return None

    def ended(self) -> tuple[bool, float | None]:
        """After a step that was discarded: (whether the unit ends the simulation by itself, up to when it came, s, if it
        says so)."""
        over, reached = c_int(0), c_double(math.nan)
        status = self._boolean_status(self.component, TERMINATED, byref(over))
        if status != 0 or not over.value:
            return False, None
        known = self._real_status(self.component, LAST_SUCCESSFUL_TIME, byref(reached)) == 0
        return True, reached.value if known and math.isfinite(reached.value) else None

    def set_kind(self, group: Group) -> int:
        """Set variables of one kind; returns FMI's status."""
        return self._kind("Set", group)

    def get_kind(self, group: Group) -> int:
        """Read variables of one kind; returns FMI's status."""
        return self._kind("Get", group)

    def _kind(self, verb: str, group: Group) -> int:
        function = self._function(self._slave.dll, f"{verb}{group.function}", c_void_p, c_void_p, c_size_t, c_void_p)
        return function(self.component, group.references, len(group.references), group.values)

    def real(self, reference: int) -> float:
        """The value of a Real variable."""
        return float(self._slave.getReal([reference])[0])

    def close(self) -> None:
        """Terminate and free, unless a call was fatal; nothing is logged from then on."""
        if not self.dead:
            with contextlib.suppress(Exception):
                self._slave.terminate()
            self._slave.freeInstance()
            self.dead = True
            self._set_back()
        _LOGS.pop(id(self.log), None)
