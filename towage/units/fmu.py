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
from towage.units.doubt import Doubt
from towage.units.kinds import is_double
from towage.units.library import NEVER_BEFORE, Instance
from towage.units.log import STATUS
from towage.units.wiring import Wanted, Wiring

OK, WARNING, DISCARD, ERROR, FATAL = range(5)
LIES = "PythonFMU"
"""The tool whose bridge (0.7) says after every step that was not done that the unit ended the simulation; units of towage never
end it."""
PENDING = "Pending: it computes on its own while the master goes on, which is not supported"
"""Of fmi2DoStep where the unit canRunAsynchronuously."""
SAME_TIME = 1e-9
"""Share of a step by which the time that a unit reached may miss the step's end."""


class StepRefused(Exception):
    """fmi2DoStep returned Discard or Error: the instance may be restored and stepped otherwise. ``ends``: unless ``unit``
    ends the simulation by itself, at ``reached`` (s, None: it does not say). ``event``: a step that ends there, s, will do."""

    def __init__(
        self, text: str, unit: str, ends: bool = False, reached: float | None = None, event: float | None = None
    ) -> None:
        super().__init__(text)
        self.unit, self.ends, self.reached, self.event = unit, ends, reached, event


class Unit:
    """An instance in a scene.

    ``inputs`` tells where in ``input_buffer`` the connected inputs live; ``values`` are those of ``outputs`` at the end of
    the last step, by place (``slot``). What the scene wants of the unit is ``wanted``.

    ``advance(time, size)`` passes the input buffer on, steps by ``size`` s and reads the outputs. ``lacks``: of a unit in a
    process of its own, what the system does not deny it.
    """

    lacks: list[str] | None = None

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
        self.begun = False
        self.endings: list[tuple[str, float]] = []
        self.can_roll_back = description.can_get_set_state
        self.instance = instance_of(name, description, directory)
        self._state = c_void_p()
        self.advance = self._stepper()

    def _check(self, status: int, what: str, time: float | None = None) -> None:
        """Raises `RunError` for a status that is neither OK nor Warning, which is counted."""
        if status == WARNING:
            self.instance.log.warn(time)
        elif status != OK:
            self.instance.dead = status == FATAL
            said = self.instance.log.said
            odd = PENDING if status == FATAL + 1 else f"{status}, which is none of the standard's statuses for it"
            word = STATUS[status] if 0 <= status <= FATAL else odd
            raise RunError(f"{what} returned {word}" + (f": {said}" if said else ""), unit=self.name, time=time)

    def enter(self, start: Mapping[str, Value], span: tuple[float, float], tolerance: float | None) -> None:
        """Set start values and enter initialisation mode: `Instance.enter`. Raises `RunError`."""
        self.wiring.fill(start)
        self.instance.enter(self.variables, start, span, tolerance)

    def begin(self, time: float) -> None:
        """Leave initialisation mode and read the outputs. Raises `RunError`."""
        self.instance.begin(time)
        self.begun = self.description.conventions  # others tell derivatives of outputs after a step alone, as FMI 2.0 has it
        self.get(time)

    def constant(self, name: str) -> float | None:
        """Current value of a double, None if the unit has none of that name; elements of arrays are not read alone."""
        v = self.variables.get(name)
        return self.instance.real(v.value_reference) if v and is_double(v) else None

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
        if wiring.others.any_in:
            self._set_others(time)

    def _set_others(self, time: float) -> None:
        """Pass on the inputs that are no doubles."""
        try:
            self.wiring.others.set(
                self.instance, self.input_buffer, lambda status: self._check(status, "setting inputs", time)
            )
        except ValueError as error:
            raise RunError(str(error), unit=self.name, time=time) from None

    def get(self, time: float) -> list[float]:
        """Read the outputs into ``values``. Raises `RunError` if one is not finite."""
        instance, wiring = self.instance, self.wiring
        if wiring.get_values:
            status = instance.get_real(instance.component, *wiring.get_values)
            if status:
                self._check(status, "reading outputs", time)
        if wiring.get_derivatives and self.begun:
            status = instance.get_derivatives(instance.component, *wiring.get_derivatives)
            if status > WARNING and status != FATAL and not self.description.conventions:
                why = f"answers {STATUS[status]} where it is asked for the derivatives of outputs that it declares"
                raise Doubt(f"{why}. Take scheme 'auto', which does without", "rates", why, self.name, "", time)
            if status:
                self._check(status, "reading output derivatives", time)
        values = wiring.output_buffer[:]
        if wiring.others.any_out:
            values += wiring.others.get(instance, wiring.typed, lambda status: self._check(status, "reading outputs", time))
        return self._accept(values, time)

    def _accept(self, values: list[float], time: float) -> list[float]:
        """Make ``values`` the present ones. Raises `RunError` if one is not finite."""
        if not abs(sum(values)) < math.inf:
            for name, value, before in zip(self.outputs, values, self.values):
                if not math.isfinite(value):
                    variable, of = name, ""
                    if name not in self.variables:  # a rate that the unit computes by function
                        variable, of = name.removesuffix("_rate"), "its time derivative "
                    raise RunError(
                        f"{of or f'{name} '}became {value}; its last finite value was {before!r}",
                        unit=self.name, variable=variable, time=time,
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
        others, words_in = wiring.others, wiring.others.any_in
        values_alone = bool(get_values) and not wiring.get_derivatives and not others.any_out

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
            if words_in:
                self._set_others(time)
            status = do_step(component, time, size, NEVER_BEFORE)
            if status:
                self._refused(status, time, size)
            if not values_alone:
                self.begun = True
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

    def _refused(self, status: int, time: float, size: float) -> None:
        """Raises `StepRefused` for a step that was not done, `RunError` for a status after which there is none. A unit that
        ends the simulation at the end of the step has done it."""
        if status not in (DISCARD, ERROR):
            self._check(status, "the step", time)
            return
        tells = status == DISCARD and not (self.description.conventions or self.description.generation_tool.startswith(LIES))
        ends, reached = self.instance.ended() if tells else (False, None)
        if ends and reached is not None and abs(reached - (time + size)) <= SAME_TIME * size:
            self.endings.append((self.name, time + size))
            return
        said = self.instance.log.said
        text = f"{self.name}, {STATUS[status]}" + (f": {said}" if said else "")
        raise StepRefused(text, self.name, ends, reached, self.instance.event_inside())

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
            self.begun = self.begun or time > 0.0  # it was stepped to there
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


def instance_of(name: str, description: Description, directory: Path) -> Instance:
    """An instance of the FMU's version of FMI. Raises what `Instance` raises."""
    if description.fmi_version == "2.0":
        return Instance(name, description, directory)
    from towage.units.library3 import Instance3

    return Instance3(name, description, directory)


UnitFactory = Callable[[str, Description, Path, Wanted], Unit]
"""Makes the units of a running scene: `Unit`, or something that stands in for it."""
