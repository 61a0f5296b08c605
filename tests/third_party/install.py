"""Installs the package of this folder, or a faulty one, as pip does: modules, and a ``.dist-info`` with entry points."""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from pathlib import Path

BUOYS = {
    "towage.units": "buoy = towage_buoys.unit:BUOY",
    "towage.schemes": "newest = towage_buoys.scheme:NEWEST",
    "towage.checks": "sinkage = towage_buoys.check:SINKAGE",
    "towage.writers": "count = towage_buoys.writer:COUNT",
}


def install(site: Path, name: str, points: Mapping[str, str], sources: Path | None = None) -> None:
    """Into the folder ``site``: the package ``name`` with entry points by group, its modules copied from ``sources``."""
    if sources:
        shutil.copytree(sources, site / sources.name, ignore=shutil.ignore_patterns("__pycache__"))
    information = site / f"{name.replace('-', '_')}-1.0.dist-info"
    information.mkdir(parents=True)
    (information / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n")
    (information / "entry_points.txt").write_text(
        "".join(f"[{group}]\n{lines}\n" for group, lines in points.items())
    )


def install_buoys(site: Path) -> None:
    """The sound package."""
    install(site, "towage-buoys", BUOYS, Path(__file__).with_name("towage_buoys"))
