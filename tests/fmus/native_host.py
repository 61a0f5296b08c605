"""The C programs of ``host/`` and what they run: scripts of native FMUs, fuzzers of their sources."""

from __future__ import annotations

import subprocess
import zipfile
from dataclasses import dataclass
from pathlib import Path

import fmpy
import numpy as np

from towage.fmus.declare.unit import load
from towage.fmus.native import build as native_fmu
from towage.fmus.native.build import RUNTIME, runtime_sources
from towage.fmus.native.compiler import compiler, host
from towage.fmus.native.traced import Traced

from .cases import CASES

HOST = Path(__file__).parent / "host"
STANDARD = (f"-I{RUNTIME / 'fmi2'}", f"-I{RUNTIME / 'fmi3'}")
"""Where the headers of the standard are."""
STRICT = ("-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror", *STANDARD)
ESTIMATED = ("margin_resolution", "margin_inextensible")
"""Margins of the errors of linear units that one flavour measures and the other estimates."""
Sines = dict[str, tuple[float, float]]


def run_of(fmu: Path) -> tuple[dict[str, float], Sines]:
    """Start values of a run of a native FMU, and an input as the amplitude and angular frequency of a sine. What the build
    fixed has its value; a model that could be reduced is not, as the flavours choose differently what to leave out."""
    description = fmpy.read_model_description(str(fmu))
    case = CASES[description.modelName]
    variables = {v.name: v for v in description.modelVariables}
    fixed = {name: float(v.start) for name, v in variables.items() if v.min is not None and v.min == v.max}
    start = {name: fixed.get(name, value) for name, value in case.start.items()}
    driven = [*load(description.modelName).reference_inputs][:1]
    return start | dict.fromkeys({"reduced"} & variables.keys(), 0.0), {name: (case.inputs[name][1], 0.9) for name in driven}


def compile_c(sources: list[Path], output: Path, *flags: str) -> Path:
    """The program of ``sources``."""
    command = [*compiler(host()), *flags, *map(str, sources), "-o", str(output), "-lm", "-ldl"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    return output


def compile_host(directory: Path) -> Path:
    """``host.c``."""
    return compile_c([HOST / "host.c", HOST / "fmu.c"], directory / "host", *STRICT, "-O1")


def rows_of(printed: str) -> np.ndarray:
    """What the command ``run`` printed."""
    return np.array([[float.fromhex(v) for v in line.split()] for line in printed.splitlines()])


@dataclass(frozen=True)
class Unpacked:
    """The library of a native FMU, its description and the script of a run."""

    library: Path
    fmi: int
    token: str
    script: str

    def command(self, program: Path, *words: object) -> list[str]:
        return [str(program), str(self.library), str(self.fmi), self.token, *map(str, words)]


def unpack(fmu: Path, fmi: int, directory: Path, step: float = 0.1, steps: int = 60) -> Unpacked:
    """Unpacked where a host would, with the run of `run_of`."""
    with zipfile.ZipFile(fmu) as archive:
        (member,) = (n for n in archive.namelist() if n.startswith("binaries/"))
        library = Path(archive.extract(member, directory))
    description = fmpy.read_model_description(str(fmu))
    token = description.guid if fmi == 2 else description.instantiationToken
    name = description.modelName
    reference = load(name).index
    start, sines = run_of(fmu)
    lines = [f"start {reference[n]} {value!r}" for n, value in start.items()]
    lines += [f"sine {reference[n]} {a!r} {w!r} {reference[f'{n}_d1']}" for n, (a, w) in sines.items()]
    lines += ["get " + " ".join(str(reference[v.name]) for v in load(name).observed), f"step {step!r} {steps}"]
    return Unpacked(library, fmi, token, "\n".join(lines) + "\n")


def write_sources(traced: Traced, directory: Path) -> list[Path]:
    """All C files of a unit with both versions of FMI; headers are written beside them."""
    members = native_fmu.contents(traced, 2, "")
    needed = traced.kernels, traced.headers
    sources = runtime_sources(2, *needed) | runtime_sources(3, *needed)
    sources |= {name: members[f"sources/{name}"] for name in ("model.c", "unit.c")}
    directory.mkdir(parents=True, exist_ok=True)
    for name, text in sources.items():
        (directory / name).write_bytes(text)
    return [directory / name for name in sources if name.endswith(".c")]
