"""Build the FMUs: ``python build_fmus.py [UNIT ...] [--out dist]``. What has not changed is left alone."""

import argparse
import sys
import time
from pathlib import Path

from towage.fmus import UNITS
from towage.fmus.python_fmu import build


def main() -> int:
    """Returns the exit code."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("units", nargs="*", metavar="UNIT", help=f"{', '.join(UNITS)} (default: all)")
    parser.add_argument("--out", type=Path, default=Path("dist"), help="directory (default: dist)")
    arguments = parser.parse_args()
    unknown = sorted(set(arguments.units) - set(UNITS))
    if unknown:
        parser.error(f"unknown unit {', '.join(unknown)}; there are {', '.join(UNITS)}")
    units = arguments.units or UNITS
    for number, name in enumerate(units, 1):
        begin = time.perf_counter()
        path, written = build(name, arguments.out)
        state = f"built in {time.perf_counter() - begin:.1f} s" if written else "up to date"
        print(f"[{number}/{len(units)}] {path} {state}", file=sys.stderr)
    return 0


if __name__ == "__main__":
    sys.exit(main())
