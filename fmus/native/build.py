"""Builds the native flavour: one C library made from the unit's traced model and the runtime in ``native/``.

The archive holds its sources. Its guid follows from them and from the flags of the compiler, not from the library, so
that every platform's build of the same sources carries the same one.
"""

from __future__ import annotations

import hashlib
import uuid
from collections.abc import Mapping
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement

from ..declare.unit import Unit, load
from ..describe import archive as archive_writer
from ..describe.documentation import documentation_page, reference_result
from ..describe.fmi2 import document, native_model_description
from ..describe.fmi3 import model_description3
from ..python.build import NAMESPACE
from . import compiler
from .source import model_source, unit_source
from .trace import trace
from .traced import Traced

RUNTIME = Path(__file__).resolve().parent / "runtime"


def runtime_sources(fmi: int) -> dict[str, bytes]:
    """The C files of the runtime, without those of the other version of FMI."""
    other = "fmi3" if fmi == 2 else "fmi2"
    files = [file for kind in ("*.c", "*.h") for file in RUNTIME.glob(kind)]
    return {file.name: file.read_bytes() for file in sorted(files) if not file.name.startswith(other)}


def contents(traced: Traced, fmi: int, reference: str) -> dict[str, bytes]:
    """The members of the archive but for its libraries. ``reference`` is the reference result."""
    interface = traced.interface
    name = interface.unit.name
    sources = runtime_sources(fmi) | {"model.c": model_source(traced.functions).encode()}
    files = sorted(["unit.c", *(file for file in sources if file.endswith(".c"))])

    def members(token: str) -> dict[str, bytes]:
        all_sources = sources | {"unit.c": unit_source(traced, token).encode()}
        found = {f"sources/{file}": text for file, text in all_sources.items()}
        if fmi == 2:
            found["modelDescription.xml"] = native_model_description(interface, name, token, files)
        else:
            found["modelDescription.xml"] = model_description3(interface, name, token)
            found["sources/buildDescription.xml"] = build_description(name, files)
        found["documentation/index.html"] = documentation_page(interface.as_built, interface.variables).encode()
        found[f"documentation/{name}_ref.csv"] = reference.encode()
        return found

    digest = hashlib.sha256(" ".join(compiler.FLAGS).encode())
    for member, text in sorted(members("").items()):
        digest.update(member.encode() + b"\0" + text + b"\0")
    return members("{" + str(uuid.uuid5(NAMESPACE, digest.hexdigest())) + "}")


def build_description(identifier: str, files: list[str]) -> bytes:
    """``buildDescription.xml`` of FMI 3: how to compile the sources."""
    root = Element("fmiBuildDescription", fmiVersion="3.0")
    configuration = SubElement(root, "BuildConfiguration", modelIdentifier=identifier)
    group = SubElement(configuration, "SourceFileSet", language="C99")
    for file in files:
        SubElement(group, "SourceFile", name=file)
    return document(root)


def build(
    name: str, directory: Path, fmi: int = 2, platforms: str = "host", structure: Mapping[str, float] | None = None
) -> tuple[Path, bool]:
    """Build the unit's FMU into ``directory``; returns (path, whether it had to be written).

    An FMU of the same sources that holds libraries of the same platforms is left alone. ``structure`` gives the values
    of structural parameters. Raises `trace.NotNative` and `compiler.CompileError`.
    """
    return build_unit(load(name), directory, fmi, platforms, structure)


def build_unit(
    unit: Unit, directory: Path, fmi: int = 2, platforms: str = "host", structure: Mapping[str, float] | None = None
) -> tuple[Path, bool]:
    """As `build`, of a unit that has no module of its own, such as a scene."""
    traced = trace(unit, structure)
    return package(traced, reference_result(traced.interface.as_built), directory, fmi, platforms)


def package(traced: Traced, reference: str, directory: Path, fmi: int, platforms: str) -> tuple[Path, bool]:
    """Compile and write what was traced; as `build`."""
    name = traced.interface.unit.name
    targets = compiler.chosen(platforms)
    members = contents(traced, fmi, reference)
    path = directory / f"{name}.fmu"
    found = archive_writer.read(path)
    wanted = set(members) | set(compiler.members(name, targets, fmi))
    if set(found) == wanted and all(found[member] == text for member, text in members.items()):
        return path, False
    sources = {m.removeprefix("sources/"): text for m, text in members.items() if m.endswith((".c", ".h"))}
    archive_writer.write(path, members | compiler.libraries(sources, name, targets, fmi))
    return path, True
