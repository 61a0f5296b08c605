"""A bare FMI 2 host for programs that run without the work tree: statuses are returned, never raised.

fmpy finds and loads the library; all calls then go straight to its functions, so that what is seen is what an FMU says.
"""

import json
import sys
from ctypes import POINTER, byref, c_char_p, c_double, c_int, c_size_t, c_uint, c_void_p, create_string_buffer
from pathlib import Path

import fmpy
from fmpy.fmi2 import (
    FMU2Slave,
    fmi2CallbackAllocateMemoryTYPE,
    fmi2CallbackFreeMemoryTYPE,
    fmi2CallbackFunctions,
    fmi2CallbackLoggerTYPE,
    fmi2StepFinishedTYPE,
)
from fmpy.logging import addLoggerProxy

OK, WARNING, DISCARD, ERROR, FATAL = range(5)


_LOGS = []


def _log(environment, instance, status, category, message):
    """fmpy's proxy, which formats messages as printf does, knows only the logger that came last: one for all."""
    _LOGS[environment - 1].append((status, (category or b"").decode(), (message or b"").decode()))


_LOGGER, _STEP_FINISHED = fmi2CallbackLoggerTYPE(_log), fmi2StepFinishedTYPE(lambda environment, status: None)


class Fmu:
    """An unpacked FMU."""

    def __init__(self, path, work):
        self.path = Path(path)
        self.name = self.path.stem
        self.description = fmpy.read_model_description(str(path), validate=True)
        self.directory = Path(work) / f"{self.path.parent.name}_{self.name}"
        if not self.directory.exists():
            fmpy.extract(str(path), str(self.directory))
        self.native = not (self.directory / "resources" / "slavemodule.txt").exists()
        self.refusal = ERROR if self.native else FATAL
        """Status of a refused call: the Python bridge has no Error."""
        self.variables = {v.name: v for v in self.description.modelVariables}
        self.reference = {n: v.valueReference for n, v in self.variables.items()}
        self.observed = [
            n for n, v in self.variables.items()
            if v.causality in ("output", "local") and not n.startswith(("state.", "der(state."))
        ]  # what both flavours show
        self.inputs = [n for n, v in self.variables.items() if v.causality == "input"]
        self.cases = CASES[self.name]["inputs"]
        """Centre and size of every input."""
        self.fixed = {n: float(v.start) for n, v in self.variables.items() if v.min is not None and v.min == v.max}
        """What the build of a native FMU fixed: it has that value and no other."""
        self.start = {n: self.fixed.get(n, value) for n, value in CASES[self.name]["start"].items()}
        """Start values of a run."""

    def instantiate(self, name="it", logging=True, guid=None):
        """A new instance; `Slave.component` is None where it was refused."""
        return Slave(self, name, logging, guid or self.description.guid)

    def ready(self, start=None, name="it", start_time=0.0, stop_time=None):
        """An instance after initialisation."""
        it = self.instantiate(name)
        assert it.initialize(start or {}, start_time, stop_time) == OK, it.messages
        return it


class Slave:
    """An instance. Every method returns the status, those that read (status, value)."""

    def __init__(self, fmu, name, logging, guid):
        self.fmu, self.messages = fmu, []
        self.slave = FMU2Slave(
            guid=guid,
            unzipDirectory=str(fmu.directory),
            modelIdentifier=fmu.description.coSimulation.modelIdentifier,
            instanceName=name,
        )
        functions = fmi2CallbackFunctions()
        functions.logger = _LOGGER
        functions.allocateMemory = fmi2CallbackAllocateMemoryTYPE(fmpy.calloc)
        functions.freeMemory = fmi2CallbackFreeMemoryTYPE(fmpy.free)
        functions.stepFinished = _STEP_FINISHED
        _LOGS.append(self.messages)
        functions.componentEnvironment = len(_LOGS)
        addLoggerProxy(byref(functions))
        dll = self.slave.dll
        signatures = {
            "SetupExperiment": [c_int, c_double, c_double, c_int, c_double], "EnterInitializationMode": [],
            "ExitInitializationMode": [], "Terminate": [], "Reset": [], "DoStep": [c_double, c_double, c_int],
            "SetReal": [POINTER(c_uint), c_size_t, POINTER(c_double)],
            "GetReal": [POINTER(c_uint), c_size_t, POINTER(c_double)],
            "GetInteger": [POINTER(c_uint), c_size_t, POINTER(c_int)],
            "GetBoolean": [POINTER(c_uint), c_size_t, POINTER(c_int)],
            "GetString": [POINTER(c_uint), c_size_t, POINTER(c_char_p)],
            "SetString": [POINTER(c_uint), c_size_t, POINTER(c_char_p)],
            "GetRealStatus": [c_int, POINTER(c_double)],
            "GetFMUstate": [POINTER(c_void_p)], "SetFMUstate": [c_void_p], "FreeFMUstate": [POINTER(c_void_p)],
            "SerializedFMUstateSize": [c_void_p, POINTER(c_size_t)],
            "SerializeFMUstate": [c_void_p, c_char_p, c_size_t],
            "DeSerializeFMUstate": [c_char_p, c_size_t, POINTER(c_void_p)],
        }  # fmt: skip
        for function, arguments in signatures.items():
            raw = getattr(dll, f"fmi2{function}")
            raw.argtypes, raw.restype = [c_void_p, *arguments], c_int
        self.dll, self.functions = dll, functions
        try:
            self.slave.instantiate(callbacks=functions, loggingOn=logging)
            self.component = self.slave.component
        except Exception:
            self.component = None

    def call(self, function, *arguments):
        return getattr(self.dll, f"fmi2{function}")(self.component, *arguments)

    def initialize(self, start, start_time=0.0, stop_time=None):
        """From instantiation to the first step; the first status that is not OK."""
        return (
            (self.set(start) if start else OK)
            or self.call("SetupExperiment", 0, 0.0, start_time, stop_time is not None, stop_time or 0.0)
            or self.call("EnterInitializationMode")
            or self.call("ExitInitializationMode")
        )

    def set(self, values):
        return self.set_references([self.fmu.reference[n] for n in values], list(values.values()))

    def set_references(self, references, values):
        n = len(references)
        return self.call("SetReal", (c_uint * n)(*references), n, (c_double * n)(*values))

    def get(self, names=None):
        return self.get_references([self.fmu.reference[n] for n in names or self.fmu.observed])

    def get_references(self, references):
        n = len(references)
        buffer = (c_double * n)()
        return self.call("GetReal", (c_uint * n)(*references), n, buffer), list(buffer)

    def value(self, name):
        status, (value,) = self.get([name])
        assert status == OK, self.messages
        return value

    def observe(self):
        """All outputs and locals as text that differs with the last bit."""
        status, values = self.get()
        assert status == OK, self.messages
        return [v.hex() for v in values]

    def step(self, time, size):
        return self.call("DoStep", time, size, 1)

    def get_state(self):
        state = c_void_p()
        assert self.call("GetFMUstate", byref(state)) == OK, self.messages
        return state

    def set_state(self, state):
        return self.call("SetFMUstate", state)

    def free_state(self, state):
        assert self.call("FreeFMUstate", byref(state)) == OK

    def serialize(self, state):
        size = c_size_t()
        assert self.call("SerializedFMUstateSize", state, byref(size)) == OK
        buffer = create_string_buffer(size.value)
        assert self.call("SerializeFMUstate", state, buffer, size.value) == OK
        return buffer.raw

    def deserialize(self, text):
        state = c_void_p()
        assert self.call("DeSerializeFMUstate", text, len(text), byref(state)) == OK
        return state

    def set_state_of(self, text):
        """The first status that is not OK: the native flavour sees already by its size what is no state."""
        state = c_void_p()
        return self.call("DeSerializeFMUstate", text, len(text), byref(state)) or self.set_state(state)

    def free(self):
        if self.component:
            self.slave.freeInstance()
            self.component = None


def resident():
    """Resident memory of this process, bytes."""
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * 4096


assert "towage" not in sys.modules

CASES = json.loads(Path(__file__).with_name("cases.json").read_text())


def random_inputs(fmu, rng):
    """A random cubic for every input, as `cases.Case.cubics`."""
    return {
        f"{name}{suffix}": (0.0 if suffix else centre) + size * rng.uniform(-1.0, 1.0)
        for name, (centre, size) in fmu.cases.items()
        for suffix in ("", "_d1", "_d2", "_d3")
    }


def wrong(fmu):
    """A value that no unit takes once it is stepping: no number for an input, or any for a fixed parameter."""
    return {fmu.inputs[0]: float("nan")} if fmu.inputs else {next(iter(fmu.start)): 1.0}


def only(*units, flavour=None):
    """Marks a check that is about some units (none named: all) or about one flavour."""

    def mark(check):
        check.flavour = flavour
        if units:
            check.units = units
        return check

    return mark


def run_checks(names):
    """Run ``check_*(fmu)`` of a program for every FMU; a line of JSON each, so that a crash does not take those before
    with it. Arguments: directory of FMUs, directory to unpack to, units."""
    import traceback

    directory, work, *units = sys.argv[1:]
    for name, check in names.items():
        for unit in units if name.startswith("check_") else ():
            fmu = Fmu(f"{directory}/{unit}.fmu", work)
            flavour = "native" if fmu.native else "python"
            if unit in getattr(check, "units", units) and (getattr(check, "flavour", None) or flavour) == flavour:
                try:
                    check(fmu)
                    failure = None
                except Exception:
                    failure = traceback.format_exc()
                print(json.dumps([name, unit, failure]), flush=True)
