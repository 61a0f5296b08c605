"""docs/how_to_add.md: its blocks are one package that runs as it stands, and its unit is the one that ``towage new`` writes."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import msgspec
import pytest

from tests.third_party.install import install
from towage.commands.new import as_package
from towage.errors import SceneError
from towage.result.result import Result
from towage.scene import parts
from towage.scene.tables import Tables

PAGE = (Path(__file__).parents[1] / "docs" / "how_to_add.md").read_text(encoding="utf-8")
BLOCKS = dict(re.findall(r'^```\w+ title="(.*?)"\n(.*?)^```$', PAGE, re.MULTILINE | re.DOTALL))
PACKAGE = "towage_mooring"


def test_the_package_of_the_page_runs(tmp_path: Path) -> None:
    source = tmp_path / "source" / PACKAGE
    source.mkdir(parents=True)
    (source / "__init__.py").touch()
    for title, text in BLOCKS.items():
        if title.startswith(PACKAGE):
            (source / Path(title).name).write_text(text, encoding="utf-8")
    project = tomllib.loads(BLOCKS["pyproject.toml"])["project"]
    points = {group: "\n".join(f"{n} = {v}" for n, v in names.items()) for group, names in project["entry-points"].items()}
    assert {"towage.units", "towage.schemes", "towage.checks", "towage.writers"} == points.keys()
    install(tmp_path / "site", project["name"], points, source)
    (tmp_path / "mooring.toml").write_text(BLOCKS["mooring.toml"], encoding="utf-8")
    command = re.search(r"^towage (run mooring.toml .*)$", PAGE, re.MULTILINE)
    assert command
    done = subprocess.run(
        [sys.executable, "-m", "towage", *command[1].split(), "--flavour", "python", "--no-report", "--out", "out"],
        cwd=tmp_path, env=os.environ | {"PYTHONPATH": str(tmp_path / "site")}, capture_output=True, text=True, timeout=300,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    result = Result.load_npz(tmp_path / "out" / "mooring.npz")
    assert result.scheme == "linear"
    (finding,) = [finding for finding in result.checks if finding.name == "travel"]
    # 500 N on 1000 kg, 4000 N/m and 200 N s/m at 2 pi / 5 s: |k - m w^2 + i c w| = 2434 N/m
    assert finding.value == pytest.approx(500.0 / 2434.0, rel=0.02) and finding.level == "ok"
    written = json.loads((tmp_path / "out" / "mooring.json").read_text(encoding="utf-8"))
    assert written["buoy.displacement"] == result["buoy.displacement"].tolist()


def test_the_unit_is_the_one_that_is_written_for_a_name() -> None:
    (module,) = [text for path, text in as_package("mooring", Path()).items() if path.name == "unit.py"]
    assert BLOCKS[f"{PACKAGE}/unit.py"] == module


def test_a_field_needs_no_more_than_its_line() -> None:
    names = dict(vars(parts))
    exec(compile("from __future__ import annotations\n" + BLOCKS["towage/scene/parts.py"], "parts.py", "exec"), names)
    longer = names["Record"]
    longer.__module__ = parts.__name__
    assert issubclass(longer, msgspec.Struct)
    assert parts.Record.__annotations__.items() <= longer.__annotations__.items(), "as it is now, and one field more"
    record = Tables(None).structure({"after": "2 min", "interval": 0.5}, longer, "record")
    assert (record.after, record.interval) == (120.0, 0.5)
    with pytest.raises(SceneError, match="did you mean 'after'"):
        Tables(None).structure({"aftr": 1.0}, longer, "record")
