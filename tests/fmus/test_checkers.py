"""What the field's checkers say of every FMU that is built here: nothing. Those that are not there are skipped, by name.

* the schemas of FMI 2.0 and 3.0, as fmpy brings them, and ``fmpy validate``
* ``fmutool -check`` of the FMU Manipulation Toolbox (pip install fmu-manipulation-toolbox): schemas and rules of FMI 2.0.5, 3.0.2
* VDMCheck 2 and 3: ``VDMCHECK`` names the folder with ``VDMCheck2.sh`` and ``VDMCheck3.sh``
"""

from __future__ import annotations

import os
import subprocess
import sys
import zipfile
from collections.abc import Callable
from functools import cache
from pathlib import Path

import fmpy
import pytest
from fmpy.validation import validate_fmu
from lxml import etree

from towage.fmus.native.build import build_unit
from towage.scene.compose import scene_unit

from .cases import NATIVE, UNITS

SCHEMAS = Path(fmpy.__file__).parent / "schema"
ALL = [
    *(f"python 2 {name}" for name in UNITS),
    *(f"native {fmi} {name}" for fmi in (2, 3) for name in NATIVE),
    *(f"scene {fmi} {name}" for fmi in (2, 3) for name in ("slack", "docking", "voyage_tow")),
]
"""Flavour, version of FMI, name."""
Find = Callable[[str], Path]


@pytest.fixture(scope="module")
def find(fmus: Path, native: Callable[[str, int], Path], tmp_path_factory: pytest.TempPathFactory) -> Find:
    """The FMU of an entry of `ALL`."""

    @cache
    def found(which: str) -> Path:
        flavour, fmi, name = which.split()
        if flavour == "python":
            return fmus / f"{name}.fmu"
        if flavour == "native":
            return native(name, int(fmi))
        return build_unit(scene_unit(name), tmp_path_factory.mktemp("scene"), int(fmi))[0]

    return found


@pytest.mark.slow
@pytest.mark.parametrize("which", ALL)
def test_schemas_and_fmpy(which: str, find: Find) -> None:
    path, version = find(which), f"fmi{which.split()[1]}"
    assert validate_fmu(str(path)) == []
    with zipfile.ZipFile(path) as archive:
        described = {"modelDescription.xml": f"{version}/{version}ModelDescription.xsd"}
        if version == "fmi3":
            described["sources/buildDescription.xml"] = "fmi3/fmi3BuildDescription.xsd"
            described["terminalsAndIcons/terminalsAndIcons.xml"] = "fmi3/fmi3TerminalsAndIcons.xsd"
        for member, schema in described.items():
            etree.XMLSchema(file=str(SCHEMAS / schema)).assertValid(etree.fromstring(archive.read(member)))


@pytest.mark.slow
@pytest.mark.parametrize("which", ALL)
def test_fmutool(which: str, find: Find) -> None:
    pytest.importorskip("fmu_manipulation_toolbox")
    command = [str(Path(sys.executable).with_name("fmutool")), "-input", str(find(which)), "-check"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300)
    said = done.stdout + done.stderr
    assert done.returncode == 0 and "seems to be compliant" in said and "No semantic error" in said, said
    assert "ERROR" not in said and "WARNING" not in said, said


@pytest.mark.slow
@pytest.mark.parametrize("which", ALL)
def test_vdmcheck(which: str, find: Find) -> None:
    folder = os.environ.get("VDMCHECK")
    if not folder:
        pytest.skip("VDMCHECK does not name the folder of VDMCheck2.sh and VDMCheck3.sh")
    script = Path(folder) / f"VDMCheck{which.split()[1]}.sh"
    done = subprocess.run([str(script), str(find(which))], capture_output=True, text=True, timeout=1800)
    assert done.stdout.strip() == "No errors found.", done.stdout + done.stderr
