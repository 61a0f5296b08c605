"""Builds the Python flavour: PythonFMU's bridge around a privately named copy of the unit's modules.

Two FMUs in one process that carry modules of one name share the first one's code, so every FMU stages the modules it
needs under ``<unit>_<hash of their text>``. The copy is unmodified but for one thing: a unit of another package imports
``from towage.models...`` and from its own package by full names, which are led to the copies. Everything in the archive
follows from the sources: two builds are byte-identical.
"""

from __future__ import annotations

import ast
import functools
import hashlib
import importlib.util
import uuid
from collections.abc import Iterator, Mapping
from importlib import metadata
from pathlib import Path

from ..declare.unit import BuildError, Unit, load
from ..describe import archive as archive_writer
from ..describe.fmi2 import model_description
from ..describe.members import members as other_members
from ..describe.members import python_notice
from .reference import reference_run

FOLDERS = {"fmus": Path(__file__).resolve().parents[1], "models": Path(__file__).resolve().parents[2] / "models"}
TOWAGE = (__package__ or "").partition(".")[0]
"""The package that holds ``fmus`` and ``models``, by which other packages import from them."""
OPTIONS = {
    "needsExecutionTool": "true",
    "canHandleVariableCommunicationStepSize": "true",
    "canInterpolateInputs": "false",
    "canBeInstantiatedOnlyOncePerProcess": "false",
    "canNotUseMemoryManagementFunctions": "true",
    "canGetAndSetFMUstate": "true",
    "canSerializeFMUstate": "true",
}
NAMESPACE = uuid.UUID("6d0cf5bc-7c1e-5f52-9c55-3a1fd5f3f6a1")


def shipped_place(name: str) -> str:
    """Where the declaration of a shipped unit is, as "module:attribute" below the private package."""
    return f"fmus.{name}:UNIT"


def staged_modules(unit_name: str, place: str = "", made: Mapping[str, bytes] | None = None) -> dict[str, bytes]:
    """Text of every module that the unit's slave imports, by path inside the private package.

    ``place``, "module:attribute", is where the unit's declaration is; default: that of a shipped unit. Modules of its own
    top-level package are carried too, and what they import from ``towage.fmus`` and ``towage.models``. ``made``: texts of modules
    that are no files, as of one that holds data. Raises `BuildError` for an import that cannot be made private.
    """
    start = (place or shipped_place(unit_name)).partition(":")[0]
    todo = [start, "fmus.python.slave"]
    staged: dict[str, bytes] = {"__init__.py": b""}
    while todo:
        module = todo.pop()
        file = _file(module)
        name = "/".join(module.split(".")) + ("/__init__.py" if file.name == "__init__.py" else ".py")
        if name in staged:
            continue
        staged[name] = text = (made or {}).get(module) or file.read_bytes()
        package = module if file.name == "__init__.py" else module.rpartition(".")[0]
        todo += [outer] if (outer := module.rpartition(".")[0]) else []
        for base, names in _imports(text, module, package, start.partition(".")[0]):
            members = [f"{base}.{member}" for member in names]
            todo += [member for member in members if _file(member).is_file()] or [base]
    return staged


def _imports(text: bytes, module: str, package: str, own: str) -> Iterator[tuple[str, list[str]]]:
    """(module, names) of every import in ``text`` that the FMU must carry; ``own`` is the unit's top-level package."""
    for node in _import_statements(text):
        if isinstance(node, ast.Import):
            for alias in node.names:
                if _carried(alias.name, own):
                    raise BuildError(
                        f"{module}, line {node.lineno}: 'import {alias.name}' cannot be carried by an FMU: write "
                        f"'from ... import ...'"
                    )
            continue
        names = [alias.name for alias in node.names]
        if node.level:
            parts = package.split(".")
            yield ".".join([*parts[: len(parts) - node.level + 1], *(node.module or "").split(".")]).strip("."), names
        elif carried := _carried(node.module or "", own):
            yield carried, names


@functools.lru_cache(maxsize=512)
def _import_statements(text: bytes) -> tuple[ast.Import | ast.ImportFrom, ...]:
    """The imports in a module's text but for those for type checkers alone. Units share most of their modules, and every
    run asks for some units, so what was parsed is kept."""
    return tuple(node for node in _statements(ast.parse(text)) if isinstance(node, (ast.Import, ast.ImportFrom)))


def _statements(node: ast.AST) -> Iterator[ast.AST]:
    """All statements below ``node`` but those that stand there for type checkers alone; no expressions."""
    for child in ast.iter_child_nodes(node):
        if not isinstance(child, (ast.stmt, ast.ExceptHandler, ast.match_case)):
            continue
        if isinstance(child, ast.If) and isinstance(child.test, ast.Name) and child.test.id == "TYPE_CHECKING":
            continue
        yield child
        yield from _statements(child)


def _carried(module: str, own: str) -> str:
    """Where a module that is imported by its full name lives in the private package; "" if the FMU does not carry it."""
    top, _, rest = module.partition(".")
    if top == TOWAGE and rest.partition(".")[0] in FOLDERS:
        return rest
    return module if top == own and own not in FOLDERS else ""


def _made_private(text: bytes, package: str, own: str) -> bytes:
    """``text`` with the full names of carried modules led into the private package; otherwise unmodified."""
    lines = text.splitlines(keepends=True)
    for node in _import_statements(text):
        if isinstance(node, ast.ImportFrom) and not node.level and (carried := _carried(node.module or "", own)):
            line, name = node.lineno - 1, (node.module or "").encode()
            begin = lines[line].index(name, node.col_offset)
            lines[line] = lines[line][:begin] + f"{package}.{carried}".encode() + lines[line][begin + len(name) :]
    return b"".join(lines)


def _file(module: str) -> Path:
    """The file of a module or package ``fmus...``, ``models...``, or of the package that brings the unit."""
    folder, *rest = module.split(".")
    place = (FOLDERS.get(folder) or _installed(folder)).joinpath(*rest)
    return place / "__init__.py" if place.is_dir() else place.with_suffix(".py")


def _installed(package: str) -> Path:
    """The folder of an installed package, or its only file without suffix."""
    spec = importlib.util.find_spec(package)
    if spec is None or not spec.origin:
        raise BuildError(f"the unit's package {package!r} has no files that an FMU could carry")
    file = Path(spec.origin)
    return file.parent if file.name == "__init__.py" else file.with_suffix("")


def contents(unit: Unit, place: str = "", made: Mapping[str, bytes] | None = None) -> dict[str, bytes]:
    """The members of the FMU of the unit declared at ``place``; default: that of a shipped unit. ``made``: as in
    `staged_modules`. Raises `BuildError`."""
    place = place or shipped_place(unit.name)
    own = place.partition(".")[0].partition(":")[0]
    modules = staged_modules(unit.name, place, made)
    digest = hashlib.sha256()
    for name in sorted(modules):
        digest.update(name.encode() + b"\0" + modules[name] + b"\0")
    package = f"{unit.name}_{digest.hexdigest()[:12]}"
    script = f"from {package}.fmus.python.slave import slave\n\n{unit.name} = slave({place!r}, globals())\n"
    members = {f"resources/{package}/{name}": _made_private(text, package, own) for name, text in modules.items()}
    members[f"resources/{package}_fmu.py"] = script.encode()
    members["resources/slavemodule.txt"] = f"{package}_fmu\n".encode()
    members |= other_members(unit, unit.variables, 2, reference_run(unit), python_notice())
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
    """Build the FMU of the shipped unit ``name`` into ``directory``; returns (path, whether it had to be written).

    An FMU of the same content is left alone. Raises `BuildError`.
    """
    return build_unit(load(name), shipped_place(name), directory)


def build_unit(
    unit: Unit, place: str, directory: Path, made: Mapping[str, bytes] | None = None
) -> tuple[Path, bool]:
    """As `build`, for the unit declared at ``place``."""
    members = contents(unit, place, made)
    path = directory / f"{unit.name}.fmu"
    if archive_writer.read(path) == members:
        return path, False
    archive_writer.write(path, members)
    return path, True
