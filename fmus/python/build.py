"""Builds the Python flavour: PythonFMU's bridge around an unmodified, privately named copy of the unit's modules.

Two FMUs in one process that carry modules of one name share the first one's code, so every FMU stages the modules it
needs under ``<unit>_<hash of their text>``. Everything in the archive follows from the sources: two builds are
byte-identical.
"""

from __future__ import annotations

import ast
import hashlib
import uuid
from collections.abc import Iterator
from importlib import metadata
from pathlib import Path

from ..declare.unit import Unit, load
from ..describe import archive as archive_writer
from ..describe.documentation import documentation_page, reference_result
from ..describe.fmi2 import model_description

FOLDERS = {"fmus": Path(__file__).resolve().parents[1], "models": Path(__file__).resolve().parents[2] / "models"}
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
    todo = [f"fmus.{unit_name}", "fmus.python.slave"]
    staged: dict[str, bytes] = {"__init__.py": b""}
    while todo:
        module = todo.pop()
        file = _file(module)
        name = "/".join(module.split(".")) + ("/__init__.py" if file.name == "__init__.py" else ".py")
        if name in staged:
            continue
        staged[name] = text = file.read_bytes()
        package = module if file.name == "__init__.py" else module.rpartition(".")[0]
        if module != package:
            todo.append(package)
        elif "." in package:
            todo.append(package.rpartition(".")[0])
        for node in _executed(ast.parse(text)):
            if isinstance(node, ast.ImportFrom) and node.level:
                parts = package.split(".")
                base = ".".join([*parts[: len(parts) - node.level + 1], *(node.module or "").split(".")]).strip(".")
                members = [f"{base}.{alias.name}" for alias in node.names]
                todo += [member for member in members if _file(member).is_file()] or [base]
    return staged


def _executed(node: ast.AST) -> Iterator[ast.AST]:
    """``node`` and all below it but what stands there for type checkers alone."""
    yield node
    for child in ast.iter_child_nodes(node):
        if not (isinstance(child, ast.If) and isinstance(child.test, ast.Name) and child.test.id == "TYPE_CHECKING"):
            yield from _executed(child)


def _file(module: str) -> Path:
    """The file of a module or package ``fmus...`` or ``models...``."""
    folder, *rest = module.split(".")
    place = FOLDERS[folder].joinpath(*rest)
    return place / "__init__.py" if place.is_dir() else place.with_suffix(".py")


def contents(unit: Unit) -> dict[str, bytes]:
    """The members of the unit's FMU."""
    modules = staged_modules(unit.name)
    digest = hashlib.sha256()
    for name in sorted(modules):
        digest.update(name.encode() + b"\0" + modules[name] + b"\0")
    package = f"{unit.name}_{digest.hexdigest()[:12]}"
    script = f"from {package}.fmus.python.slave import slave\n\n{unit.name} = slave({unit.name!r}, globals())\n"
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
    libraries = {}
    for file in files:
        if file.suffix in (".so", ".dll", ".dylib") and "binaries" in file.parts:
            libraries[f"binaries/{file.parent.name}/{identifier}{file.suffix}"] = Path(str(file.locate())).read_bytes()
    if not libraries:
        raise FileNotFoundError("PythonFMU is installed without its binaries: reinstall pythonfmu 0.7")
    return libraries


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
