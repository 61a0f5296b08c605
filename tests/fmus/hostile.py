"""Programs that call a native unit at random (``host/fuzz.c``), for the tests and for `tests.faults.calls`."""

from __future__ import annotations

import hashlib
import subprocess
from dataclasses import replace
from pathlib import Path

from towage.fmus.declare.unit import Unit, load
from towage.fmus.native.trace import trace

from . import linear_example
from .cases import NATIVE
from .native_host import HOST, compile_c, write_sources

SANITIZERS = ("-g", "-O1", "-fsanitize=address,undefined", "-fno-sanitize-recover=undefined")
FAST = ("-O2",)
LINEAR: dict[str, tuple[str, dict[str, float]]] = {
    "tow_system": ("tow_system", {"segments": 4.0, "extensible": 0.0}),
    "tow_system elastic": ("tow_system", {"segments": 4.0, "extensible": 1.0}),
    "tow_system, two states": ("tow_system", {"segments": 1.0, "extensible": 0.0}),
    "tow_cable": ("tow_cable", {"segments": 5.0}),
    "tow_cable, one node": ("tow_cable", {"segments": 2.0}),
    "slender_body": ("slender_body", {"flexible": 1.0, "shape_functions": 4.0}),
    "slender_body rigid": ("slender_body", {"flexible": 0.0}),
}
"""Unit and structure: few states, so that many runs begin in the time."""
EXAMPLE = "linear_example"
LARGE = ("ship_in_sea", "playback")
SMALL = tuple(name for name in NATIVE if name not in (*LINEAR, *LARGE))
ALL = (*SMALL, EXAMPLE, *LINEAR, *LARGE)


def usable(unit: Unit) -> Unit:
    """The unit with start values with which a run can begin: no start value, no step."""
    starts = {**unit.start, "axial_stiffness": 4e6}
    parameters, inputs = (
        tuple(replace(v, start=starts.get(v.name, v.start)) for v in group) for group in (unit.parameters, unit.inputs)
    )
    return replace(unit, parameters=parameters, inputs=inputs)


def program(name: str, directory: Path, *flags: str) -> tuple[Path, str]:
    """The program for a unit of `ALL`, made in ``directory`` if it is not there already, and the digest of its sources."""
    base, structure = LINEAR.get(name, (name, {}))
    traced = trace(linear_example.UNIT if name == EXAMPLE else usable(load(base)), structure)
    sources = [*sorted(HOST.glob("fuzz*.[ch]")), *write_sources(traced, directory / name)]
    flags = ("-std=c99", *flags, f"-I{directory / name}")
    made_from = b"\0".join(path.read_bytes() for path in [*sources, *sorted((directory / name).glob("*.h"))])
    digest = hashlib.sha256(made_from + repr(flags).encode()).hexdigest()[:16]
    made = directory / f"fuzz_{name}.{digest}"
    if not made.exists():
        compile_c([path for path in sources if path.suffix == ".c"], made, *flags)
    return made, digest


def has_sanitizers(directory: Path) -> bool:
    """Whether the C compiler has those that are wanted, and they work here."""
    try:
        (directory / "empty.c").write_text("int main(void) { return 0; }\n")
        compile_c([directory / "empty.c"], directory / "empty", *SANITIZERS)
        subprocess.run([directory / "empty"], check=True, timeout=60)
    except (AssertionError, subprocess.CalledProcessError):
        return False
    return True
