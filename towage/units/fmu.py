"""One FMI 2.0 co-simulation FMU at work: fmpy loads it, its functions are then called directly on fixed buffers.

A communication step costs one set, one step and one get, whatever the number of variables; fmpy's own wrappers would
allocate arrays for each.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Mapping, Sequence
from ctypes import CDLL, Array, addressof, byref, c_double, c_int, c_size_t, c_uint, c_void_p, sizeof
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

from towage.errors import FmuError, RunError
from towage.fmus.declare.unit import INPUT_ORDERS
from towage.units.description import Description

OK, WARNING, DISCARD, ERROR, FATAL = range(5)
STATUS = ("OK", "Warning", "Discard", "Error", "Fatal")
BY_FUNCTION = False
"""Whether input derivatives go through fmi2SetRealInputDerivatives where they may go with the inputs too: a second call
costs more than the values it carries (``benchmarks/native.py``)."""


@dataclass(frozen=True)
class Input:
    """Where a connected input lives in the input buffer: its value in ``slot``, its derivatives up to order ``orders``
    from ``derivatives`` on."""

    name: str
    slot: int
    derivatives: int
    orders: int
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


def _function(dll: CDLL, name: str, *types: Any) -> Callable[..., int]:
    """A function of the library that takes addresses: to check and convert arrays costs as much as a native step."""
    function = dll[f"fmi2{name}"]  # a new one, fmpy keeps its own
    function.argtypes, function.restype = types, c_int
    return function


class Unit:
    """An instance in a scene: ``connected`` inputs, outputs that are ``sources`` of connections, and all ``outputs``
    that are read after every step, in the order of ``values``. ``cubic``: inputs are given their derivatives too, and
    rates of sources that are not among the outputs follow these as ``<source>_rate`` if the unit computes them.

    A derivative of an input is the variable ``<input>_d1``, ``_d2`` or ``_d3`` if there is one, else it goes through
    fmi2SetRealInputDerivatives: up to order 3 into our own units, the slope alone into others, whose limit FMI 2.0 does
    not tell."""

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
        self._alive: list[Any] = []
        self._wire(connected, sources, outputs, cubic)
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
        self._component: int = self._slave.component
        dll = self._slave.dll
        self._set_real = _function(dll, "SetReal", c_void_p, c_void_p, c_size_t, c_void_p)
        self._get_real = _function(dll, "GetReal", c_void_p, c_void_p, c_size_t, c_void_p)
        derivatives = c_void_p, c_void_p, c_size_t, c_void_p, c_void_p
        self._set_derivatives = _function(dll, "SetRealInputDerivatives", *derivatives)
        self._get_derivatives = _function(dll, "GetRealOutputDerivatives", *derivatives)
        self._do_step = _function(dll, "DoStep", c_void_p, c_double, c_double, c_int)
        self._get_state = _function(dll, "GetFMUstate", c_void_p, c_void_p)
        self._set_state = _function(dll, "SetFMUstate", c_void_p, c_void_p)
        self._free_state = _function(dll, "FreeFMUstate", c_void_p, c_void_p)
        self._state = c_void_p()
        self.advance = self._stepper()

    def _wire(self, connected: Sequence[str], sources: Sequence[str], outputs: Sequence[str], cubic: bool) -> None:
        """Fix the buffers: values of inputs, then derivatives that are variables, then those that the function takes."""
        interpolates = self.description.can_interpolate_inputs

        def declared(name: str) -> bool:
            return all(f"{name}_d{k}" in self.variables for k in INPUT_ORDERS)

        by_function = [i for i in connected if cubic and interpolates and (BY_FUNCTION or not declared(i))]
        by_variable = [i for i in connected if cubic and declared(i) and i not in by_function]
        orders = {i: 3 if declared(i) else 1 for i in by_function} | dict.fromkeys(by_variable, 3)
        names = [*connected, *(f"{i}_d{k}" for i in by_variable for k in INPUT_ORDERS)]
        taken = [(i, k) for i in by_function for k in range(1, orders[i] + 1)]
        first = {i: len(connected) + 3 * n for n, i in enumerate(by_variable)}
        first |= {i: len(names) + taken.index((i, 1)) for i in by_function}
        self.inputs = {
            i: Input(i, n, first.get(i, 0), orders.get(i, 0), self.feeds[i]) for n, i in enumerate(connected)
        }
        self.input_buffer = (c_double * (len(names) + len(taken)))()
        self._inputs = self._call(names, self.input_buffer, 0)
        self._taken = self._call([i for i, _ in taken], self.input_buffer, len(names), [k for _, k in taken])
        rated = [n for n in sources if f"{n}_rate" not in outputs and self.description.max_output_derivative_order]
        rated = rated if cubic else []
        self.outputs = [*outputs, *(f"{n}_rate" for n in rated)]
        self.slot = {n: k for k, n in enumerate(self.outputs)}
        self._output_buffer = (c_double * len(self.outputs))()
        self._outputs = self._call(outputs, self._output_buffer, 0)
        self._rates = self._call(rated, self._output_buffer, len(outputs), [1] * len(rated))
        self.values: list[float] = [0.0] * len(self.outputs)

    def _call(
        self, names: Sequence[str], buffer: Array[c_double], first: int, orders: Sequence[int] | None = None
    ) -> tuple[int, ...]:
        """What a call for these variables takes after the component: addresses of the references, their number, the
        addresses of the orders of derivatives if there are any, and of the values, in ``buffer`` from ``first`` on. Empty
        if there is nothing to call for."""
        references = (c_uint * len(names))(*(self.variables[n].value_reference for n in names))
        kinds = (c_int * len(names))(*(orders or ()))
        self._alive += [references, kinds]
        middle = () if orders is None else (addressof(kinds),)
        values = addressof(buffer) + first * sizeof(c_double)
        return (addressof(references), len(names), *middle, values) if names else ()

    def _said(self) -> str:
        """The last thing the unit logged."""
        return self.messages[-1] if self.messages else ""

    def _check(self, status: int, what: str, time: float | None = None) -> None:
        if status not in (OK, WARNING):
            self.dead = status == FATAL
            said = self._said()
            word = STATUS[status] if 0 <= status <= FATAL else f"{status}, which is none of the standard's statuses for it"
            raise RunError(
                f"{what} returned {word}" + (f": {said}" if said else ""),
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
        if self._inputs:
            status = self._set_real(self._component, *self._inputs)
            if status:
                self._check(status, "setting inputs", time)
        if self._taken:
            status = self._set_derivatives(self._component, *self._taken)
            if status:
                self._check(status, "setting input derivatives", time)

    def get(self, time: float) -> list[float]:
        """Read the outputs into ``values``. Raises `RunError` if one is not finite."""
        if self._outputs:
            status = self._get_real(self._component, *self._outputs)
            if status:
                self._check(status, "reading outputs", time)
        if self._rates:
            status = self._get_derivatives(self._component, *self._rates)
            if status:
                self._check(status, "reading output derivatives", time)
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
        component, do_step, get, buffer = self._component, self._do_step, self.get, self._output_buffer
        set_inputs, check = self.set if self._inputs else None, self._check
        get_real, outputs = self._get_real, self._outputs
        plain = bool(outputs) and not self._rates

        def advance(time: float, size: float) -> list[float]:
            if set_inputs:
                set_inputs(time)
            status = do_step(component, time, size, 0)
            if status and status != WARNING:
                if status not in (DISCARD, ERROR):
                    check(status, "the step", time)
                said = self._said()
                raise StepRefused(f"{self.name}, {STATUS[status]}" + (f": {said}" if said else ""))
            if not plain:
                return get(time + size)
            status = get_real(component, *outputs)
            if status:  # Fatal may be its last: it is not asked again
                check(status, "reading outputs", time + size)
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
