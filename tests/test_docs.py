"""The programs that make pages run, and what the README and the pages name exists."""

from __future__ import annotations

import ast
import importlib
import importlib.util
import json
import os
import re
import runpy
import socket
import subprocess
import sys
from fnmatch import fnmatch
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

import towage
from towage.fmus import UNITS
from towage.fmus.declare.unit import load
from towage.scene.scene import available_scenes

ROOT = Path(__file__).parents[1]


MADE = tuple(
    line for line in (ROOT / ".gitignore").read_text(encoding="utf-8").splitlines() if line.startswith("docs/")
)
"""What `make docs` writes: not committed."""


def test_page_of_the_units_names_every_variable() -> None:
    units = [load(name) for name in UNITS]
    page = runpy.run_path(str(ROOT / "docs" / "make_units.py"))["page"](units)
    for unit in units:
        section = page.partition(f"\n## {unit.name}\n")[2].partition("\n## ")[0]
        for variable in (*unit.parameters, *unit.inputs, *unit.observed):
            assert f"| `{variable.name}` | {variable.unit} |" in section, f"{unit.name}: {variable.name}"


def test_pages_of_the_api_hold_every_public_name_and_module(tmp_path: Path) -> None:
    make = runpy.run_path(str(ROOT / "docs" / "make_api.py"))
    (tmp_path / "gone.md").touch()
    make["write"](tmp_path)
    pages = {path.relative_to(tmp_path).as_posix(): path.read_text(encoding="utf-8") for path in tmp_path.rglob("*.md")}
    assert "gone.md" not in pages
    for name in towage.__all__:
        assert name.startswith("_") or f"\n::: towage.{name}\n" in pages["index.md"]
    named = set(re.findall(r"^::: (\S+)$", "\n".join(pages.values()), re.MULTILINE))
    for module in ("towage.models.heave.cradle", "towage.fmus.declare.unit", "towage.master.master"):
        assert module in named
        assert importlib.util.find_spec(module)


def test_what_is_made_is_not_committed() -> None:
    if not (ROOT / ".git").exists():
        pytest.skip("no repository")
    kept = subprocess.run(["git", "-C", str(ROOT), "ls-files", *MADE], capture_output=True, text=True, check=True)
    assert kept.stdout == ""


def test_picture_of_the_readme_is_of_its_scene(tmp_path: Path) -> None:
    make = runpy.run_path(str(ROOT / "docs" / "make_scenes.py"))
    path, name, case = make["README"]
    assert f"(docs/{path.name})" in (ROOT / "README.md").read_text(encoding="utf-8")
    make["draw_readme"](tmp_path / "picture.svg")
    curves = [
        [element.get("d", "") for element in ElementTree.parse(file).iter("{http://www.w3.org/2000/svg}path")]
        for file in (path, tmp_path / "picture.svg")
    ]
    assert len(curves[0]) == len(curves[1]), f"python docs/make_scenes.py --readme ({name}, {case})"
    assert max(map(len, curves[1])) > 1000, "a curve"


def test_links_lead_somewhere() -> None:
    for file in (ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").glob("*.md"))):
        if made(file):
            continue
        for link in re.findall(r"\]\(([^)#]+)", file.read_text(encoding="utf-8")):
            target = file.parent / link
            assert link.startswith("https:") or target.exists() or made(target), f"{file.name}: {link}"


@pytest.mark.parametrize("file", ["README.md", "docs/ensemble.md", "docs/sweeps.md", "docs/how_to_add.md"])
def test_what_code_in_the_pages_names_exists(file: str) -> None:
    blocks = re.findall(r"^```python.*?\n(.*?)^```$", (ROOT / file).read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)
    assert blocks
    for node in (node for block in blocks for node in ast.walk(ast.parse(block))):
        if isinstance(node, ast.ImportFrom) and node.module and node.module.startswith("towage."):
            module = importlib.import_module(node.module)
            assert [alias.name for alias in node.names if not hasattr(module, alias.name)] == [], node.module
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "towage":
            assert node.attr in towage.__all__


def test_files_that_the_pages_name_exist() -> None:
    named = re.compile(r"`((?:models|fmus|towage|tests|benchmarks|docs)/[\w./]+)`")
    for file in (ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").glob("*.md"))):
        for path in () if made(file) else named.findall(file.read_text(encoding="utf-8")):
            example = file.stem == "how_to_add" and "mooring" in path
            assert example or (ROOT / path).exists() or made(ROOT / path), f"{file.name}: {path}"


def made(path: Path) -> bool:
    """Whether `make docs` writes this file, so that a checkout need not have it."""
    relative = os.path.relpath(path, ROOT)
    return any(fnmatch(relative, f"{pattern}*") for pattern in MADE)


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
    monkeypatch.setattr(page, "BENCHMARKS", (page.Benchmark("cost", "Cost", (read.Column("^s$", "more", over="peer"),)),))
    text = (
        "## Cost\n\n| way | error | s |\n|---|---|---|\n| ours, fine | 1e-6 | 0.50 |\n| ours, coarse | 1e-3 | 0.05 |\n"
        "| peer | 1e-4 | 2.0 |\n| libcosim | lost | 3.0 |\n"
    )
    printed = read.tables(text)
    now = read.ratios(printed, (read.Column("^s$", "more", over="peer"),))
    assert {key: ratio.value for key, ratio in now.items()} == {"Cost / ours, fine / s": 4.0}, "0.05 has one digit"
    assert list(read.curves(printed, read.Curves("^s$", "^error$"))) == [
        ("Cost", {"ours": [(0.5, 1e-6), (0.05, 1e-3)], "peer": [(2.0, 1e-4)]})
    ]
    last = {"ratios": {"Cost / ours, fine / s": 6.1}}
    assert list(page.fallen(now, last)) == ["Cost / ours, fine / s"]
    assert f'<span style="color:{page.RED}">**4**</span>' in page.comparison(now, last)
    last["ratios"]["Cost / ours, fine / s"] = 5.9  # less than 1.5 times worse
    assert page.fallen(now, last) == {} == page.fallen(now, None)
    assert page.ratios_of({"texts": {"cost": text.splitlines()}}) == {f"cost: {key}": now[key] for key in now}
    assert page.Ratio(2.0, "less").gain(1.0) == 0.5


def test_page_of_the_benchmarks_is_drawn_from_what_is_kept(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(str(ROOT / "benchmarks"))
    page = importlib.import_module("page")
    kept = json.loads((ROOT / "docs" / "benchmarks.json").read_text(encoding="utf-8"))
    kept["texts"] = {"coupling": kept["texts"]["coupling"]}  # drawing all takes 4 s
    text = page.write_page(kept, tmp_path).read_text(encoding="utf-8")
    assert "## Coupling, beside libcosim" in text and "(benchmarks_coupling.svg)" in text
    assert (tmp_path / "benchmarks_coupling.svg").is_file()
    ratios = {key: value for key, value in kept["ratios"].items() if key.startswith("coupling: ")}
    assert ratios and {key: ratio._asdict() for key, ratio in page.ratios_of(kept).items()} == ratios


def test_benchmarks_print_the_columns_that_the_page_reads(monkeypatch):
    monkeypatch.syspath_prepend(str(ROOT / "benchmarks"))
    page = importlib.import_module("page")
    for benchmark in page.BENCHMARKS:
        text = (ROOT / "benchmarks" / f"{benchmark.name}.py").read_text(encoding="utf-8")
        parts = (ROOT / "benchmarks" / f"{name}.py" for name in re.findall(r"^(?:from|import) (\w+)", text, re.MULTILINE))
        text += "".join(part.read_text(encoding="utf-8") for part in parts if part.is_file())
        heads = [cell.strip(' "') for line in text.splitlines() if "| " in line for cell in re.split(r"\||\\n", line)]
        for column in benchmark.columns:
            assert any(re.search(column.pattern, head) for head in heads), f"{benchmark.name}: {column.pattern}"
            assert not column.over or column.over in text


@pytest.mark.slow
def test_quick_benchmarks_write_their_page(tmp_path):
    command = [sys.executable, str(ROOT / "benchmarks" / "run_all.py"), "--quick", "--out", str(tmp_path)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=600)
    assert done.returncode in (0, 1) and "FAILED" not in done.stderr, done.stderr  # 1: slower than the last page
    kept = json.loads((tmp_path / "benchmarks.json").read_text(encoding="utf-8"))
    assert len(kept["ratios"]) > 5 and kept["versions"]["numpy"] == np.__version__
    page = (tmp_path / "benchmarks.md").read_text(encoding="utf-8")
    assert "## Coupling" in page and "over raw FMI calls" in page and socket.gethostname() not in page
