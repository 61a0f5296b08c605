"""Native FMUs and the C programs that time them: the host of the tests, and the small ones of this directory."""

from __future__ import annotations

import subprocess
from collections.abc import Mapping
from pathlib import Path

from towage.fmus.native import build as native_fmu
from towage.fmus.native import compiler
from towage.units.archive import extract, read_description

ROOT = Path(__file__).resolve().parent.parent
FLAGS = ("-std=c99", "-O2", "-ffp-contract=off", "-fno-math-errno")
"""Those of the units."""


class Native:
    """The native FMU of a unit, built and unpacked below ``folder``."""

    def __init__(self, name: str, folder: Path, structure: Mapping[str, float] | None = None) -> None:
        label = "_".join([name, *(f"{v:g}" for v in (structure or {}).values())])
        self.path = native_fmu.build(name, folder / label, structure=structure)[0]
        self.directory = folder / label / name
        extract(self.path, self.directory)
        self.description = read_description(self.path)
        self.index = {v.name: v.value_reference for v in self.description.variables}
        host = compiler.host()
        self.library = self.directory / "binaries" / host.fmi2 / f"{name}{host.suffix}"
        self.sources = self.directory / "sources"

    def script(
        self,
        start: Mapping[str, float],
        sines: Mapping[str, tuple[float, float]],
        wanted: list[str],
        step: float,
        count: int,
    ) -> str:
        """What the host is to do: start values, inputs as amplitude and angular frequency of a sine, variables to read."""
        lines = [f"start {self.index[n]} {v!r}" for n, v in start.items()]
        lines += [f"sine {self.index[n]} {a!r} {w!r} {self.index[f'{n}_d1']}" for n, (a, w) in sines.items()]
        return "\n".join([*lines, " ".join(["get", *(str(self.index[n]) for n in wanted)]), f"step {step!r} {count}\n"])

    def hosted(self, program: Path, script: str, *command: str) -> str:
        """What the C host prints."""
        return output([program, self.library, "2", self.description.guid, *command], script)


def output(command: list[str | Path], text: str = "") -> str:
    """What a program prints that is given ``text``."""
    return subprocess.run(command, input=text, capture_output=True, text=True, check=True).stdout


def compiled(folder: Path, name: str, sources: list[Path], *include: Path) -> Path:
    """A C program."""
    program = folder / name
    places = [f"-I{place}" for place in include]
    command = [*compiler.compiler(compiler.host()), *FLAGS, *places, "-o", program, *sources, "-ldl", "-lm"]
    subprocess.run(command, check=True)
    return program


def c_host(folder: Path) -> Path:
    """The host of the tests."""
    sources = [ROOT / f"tests/fmus/host/{name}.c" for name in ("host", "fmu")]
    return compiled(folder, "host", sources, native_fmu.RUNTIME / "fmi2", native_fmu.RUNTIME / "fmi3")
