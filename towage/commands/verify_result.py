"""``towage verify-result``: whether a result is what it says, and comes out again."""

from __future__ import annotations

import argparse
from pathlib import Path

HELP = "check a result against its checksum and its inputs, and compute it again"
DIFFERS = 1


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options of ``towage verify-result``."""
    from towage.commands import common

    parser.add_argument("file", metavar="FILE", type=Path, help="an npz file of towage run")
    parser.add_argument("--again", action="store_true", help="run the scene in the file again and compare every number")
    common.add_fmus(parser)
    parser.epilog = (
        "Every npz file has a checksum of all its numbers, and tells its scene, the SHA-256 of its FMUs, versions and machine.\n"
        "Returns 1 if an input is not here as it was, or a number comes out otherwise.\n\n"
        "example:\n  towage verify-result out/sea_cliff/8_s_wave.npz --again"
    )


def execute(arguments: argparse.Namespace) -> int:
    """0, or 1 where something differs. Raises `FileError` for a file that is damaged or no result."""
    from towage.process.verified import compared, inputs
    from towage.result.result import Result

    result = Result.load_npz(arguments.file)
    print(f"{arguments.file}: {len(result.columns)} columns of {len(result.time)} rows; the checksum fits")
    resolved, differ = inputs(result, arguments.fmus)
    for line in differ:
        print(f"  differs  {line}")
    if not differ:
        print(f"  the scene, {len(resolved.units)} FMUs, versions and machine are here as they were")
    if arguments.again:
        changed = compared(result, resolved)
        for line in changed:
            print(f"  differs  {line}")
        differ += changed
        if not changed:
            print("  computed again: every number is the same to the last bit")
    return DIFFERS if differ else 0
