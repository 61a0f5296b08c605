"""Builds the Python flavour: PythonFMU's bridge around an unmodified, privately named copy of the unit's modules.

Two FMUs in one process that carry modules of one name share the first one's code, so every FMU stages the modules it
needs under ``<unit>_<hash of their text>``. Everything in the archive follows from the sources: two builds are
byte-identical.
"""

from __future__ import annotations

import ast
import hashlib
import uuid
from importlib import metadata
from pathlib import Path

from . import archive_writer
from .description import model_description
from .documentation import documentation_page, reference_result
from .unit import Unit, load

PACKAGE = Path(__file__).resolve().parent
OPTIONS = {
    "needsExecutionTool": "false",
    "canHandleVariableCommunicationStepSize": "true",
    "canInterpolateInputs": "false",
    "canBeInstantiatedOnlyOncePerProcess": "false",
    "canNotUseMemoryManagementFunctions": "true",
    "canGetAndSetFMUstate": "true",
    "canSerializeFMUstate": "true",
}
NAMESPACE = uuid.UUID("6d0cf5bc-7c1e-5f52-9c55-3a1fd5f3f6a1")


def staged_modules(unit_name: str) -> dict[str, bytes]:
    """Text of every module that the unit's slave imports, by path inside the private package."""
    folders = {"fmus": PACKAGE, "models": PACKAGE.parent / "models"}
    todo = [("fmus", unit_name), ("fmus", "python_slave"), ("fmus", "__init__"), ("models", "__init__")]
    found: dict[str, bytes] = {"__init__.py": b""}
    while todo:
        folder, module = todo.pop()
        name = f"{folder}/{module}.py"
        if name in found:
            continue
        text = (folders[folder] / f"{module}.py").read_bytes()
        found[name] = text
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.ImportFrom) and node.level:
                parts = ([folder] if node.level == 1 else []) + (node.module.split(".") if node.module else [])
                modules = [parts[1]] if len(parts) > 1 else [alias.name for alias in node.names]
                todo += [(parts[0], m) for m in modules]
    return found


def contents(unit: Unit) -> dict[str, bytes]:
    """The members of the unit's FMU."""
    modules = staged_modules(unit.name)
    digest = hashlib.sha256()
    for name in sorted(modules):
        digest.update(name.encode() + b"\0" + modules[name] + b"\0")
    package = f"{unit.name}_{digest.hexdigest()[:12]}"
    script = f"from {package}.fmus.python_slave import slave\n\n{unit.name} = slave({unit.name!r}, globals())\n"
    members = {f"resources/{package}/{name}": text for name, text in modules.items()}
    members[f"resources/{package}_fmu.py"] = script.encode()
    members["resources/slavemodule.txt"] = f"{package}_fmu\n".encode()
    members["documentation/index.html"] = documentation_page(unit).encode()
    members[f"documentation/{unit.name}_ref.csv"] = reference_result(unit).encode()
    members |= _binaries(unit.name)
    for name in sorted(members):
        digest.update(name.encode() + b"\0" + members[name] + b"\0")
    digest.update(model_description(unit, unit.name, "", OPTIONS))
    guid = "{" + str(uuid.uuid5(NAMESPACE, digest.hexdigest())) + "}"
    members["modelDescription.xml"] = model_description(unit, unit.name, guid, OPTIONS)
    return members


def _binaries(identifier: str) -> dict[str, bytes]:
    """PythonFMU's bridge for every platform it ships."""
    files = metadata.files("pythonfmu") or []
    found = {}
    for file in files:
        if file.suffix in (".so", ".dll", ".dylib") and "binaries" in file.parts:
            found[f"binaries/{file.parent.name}/{identifier}{file.suffix}"] = Path(str(file.locate())).read_bytes()
    if not found:
        raise FileNotFoundError("PythonFMU is installed without its binaries: reinstall pythonfmu 0.7")
    return found


def build(name: str, directory: Path) -> tuple[Path, bool]:
    """Build the unit's FMU into ``directory``; returns (path, whether it had to be written).

    An FMU of the same content is left alone.
    """
    members = contents(load(name))
    path = directory / f"{name}.fmu"
    if archive_writer.read(path) == members:
        return path, False
    archive_writer.write(path, members)
    return path, True
