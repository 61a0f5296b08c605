"""Native FMUs of other platforms, run under an emulator and compared with those of this one. ``python -m tests.fmus.platforms
[UNIT ...]`` prints a table: the largest difference of an output over its largest value in 60 steps of 0.1 s. Linear units are
small ones (`SMALL`)."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
import zipfile
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np

from towage.fmus.native.build import RUNTIME, build
from towage.fmus.native.compiler import Platform, chosen, compiled, compiler, library, output_of

from .cases import NATIVE
from .native_host import HOST, compile_host, rows_of, unpack

EMULATED = ("x86_64-windows", "aarch64-linux")
ARM = Path("/usr/aarch64-linux-gnu")
"""Where Debian's libc6-arm64-cross puts the C library."""


def emulator(platform: str) -> list[str]:
    """The command that runs a program of ``platform``. Raises ``LookupError``, which says what is missing."""
    if platform == "x86_64-windows":
        wine = shutil.which("wine64") or shutil.which("wine") or shutil.which("/usr/lib/wine/wine64")
        if wine is None:
            raise LookupError("wine is not installed (Debian: wine64)")
        return [wine]
    qemu = shutil.which("qemu-aarch64") or shutil.which("qemu-aarch64-static")
    if qemu is None:
        raise LookupError("qemu-aarch64 is not installed (Debian: qemu-user)")
    if not ARM.is_dir():
        raise LookupError("there is no C library for it (Debian: libc6-arm64-cross)")
    return [qemu, "-L", str(ARM)]


SMALL: dict[str, dict[str, float]] = {
    "tow_system": {"segments": 6.0}, "tow_cable": {"segments": 6.0}, "slender_body": {"shape_functions": 4.0},
}  # fmt: skip
"""Structure of linear units: with the usual one a compiler works for minutes on the matrices of each platform."""


class Emulation:
    """Programs and libraries of a platform, in a directory of their own. Raises ``LookupError``."""

    def __init__(self, platform: str, directory: Path) -> None:
        self.emulator = emulator(platform)
        (self.platform,) = chosen(platform)
        self.directory = directory
        self.environment = {**os.environ, "WINEPREFIX": str(directory / "wine"), "WINEDEBUG": "-all", "DISPLAY": ""}
        self.program = cross_compiled(self.platform, directory)

    def rows(self, fmu: Path, fmi: int, word: str = "run") -> np.ndarray:
        """What the C host reads of the unit there."""
        run = unpack(fmu, fmi, self.directory / f"{fmu.stem}{fmi}")
        with zipfile.ZipFile(fmu) as archive:
            members = [n for n in archive.namelist() if n.startswith("sources/") and n.endswith((".c", ".h"))]
            sources = {Path(n).name: archive.read(n) for n in members}
        path = run.library.with_suffix(self.platform.suffix)
        path.write_bytes(library(sources, fmu.stem, self.platform))
        command = [*self.emulator, *replace(run, library=path).command(self.program, word)]
        done = subprocess.run(
            command, input=run.script, capture_output=True, text=True, timeout=600, env=self.environment, cwd=self.directory
        )
        assert done.returncode == 0, done.stderr[-3000:]
        return rows_of(done.stdout)


def cross_compiled(platform: Platform, directory: Path) -> Path:
    """``host.c`` for the platform, compiled and linked as units are: for other flags zig would make the C library once more."""
    headers = [HOST / "fmu.h", *RUNTIME.glob("fmi[23]/fmi[23]*.h")]
    texts = tuple((file.name, file.read_bytes()) for file in headers)
    objects = {f"{n}.o": compiled(platform, f"{n}.c", (HOST / f"{n}.c").read_bytes(), texts) for n in ("host", "fmu")}
    output = directory / ("host.exe" if platform.suffix == ".dll" else "host")
    libraries = [] if platform.suffix == ".dll" else ["-lm", "-ldl"]
    output.write_bytes(output_of([*compiler(platform), "-s", "-o", output.name, *objects, *libraries], objects, output.name))
    output.chmod(0o755)
    return output


def here(fmu: Path, fmi: int, directory: Path) -> np.ndarray:
    """The same on this platform."""
    run = unpack(fmu, fmi, directory / f"{fmu.stem}{fmi}")
    command = run.command(_host(), "run")
    return rows_of(subprocess.run(command, input=run.script, capture_output=True, text=True, check=True).stdout)


@cache
def _host() -> Path:
    return compile_host(Path(tempfile.mkdtemp()))


def difference(one: np.ndarray, other: np.ndarray) -> float:
    """The largest of the columns: maximum of the difference over the maximum of ``one``."""
    assert one.shape == other.shape
    return float(np.max(np.max(np.abs(one - other), axis=0) / np.maximum(np.max(np.abs(one), axis=0), 1e-300)))


def table(units: tuple[str, ...]) -> None:
    """Prints the rows as they come."""
    with tempfile.TemporaryDirectory() as name:
        directory = Path(name)
        emulations = {}
        for platform in EMULATED:
            (directory / platform).mkdir()
            emulations[platform] = Emulation(platform, directory / platform)
        print("| unit | FMI |", " | ".join(EMULATED), "|", flush=True)
        for unit in units:
            for fmi in (2, 3):
                fmu = build(unit, directory / f"fmi{fmi}", fmi, structure=SMALL.get(unit))[0]
                own = here(fmu, fmi, directory / "here")
                found = [difference(own, emulation.rows(fmu, fmi)) for emulation in emulations.values()]
                print(f"| {unit} | {fmi} |", " | ".join(f"{value:.1e}" for value in found), "|", flush=True)


if __name__ == "__main__":
    table(tuple(sys.argv[1:]) or NATIVE)
