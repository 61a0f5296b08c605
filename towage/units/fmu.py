"""One FMI 2.0 co-simulation FMU in a running scene: start, step, outputs, saved state.

A status that ends the run becomes a `RunError` with unit and time; a step that the unit refuses becomes `StepRefused`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from ctypes import byref, c_void_p
from pathlib import Path

from towage.errors import RunError
from towage.units.description import Description, Value
from towage.units.library import Instance
from towage.units.wiring import Wanted, Wiring

OK, WARNING, DISCARD, ERROR, FATAL = range(5)
STATUS = ("OK", "Warning", "Discard", "Error", "Fatal")


class StepRefused(Exception):
    """fmi2DoStep returned Discard or Error: the instance may be restored and stepped otherwise."""


class Unit:
    """An instance in a scene.

    ``inputs`` tells where in ``input_buffer`` the connected inputs live; ``values`` are those of ``outputs`` at the end of
    the last step, by place (``slot``). What the scene wants of the unit is ``wanted``.

    ``advance(time, size)`` passes the input buffer on, steps by ``size`` s and reads the outputs.
    """

    def __init__(self, name: str, description: Description, directory: Path, wanted: Wanted) -> None:
        self.name = name
        self.description = description
        self.wiring = Wiring(description, wanted)
        self.variables = self.wiring.variables
        self.inputs = self.wiring.inputs
        self.input_buffer = self.wiring.input_buffer
        self.outputs = self.wiring.outputs
        self.slot = {n: k for k, n in enumerate(self.outputs)}
        self.values: list[float] = [0.0] * len(self.outputs)
        self.instance = Instance(name, description, directory)
        self._state = c_void_p()
        self.advance = self._stepper()

    def _check(self, status: int, what: str, time: float | None = None) -> None:
        """Raises `RunError` for a status that is neither OK nor Warning."""
        if status not in (OK, WARNING):
            self.instance.dead = status == FATAL
            said = self.instance.last_message
            word = (
                STATUS[status] if 0 <= status <= FATAL else f"{status}, which is none of the standard's statuses for it"
            )
            raise RunError(f"{what} returned {word}" + (f": {said}" if said else ""), unit=self.name, time=time)

    def start(self, start: Mapping[str, Value], start_time: float, stop_time: float) -> None:
        """Set start values, initialise and read the outputs. Raises `RunError`."""
        self.instance.initialize(self.variables, start, start_time, stop_time)
        self.get(start_time)

    def constant(self, name: str) -> float | None:
        """Current value of a Real variable, None if the unit has none of that name."""
        v = self.variables.get(name)
        return self.instance.real(v.value_reference) if v and v.type == "Real" else None

    def set(self, time: float) -> None:
        """Pass the input buffer on."""
        instance, wiring = self.instance, self.wiring
        if wiring.set_values:
            status = instance.set_real(instance.component, *wiring.set_values)
            if status:
                self._check(status, "setting inputs", time)
        if wiring.set_derivatives:
            status = instance.set_derivatives(instance.component, *wiring.set_derivatives)
            if status:
                self._check(status, "setting input derivatives", time)

    def get(self, time: float) -> list[float]:
        """Read the outputs into ``values``. Raises `RunError` if one is not finite."""
        instance, wiring = self.instance, self.wiring
        if wiring.get_values:
            status = instance.get_real(instance.component, *wiring.get_values)
            if status:
                self._check(status, "reading outputs", time)
        if wiring.get_derivatives:
            status = instance.get_derivatives(instance.component, *wiring.get_derivatives)
            if status:
                self._check(status, "reading output derivatives", time)
        return self._accept(wiring.output_buffer[:], time)

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
        """``advance``: one closure, because a step of a small unit costs no more than a few Python calls. Raises
        `StepRefused` if the unit refuses a step of this size, `RunError` if it cannot go on or an output is not finite."""
        instance, wiring, check = self.instance, self.wiring, self._check
        component, do_step, get = instance.component, instance.do_step, self.get
        set_real, set_values = instance.set_real, wiring.set_values
        set_input_derivatives, set_derivatives = instance.set_derivatives, wiring.set_derivatives
        get_real, get_values, buffer = instance.get_real, wiring.get_values, wiring.output_buffer
        values_alone = bool(get_values) and not wiring.get_derivatives

        def advance(time: float, size: float) -> list[float]:
            """One step from ``time`` by ``size``, s; returns the outputs."""
            if set_values:
                status = set_real(component, *set_values)
                if status:
                    check(status, "setting inputs", time)
            if set_derivatives:
                status = set_input_derivatives(component, *set_derivatives)
                if status:
                    check(status, "setting input derivatives", time)
            status = do_step(component, time, size, 0)
            if status and status != WARNING:
                if status not in (DISCARD, ERROR):
                    check(status, "the step", time)
                said = instance.last_message
                raise StepRefused(f"{self.name}, {STATUS[status]}" + (f": {said}" if said else ""))
            if not values_alone:
                return get(time + size)
            status = get_real(component, *get_values)
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
        status = self.instance.get_state(self.instance.component, byref(self._state))
        if status:
            self._check(status, "saving the state", time)

    def restore(self, time: float) -> None:
        """Go back to the saved state."""
        status = self.instance.set_state(self.instance.component, self._state)
        if status:
            self._check(status, "restoring the state", time)

    def frozen(self, time: float) -> bytes:
        """The present state, as it may be stored. Raises `RunError`."""
        state = c_void_p()
        try:
            self._check(self.instance.get_state(self.instance.component, byref(state)), "saving the state", time)
            status, data = self.instance.serialized(state)
            self._check(status, "serialising the state", time)
            return data
        finally:
            self.instance.free_state(self.instance.component, byref(state))

    def thaw(self, data: bytes, time: float) -> None:
        """Go to a state that `frozen` gave. Raises `RunError`."""
        state = c_void_p()
        try:
            status = self.instance.deserialize(self.instance.component, data, len(data), byref(state))
            self._check(status, "deserialising the state", time)
            self._check(self.instance.set_state(self.instance.component, state), "restoring the state", time)
        finally:
            self.instance.free_state(self.instance.component, byref(state))

    def forget(self) -> None:
        """Free the saved state."""
        if self._state.value is not None:
            self.instance.free_state(self.instance.component, byref(self._state))
            self._state = c_void_p()

    def close(self) -> None:
        """Terminate and free, unless the unit reported a fatal error."""
        if not self.instance.dead:
            self.forget()
        self.instance.close()


UnitFactory = Callable[[str, Description, Path, Wanted], Unit]
"""Makes the units of a running scene: `Unit`, or something that stands in for it."""
