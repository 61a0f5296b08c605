"""An instance of FMI 3.0 behind the calls of FMI 2.0 (`towage.units.library.Instance`).

Event mode is used where the unit has it: after a step that needs event handling, and where discrete inputs change, it updates
its discrete states. A step that returns early for an event is one that is refused where the host can take it again, so that a
communication point comes to lie on the event; else the event is handled inside the step, which goes on.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from ctypes import byref, c_bool, c_char_p, c_double, c_size_t, c_void_p
from pathlib import Path
from typing import Any

from fmpy.fmi3 import FMU3Slave

from towage.errors import FmuError, RunError
from towage.units.description import Description, Value, Variable
from towage.units.doubt import Doubt
from towage.units.kinds import Group, groups
from towage.units.library import NEVER_BEFORE, Instance
from towage.units.log import Log

OK, DISCARD, ERROR = 0, 2, 3
MAX_UPDATES = 1000
"""Updates of the discrete states at one event."""
SAME = 1e-12
"""Share of a step that is rounding."""
SAME_TIME = 1e-9
"""Share of a step by which the time that a unit reached may miss the step's end."""


class Instance3(Instance):
    """As `Instance`, for FMI 3.0."""

    prefix = "fmi3"

    def __init__(self, name: str, description: Description, directory: Path) -> None:
        self.name = name
        self.log = Log(name)
        self.dead = False
        self._surround(description)
        self.next_event = math.inf
        self.locates = False
        self._events = description.event_mode
        self.freezes = not self._events  # what it announced and whether it waits for event mode is known here alone
        self._stepping = False
        self._pending = False
        self._over = False
        self._reached = math.nan
        self._event_at: float | None = None
        self._expected: float | None = None
        self._owed: float | None = None
        self._astray = False
        try:
            self._slave = FMU3Slave(
                guid=description.guid,
                unzipDirectory=str(directory),
                modelIdentifier=description.model_identifier,
                instanceName=name,
            )
        except Exception as error:
            raise FmuError(
                f"its library cannot be loaded: {error}. Ask the supplier for one that exports every function of FMI 3.0 "
                "and brings what it needs", file=description.path,
            ) from error  # fmt: skip
        self._instantiate()
        self.component = self._slave.component
        dll = self._slave.dll
        values = c_void_p, c_void_p, c_size_t, c_void_p, c_size_t
        self.set_real = self._function(dll, "SetFloat64", *values)
        self.get_real = self._function(dll, "GetFloat64", *values)
        self.get_derivatives = self._function(
            dll, "GetOutputDerivatives", c_void_p, c_void_p, c_size_t, c_void_p, c_void_p, c_size_t
        )
        self.set_derivatives = self.get_derivatives  # FMI 3 has none: never called
        self._do_step = self._function(
            dll, "DoStep", c_void_p, c_double, c_double, c_bool, c_void_p, c_void_p, c_void_p, c_void_p
        )
        self.get_state = self._function(dll, "GetFMUState", c_void_p, c_void_p)
        self._set_state = self._function(dll, "SetFMUState", c_void_p, c_void_p)
        self.free_state = self._function(dll, "FreeFMUState", c_void_p, c_void_p)
        self._serialized_size = self._function(dll, "SerializedFMUStateSize", c_void_p, c_void_p, c_void_p)
        self._serialize = self._function(dll, "SerializeFMUState", c_void_p, c_void_p, c_char_p, c_size_t)
        self.deserialize = self._function(dll, "DeserializeFMUState", c_void_p, c_char_p, c_size_t, c_void_p)

    def _instantiate(self) -> None:
        """With event mode if the description offers it, and without if the unit then does not offer it. Raises `RunError`."""
        try:
            self._slave.instantiate(
                loggingOn=True, eventModeUsed=self._events, earlyReturnAllowed=self._events, logMessage=self._hear
            )
        except Exception as error:
            if not self._events:
                raise RunError(f"could not be instantiated: {self.log.said or error}", unit=self.name) from error
            self._events, self.freezes = False, True
            self._instantiate()
            self.log.add(1, "towage", "cannot be instantiated with event mode, which its description offers: taken without")
        finally:
            self._set_back()

    def _hear(self, environment: Any, status: int, category: bytes | None, message: bytes | None) -> None:
        self.log.add(status, (category or b"").decode(errors="replace"), (message or b"").decode(errors="replace"))

    def set_state(self, component: int, state: Any) -> int:
        """Go back to a saved state, before its events."""
        self._over = self._pending = False
        self._expected = self._event_at
        return self._set_state(component, state)

    def enter(
        self,
        variables: Mapping[str, Variable],
        start: Mapping[str, Value],
        span: tuple[float, float],
        tolerance: float | None,
    ) -> None:
        """As `Instance.enter`; an array is set whole, its other elements to their start values."""
        with self._stage("setting start values", span[0]):
            touched = {(variables[n].value_reference, variables[n].kind) for n in start}
            wanted = [v for v in variables.values() if (v.value_reference, v.kind) in touched]
            for group in groups(wanted, range(len(wanted))):
                given = [start.get(n, variables[n].start) for n in group.names]
                group.put([0.0 if value is None else value for value in given])
                if status := self._kind("Set", group):
                    raise RuntimeError(f"status {status} for {', '.join(group.names)}")
        with self._stage("initialisation", span[0]):
            self._slave.enterInitializationMode(tolerance=tolerance, startTime=span[0], stopTime=span[1])

    def begin(self, time: float) -> None:
        """As `Instance.begin`; a unit with event mode handles its first events."""
        with self._stage("initialisation", time):
            self._slave.exitInitializationMode()
            self._stepping = True
            if self._events and (status := self._update()):
                raise RuntimeError(f"the update of the discrete states returned status {status}")

    def do_step(self, component: int, time: float, size: float, flag: int) -> int:
        """One step, with what happens inside."""
        if self._over:
            return DISCARD
        begin, end = time, time + size
        expected, self._expected, self._event_at = self._expected, None, None
        while True:
            needs, over, early, reached = c_bool(), c_bool(), c_bool(), c_double(time)
            status = self._do_step(
                component, time, end - time, flag == NEVER_BEFORE, byref(needs), byref(over), byref(early), byref(reached)
            )
            self._over, self._reached, self._pending = bool(over.value), reached.value, bool(needs.value)
            if status > 1:
                return status
            if self._over:
                return DISCARD
            if begin == self._owed and not (early.value or self._pending):
                self._forgotten()
            if not early.value or reached.value >= end - SAME * size:
                if expected is not None and abs(expected - end) <= SAME_TIME * size and not self._pending:
                    self._owed = end  # it may come at once in the next step
                self._check_end(time, end, reached.value)
                return status
            if self.locates and reached.value > time:
                self._event_at = reached.value
                return DISCARD
            if self._pending and (status := self._enter_and_update()):
                return status
            if reached.value <= time and not needs.value:
                return ERROR  # it returns early and gets nowhere
            time = reached.value

    def _forgotten(self) -> None:
        """Raises `Doubt` for an event that ended a step, and did not come again after its state was restored."""
        why = f"forgets an event at t = {self._owed:.9g} s when its state is restored"
        remedy = "Take scheme 'extrapolate' with events = false, which never goes back"
        raise Doubt(f"{why}. {remedy}", "state", why, self.name, "", self._owed)

    def _check_end(self, time: float, end: float, reached: float) -> None:
        """A warning for a step that was done, as the unit says, but to another time than the one it was given; some leave what
        they were given to write on."""
        if reached != time and abs(reached - end) > SAME_TIME * (end - time):
            if not self._astray:
                text = f"says that it did the whole step to {end:.9g} s, and that it came to {reached:.9g} s: one is wrong"
                self.log.add(1, "towage", text)
            self._astray = True
            self.log.warn(time)

    def handle_events(self) -> bool:
        """As `Instance.handle_events`. Raises `RunError`."""
        if not self._events or not (self._pending or self._reached >= self.next_event * (1.0 - SAME)):
            return False
        if status := self._enter_and_update():
            raise RunError(f"event mode: status {status}" + (f": {self.log.said}" if self.log.said else ""), unit=self.name)
        return True

    def _enter_and_update(self) -> int:
        self._pending = False
        return self._function(self._slave.dll, "EnterEventMode", c_void_p)(self.component) or self._update()

    def _update(self) -> int:
        """From event mode to step mode."""
        update = self._function(self._slave.dll, "UpdateDiscreteStates", *[c_void_p] * 7)
        for _ in range(MAX_UPDATES):
            more, over, nominals, values, defined, then = c_bool(), c_bool(), c_bool(), c_bool(), c_bool(), c_double()
            flags = (byref(flag) for flag in (more, over, nominals, values, defined, then))
            status = update(self.component, *flags)
            if status > 1:
                return status
            self.next_event = then.value if defined.value else math.inf
            self._over = self._over or bool(over.value)
            if not more.value:
                return self._function(self._slave.dll, "EnterStepMode", c_void_p)(self.component)
        return ERROR

    def event_inside(self) -> float | None:
        """As `Instance.event_inside`."""
        return self._event_at

    def ended(self) -> tuple[bool, float | None]:
        """As `Instance.ended`."""
        return (True, self._reached if math.isfinite(self._reached) else None) if self._over else (False, None)

    def set_kind(self, group: Group) -> int:
        """As `Instance.set_kind`; discrete inputs of a unit with event mode are set there, when they change."""
        if not (self._events and self._stepping and group.discrete):
            return self._kind("Set", group)
        now = group.taken()
        if now == group.before:
            return OK
        group.before = now
        status = self._function(self._slave.dll, "EnterEventMode", c_void_p)(self.component) or self._kind("Set", group)
        return status or self._update()

    def _kind(self, verb: str, group: Group) -> int:
        sizes = (group.sizes,) if group.kind == "Binary" else ()
        types = [c_void_p, c_void_p, c_size_t, *[c_void_p] * len(sizes), c_void_p, c_size_t]
        function = self._function(self._slave.dll, f"{verb}{group.function}", *types)
        return function(self.component, group.references, len(group.references), *sizes, group.values, len(group.values))

    def real(self, reference: int) -> float:
        """The value of a Float64 variable."""
        return float(self._slave.getFloat64([reference])[0])
