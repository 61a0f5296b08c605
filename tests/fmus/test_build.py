"""The archive: what it declares, and that it follows from the sources alone."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import zipfile
from pathlib import Path
from xml.etree import ElementTree

import fmpy
import pytest
from fmpy.validation import validate_fmu

from towage.fmus.declare import quantities
from towage.fmus.declare.dependencies import dependencies
from towage.fmus.declare.unit import load
from towage.fmus.python.build import build

from .conftest import UNITS

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.parametrize("name", UNITS)
def test_validator_reports_nothing(name: str, fmus: Path) -> None:
    assert validate_fmu(str(fmus / f"{name}.fmu")) == []
    assert fmpy.read_model_description(str(fmus / f"{name}.fmu"), validate=True).coSimulation.canGetAndSetFMUstate


@pytest.mark.parametrize("name", UNITS)
def test_description_says_what_the_declaration_says(name: str, fmus: Path) -> None:
    unit = load(name)
    with zipfile.ZipFile(fmus / f"{name}.fmu") as archive:
        root = ElementTree.fromstring(archive.read("modelDescription.xml"))
    assert "generationDateAndTime" not in root.attrib
    assert re.fullmatch(r"\{[0-9a-f]{8}-[0-9a-f]{4}-5[0-9a-f]{3}-[0-9a-f]{4}-[0-9a-f]{12}\}", root.attrib["guid"])
    assert root.find("CoSimulation").attrib["needsExecutionTool"] == "true"  # type: ignore[union-attr]
    units = {u.attrib["name"]: u for u in root.iter("Unit")}
    variables = list(root.iter("ScalarVariable"))
    assert len(variables) == len(unit.variables)
    for reference, (v, element) in enumerate(zip(unit.variables, variables)):
        real = element.find("Real")
        assert real is not None
        assert element.attrib["name"] == v.name and element.attrib["valueReference"] == str(reference)
        assert element.attrib["causality"] == v.causality and element.attrib["variability"] == v.variability
        assert element.attrib["description"] == v.description
        for bound in ("start", "min", "max", "nominal"):
            expected = getattr(v, bound)
            assert (float(real.attrib[bound]) if bound in real.attrib else None) == expected
        assert ("start" in real.attrib) == (v.causality in ("parameter", "input"))
        definition = units[real.attrib["unit"]]
        assert definition.find("BaseUnit") is not None
        if v.display:
            assert real.attrib["displayUnit"] == v.display
            (display,) = [d for d in definition.iter("DisplayUnit") if d.attrib["name"] == v.display]
            # value in display units = factor * value in SI; two roundings
            factor = float(display.attrib["factor"]) * quantities.convert(1.0, v.display, v.unit)
            assert factor == pytest.approx(1.0, rel=1e-15)
    declared = {
        unit.variables[int(u.attrib["index"]) - 1].name: {
            unit.variables[int(i) - 1].name for i in u.attrib["dependencies"].split()
        }
        for u in root.iterfind("ModelStructure/Outputs/Unknown")
    }
    found = dependencies(unit)
    assert declared == {v.name: set(found[v.name]) for v in unit.observed if v.causality == "output"}
    initial = {unit.variables[int(u.attrib["index"]) - 1].name for u in root.iterfind(".//InitialUnknowns/Unknown")}
    assert initial == {v.name for v in unit.variables if v.causality in ("output", "calculatedParameter")}


@pytest.mark.parametrize("name", UNITS)
def test_archive_holds_what_it_needs(name: str, fmus: Path) -> None:
    with zipfile.ZipFile(fmus / f"{name}.fmu") as archive:
        names = set(archive.namelist())
        assert {"modelDescription.xml", "documentation/index.html", f"documentation/{name}_ref.csv"} <= names
        assert {f"binaries/linux64/{name}.so", f"binaries/win64/{name}.dll"} <= names
        package = archive.read("resources/slavemodule.txt").decode().strip().removesuffix("_fmu")
        assert re.fullmatch(rf"{name}_[0-9a-f]{{12}}", package)
        for member in names:
            if member.startswith(f"resources/{package}/") and member.count("/") == 3:
                assert archive.read(member) == (ROOT / member.removeprefix(f"resources/{package}/")).read_bytes()
        assert all(info.date_time == (2000, 1, 1, 0, 0, 0) for info in archive.infolist())
        text = b"".join(archive.read(n) for n in names if not n.startswith("binaries/") and n != "model.png").decode()
    assert str(ROOT) not in text and os.path.expanduser("~") not in text


def test_two_builds_are_byte_identical(fmus: Path, tmp_path: Path) -> None:
    """In another directory, by the command, with another order of hashes."""
    for seed in ("1", "2"):
        subprocess.run(
            [sys.executable, str(ROOT / "build_fmus.py"), *UNITS, "--out", str(tmp_path / seed)],
            cwd=ROOT, check=True, capture_output=True, timeout=60, env=os.environ | {"PYTHONHASHSEED": seed},
        )  # fmt: skip
        for name in UNITS:
            assert (tmp_path / seed / f"{name}.fmu").read_bytes() == (fmus / f"{name}.fmu").read_bytes()


def test_only_what_changed_is_built(tmp_path: Path) -> None:
    path, written = build("ship", tmp_path)
    good = path.read_bytes()
    assert written
    os.utime(path, (1.0, 1.0))
    assert build("ship", tmp_path) == (path, False)
    assert path.stat().st_mtime == 1.0
    flipped = bytes([good[60_000] ^ 1])
    damages = {
        "truncated": good[: len(good) // 2], "one bit": good[:60_000] + flipped + good[60_001:], "empty": b"",
        "no archive": b"not an FMU",
    }  # fmt: skip
    for damage, content in damages.items():
        path.write_bytes(content)
        assert build("ship", tmp_path) == (path, True), damage
        assert path.read_bytes() == good
    with zipfile.ZipFile(path, "a") as archive:
        archive.writestr("resources/extra.py", "")
    assert build("ship", tmp_path) == (path, True)
    assert path.read_bytes() == good
    with zipfile.ZipFile(path) as archive:
        members = {i.filename: archive.read(i) for i in archive.infolist()}
    with zipfile.ZipFile(path, "w") as archive:
        for member, content in members.items():
            archive.writestr(member, content.replace(b"heave", b"eaveh") if member.endswith("/ship.py") else content)
    assert build("ship", tmp_path) == (path, True)
    assert path.read_bytes() == good
    assert sorted(p.name for p in tmp_path.iterdir()) == ["ship.fmu"], "temporary files were left"


def test_unknown_unit_is_refused_by_name(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, str(ROOT / "build_fmus.py"), "shp", "--out", str(tmp_path)],
        cwd=ROOT, capture_output=True, text=True, timeout=60,
    )  # fmt: skip
    assert done.returncode == 2 and "unknown unit shp" in done.stderr and "ship" in done.stderr
    assert list(tmp_path.iterdir()) == []
