"""The object that PythonFMU's bridge drives inside a host process: an `Instance` behind the bridge's calling protocol.

What the bridge can say is OK, Discard (``do_step`` returns False) and Fatal (an exception); a third exception in one
instance crashes the host. Hence: a step that is refused or fails numerically is Discard with a logged message; a value
or a call that makes no sense raises once, with a message, and after that the instance answers quietly and steps no more.
"""

from __future__ import annotations

import ctypes
import json
import traceback
from typing import Any, Callable

from .instance import FAILED, CallError, Instance, StepError
from .unit import load

OK, WARNING, DISCARD, ERROR, FATAL = range(5)


class Message:
    """A log entry as the bridge reads it."""

    def __init__(self, status: int, category: str, msg: str) -> None:
        self.status, self.category, self.msg = status, category, msg


def slave(unit_name: str, script: dict[str, Any]) -> type:
    """The class that the FMU's script derives from. ``script`` is the namespace of the script.

    The bridge runs the script once at import and once an instance, and drops a reference to its namespace each time
    that it does not own (PythonFMU 0.7: ``Py_DECREF`` of ``PyModule_GetDict``); a second instance would find the
    module gone. Each run therefore adds the reference that will be dropped.
    """
    ctypes.pythonapi.Py_IncRef(ctypes.py_object(script))
    unit = load(unit_name)

    class Fmi2Slave:
        """One FMU instance. The bridge takes the class furthest derived from one of this name."""

        def __init__(self, **options: Any) -> None:
            self.instance_name = options.get("instance_name", unit.name)
            self.instance = Instance(unit)
            self.log_queue: list[Message] = []
            self.get_real = self._guarded(self.instance.get_values)
            self.set_real = self._guarded(self.instance.set_values)
            self._get_fmu_state = self.instance.state

        def _get_log_queue(self) -> list[Message]:
            return self.log_queue

        def _log(self, status: int, category: str, text: str) -> None:
            self.log_queue.append(Message(status, category, f"{self.instance_name} ({unit.name}): {text}"))

        def _guarded(self, call: Callable[..., Any]) -> Callable[..., Any]:
            """``call``, raising at most once in the life of the instance."""

            def guarded(*arguments: Any) -> Any:
                if self.instance.phase != FAILED:
                    try:
                        return call(*arguments)
                    except CallError as error:
                        self._fail(str(error))
                    except Exception:
                        self._fail(traceback.format_exc())
                return [float("nan")] * len(arguments[0]) if arguments and isinstance(arguments[0], list) else None

            return guarded

        def _fail(self, text: str) -> None:
            self.instance.phase = FAILED
            self._log(FATAL, "logStatusFatal", text)
            raise RuntimeError(f"{self.instance_name} ({unit.name}): {text}")

        def setup_experiment(self, start: float, stop: float | None = None, tolerance: float | None = None) -> None:
            self._guarded(self.instance.set_up)(start, stop)

        def enter_initialization_mode(self) -> None:
            self._guarded(self.instance.enter_initialization)()

        def exit_initialization_mode(self) -> None:
            self._guarded(self.instance.exit_initialization)()

        def terminate(self) -> None:
            self._guarded(self.instance.terminate)()

        def do_step(self, time: float, step: float) -> bool:
            try:
                self.instance.do_step(time, step)
                return True
            except CallError as error:
                self._log(ERROR, "logStatusError", str(error))
            except StepError as error:
                self._log(DISCARD, "logStatusDiscard", str(error))
            except Exception:
                self.instance.phase = FAILED
                self._log(ERROR, "logStatusError", traceback.format_exc())
            return False

        def _no_values(self, references: list[int], values: list[Any] | None = None) -> list[Any]:
            if references:
                self._guarded(_wrong_type)(references)
            return [0] * len(references)

        get_integer = set_integer = get_boolean = set_boolean = get_string = set_string = _no_values

        def _set_fmu_state(self, state: Any) -> None:
            if self.instance.phase != FAILED:
                self._guarded(self.instance.restore)(state)

        @staticmethod
        def _fmu_state_to_bytes(state: Any) -> bytes:
            return json.dumps([unit.name, state]).encode()

        @staticmethod
        def _fmu_state_from_bytes(state: bytes) -> Any:
            """The state, or None (which `restore` refuses) for bytes that are none of this unit's."""
            try:
                name, content = json.loads(state.decode())
                return tuple(content) if name == unit.name else ()
            except (ValueError, TypeError):
                return ()

    return Fmi2Slave


def _wrong_type(references: list[int]) -> None:
    raise CallError(f"all variables are of type Real, there is none of another type with references {references}")
