"""The library of an FMU and one instance in it: fmpy loads and instantiates, the functions of a step are called directly.

fmpy's own wrappers allocate arrays at each call. The functions here take addresses (`towage.units.wiring`): to check and
convert arrays costs as much as a native step.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Mapping
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
from towage.units.description import Description, Value, Variable, is_own
from towage.units.surroundings import Surroundings

_LOGS: dict[int, list[str]] = {}
"""The messages of every living instance, by the environment that it hands to the logger."""
MAX_MESSAGES = 1000
_GUARDED = (
    "set_real", "get_real", "set_derivatives", "get_derivatives", "do_step", "get_state", "set_state", "free_state", "deserialize"
)  # fmt: skip


def _log(environment: int | None, instance: Any, status: int, category: Any, message: bytes | None) -> None:
    kept = _LOGS.get(environment or 0)
    if kept is not None and len(kept) < MAX_MESSAGES:
        kept.append((message or b"").decode(errors="replace"))


_LOGGER = fmi2CallbackLoggerTYPE(_log)
"""One for all instances and for ever: fmpy's proxy, which formats the messages, knows only the last one it was given."""


class Instance:
    """An instance of the FMU unpacked in ``directory``, called ``name``.

    ``component`` is its address, the first argument of every function: ``set_real``, ``get_real``, ``set_derivatives``,
    ``get_derivatives``, ``do_step``, ``get_state``, ``set_state`` and ``free_state``, which return FMI's status. What the
    instance logs is in ``messages``. ``dead``: it must not be called any more. ``meddled``: what the instance, of another
    make, changed of the process, and was set back.

    Raises `FmuError` if the library cannot be loaded, `RunError` if the instance cannot be made.
    """

    def __init__(self, name: str, description: Description, directory: Path) -> None:
        self.name = name
        self.messages: list[str] = []
        self.dead = False
        self.meddled: dict[str, None] = {}
        self._surroundings = None if is_own(description) else Surroundings()
        try:
            self._slave = FMU2Slave(
                guid=description.guid,
                unzipDirectory=str(directory),
                modelIdentifier=description.model_identifier,
                instanceName=name,
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
            raise RunError(f"could not be instantiated: {self.last_message or error}", unit=name) from error
        finally:
            self._set_back()
        self.component: int = self._slave.component
        dll = self._slave.dll
        self.set_real = _function(dll, "SetReal", c_void_p, c_void_p, c_size_t, c_void_p)
        self.get_real = _function(dll, "GetReal", c_void_p, c_void_p, c_size_t, c_void_p)
        derivatives = c_void_p, c_void_p, c_size_t, c_void_p, c_void_p
        self.set_derivatives = _function(dll, "SetRealInputDerivatives", *derivatives)
        self.get_derivatives = _function(dll, "GetRealOutputDerivatives", *derivatives)
        self.do_step = _function(dll, "DoStep", c_void_p, c_double, c_double, c_int)
        self.get_state = _function(dll, "GetFMUstate", c_void_p, c_void_p)
        self.set_state = _function(dll, "SetFMUstate", c_void_p, c_void_p)
        self.free_state = _function(dll, "FreeFMUstate", c_void_p, c_void_p)
        self._serialized_size = _function(dll, "SerializedFMUstateSize", c_void_p, c_void_p, c_void_p)
        self._serialize = _function(dll, "SerializeFMUstate", c_void_p, c_void_p, c_char_p, c_size_t)
        self.deserialize = _function(dll, "DeSerializeFMUstate", c_void_p, c_char_p, c_size_t, c_void_p)
        if self._surroundings:
            for function in _GUARDED:
                setattr(self, function, self._surroundings.guarded(getattr(self, function), self._note))

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
        callbacks.componentEnvironment = id(self.messages)
        _LOGS[id(self.messages)] = self.messages
        addLoggerProxy(byref(callbacks))
        return callbacks

    @property
    def last_message(self) -> str:
        """The last thing that the instance logged."""
        return self.messages[-1] if self.messages else ""

    def initialize(
        self, variables: Mapping[str, Variable], start: Mapping[str, Value], time: float, stop: float
    ) -> None:
        """Set start values and initialise; times in s. Raises `RunError`."""
        slave = self._slave
        stage = "setting start values"
        try:
            for name, value in start.items():
                v = variables[name]
                getattr(slave, f"set{'Integer' if v.type == 'Enumeration' else v.type}")([v.value_reference], [value])
            stage = "initialisation"
            slave.setupExperiment(startTime=time, stopTime=stop)
            slave.enterInitializationMode()
            slave.exitInitializationMode()
        except Exception as error:
            self.dead = "fatal" in str(error)
            said = self.last_message or error
            raise RunError(f"{stage} failed: {said}", unit=self.name, time=time) from error
        finally:
            self._set_back()

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
        _LOGS.pop(id(self.messages), None)


def _function(dll: CDLL, name: str, *types: Any) -> Callable[..., int]:
    """A function of the library that takes addresses."""
    function = dll[f"fmi2{name}"]  # a new one, fmpy keeps its own
    function.argtypes, function.restype = types, c_int
    return function
