"""``towage report``: several runs side by side."""

from __future__ import annotations

import argparse
from pathlib import Path

HELP = "compare several runs in one report"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options of ``towage report``."""
    parser.add_argument("runs", metavar="RUN", nargs="+", help="an npz file of towage run, or the directory of its files")
    parser.add_argument(
        "--out", metavar="FILE", type=Path, default=Path("comparison.html"), help="the report (default: comparison.html)"
    )
    parser.epilog = (
        "Differences are those against the first run.\n\n"
        "example:\n  towage report out/sea_cliff/8_s_wave.npz out/sea_cliff/10_s_wave.npz --out waves.html"
    )


def execute(arguments: argparse.Namespace) -> int:
    """0."""
    from towage.report.compare import runs_of, write_comparison

    runs = runs_of(arguments.runs)
    for name, result in runs:
        print(f"{name}: {'failed' if result.status == 'failed' else result.verdict.word}")
    print(f"written to {write_comparison(runs, arguments.out)}")
    return 0
