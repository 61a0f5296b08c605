"""Builds the native flavour: one C library made from the unit's traced model and the runtime in ``native/``.

The archive holds its sources. Its guid follows from them and from the flags of the compiler, not from the library, so
that every platform's build of the same sources carries the same one.
"""

from __future__ import annotations

import hashlib
import uuid
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from types import MappingProxyType
from xml.etree.ElementTree import Element, SubElement

import casadi as ca

from ...models.numeric.kernel import Kernel
from ..declare.unit import Unit, load
from ..describe import archive as archive_writer
from ..describe.fmi2 import document, native_model_description
from ..describe.fmi3 import model_description3
from ..describe.members import Reference, native_notice
from ..describe.members import members as other_members
from ..python.build import FOLDERS, NAMESPACE
from ..python.reference import reference_run
from ..python.values import CallError
from . import compiler
from .constants import constants_header
from .kernels import sources as kernel_sources
from .source import model_source, unit_source
from .stages import runtime_stages
from .trace import trace
from .traced import Traced

RUNTIME = Path(__file__).resolve().parent / "runtime"
NOTHING: Mapping[str, str] = MappingProxyType({})


def runtime_sources(fmi: int, kernels: Sequence[Kernel] = (), headers: Mapping[str, str] = NOTHING) -> dict[str, bytes]:
    """The C files that serve every unit, by name: those of ``runtime/`` without the other version of FMI, without ``kernel``
    where there are none, and without ``chain`` where there are no ``headers`` of a wire; and those that are made from
    Python. The archive has them in one folder: FMI 2 names files in ``sources/`` alone."""
    spared = [folder for folder, wanted in (("chain", headers), ("kernel", kernels)) if not wanted]
    left_out = ("fmi3" if fmi == 2 else "fmi2", *spared)
    files = sorted(file for file in RUNTIME.rglob("*.[ch]") if file.parent.name not in left_out)
    made = {"constants.h": constants_header().encode(), "stages.h": runtime_stages().encode()}
    made |= {name: text.encode() for name, text in headers.items()}
    if kernels:
        made |= kernel_sources(kernels)
    return {file.name: file.read_bytes() for file in files} | made


def contents(traced: Traced, fmi: int, reference: Reference | None) -> dict[str, bytes]:
    """The members of the archive but for its libraries. ``reference`` is the reference run, None where there is none."""
    interface = traced.interface
    name = interface.unit.name
    sources = runtime_sources(fmi, traced.kernels, traced.headers) | {"model.c": model_source(traced.functions).encode()}
    files = sorted(["unit.c", *(file for file in sources if file.endswith(".c"))])

    def members(token: str) -> dict[str, bytes]:
        all_sources = sources | {"unit.c": unit_source(traced, token).encode()}
        archive = {f"sources/{file}": text for file, text in all_sources.items()}
        if fmi == 2:
            archive["modelDescription.xml"] = native_model_description(interface, name, token, files)
        else:
            archive["modelDescription.xml"] = model_description3(interface, name, token)
            archive["sources/buildDescription.xml"] = build_description(name, files)
        return archive | other_members(interface.as_built, interface.variables, fmi, reference, native_notice(fmi))

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
    of structural parameters. Raises `traced.NotNative` and `compiler.CompileError`.

    Tracing takes seconds. A file ``.<name>.built`` beside the FMU keeps the digests of all that it was made from and of the
    FMU itself; while both hold, nothing is traced.
    """
    path, note = directory / f"{name}.fmu", directory / f".{name}.built"
    made_from = digest_of_sources(name, fmi, compiler.chosen(platforms), structure or {})
    if note.is_file() and path.is_file() and note.read_text() == f"{made_from} {_digest(path.read_bytes())}\n":
        return path, False
    path, written = build_unit(load(name), directory, fmi, platforms, structure)
    with suppress(OSError):  # without the note the next call traces again, that is all
        note.write_text(f"{made_from} {_digest(path.read_bytes())}\n")
    return path, written


def digest_of_sources(
    name: str, fmi: int, platforms: Iterable[compiler.Platform], structure: Mapping[str, float]
) -> str:
    """Digest of everything from which a unit's FMU is made: models, declarations, runtime, CasADi and what was asked for."""
    parts = [name, fmi, *platforms, sorted(structure.items()), compiler.FLAGS, ca.CasadiMeta.version()]
    for folder in FOLDERS.values():
        for file in sorted(folder.rglob("*.*")):
            if file.suffix in (".py", ".c", ".h", ".svg", ".png"):
                parts.append((file.relative_to(folder).as_posix(), _digest(file.read_bytes())))
    return _digest(repr(parts).encode())


def _digest(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def build_unit(
    unit: Unit, directory: Path, fmi: int = 2, platforms: str = "host", structure: Mapping[str, float] | None = None
) -> tuple[Path, bool]:
    """As `build`, of a unit that has no module of its own, such as a scene."""
    traced = trace(unit, structure)
    try:
        reference: Reference | None = reference_run(traced.interface.as_built)
    except CallError:  # a cable that stretches, without its stiffness
        reference = None
    return package(traced, reference, directory, fmi, platforms)


def package(traced: Traced, reference: Reference | None, directory: Path, fmi: int, platforms: str) -> tuple[Path, bool]:
    """Compile and write what was traced; as `build`."""
    name = traced.interface.unit.name
    targets = compiler.chosen(platforms)
    members = contents(traced, fmi, reference)
    path = directory / f"{name}.fmu"
    there = archive_writer.read(path)
    wanted = set(members) | set(compiler.members(name, targets, fmi))
    if set(there) == wanted and all(there[member] == text for member, text in members.items()):
        return path, False
    sources = {m.removeprefix("sources/"): text for m, text in members.items() if m.endswith((".c", ".h"))}
    archive_writer.write(path, members | compiler.libraries(sources, name, targets, fmi))
    return path, True
