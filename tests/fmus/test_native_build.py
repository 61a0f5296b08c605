"""The native archive: what it declares and exports, and that it follows from the sources alone."""

from __future__ import annotations

import os
import re
import struct
import subprocess
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path
from xml.etree import ElementTree

import fmpy
import pytest
from fmpy.validation import validate_fmu

from towage.fmus.declare.unit import BuildError, load
from towage.fmus.native import build as native_build
from towage.fmus.native import compiler
from towage.fmus.native.build import build
from towage.fmus.native.trace import trace
from towage.fmus.native.universal import universal

from .cases import NATIVE

ROOT = Path(__file__).resolve().parents[2]
Built = Callable[[str, int], Path]


@pytest.fixture
def built(native: Built) -> Built:
    return native


def binary(path: Path) -> bytes:
    with zipfile.ZipFile(path) as archive:
        (name,) = (n for n in archive.namelist() if n.startswith("binaries/"))
        return archive.read(name)


@pytest.mark.parametrize("fmi", [2, 3])
@pytest.mark.parametrize("name", NATIVE)
def test_validator_reports_nothing(name: str, fmi: int, built: Built) -> None:
    path = built(name, fmi)
    assert validate_fmu(str(path)) == []
    description = fmpy.read_model_description(str(path), validate=True)
    # a wire steps by itself
    assert description.coSimulation and bool(description.modelExchange) != bool(load(name).model.numbers)
    assert description.fmiVersion == f"{fmi}.0"


@pytest.mark.parametrize("name", NATIVE)
def test_shared_variables_are_those_of_the_python_flavour(name: str, built: Built) -> None:
    """Same names and references; more only behind them: states, their derivatives, extras."""
    unit, description = load(name), fmpy.read_model_description(str(built(name, 2)))
    names = [v.name for v in description.modelVariables]
    shared = len(unit.variables)
    assert names[:shared] == [v.name for v in unit.variables]
    assert [v.valueReference for v in description.modelVariables] == list(range(len(names)))
    rates = [i for i, v in enumerate(description.modelVariables) if v.derivative is not None]
    states = range(shared, shared + len(rates))
    assert rates == [k + len(rates) for k in states]
    assert all(names[k].startswith("state") for k in states)
    assert [names[k] for k in rates] == [f"der({names[k]})" for k in states]


def test_structure_of_the_cradle(built: Built) -> None:
    """By hand from its equations: y' = v, v' = (T - W - b |v| v)/M; docking may change v, and through it the outputs."""
    description = fmpy.read_model_description(str(built("cradle", 2)))
    assert description.numberOfEventIndicators == 1

    def known(unknowns: list[fmpy.model_description.Unknown]) -> dict[str, set[str]]:
        return {u.variable.name: {d.name for d in u.dependencies} for u in unknowns}

    assert known(description.derivatives) == {
        "der(state.heave)": {"state.velocity"}, "der(state.velocity)": {"state.velocity", "line_tension"},
    }  # fmt: skip
    assert known(description.outputs) == {
        "heave": {"state.heave"},
        "velocity": {"state.velocity", "submersible_velocity"},
        "acceleration": {"state.velocity", "line_tension", "submersible_velocity"},
        "margin_drag_reynolds": {"state.velocity", "submersible_velocity"},
    }
    with zipfile.ZipFile(built("cradle", 2)) as archive:
        root = ElementTree.fromstring(archive.read("modelDescription.xml"))
    assert [v.attrib["name"] for v in root.iter("ScalarVariable") if v.find("Real[@reinit]") is not None] == ["state.velocity"]


@pytest.mark.skipif(sys.platform != "linux", reason="reads the table of an ELF file with nm")
@pytest.mark.parametrize("fmi", [2, 3])
def test_only_the_standard_is_exported(fmi: int, built: Built, tmp_path: Path) -> None:
    (tmp_path / "library.so").write_bytes(binary(built("cradle_on_line", fmi)))
    command = ["nm", "-D", "--defined-only", str(tmp_path / "library.so")]
    table = subprocess.run(command, check=True, capture_output=True, text=True, timeout=60).stdout
    names = {line.split()[-1] for line in table.splitlines()}
    # every function of the standard is declared there as: FMI2_Export fmi2ResetTYPE fmi2Reset;
    header = (ROOT / "fmus" / "native" / "runtime" / f"fmi{fmi}" / f"fmi{fmi}Functions.h").read_text()
    assert names == set(re.findall(rf"\bfmi{fmi}\w+TYPE\s+(fmi{fmi}\w+);", header)) and len(names) > 40


@pytest.mark.parametrize("fmi", [2, 3])
def test_sources_compile_on_their_own(fmi: int, built: Built, tmp_path: Path) -> None:
    """As the archive says how, by any C99 compiler, without this project."""
    with zipfile.ZipFile(built("ship", fmi)) as archive:
        archive.extractall(tmp_path)
    if fmi == 2:
        root = ElementTree.parse(tmp_path / "modelDescription.xml").getroot()
        lists = [[f.attrib["name"] for f in kind.iter("File")] for kind in root.iter() if kind.find("SourceFiles") is not None]
        files, other = lists
        assert files == other
    else:
        root = ElementTree.parse(tmp_path / "sources" / "buildDescription.xml").getroot()
        files = [f.attrib["name"] for f in root.iter("SourceFile")]
    assert sorted(files) == sorted(path.name for path in (tmp_path / "sources").glob("*.c"))
    subprocess.run(
        ["cc", "-std=c99", "-fPIC", "-shared", "-Werror", *files, "-lm", "-o", "ship.so"],
        cwd=tmp_path / "sources", check=True, timeout=120,
    )  # fmt: skip


def build_elsewhere(out: Path, *units: str, without: tuple[str, ...] = ()) -> None:
    """By the command, in another process, with another order of hashes."""
    environment = {k: v for k, v in os.environ.items() if k not in without} | {"PYTHONHASHSEED": "3"}
    subprocess.run(
        [sys.executable, "build_fmus.py", *units, "--flavour", "native", "--out", str(out)],
        cwd=ROOT, check=True, capture_output=True, timeout=300, env=environment,
    )  # fmt: skip


def test_two_builds_are_byte_identical(tmp_path: Path, native: Built) -> None:
    """In another process, in another directory, with another order of hashes; and no path is in it."""
    build_elsewhere(tmp_path, *NATIVE)
    for name in NATIVE:
        again = tmp_path / f"{name}.fmu"
        assert again.read_bytes() == native(name, 2).read_bytes()
        with zipfile.ZipFile(again) as archive:
            everything = b"".join(archive.read(n) for n in archive.namelist())
        for path in (ROOT, tmp_path, Path.home()):
            assert str(path).encode() not in everything


def test_two_compilations_are_byte_identical(tmp_path: Path, native: Built) -> None:
    """By the host's compiler itself, where the tests keep what it made once (`caching_compiler`)."""
    build_elsewhere(tmp_path, "cradle", without=("CC",))
    assert (tmp_path / "cradle.fmu").read_bytes() == native("cradle", 2).read_bytes()


def test_only_what_changed_is_built(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path, written = build("ship", tmp_path)
    good = path.read_bytes()
    assert written
    assert build("ship", tmp_path) == (path, False)
    middle = len(good) // 2
    for damage in (good[:middle], good[:middle] + bytes([good[middle] ^ 1]) + good[middle + 1 :]):
        path.write_bytes(damage)
        assert build("ship", tmp_path) == (path, True)
        assert path.read_bytes() == good
    traced: list[str] = []
    monkeypatch.setattr(native_build, "trace", lambda unit, structure: traced.append(unit.name) or trace(unit, structure))
    assert build("ship", tmp_path) == (path, False) and not traced, "nothing is traced that is up to date"
    path.write_bytes(good[: len(good) // 2])
    assert build("ship", tmp_path) == (path, True) and traced == ["ship"]
    monkeypatch.setattr(compiler, "FLAGS", (*compiler.FLAGS, "-O1"))
    assert build("ship", tmp_path) == (path, True), "other flags, another library"


def test_token_follows_from_the_content(built: Built) -> None:
    """It is the same in the description and in the library, and another for every unit and version."""
    tokens = set()
    for name, fmi in (("ship", 2), ("ship", 3), ("cradle", 2)):
        description = fmpy.read_model_description(str(built(name, fmi)))
        token = description.guid or description.instantiationToken
        assert token.encode() in binary(built(name, fmi))
        tokens.add(token)
    assert len(tokens) == 3


def test_without_a_compiler_the_message_says_what_to_do(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CC", "no-such-cc")
    with pytest.raises(BuildError, match="CC = no-such-cc: there is no program"):
        build("ship", tmp_path)
    monkeypatch.delenv("CC")
    monkeypatch.setattr(compiler.shutil, "which", lambda name: None)
    monkeypatch.setattr(compiler.importlib.util, "find_spec", lambda name: None)
    with pytest.raises(BuildError, match=r"no C compiler on this machine: pip install 'towage\[native\]'"):
        build("ship", tmp_path)
    with pytest.raises(BuildError, match="unknown platform amiga: there are host, all, x86_64-linux"):
        build("ship", tmp_path, platforms="amiga")
    assert list(tmp_path.iterdir()) == []


def test_a_compiler_that_fails_is_quoted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("CC", raising=False)
    with pytest.raises(BuildError, match=r"(?s)^cc .*unit\.c.*\nended with 1:.*‘g’|'g'"):
        compiler.library({"unit.c": b"int f(void) { return g; }"}, "ship", compiler.host())


def test_time_of_linking_is_taken_out() -> None:
    """Layout of a PE file: the header's place at 0x3c, its signature, machine, number of sections, the time."""
    head = bytes(0x3C) + struct.pack("<I", 0x80) + bytes(0x40)
    libraries = [head + b"PE\0\0" + struct.pack("<HHI", 0x8664, 7, time) + b"rest" for time in (0, 1_795_323_267)]
    assert compiler.timeless(libraries[1]) == libraries[0]
    with pytest.raises(BuildError, match="no Windows library"):
        compiler.timeless(bytes(200))


def test_universal_file_holds_its_slices(tmp_path: Path) -> None:
    """Read back by the layout of ``mach-o/fat.h``."""
    slices = [struct.pack("<Iii", 0xFEEDFACF, cpu, kind) + os.urandom(40_000) for cpu, kind in ((0x01000007, 3), (0x0100000C, 0))]
    joined = universal(slices)
    magic, count = struct.unpack_from(">II", joined)
    assert (magic, count) == (0xCAFEBABE, 2)
    for k, data in enumerate(slices):
        cpu, kind, offset, size, align = struct.unpack_from(">iiIII", joined, 8 + 20 * k)
        assert (cpu, kind) == struct.unpack_from("<ii", data, 4)
        assert offset % (1 << align) == 0 and joined[offset : offset + size] == data
    with pytest.raises(ValueError, match="not a 64-bit Mach-O file: it begins with 7f454c46"):
        universal([b"\x7fELF" + bytes(100)])


def test_a_build_whose_start_values_are_refused_has_no_reference_result(tmp_path: Path) -> None:
    """A cable that stretches starts with no stiffness: the FMU is built, and its page says why the result is missing."""
    path, written = build("tow_system", tmp_path, structure={"segments": 3.0, "extensible": 1.0})
    assert written
    with zipfile.ZipFile(path) as archive:
        assert "documentation/tow_system_ref.csv" not in archive.namelist()
        assert "no reference run" in archive.read("documentation/index.html").decode()
