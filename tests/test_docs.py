"""Pages that are made from the declarations are up to date, and what the README names exists."""

from __future__ import annotations

import importlib
import json
import re
import runpy
import socket
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from towage.fmus import UNITS
from towage.fmus.declare.unit import load
from towage.scene.scene import available_scenes

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


def test_page_of_a_scene_is_made_from_its_run(tmp_path):
    runpy.run_path(str(ROOT / "docs" / "make_scenes.py"))["write"]("stiff_line", tmp_path)
    page = (tmp_path / "stiff_line.md").read_text(encoding="utf-8")
    assert "towage run stiff_line" in page and "| the scene | **valid** |" in page
    svg = ElementTree.parse(tmp_path / "stiff_line.svg").getroot()
    assert max(len(path.get("d", "")) for path in svg.iter("{http://www.w3.org/2000/svg}path")) > 1000, "a curve"


def test_site_links_scenes_and_names_files_outside(tmp_path, monkeypatch):
    hook = runpy.run_path(str(ROOT / "docs" / "make_links.py"))
    monkeypatch.setitem(hook["linked"].__globals__, "SCENES", tmp_path)
    (tmp_path / "slack.md").touch()
    assert hook["linked"]("| `slack` | x |\n| `other` | x |") == "| [`slack`](scenes/slack.md) | x |\n| `other` | x |"


def test_site_has_every_page():
    nav = (ROOT / "mkdocs.yml").read_text(encoding="utf-8")
    assert [file.name for file in (ROOT / "docs").glob("*.md") if file.name not in nav] == []


def test_benchmarks_page_reads_ratios_and_curves(monkeypatch):
    monkeypatch.syspath_prepend(str(ROOT / "benchmarks"))
    page, read = importlib.import_module("page"), importlib.import_module("page_tables")
    text = (
        "## Cost\n\n| way | error | s |\n|---|---|---|\n| ours, fine | 1e-6 | 0.50 |\n| ours, coarse | 1e-3 | 0.05 |\n"
        "| peer | 1e-4 | 2.0 |\n| libcosim | lost | 3.0 |\n"
    )
    found = read.tables(text)
    now = read.ratios(found, (read.Column("^s$", "more", over="peer"),))
    assert {key: ratio.value for key, ratio in now.items()} == {"Cost / ours, fine / s": 4.0}, "0.05 has one digit"
    assert list(read.curves(found, read.Curves("^s$", "^error$"))) == [
        ("Cost", {"ours": [(0.5, 1e-6), (0.05, 1e-3)], "peer": [(2.0, 1e-4)]})
    ]
    before = {"ratios": {"Cost / ours, fine / s": {"value": 6.1, "better": "more"}}}
    assert list(page.fallen(now, before)) == ["Cost / ours, fine / s"]
    assert f'<span style="color:{page.RED}">**4**</span>' in page.comparison(now, before)
    before["ratios"]["Cost / ours, fine / s"]["value"] = 5.9  # less than 1.5 times worse
    assert page.fallen(now, before) == {}
    assert page.Ratio(2.0, "less").gain(1.0) == 0.5


def test_benchmarks_print_the_columns_that_the_page_reads(monkeypatch):
    monkeypatch.syspath_prepend(str(ROOT / "benchmarks"))
    page = importlib.import_module("page")
    for benchmark in page.BENCHMARKS:
        text = (ROOT / "benchmarks" / f"{benchmark.name}.py").read_text(encoding="utf-8")
        heads = [cell.strip(' "') for line in text.splitlines() if "| " in line for cell in re.split(r"\||\\n", line)]
        for column in benchmark.columns:
            assert any(re.search(column.pattern, head) for head in heads), f"{benchmark.name}: {column.pattern}"
            assert not column.over or column.over in text


@pytest.mark.slow
def test_quick_benchmarks_write_their_page(tmp_path):
    command = [sys.executable, str(ROOT / "benchmarks" / "page.py"), "--quick", "--out", str(tmp_path)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=600)
    assert done.returncode in (0, 1) and "FAILED" not in done.stderr, done.stderr  # 1: slower than the last page
    kept = json.loads((tmp_path / "benchmarks.json").read_text(encoding="utf-8"))
    assert len(kept["ratios"]) > 5 and kept["versions"]["numpy"] == np.__version__
    page = (tmp_path / "benchmarks.md").read_text(encoding="utf-8")
    assert "## Coupling" in page and "over raw FMI calls" in page and socket.gethostname() not in page
