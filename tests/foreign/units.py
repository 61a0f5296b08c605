"""Foreign FMUs: nothing in them comes from towage. ``hostile.c`` is compiled here, with a misdeed in its GUID."""

from __future__ import annotations

import functools
import shutil
import subprocess
import tempfile
import zipfile
from pathlib import Path

import pytest

from towage.units.binary import platform_name

SOURCE = Path(__file__).with_name("hostile.c")
DESCRIPTION = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="hostile" guid="{misdeed}" generationTool="by hand">
<CoSimulation modelIdentifier="hostile" canHandleVariableCommunicationStepSize="true"
  canGetAndSetFMUstate="{rollback}" {options}/>
<ModelVariables>
<ScalarVariable name="u" valueReference="0" causality="input" variability="continuous"><Real start="0"/></ScalarVariable>
<ScalarVariable name="y" valueReference="1" causality="output" variability="continuous"><Real/></ScalarVariable>
<ScalarVariable name="gain" valueReference="2" causality="parameter" variability="fixed"><Real start="1"/></ScalarVariable>
<ScalarVariable name="x0" valueReference="3" causality="parameter" variability="fixed"><Real start="0"/></ScalarVariable>
<ScalarVariable name="factor" valueReference="0" causality="parameter" variability="fixed"><Integer start="1" min="0"/>
</ScalarVariable>
<ScalarVariable name="steps" valueReference="1" causality="output" variability="discrete"><Integer/></ScalarVariable>
<ScalarVariable name="reversed" valueReference="0" causality="parameter" variability="fixed"><Boolean start="false"/>
</ScalarVariable>
<ScalarVariable name="moving" valueReference="1" causality="output" variability="discrete"><Boolean/></ScalarVariable>
<ScalarVariable name="label" valueReference="0" causality="parameter" variability="fixed"><String start="crane"/>
</ScalarVariable>
<ScalarVariable name="word" valueReference="1" causality="output" variability="discrete"><String/></ScalarVariable>
</ModelVariables>
<ModelStructure><Outputs><Unknown index="2" dependencies=""/><Unknown index="6" dependencies=""/>
<Unknown index="8" dependencies=""/><Unknown index="10" dependencies=""/></Outputs></ModelStructure>
</fmiModelDescription>
"""


@functools.cache
def library(*flags: str) -> bytes:
    """``hostile.c`` compiled with these flags; a test that wants it is skipped where there is no compiler."""
    if not (compiler := shutil.which("cc")):
        pytest.skip("needs a C compiler")
    with tempfile.TemporaryDirectory() as directory:
        path = Path(directory, "hostile")
        command = [compiler, "-std=c99", "-O0", "-w", "-shared", "-fPIC", *flags, "-o", str(path), str(SOURCE), "-lm"]
        subprocess.run(command, check=True, timeout=60)
        return path.read_bytes()


def hostile(
    path: Path, misdeed: str = "none", rollback: bool = True, options: str = "", flags: tuple[str, ...] = ()
) -> Path:
    """The FMU that does ``misdeed``; ``options`` are further attributes of its CoSimulation element."""
    platform, suffix = platform_name()
    text = DESCRIPTION.format(misdeed=misdeed, rollback=str(rollback).lower(), options=options)
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("modelDescription.xml", text)
        archive.writestr(f"binaries/{platform}/hostile{suffix}", library(*flags))
    return path
