"""The zoo: units of another make, compiled here, each of which does one thing that the standard allows or that is found in the
wild. Their model is y' = gain u and w = gain u, with a staircase, an integer, a truth value and a text; the GUID is their manner.
"""

from __future__ import annotations

import functools
import shutil
import subprocess
import tempfile
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

from towage.master.master import run_resolved
from towage.result.result import Result
from towage.scene.flavour import resolve
from towage.scene.scene import Scene
from towage.units.binary import platform_name, platform_tuple

HERE = Path(__file__).parent
RUNTIME = HERE.parents[1] / "fmus" / "native" / "runtime"
PARAMETER = 'causality="parameter" variability="fixed"'
OUTPUT = 'causality="output" variability="{}"'
VARIABLES = {
    "u": (0, 'causality="input" variability="continuous"', '<Real start="0"{u}/>'),
    "y": (1, OUTPUT.format("continuous"), "<Real{y}/>"),
    "w": (2, OUTPUT.format("continuous"), "<Real{w}/>"),
    "stairs": (3, OUTPUT.format("discrete"), "<Real/>"),
    "tolerance": (4, OUTPUT.format("discrete"), "<Real/>"),
    "calls": (5, OUTPUT.format("discrete"), "<Real/>"),
    "gain": (6, PARAMETER, '<Real start="1"/>'),
    "x0": (7, PARAMETER, '<Real start="0"/>'),
    "end": (8, PARAMETER, '<Real start="1e300"/>'),
    "noise": (9, PARAMETER, '<Real start="0"/>'),
    "rate": (10, OUTPUT.format("continuous"), "<Real{rate}/>"),
    "n_in": (20, 'causality="input" variability="discrete"', '<Integer start="0"/>'),
    "n": (21, OUTPUT.format("discrete"), "<Integer/>"),
    "b_in": (22, 'causality="input" variability="discrete"', '<Boolean start="false"/>'),
    "b": (23, OUTPUT.format("discrete"), "<Boolean/>"),
    "s_in": (24, 'causality="input" variability="discrete"', '<String start="none"/>'),
    "s": (25, OUTPUT.format("discrete"), "<String/>"),
}
MORE = {"array": "Float64", "bytes": "Binary", "single": "Float32", "byte": "Int8", "wide": "UInt64"}
"""What FMI 3.0 has more: name_in is passed on as name."""
DEPENDS = {"y": "", "w": "1", "stairs": "", "tolerance": "", "calls": "", "rate": "1", "n": "12", "b": "14", "s": "16"}
"""Positions, from 1, of the inputs that act on each output without delay."""


@functools.cache
def library(version: int) -> bytes:
    """The zoo compiled for a version of FMI; a test that wants it is skipped where there is no compiler."""
    if not (compiler := shutil.which("cc")):
        pytest.skip("needs a C compiler")
    with tempfile.TemporaryDirectory() as directory:
        path = Path(directory, "zoo")
        headers = ["-I", str(RUNTIME / f"fmi{version}")]
        command = [compiler, "-std=c99", "-O0", "-w", "-shared", "-fPIC", *headers, "-o", str(path)]
        sources = [f"zoo{version}.c", *(["absent3.c"] if version == 3 else [])]
        subprocess.run([*command, *(str(HERE / name) for name in sources), "-lm"], check=True, timeout=60)
        return path.read_bytes()


def description(
    manner: str = "sound",
    *,
    identifier: str = "zoo",
    options: str = "",
    rollback: bool = True,
    variable_step: bool = True,
    names: Mapping[str, str] | None = None,
    reals: Mapping[str, str] | None = None,
    declared: bool = True,
    depends: Mapping[str, str] | None = None,
    extra: str = "",
    experiment: str = "",
    more: Mapping[str, tuple[int, str, str]] | None = None,
) -> str:
    """A model description of FMI 2.0. ``names`` renames variables, ``reals`` are attributes of the type of u, y and rate;
    ``declared``: dependencies are; ``more``: further variables."""
    words = {"u": "", "y": "", "w": "", "rate": "", **(reals or {})}
    renamed = names or {}
    variables = "\n".join(
        f'<ScalarVariable name="{renamed.get(name, name)}" valueReference="{reference}" {what}>{kind.format(**words)}'
        "</ScalarVariable>"
        for name, (reference, what, kind) in {**VARIABLES, **(more or {})}.items()
    )
    outputs = "".join(
        f'<Unknown index="{[*VARIABLES].index(name) + 1}"' + (f' dependencies="{on}"/>' if declared else "/>")
        for name, on in {**DEPENDS, **(depends or {})}.items()
    )
    return f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="zoo" guid="{manner}" generationTool="by hand">
<CoSimulation modelIdentifier="{identifier}" canGetAndSetFMUstate="{str(rollback).lower()}"
  canHandleVariableCommunicationStepSize="{str(variable_step).lower()}" {options}/>
{extra}{experiment}
<ModelVariables>
{variables}
</ModelVariables>
<ModelStructure><Outputs>{outputs}</Outputs></ModelStructure>
</fmiModelDescription>
"""


def description3(
    manner: str = "sound", *, events: bool = False, rollback: bool = True, serialises: bool = False, extra: str = ""
) -> str:
    """A model description of FMI 3.0 of the same unit, with arrays, bytes and numbers of other widths."""
    types = {"Real": "Float64", "Integer": "Int32", "Boolean": "Boolean", "String": "String"}
    lines = []
    for name, (reference, what, kind) in VARIABLES.items():
        kind = kind.format(u="", y="", w="", rate="")
        tag, start = kind[1:].split("/")[0].split(" ")[0], kind[1:].partition(" ")[2].rstrip("/>")
        if tag == "String":
            value = f'<Start {start.replace("start", "value")}/>' if start else ""
            lines.append(f'<String name="{name}" valueReference="{reference}" {what}>{value}</String>')
        else:
            lines.append(f'<{types[tag]} name="{name}" valueReference="{reference}" {what} {start}/>')
    for k, (name, tag) in enumerate(MORE.items()):
        inside = '<Dimension start="3"/>' if name == "array" else ""
        start = '<Start value="00"/>' if tag == "Binary" else ""
        about = 'start="1 2 3"' if name == "array" else "" if tag == "Binary" else 'start="0"'
        lines.append(f'<{tag} name="{name}_in" valueReference="{30 + 2 * k}" causality="input" {about}>{inside}{start}</{tag}>')
        lines.append(f'<{tag} name="{name}" valueReference="{31 + 2 * k}" causality="output">{inside}</{tag}>')
    inputs = {name: VARIABLES[[*VARIABLES][int(on) - 1]][0] for name, on in DEPENDS.items() if on}
    outputs = [f'<Output valueReference="{VARIABLES[n][0]}" dependencies="{inputs.get(n, "")}"/>' for n in DEPENDS]
    outputs += [f'<Output valueReference="{31 + 2 * k}" dependencies="{30 + 2 * k}"/>' for k in range(5)]
    new_line = "\n"
    return f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="3.0" modelName="zoo" instantiationToken="{manner}" generationTool="by hand">
<CoSimulation modelIdentifier="zoo" canGetAndSetFMUState="{str(rollback).lower()}"
  canSerializeFMUState="{str(serialises).lower()}" hasEventMode="{str(events).lower()}"
  canHandleVariableCommunicationStepSize="true"/>
<ModelVariables>
{new_line.join(lines)}
{extra}</ModelVariables>
<ModelStructure>{"".join(outputs)}</ModelStructure>
</fmiModelDescription>
"""


def animal3(path: Path, manner: str = "sound", **about: Any) -> str:
    """As `animal`, of FMI 3.0."""
    platform, suffix = platform_tuple()
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("modelDescription.xml", description3(manner, **about))
        archive.writestr(f"binaries/{platform}/zoo{suffix}", library(3))
    return str(path)


def animal(path: Path, manner: str = "sound", *, entries: Mapping[str, str] | None = None, **about: Any) -> str:
    """The path of a unit of that manner, built there; ``about`` goes to `description`, ``entries`` are further files."""
    platform, suffix = platform_name()
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("modelDescription.xml", description(manner, **about))
        archive.writestr(f"binaries/{platform}/{about.get('identifier', 'zoo')}{suffix}", library(2))
        for name, text in (entries or {}).items():
            archive.writestr(name, text)
    return str(path)


def scene(units: Mapping[str, Any], connections: list[str], stop: float = 2.0, **tables: Any) -> Scene:
    """A scene of such units, each the path of its FMU or a table."""
    entries = {name: {"fmu": unit} if isinstance(unit, str) else unit for name, unit in units.items()}
    coupling = {"step": 0.1, "error_estimate": False, **tables.pop("coupling", {})}
    tables = {"title": "Zoo", "stop_time": stop, "units": entries, "connections": connections, "coupling": coupling} | tables
    return Scene.from_dict(tables)


def run(units: Mapping[str, Any], connections: list[str], stop: float = 2.0, **tables: Any) -> Result:
    """The result of such a scene."""
    return run_resolved(resolve(scene(units, connections, stop, **tables)))


def told(result: Result, name: str) -> str:
    """What the findings called ``name`` say."""
    return "\n".join(finding.message for finding in result.checks if finding.name == name)
