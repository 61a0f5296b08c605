"""``towage export``: a scene for another co-simulation host."""

from __future__ import annotations

import argparse
from pathlib import Path

from towage.commands import common
from towage.terminal import tell

HELP = "write a scene as a system of OSP or SSP, for another host"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options of ``towage export``."""
    common.add_one_scene(parser)
    parser.add_argument(
        "--flavour",
        choices=("auto", "python", "native"),
        default="auto",
        help="which FMUs of the shipped units, as in towage run (default: auto)",
    )
    target = parser.add_mutually_exclusive_group(required=True)
    target.add_argument("--osp", metavar="DIR", type=Path, help="a directory for libcosim, Kopl and cosim")
    target.add_argument("--ssp", metavar="FILE", type=Path, help="an SSP 1.0 archive, for OMSimulator and others")
    parser.epilog = (
        "The host holds inputs over the scene's step, as scheme jacobi does; docs/hosts.md tells what was tried.\n\n"
        "example:\n  towage export sea_cliff --case '8 s wave' --osp out/sea_cliff_osp --flavour native"
    )


def execute(arguments: argparse.Namespace) -> int:
    """0."""
    from towage.export.export import prepare
    from towage.scene.flavour import resolve

    one = common.one_scene(arguments)
    export = prepare(resolve(one, arguments.fmus, arguments.flavour, tell))
    if arguments.osp:
        from towage.export.osp import write_osp

        names = ", ".join(path.name for path in write_osp(export, arguments.osp))
        print(f"written to {arguments.osp}: {names}")
    else:
        from towage.export.ssp import write_ssp

        write_ssp(export, arguments.ssp)
        print(f"written to {arguments.ssp}")
    if one.coupling.scheme != "jacobi":
        print(
            f"The host couples at {export.step:g} s with held inputs, which is less accurate than scheme "
            f"{one.coupling.scheme}; compare with: towage run {arguments.scene} --set coupling.scheme=jacobi"
        )
    return 0
