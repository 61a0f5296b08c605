"""FMI 2.0 co-simulation archives, read and unpacked without running or trusting anything in them.

``read_description`` answers what a scene needs to be checked; ``extract`` unpacks after every check. What is refused:
names that leave the directory or collide, links, decompression bombs, truncated or damaged data, a DOCTYPE (entities),
other FMI versions and interfaces, duplicate variables, and a binary that the loader of this platform would choke on.
"""

from __future__ import annotations

import math
import re
import shutil
import stat
import struct
import sys
import tempfile
import unicodedata
import zipfile
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Literal, TypeVar
from xml.etree import ElementTree
from xml.parsers import expat

import msgspec

from towage.errors import FmuError
from towage.fmus.quantities import BASES

MAX_ENTRIES = 10_000
MAX_UNPACKED = 512 * 2**20
MAX_RATIO = 200
RATIO_FLOOR = 16 * 2**20
"""Bytes unpacked below which no ratio is a bomb."""
MAX_XML = 64 * 2**20
_DESCRIPTION = "modelDescription.xml"
_SUFFIXES = {".so": "linux", ".dll": "win", ".dylib": "darwin"}
_INITIAL = {"parameter": "exact", "calculatedParameter": "calculated", "input": "", "independent": ""}

T = TypeVar("T")
Value = float | int | bool | str
Kind = Literal["Real", "Integer", "Boolean", "String", "Enumeration"]
_KINDS: dict[str, Kind] = {k: k for k in ("Real", "Integer", "Boolean", "String", "Enumeration")}


class Variable(msgspec.Struct, frozen=True):
    """A scalar variable, with what its declared type adds; ``start``, ``min``, ... are in ``unit``.

    ``initial`` is "" where FMI forbids it (inputs, time); ``unit`` None means undeclared, not dimensionless.
    """

    name: str
    value_reference: int
    type: Kind
    causality: str
    variability: str
    initial: str
    start: Value | None = None
    unit: str | None = None
    display_unit: str | None = None
    min: float | None = None
    max: float | None = None
    nominal: float | None = None
    description: str = ""


class UnitDefinition(msgspec.Struct, frozen=True):
    """SI value = factor * value + offset; exponents in the order of ``quantities.BASES``."""

    exponents: tuple[int, ...]
    factor: float
    offset: float


class DefaultExperiment(msgspec.Struct, frozen=True):
    """Times in s; None: not declared."""

    start_time: float | None = None
    stop_time: float | None = None
    tolerance: float | None = None
    step_size: float | None = None


class Description(msgspec.Struct, frozen=True):
    """A modelDescription.xml, and the platforms that the archive has a binary for.

    ``dependencies`` gives the inputs that act on an output without delay; None: not declared, so all of them may.
    """

    path: Path
    fmi_version: str
    model_name: str
    guid: str
    model_identifier: str
    generation_tool: str
    can_get_set_state: bool
    can_serialize_state: bool
    can_interpolate_inputs: bool
    max_output_derivative_order: int
    can_handle_variable_step: bool
    needs_execution_tool: bool
    default_experiment: DefaultExperiment
    variables: tuple[Variable, ...]
    dependencies: dict[str, tuple[str, ...] | None]
    units: dict[str, UnitDefinition]
    platforms: tuple[str, ...]

    def by_name(self) -> dict[str, Variable]:
        """The variables under their names."""
        return {variable.name: variable for variable in self.variables}


def read_description(path: Path) -> Description:
    """Describe the FMU at ``path``; a binary for this platform is not required. Raises ``FmuError``."""
    with _opened(path) as archive:
        return _describe(path, archive)


def check_platform(description: Description) -> str:
    """The name of this platform's directory in ``binaries``. Raises ``FmuError`` if the FMU has no binary for it."""
    platform, suffix = _platform()
    if platform not in description.platforms:
        raise FmuError(
            f"no binary for {platform} (binaries/{platform}/{description.model_identifier}{suffix}); "
            f"present: {', '.join(description.platforms) or 'none'}. Ask the supplier for a build for {platform}",
            file=description.path,
        )
    return platform


def extract(path: Path, directory: Path) -> None:
    """Unpack the FMU at ``path`` into ``directory``, which appears complete or not at all.

    A directory that already holds the same files is left alone, so processes that unpack one FMU at the same time all
    succeed. Raises ``FmuError``, also if ``directory`` holds something else.
    """
    with _opened(path) as archive:
        platform = check_platform(description := _describe(path, archive))
        entry = f"binaries/{platform}/{description.model_identifier}{_platform()[1]}"
        if problem := _binary_problem(archive.read(entry)):
            raise FmuError(
                f"not a loadable library: {problem}. Rebuild or download the FMU again", file=path, entry=entry
            )
        if _holds(directory, archive):
            return
        directory.parent.mkdir(parents=True, exist_ok=True)
        scratch = Path(tempfile.mkdtemp(prefix=f".{directory.name}-", dir=directory.parent))
        try:
            _unpack(archive, scratch)
            try:
                scratch.rename(directory)
            except OSError:
                if not _holds(directory, archive):
                    raise FmuError(f"{directory} exists and holds something else: remove it", file=path) from None
        finally:
            shutil.rmtree(scratch, ignore_errors=True)


@contextmanager
def _opened(path: Path) -> Iterator[zipfile.ZipFile]:
    """The archive, its names and sizes checked; whatever goes wrong while it is open becomes a ``FmuError``."""
    try:
        with zipfile.ZipFile(path) as archive:
            _check_entries(path, archive)
            yield archive
    except FileNotFoundError:
        raise FmuError("there is no such file", file=path) from None
    except (zipfile.BadZipFile, zlib.error, EOFError, struct.error, NotImplementedError, ValueError) as error:
        raise FmuError(f"damaged or truncated archive ({error}): download or build it again", file=path) from error
    except OSError as error:
        raise FmuError(f"cannot be read or unpacked: {error}", file=path) from error


def _check_entries(path: Path, archive: zipfile.ZipFile) -> None:
    """Refuse an archive by its directory alone."""
    entries = archive.infolist()
    unpacked, packed = sum(entry.file_size for entry in entries), path.stat().st_size
    if len(entries) > MAX_ENTRIES:
        raise FmuError(f"{len(entries)} entries, more than {MAX_ENTRIES}: refused as a bomb", file=path)
    if unpacked > MAX_UNPACKED:
        raise FmuError(f"{unpacked / 2**20:.0f} MB unpacked, over {MAX_UNPACKED >> 20}: refused as a bomb", file=path)
    if unpacked > RATIO_FLOOR and unpacked > MAX_RATIO * packed:
        raise FmuError(f"unpacks to {unpacked / packed:.0f} times its size: refused as a bomb", file=path)
    spelled: dict[str, tuple[str, bool]] = {}
    listed: set[str] = set()
    for entry in entries:
        name = entry.orig_filename
        parts = name.rstrip("/").split("/")
        if problem := _entry_problem(entry, parts):
            raise FmuError(problem, file=path, entry=repr(name))
        for depth in range(1, len(parts) + 1):
            here = ("/".join(parts[:depth]), depth < len(parts) or entry.is_dir())
            there = spelled.setdefault(unicodedata.normalize("NFC", here[0]).casefold(), here)
            if there != here:
                raise FmuError(f"collides with {there[0]!r} where case is ignored", file=path, entry=repr(name))
        if here[0] in listed:
            raise FmuError("occurs twice in the archive", file=path, entry=repr(name))
        listed.add(here[0])


def _entry_problem(entry: zipfile.ZipInfo, parts: list[str]) -> str:
    """Why one entry is refused, or ""."""
    name, mode = entry.orig_filename, entry.external_attr >> 16
    if name.startswith("/") or re.match("[A-Za-z]:", name):
        return "is an absolute path"
    if ".." in parts:
        return "leaves the archive's directory"
    if re.search(r"[\\:\x00-\x1f]", name) or any(part.strip() in ("", ".") or part[-1] in ". " for part in parts):
        return "is not a portable name: expected words separated by '/'"
    if stat.S_IFMT(mode) not in (0, stat.S_IFREG, stat.S_IFDIR):
        return "is a symbolic link" if stat.S_ISLNK(mode) else "is not a regular file"
    if entry.flag_bits & 1:
        return "is encrypted"
    if entry.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
        return f"is compressed by method {entry.compress_type}: FMI allows stored and deflated"
    return ""


def _unpack(archive: zipfile.ZipFile, target: Path) -> None:
    """Write every entry below ``target``; reading to the end checks length and CRC."""
    for entry in archive.infolist():
        place = target.joinpath(*entry.orig_filename.split("/"))
        if entry.is_dir():
            place.mkdir(parents=True, exist_ok=True)
            continue
        place.parent.mkdir(parents=True, exist_ok=True)
        with archive.open(entry) as packed, open(place, "xb") as unpacked:
            shutil.copyfileobj(packed, unpacked)


def _holds(directory: Path, archive: zipfile.ZipFile) -> bool:
    """Whether the directory has every file of the archive, unchanged; what a unit adds at run time is no matter."""
    for entry in archive.infolist():
        place = directory.joinpath(*entry.orig_filename.split("/"))
        if entry.is_dir():
            continue
        if place.is_symlink() or not place.is_file() or place.stat().st_size != entry.file_size:
            return False
        if zlib.crc32(place.read_bytes()) != entry.CRC:
            return False
    return True


def _parse(path: Path, data: bytes) -> ElementTree.Element:
    """The root element; a DOCTYPE is refused before any entity of it is looked at."""

    def refuse(*_: object) -> None:
        raise FmuError("contains a DOCTYPE, which FMI does not need: refused", file=path, entry=_DESCRIPTION)

    builder, parser = ElementTree.TreeBuilder(), expat.ParserCreate()
    parser.buffer_text = True
    parser.StartDoctypeDeclHandler = refuse
    parser.StartElementHandler = builder.start
    parser.EndElementHandler = builder.end
    try:
        parser.Parse(data, True)
        return builder.close()
    except (expat.ExpatError, ValueError, LookupError, AssertionError) as error:
        raise FmuError(f"is not well-formed XML: {error}", file=path, entry=_DESCRIPTION) from error


def _describe(path: Path, archive: zipfile.ZipFile) -> Description:
    """Read modelDescription.xml and the list of binaries."""
    names = archive.namelist()
    if _DESCRIPTION not in names:
        raise FmuError(f"no {_DESCRIPTION} at the top of the archive: is it an FMU?", file=path)
    if archive.getinfo(_DESCRIPTION).file_size > MAX_XML:
        raise FmuError(f"larger than {MAX_XML >> 20} MB", file=path, entry=_DESCRIPTION)
    root = _parse(path, archive.read(_DESCRIPTION))
    try:
        return _Reader(root).description(path, names)
    except _Invalid as error:
        raise FmuError(str(error), file=path, entry=_DESCRIPTION) from None


class _Invalid(Exception):
    """A model description that breaks FMI 2.0."""


def _number(element: ElementTree.Element, key: str, as_type: Callable[[str], T]) -> T | None:
    text = element.get(key)
    try:
        return None if text is None else as_type(text)
    except ValueError:
        where = f"'{element.get('name')}': " if element.get("name") else ""
        raise _Invalid(f"{where}{element.tag} has {key}={text!r}, expected {as_type.__name__.strip('_')}") from None


def _boolean(text: str) -> bool:
    if text not in ("true", "false", "1", "0"):
        raise ValueError
    return text in ("true", "1")


_VALUES: dict[str, Callable[[str], Value]] = {
    "Real": float, "Integer": int, "Boolean": _boolean, "String": str, "Enumeration": int,
}  # fmt: skip


class _Reader:
    """Reads one parsed model description."""

    def __init__(self, root: ElementTree.Element) -> None:
        self.root = root
        self.types: dict[str, ElementTree.Element] = {}
        for simple in root.iterfind("TypeDefinitions/SimpleType"):
            self.types |= {simple.get("name", ""): child for child in simple if child.tag in _KINDS}

    def description(self, path: Path, names: list[str]) -> Description:
        root = self.root
        if root.tag != "fmiModelDescription":
            raise _Invalid(f"root element is {root.tag!r}, expected 'fmiModelDescription'")
        version, unit = root.get("fmiVersion"), root.find("CoSimulation")
        if version != "2.0":
            raise _Invalid(f"FMI version {version!r} is not supported, expected '2.0': export the model as FMI 2.0")
        if unit is None:
            raise _Invalid("no CoSimulation element: model exchange is not supported, export for co-simulation")
        identifier = unit.get("modelIdentifier", "")
        if not re.fullmatch("[A-Za-z_][A-Za-z0-9_]*", identifier):
            raise _Invalid(f"modelIdentifier {identifier!r} is not a C identifier")
        missing = [key for key in ("modelName", "guid") if not root.get(key)]
        if missing:
            raise _Invalid(f"required attribute {missing[0]!r} is missing")
        variables = tuple(map(self.variable, root.iterfind("ModelVariables/ScalarVariable")))
        seen: set[str] = set()
        for variable in variables:
            if variable.name in seen:
                raise _Invalid(f"variable {variable.name!r} is declared twice")
            seen.add(variable.name)
        experiment = root.find("DefaultExperiment")
        times = () if experiment is None else ("startTime", "stopTime", "tolerance", "stepSize")
        libraries = (re.fullmatch(rf"binaries/([^/]+)/{identifier}(\.so|\.dll|\.dylib)", name) for name in names)
        return Description(
            path=path,
            fmi_version=version,
            model_name=root.get("modelName", ""),
            guid=root.get("guid", ""),
            model_identifier=identifier,
            generation_tool=root.get("generationTool", ""),
            can_get_set_state=self.flag(unit, "canGetAndSetFMUstate"),
            can_serialize_state=self.flag(unit, "canSerializeFMUstate"),
            can_interpolate_inputs=self.flag(unit, "canInterpolateInputs"),
            max_output_derivative_order=_number(unit, "maxOutputDerivativeOrder", int) or 0,
            can_handle_variable_step=self.flag(unit, "canHandleVariableCommunicationStepSize"),
            needs_execution_tool=self.flag(unit, "needsExecutionTool"),
            default_experiment=DefaultExperiment(*(_number(experiment, key, float) for key in times))
            if experiment is not None
            else DefaultExperiment(),
            variables=variables,
            dependencies=self.dependencies(variables),
            units=dict(map(self.unit, root.iterfind("UnitDefinitions/Unit[BaseUnit]"))),
            platforms=tuple(sorted({match[1] for match in libraries if match})),
        )

    @staticmethod
    def flag(element: ElementTree.Element, key: str) -> bool:
        return bool(_number(element, key, _boolean))

    @staticmethod
    def unit(element: ElementTree.Element) -> tuple[str, UnitDefinition]:
        base = element.find("BaseUnit")
        assert base is not None
        factor, offset = _number(base, "factor", float), _number(base, "offset", float) or 0.0
        exponents = tuple(_number(base, key, int) or 0 for key in BASES)
        if factor == 0.0 or not math.isfinite(factor or 1.0) or not math.isfinite(offset):
            raise _Invalid(f"unit {element.get('name')!r} has factor {factor} and offset {offset}")
        return element.get("name", ""), UnitDefinition(exponents, 1.0 if factor is None else factor, offset)

    def variable(self, element: ElementTree.Element) -> Variable:
        name = element.get("name", "")
        kinds = [child for child in element if child.tag in _KINDS]
        reference = _number(element, "valueReference", int)
        if not name or reference is None or not 0 <= reference < 2**32 or len(kinds) != 1:
            raise _Invalid(f"variable {name!r} needs a name, a value reference from 0 to 2^32 - 1 and exactly one type")
        own, causality = kinds[0], element.get("causality", "local")
        declared = own.get("declaredType")
        if declared is not None and (declared not in self.types or self.types[declared].tag != own.tag):
            raise _Invalid(f"variable {name!r} has declaredType {declared!r}, which is no {own.tag} of TypeDefinitions")
        kind = ElementTree.Element(own.tag, {**(self.types[declared].attrib if declared else {}), **own.attrib})
        kind.attrib.pop("name", None)
        variability = element.get("variability", "continuous")
        exact = variability == "constant"
        return Variable(
            name=name,
            value_reference=reference,
            type=_KINDS[own.tag],
            causality=causality,
            variability=variability,
            initial=element.get("initial") or _INITIAL.get(causality, "exact" if exact else "calculated"),
            start=_number(kind, "start", _VALUES[own.tag]),
            unit=kind.get("unit"),
            display_unit=kind.get("displayUnit"),
            min=_number(kind, "min", float),
            max=_number(kind, "max", float),
            nominal=_number(kind, "nominal", float),
            description=element.get("description", ""),
        )

    def dependencies(self, variables: tuple[Variable, ...]) -> dict[str, tuple[str, ...] | None]:
        """Direct dependencies of the outputs, on inputs only."""

        def at(index: str) -> Variable:
            if not index.isdecimal() or not 1 <= int(index) <= len(variables):
                raise _Invalid(f"ModelStructure names variable {index!r}, expected 1 to {len(variables)}")
            return variables[int(index) - 1]

        result: dict[str, tuple[str, ...] | None] = {v.name: None for v in variables if v.causality == "output"}
        for unknown in self.root.iterfind("ModelStructure/Outputs/Unknown"):
            output, declared = at(unknown.get("index", "")), unknown.get("dependencies")
            if output.name not in result:
                raise _Invalid(f"ModelStructure lists {output.name!r} as an output, but its causality is not")
            if declared is not None:
                known = map(at, declared.split())
                result[output.name] = tuple(v.name for v in known if v.causality == "input")
        return result


def _platform() -> tuple[str, str]:
    """FMI 2.0's name of this platform and the suffix of its libraries."""
    suffix = {"win32": ".dll", "cygwin": ".dll", "darwin": ".dylib"}.get(sys.platform, ".so")
    return f"{_SUFFIXES[suffix]}{64 if sys.maxsize > 2**32 else 32}", suffix


def _binary_problem(data: bytes) -> str:
    """Why the loader of this platform cannot take the library, or "".

    Only headers and extents are looked at: a segment that ends beyond the file would be SIGBUS, not an error.
    """
    import platform  # of the host, looked at here only: costs 3 ms to import

    arm = platform.machine().lower() in ("arm64", "aarch64")
    check = {".so": _elf_problem, ".dll": _pe_problem, ".dylib": _macho_problem}[_platform()[1]]
    try:
        return check(data, arm)
    except struct.error:
        return "truncated header"


def _elf_problem(data: bytes, arm: bool) -> str:
    if data[:4] != b"\x7fELF":
        return "no ELF header"
    if data[4:6] != b"\x02\x01":
        return "not 64-bit little-endian ELF"
    kind, machine = struct.unpack_from("<HH", data, 16)
    programs, sections = struct.unpack_from("<QQ", data, 32)
    program_size, program_count, section_size, section_count = struct.unpack_from("<HHHH", data, 54)
    if machine != (183 if arm else 62):
        return f"ELF for another processor (e_machine {machine})"
    if kind != 3:
        return f"ELF, but no shared object (e_type {kind})"
    tables = max(programs + program_size * program_count, sections + section_size * section_count)
    if tables > len(data) or not program_count or program_size < 56:
        return "truncated: header tables lie beyond the end of the file"
    for index in range(program_count):
        offset, _, _, size = struct.unpack_from("<QQQQ", data, programs + program_size * index + 8)
        if size and offset + size > len(data):
            return "truncated: a segment ends beyond the end of the file"
    return ""


def _pe_problem(data: bytes, arm: bool) -> str:
    (start,) = struct.unpack_from("<I", data, 60)
    if data[:2] != b"MZ" or data[start : start + 4] != b"PE\0\0":
        return "no PE header"
    machine, sections = struct.unpack_from("<HH", data, start + 4)
    (optional,) = struct.unpack_from("<H", data, start + 20)
    if machine != (0xAA64 if arm else 0x8664):
        return f"PE for another processor (machine {machine:#x})"
    for index in range(sections):
        size, offset = struct.unpack_from("<II", data, start + 24 + optional + 40 * index + 16)
        if offset + size > len(data):
            return "truncated: a section ends beyond the end of the file"
    return ""


def _macho_problem(data: bytes, arm: bool) -> str:
    processor = 0x0100000C if arm else 0x01000007
    if data[:4] == b"\xca\xfe\xba\xbe":
        for index in range(min(struct.unpack_from(">I", data, 4)[0], 64)):
            kind, _, offset, size = struct.unpack_from(">IIII", data, 8 + 20 * index)
            if kind == processor:
                return _macho_problem(data[offset : offset + size], arm) if offset + size <= len(data) else "truncated"
        return "no slice for this processor"
    if data[:4] != b"\xcf\xfa\xed\xfe":
        return "no 64-bit Mach-O header"
    (kind,) = struct.unpack_from("<I", data, 4)
    commands, size = struct.unpack_from("<II", data, 16)
    if kind != processor:
        return f"Mach-O for another processor (type {kind:#x})"
    if 32 + size > len(data):
        return "truncated: load commands end beyond the end of the file"
    place = 32
    for _ in range(commands):
        command, length = struct.unpack_from("<II", data, place)
        if command == 0x19 and sum(struct.unpack_from("<QQ", data, place + 40)) > len(data):
            return "truncated: a segment ends beyond the end of the file"
        place += max(length, 8)
    return ""
