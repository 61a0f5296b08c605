"""One FMI 2.0 co-simulation FMU at work: fmpy loads it, its functions are then called directly on fixed buffers.

A communication step costs one set, one step and one get, whatever the number of variables; fmpy's own wrappers would
allocate arrays for each.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Mapping, Sequence
from ctypes import byref, c_double, c_int, c_uint, c_void_p
from dataclasses import dataclass
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

from .description import Description
from .errors import RunError

OK, WARNING, DISCARD, ERROR, FATAL = range(5)
STATUS = ("OK", "Warning", "Discard", "Error", "Fatal")
INPUT_SLOTS = 4


@dataclass(frozen=True)
class Input:
    """Where a connected input lives in the input buffer. ``smooth``: its three derivatives follow it there;
    ``interpolated``: fmi2SetRealInputDerivatives takes its slope."""

    name: str
    slot: int
    smooth: bool
    interpolated: bool
    feedthrough: bool


_LOGS: dict[int, list[str]] = {}
"""The messages of every living instance, by the environment that it hands to the logger."""
MAX_MESSAGES = 1000


def _log(environment: int | None, instance: Any, status: int, category: Any, message: bytes | None) -> None:
    kept = _LOGS.get(environment or 0)
    if kept is not None and len(kept) < MAX_MESSAGES:
        kept.append((message or b"").decode(errors="replace"))


_LOGGER = fmi2CallbackLoggerTYPE(_log)
"""One for all instances and for ever: fmpy's proxy, which formats the messages, knows only the last one it was given."""


class StepRefused(Exception):
    """fmi2DoStep returned Discard or Error: the instance may be restored and stepped otherwise."""


class Unit:
    """An instance in a scene: ``connected`` inputs, outputs that are ``sources`` of connections, and all ``outputs``
    that are read after every step, in the order of ``values``. ``cubic``: inputs are given their derivatives too."""

    def __init__(
        self,
        name: str,
        description: Description,
        directory: Path,
        connected: Sequence[str],
        sources: Sequence[str],
        outputs: Sequence[str],
        cubic: bool = True,
    ) -> None:
        self.name = name
        self.description = description
        self.variables = {v.name: v for v in description.variables}
        self.messages: list[str] = []
        self.dead = False
        self.feeds = {
            i: any(d is None or i in d for o, d in description.dependencies.items() if o in sources) for i in connected
        }
        self.inputs: dict[str, Input] = {}
        references: list[int] = []
        for i in connected:
            smooth = cubic and all(f"{i}_d{k}" in self.variables for k in (1, 2, 3))
            slope = cubic and not smooth and description.can_interpolate_inputs
            self.inputs[i] = Input(i, len(references), smooth, slope, self.feeds[i])
            names = [i] + [f"{i}_d{k}" for k in (1, 2, 3)] if smooth else [i]
            references += [self.variables[n].value_reference for n in names]
        self.outputs = list(outputs)
        self.slot = {n: k for k, n in enumerate(self.outputs)}
        self._input_references = (c_uint * max(1, len(references)))(*references)
        self.input_buffer = (c_double * max(1, len(references)))()
        self._input_count = len(references)
        self._output_references = (c_uint * max(1, len(outputs)))(
            *(self.variables[n].value_reference for n in self.outputs)
        )
        self._output_buffer = (c_double * max(1, len(outputs)))()
        self._output_count = len(outputs)
        self.values: list[float] = [0.0] * len(outputs)
        self._slave = FMU2Slave(
            guid=description.guid,
            unzipDirectory=str(directory),
            modelIdentifier=description.model_identifier,
            instanceName=name,
        )
        self._callbacks = fmi2CallbackFunctions()
        self._callbacks.logger = _LOGGER
        self._callbacks.allocateMemory = fmi2CallbackAllocateMemoryTYPE(calloc)
        self._callbacks.freeMemory = fmi2CallbackFreeMemoryTYPE(free)
        self._callbacks.stepFinished = fmi2StepFinishedTYPE(lambda environment, status: None)
        self._callbacks.componentEnvironment = id(self.messages)
        _LOGS[id(self.messages)] = self.messages
        addLoggerProxy(byref(self._callbacks))
        try:
            self._slave.instantiate(callbacks=self._callbacks, loggingOn=True)
        except Exception as error:
            raise RunError(f"could not be instantiated: {self._said() or error}", unit=name) from error
        dll = self._slave.dll
        self._component = c_void_p(self._slave.component)
        self._set_real = dll.fmi2SetReal
        self._get_real = dll.fmi2GetReal
        self._do_step = dll.fmi2DoStep
        self._get_state = dll.fmi2GetFMUstate
        self._set_state = dll.fmi2SetFMUstate
        self._free_state = dll.fmi2FreeFMUstate
        self._set_slopes: Callable[..., int] = dll.fmi2SetRealInputDerivatives
        self._state = c_void_p()
        slopes = [i for i in self.inputs.values() if i.interpolated]
        self._slope_inputs = slopes
        self._slope_references = (c_uint * max(1, len(slopes)))(
            *(self.variables[i.name].value_reference for i in slopes)
        )
        self._slope_orders = (c_int * max(1, len(slopes)))(*([1] * len(slopes)))
        self.slopes = (c_double * max(1, len(slopes)))()
        self.slope_slot = {i.name: k for k, i in enumerate(slopes)}
        self.advance = self._stepper()

    def _said(self) -> str:
        """The last thing the unit logged."""
        return self.messages[-1] if self.messages else ""

    def _check(self, status: int, what: str, time: float | None = None) -> None:
        if status > WARNING:
            self.dead = status == FATAL
            said = self._said()
            raise RunError(
                f"{what} returned {STATUS[status] if status <= FATAL else status}" + (f": {said}" if said else ""),
                unit=self.name,
                time=time,
            )

    def start(self, start: Mapping[str, Any], start_time: float, stop_time: float) -> None:
        """Set start values, initialise and read the outputs."""
        slave = self._slave
        stage = "setting start values"
        try:
            for name, value in start.items():
                v = self.variables[name]
                getattr(slave, f"set{'Integer' if v.type == 'Enumeration' else v.type}")([v.value_reference], [value])
            stage = "initialisation"
            slave.setupExperiment(startTime=start_time, stopTime=stop_time)
            slave.enterInitializationMode()
            slave.exitInitializationMode()
        except Exception as error:
            self.dead = "fatal" in str(error)
            raise RunError(f"{stage} failed: {self._said() or error}", unit=self.name, time=start_time) from error
        self.get(start_time)

    def constant(self, name: str) -> float | None:
        """Current value of a Real variable, None if the unit has none of that name."""
        v = self.variables.get(name)
        return float(self._slave.getReal([v.value_reference])[0]) if v and v.type == "Real" else None

    def set(self, time: float) -> None:
        """Pass the input buffer on."""
        if self._input_count:
            status = self._set_real(self._component, self._input_references, self._input_count, self.input_buffer)
            if status:
                self._check(status, "setting inputs", time)
            if self._slope_inputs:
                count = len(self._slope_inputs)
                self._check(
                    self._set_slopes(self._component, self._slope_references, count, self._slope_orders, self.slopes),
                    "setting input derivatives",
                    time,
                )

    def get(self, time: float) -> list[float]:
        """Read the outputs into ``values``. Raises `RunError` if one is not finite."""
        status = self._get_real(self._component, self._output_references, self._output_count, self._output_buffer)
        if status:
            self._check(status, "reading outputs", time)
        return self._accept(self._output_buffer[:], time)

    def _accept(self, values: list[float], time: float) -> list[float]:
        """Make ``values`` the present ones. Raises `RunError` if one is not finite."""
        if not abs(sum(values)) < math.inf:
            for name, value, before in zip(self.outputs, values, self.values):
                if not math.isfinite(value):
                    raise RunError(
                        f"{name} became {value}; its last finite value was {before!r}",
                        unit=self.name, variable=name, time=time,
                    )  # fmt: skip
        self.values = values
        return values

    def _stepper(self) -> Callable[[float, float], list[float]]:
        """``advance(time, size)``: pass the input buffer on, step, read the outputs; one closure, because a step of a
        small unit costs no more than a few Python calls. Raises `StepRefused` if the unit would rather not step so far,
        `RunError` if it is beyond help or an output is not finite."""
        component, do_step, get_real, count = self._component, self._do_step, self._get_real, self._output_count
        references, buffer = self._output_references, self._output_buffer
        set_inputs = self.set if self._input_count else None

        def advance(time: float, size: float) -> list[float]:
            if set_inputs:
                set_inputs(time)
            status = do_step(component, time, size, 0)
            if status > WARNING:
                if status == FATAL:
                    self._check(status, "the step", time)
                said = self._said()
                raise StepRefused(f"{self.name}, {STATUS[status]}" + (f": {said}" if said else ""))
            status = get_real(component, references, count, buffer)
            if status:
                self._check(status, "reading outputs", time + size)
            values = buffer[:]
            if abs(sum(values)) < math.inf:
                self.values = values
                return values
            return self._accept(values, time + size)

        return advance

    @property
    def can_roll_back(self) -> bool:
        """Whether the unit can save and restore its state."""
        return self.description.can_get_set_state

    def save(self, time: float) -> None:
        """Keep the present state for `restore`; only the newest is kept."""
        self.forget()
        status = self._get_state(self._component, byref(self._state))
        if status:
            self._check(status, "saving the state", time)

    def restore(self, time: float) -> None:
        """Go back to the saved state."""
        status = self._set_state(self._component, self._state)
        if status:
            self._check(status, "restoring the state", time)

    def forget(self) -> None:
        """Free the saved state."""
        if self._state.value is not None:
            self._free_state(self._component, byref(self._state))
            self._state = c_void_p()

    def close(self) -> None:
        """Terminate and free, unless the unit reported a fatal error."""
        if not self.dead:
            self.forget()
            with contextlib.suppress(Exception):
                self._slave.terminate()
            self._slave.freeInstance()
            self.dead = True
        _LOGS.pop(id(self.messages), None)
