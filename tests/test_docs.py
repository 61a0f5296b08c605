"""Pages that are made from the declarations are up to date, and what the README names exists."""

from __future__ import annotations

import re
import runpy
from pathlib import Path

from towage.fmus import UNITS
from towage.fmus.unit import load
from towage.scene import available_scenes

ROOT = Path(__file__).parents[1]


def test_page_of_the_units_is_current() -> None:
    page = runpy.run_path(str(ROOT / "docs" / "make_units.py"))["page"]
    assert (ROOT / "docs" / "units.md").read_text(encoding="utf-8") == page([load(name) for name in UNITS])


def test_links_lead_somewhere() -> None:
    for file in (ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").glob("*.md"))):
        for link in re.findall(r"\]\(([^)#]+)", file.read_text(encoding="utf-8")):
            assert link.startswith("https:") or (file.parent / link).exists(), f"{file.name}: {link}"


def test_every_scene_and_unit_has_its_words() -> None:
    scenes = (ROOT / "docs" / "scenes.md").read_text(encoding="utf-8")
    assert [s.name for s in available_scenes() if f"`{s.name}`" not in scenes] == []


def test_no_machine_paths() -> None:
    for folder in ("models", "fmus", "towage", "docs", "benchmarks", "examples"):
        for file in (ROOT / folder).rglob("*"):
            if file.suffix in (".py", ".md", ".toml", ".json") and "__pycache__" not in file.parts:
                assert not re.search(r"/(home|root|work|tmp)/", file.read_text(encoding="utf-8")), file
