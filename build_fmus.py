"""Build the FMUs: ``python build_fmus.py [UNIT ...] [--flavour python|native] [--out dist]``, or a whole scene as one native
FMU: ``python build_fmus.py --scene SCENE [--case CASE]``. What has not changed is left alone."""

import argparse
import sys
import time
from collections.abc import Callable
from pathlib import Path

from towage.errors import SceneError
from towage.fmus import UNITS
from towage.fmus.declare.unit import BuildError, load
from towage.scene.compose import scene_unit

Build = Callable[[str], tuple[Path, bool]]


def arguments_of_the_command() -> argparse.Namespace:
    """Checked as far as they can be on their own."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("units", nargs="*", metavar="UNIT", help=f"{', '.join(UNITS)} (default: all)")
    parser.add_argument("--out", type=Path, help="directory (default: dist, native: dist/native, FMI 3: dist/native/fmi3)")
    parser.add_argument("--scene", help="a whole scene, shipped or of a file, as one native FMU named like it")
    parser.add_argument("--case", help="the case of the scene whose values the parameters start with")
    parser.add_argument("--flavour", choices=("python", "native"), default="python", help="default: python")
    native = parser.add_argument_group("native flavour")
    native.add_argument("--fmi", type=int, choices=(2, 3), default=2, help="version of FMI (default: 2)")
    native.add_argument("--platforms", default="host", help="host, all, or names like x86_64-windows with commas")
    native.add_argument(
        "--structure", action="append", default=[], metavar="UNIT.PARAMETER=VALUE",
        help="a structural parameter, which the build fixes; may be given more than once",
    )  # fmt: skip
    arguments = parser.parse_args()
    unknown = sorted(set(arguments.units) - set(UNITS))
    if unknown:
        parser.error(f"unknown unit {', '.join(unknown)}; there are {', '.join(UNITS)}")
    if arguments.case and not arguments.scene:
        parser.error("--case is for --scene")
    if arguments.scene:
        if arguments.units or arguments.structure:
            parser.error("--scene builds one FMU, from the units and sizes that the scene names")
        arguments.flavour, arguments.units = "native", [arguments.scene]
    if arguments.flavour == "python" and (arguments.fmi != 2 or arguments.platforms != "host" or arguments.structure):
        parser.error("--fmi, --platforms and --structure are for --flavour native")
    try:
        arguments.structure = structures(arguments.structure)
    except ValueError as error:
        parser.error(str(error))
    return arguments


def structures(given: list[str]) -> dict[str, dict[str, float]]:
    """Structural parameters by unit. Raises ``ValueError``."""
    found: dict[str, dict[str, float]] = {}
    for text in given:
        path, equals, value = text.partition("=")
        unit, dot, parameter = path.partition(".")
        if not (equals and dot and unit in UNITS):
            raise ValueError(f"--structure {text}: expected unit.parameter=value, as in tow_cable.segments=20")
        try:
            found.setdefault(unit, {})[parameter] = float(value)
        except ValueError:
            raise ValueError(f"--structure {text}: {value!r} is not a number") from None
    return found


def builder(arguments: argparse.Namespace) -> Build:
    """What builds one unit. Raises ``SystemExit`` where CasADi is missing."""
    if arguments.flavour == "python":
        from towage.fmus.python import build as python_fmu

        out = arguments.out or Path("dist")
        return lambda name: python_fmu.build(name, out)
    try:
        from towage.fmus.native import build as native_fmu
    except ModuleNotFoundError as error:
        if error.name != "casadi":
            raise
        raise SystemExit("native FMUs are traced with CasADi, which is missing: pip install 'towage[native]'") from None
    out = arguments.out or (Path("dist/native") if arguments.fmi == 2 else Path("dist/native/fmi3"))
    if arguments.scene:
        return lambda name: native_fmu.build_unit(
            scene_unit(name, arguments.case), out, arguments.fmi, arguments.platforms
        )
    return lambda name: native_fmu.build(name, out, arguments.fmi, arguments.platforms, arguments.structure.get(name))


def main() -> int:
    """Returns the exit code."""
    arguments = arguments_of_the_command()
    units = arguments.units or UNITS
    if arguments.flavour == "native" and not arguments.units:
        units = tuple(name for name in UNITS if not load(name).not_native)
    build = builder(arguments)
    for number, name in enumerate(units, 1):
        begin = time.perf_counter()
        try:
            path, written = build(name)
        except (BuildError, SceneError) as error:
            print(f"[{number}/{len(units)}] {error}", file=sys.stderr)
            return 1
        state = f"built in {time.perf_counter() - begin:.1f} s" if written else "up to date"
        print(f"[{number}/{len(units)}] {path} {state}", file=sys.stderr)
    return 0


if __name__ == "__main__":
    sys.exit(main())
