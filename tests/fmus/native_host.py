"""The C programs of ``host/`` and what they run: scripts of native FMUs, fuzzers of their sources."""

from __future__ import annotations

import subprocess
import zipfile
from dataclasses import dataclass
from pathlib import Path

import fmpy

from towage.fmus.declare.unit import load
from towage.fmus.native import build as native_fmu
from towage.fmus.native.build import RUNTIME, runtime_sources
from towage.fmus.native.compiler import compiler, host
from towage.fmus.native.traced import Traced

HOST = Path(__file__).parent / "host"
STANDARD = (f"-I{RUNTIME / 'fmi2'}", f"-I{RUNTIME / 'fmi3'}")
"""Where the headers of the standard are."""
STRICT = ("-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror", *STANDARD)
STARTS: dict[str, dict[str, float]] = {
    "ship": {"mass": 8e5, "damping": 1e5, "stiffness": 2e6, "ramp_time": 4.0},
    "spring_line": {"stiffness": 1e4, "static_tension": 2e4, "breaking_load": 2e5},
    "cradle": {"mass": 5e3, "drag_area": 10.0, "weight_in_water": 2e4, "docking_time": 3.0, "submersible_mass": 8e3},
    "cradle_on_line": {
        "stiffness": 1e4, "mass": 5e3, "drag_area": 10.0, "weight_in_water": 2e4, "docking_time": 3.0,
        "submersible_mass": 8e3,
    },
}  # fmt: skip
SINES: dict[str, tuple[str, float, float]] = {
    "ship": ("reaction", 5e4, 0.7), "spring_line": ("heave_top", 4.0, 0.9), "cradle": ("line_tension", 3e4, 0.9),
    "cradle_on_line": ("heave_top", 3.0, 0.9),
}  # fmt: skip
"""Input, amplitude and angular frequency of a run; large enough to make the line slack at times."""


def compile_c(sources: list[Path], output: Path, *flags: str) -> Path:
    """The program of ``sources``."""
    command = [*compiler(host()), *flags, *map(str, sources), "-o", str(output), "-lm", "-ldl"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    return output


def compile_host(directory: Path) -> Path:
    """``host.c``."""
    return compile_c([HOST / "host.c", HOST / "fmu.c"], directory / "host", *STRICT, "-O1")


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
    """Unpacked where a host would, with the unit's run of ``STARTS`` and ``SINES``."""
    with zipfile.ZipFile(fmu) as archive:
        (member,) = (n for n in archive.namelist() if n.startswith("binaries/"))
        library = Path(archive.extract(member, directory))
    description = fmpy.read_model_description(str(fmu))
    token = description.guid if fmi == 2 else description.instantiationToken
    name = description.modelName
    reference = load(name).index
    entry, amplitude, frequency = SINES[name]
    lines = [f"start {reference[n]} {value!r}" for n, value in STARTS[name].items()]
    lines += [f"sine {reference[entry]} {amplitude!r} {frequency!r} {reference[f'{entry}_d1']}"]
    lines += ["get " + " ".join(str(reference[v.name]) for v in load(name).observed), f"step {step!r} {steps}"]
    return Unpacked(library, fmi, token, "\n".join(lines) + "\n")


def write_sources(traced: Traced, directory: Path) -> list[Path]:
    """All C files of a unit with both versions of FMI; headers are written beside them."""
    members = native_fmu.contents(traced, 2, "")
    sources = runtime_sources(2) | runtime_sources(3)
    sources |= {name: members[f"sources/{name}"] for name in ("model.c", "unit.c")}
    directory.mkdir(parents=True, exist_ok=True)
    for name, text in sources.items():
        (directory / name).write_bytes(text)
    return [directory / name for name in sources if name.endswith(".c")]
