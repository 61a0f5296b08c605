"""Instances of the native runtime without FMI: the sources compiled to a library whose every function can be called."""

from __future__ import annotations

import ctypes
import subprocess
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from towage.fmus.native.build import runtime_sources
from towage.fmus.native.compiler import compiler, host
from towage.fmus.native.source import model_source, unit_source
from towage.fmus.native.traced import Traced
from towage.models.numeric.kernel import Kernel

FLAGS = ("-std=c99", "-O1", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-ffp-contract=off", "-fPIC")
DONE, REFUSED, NO_STEP = range(3)
CO_SIMULATION, MODEL_EXCHANGE = range(2)
Library = tuple[ctypes.CDLL, Traced]
GENERATED = ("-std=c99", "-O0", "-ffp-contract=off", "-fPIC")
"""Thousands of straight lines, which take the compiler longer to improve than a test to run."""
TOLERANT = {"model.c"}
"""Generated files, in which unused variables are no mistake."""


def compile_library(names: Iterable[str], path: Path, kernels: Sequence[Kernel] = (), **more: str) -> ctypes.CDLL:
    """The library of the runtime's files ``names`` and of ``more``, text by name without suffix; all symbols visible."""
    folder = path.parent / f"{path.stem}_sources"
    folder.mkdir()
    texts = runtime_sources(2, kernels) | {f"{name}.c": text.encode() for name, text in more.items()}
    for name, text in texts.items():
        (folder / name).write_bytes(text)
    objects = []
    for name in (*names, *(f"{name}.c" for name in more)):
        objects.append(folder / f"{name}.o")
        flags = GENERATED if name in TOLERANT else FLAGS
        subprocess.run([*compiler(host()), *flags, "-c", str(folder / name), "-o", str(objects[-1])], check=True)
    subprocess.run([*compiler(host()), "-shared", *map(str, objects), "-o", str(path), "-lm"], check=True)
    return ctypes.CDLL(str(path))


def unit_library(traced: Traced, directory: Path) -> ctypes.CDLL:
    """The library of a unit with the runtime, without FMI."""
    look = (
        '#include "instance.h"\nconst char *message(Instance *);\n'
        "const char *message(Instance *it) { return it->message; }\n"
    )
    names = runtime_sources(2, traced.kernels)
    runtime = [name for name in names if name.endswith(".c") and not name.startswith("fmi")]
    library = compile_library(
        runtime, directory / "unit.so", traced.kernels, look=look, model=model_source(traced.functions),
        unit=unit_source(traced, "token"),
    )
    library.instance_new.restype, library.message.restype = ctypes.c_void_p, ctypes.c_char_p
    return library


def doubles(values: Sequence[float] | int) -> Any:
    """An array of values, or of so many zeros."""
    return (ctypes.c_double * values)() if isinstance(values, int) else (ctypes.c_double * len(values))(*values)


Pointer = ctypes.POINTER(ctypes.c_double)
Rates = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_double, Pointer, Pointer)
"""Rates or indicators: context, time, state, where the result goes."""
OnEvent = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_double, Pointer)


class System(ctypes.Structure):
    """``System`` of integrate.h."""

    _fields_ = (
        ("context", ctypes.c_void_p), ("states", ctypes.c_int), ("indicators", ctypes.c_int), ("rates", Rates),
        ("indicate", Rates), ("on_event", OnEvent),
    )  # fmt: skip


class NativeInstance:
    """``Instance`` of instance.h, variables by name."""

    def __init__(self, library: ctypes.CDLL, traced: Traced, kind: int = CO_SIMULATION, **start: float) -> None:
        self.library = library
        self.names = [v.name for v in traced.interface.variables]
        self.states = len(traced.interface.states)
        unit = ctypes.c_void_p(ctypes.addressof(ctypes.c_char.in_dll(library, "towage_unit")))
        self.handle = ctypes.c_void_p(library.instance_new(unit, kind))
        assert self.set(**start) == DONE
        assert library.instance_set_up(self.handle, ctypes.c_double(0.0), False, ctypes.c_double(0.0)) == DONE
        assert library.instance_enter_initialization(self.handle) == DONE
        self.initialized = library.instance_exit_initialization(self.handle)

    def __del__(self) -> None:
        self.library.instance_free(self.handle)

    def references(self, names: Sequence[str]) -> Any:
        return (ctypes.c_uint * len(names))(*map(self.names.index, names))

    def set(self, **values: float) -> int:
        count = ctypes.c_size_t(len(values))
        return int(
            self.library.instance_set(self.handle, self.references(list(values)), count, doubles(list(values.values())))
        )

    def get(self, *names: str) -> list[float]:
        found = doubles(len(names))
        count = ctypes.c_size_t(len(names))
        assert self.library.instance_get(self.handle, self.references(names), count, found) == DONE
        return list(found)

    def step(self, time: float, step: float) -> int:
        return int(self.library.instance_step(self.handle, ctypes.c_double(time), ctypes.c_double(step)))

    @property
    def message(self) -> str:
        text: bytes = self.library.message(self.handle)
        return text.decode()

    def set_states(self, x: Sequence[float]) -> None:
        assert self.library.instance_set_states(self.handle, doubles(x), ctypes.c_size_t(len(x))) == DONE

    def get_states(self) -> list[float]:
        x = doubles(self.states)
        assert self.library.instance_get_states(self.handle, x, ctypes.c_size_t(self.states)) == DONE
        return list(x)

    def derivatives(self) -> list[float]:
        dx = doubles(self.states)
        assert self.library.instance_get_derivatives(self.handle, dx, ctypes.c_size_t(self.states)) == DONE
        return list(dx)

    def directional(self, unknowns: Sequence[str], knowns: Sequence[str], seed: Sequence[float]) -> list[float]:
        found = doubles(len(unknowns))
        counts = ctypes.c_size_t(len(unknowns)), ctypes.c_size_t(len(knowns))
        assert self.library.instance_directional_derivative(
            self.handle, self.references(unknowns), counts[0], self.references(knowns), counts[1], doubles(seed), found
        ) == DONE  # fmt: skip
        return list(found)
