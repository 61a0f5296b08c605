"""Hostile and broken FMUs are refused by name, before anything of them is unpacked or run; sound ones are read."""

from __future__ import annotations

import os
import platform
import random
import stat
import struct
import subprocess
import sys
import zipfile
from pathlib import Path

import msgspec
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from towage.errors import FmuError
from towage.units import archive, binary, description
from towage.units.archive import check_platform, extract, library_of, read_description

from .faults.boxes import (
    BROKEN_LIBRARIES,
    DOCTYPE,
    HOSTILE_NAMES,
    INVALID_DESCRIPTIONS,
    build,
    declare_size,
    elf,
    with_entry,
    xml,
)


@pytest.fixture(autouse=True)
def linux(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(binary, "platform_name", lambda: ("linux64", ".so"))


def assert_refused(path: Path, says: str, description_too: bool = True) -> None:
    target = path.parent / "unpacked"
    if description_too:
        with pytest.raises(FmuError, match=says):
            read_description(path)
    with pytest.raises(FmuError, match=says) as caught:
        extract(path, target)
    assert str(path) in str(caught.value)
    assert [entry.name for entry in path.parent.iterdir()] == [path.name], "something was unpacked"


def test_description(tmp_path: Path) -> None:
    d = read_description(build(tmp_path / "box.fmu"))
    assert (d.fmi_version, d.model_name, d.guid, d.model_identifier) == ("2.0", "Box", "{1-2}", "box")
    assert d.generation_tool == "by hand" and d.platforms == ("linux64",)
    assert d.can_get_set_state and d.can_serialize_state and d.can_interpolate_inputs and d.can_handle_variable_step
    assert d.max_output_derivative_order == 2 and not d.needs_execution_tool
    experiment = d.default_experiment
    assert (experiment.start_time, experiment.stop_time, experiment.tolerance, experiment.step_size) == (
        0,
        10,
        None,
        0.1,
    )
    assert d.dependencies == {"depth": (), "count": None, "pull": ("force",)}
    assert d.units["m"] == description.UnitDefinition((0, 1, 0, 0, 0, 0, 0, 0), 1.0, 0.0)
    assert d.units["degC"].offset == 273.15 and "bare" not in d.units


def test_variables_with_what_their_type_adds(tmp_path: Path) -> None:
    v = read_description(build(tmp_path / "box.fmu")).by_name()
    depth = v["depth"]
    assert (depth.unit, depth.display_unit, depth.min, depth.max, depth.nominal) == ("m", "ft", -10.0, 1.0, 5.0)
    assert (depth.type, depth.value_reference, depth.causality, depth.variability) == (
        "Real",
        1,
        "output",
        "continuous",
    )
    assert [v[name].start for name in ("force", "on", "label", "depth")] == [0.0, True, " a ", None]
    assert [v[name].initial for name in ("force", "on", "depth")] == ["", "exact", "calculated"]
    assert v["force"].description == "Force" and v["force"].unit == "N" and v["pull"].unit is None


def test_extract(tmp_path: Path) -> None:
    path = build(tmp_path / "box.fmu", resources__data__table=b"1 2 3")
    extract(path, tmp_path / "cache" / "box")
    assert (tmp_path / "cache/box/resources/data/table").read_bytes() == b"1 2 3"
    assert (tmp_path / "cache/box/binaries/linux64/box.so").read_bytes() == elf()
    assert os.listdir(tmp_path / "cache") == ["box"]


def test_extract_into_an_empty_directory(tmp_path: Path) -> None:
    (tmp_path / "box").mkdir()
    extract(build(tmp_path / "box.fmu"), tmp_path / "box")
    assert (tmp_path / "box/modelDescription.xml").is_file()


def test_extract_again_keeps_what_is_there_and_refuses_another_fmu(tmp_path: Path) -> None:
    path, target = build(tmp_path / "box.fmu"), tmp_path / "box"
    extract(path, target)
    (target / "log.txt").write_text("written by the unit")
    extract(path, target)
    assert (target / "log.txt").exists()
    with pytest.raises(FmuError, match="holds something else"):
        extract(build(tmp_path / "other.fmu", xml('author="x"')), target)
    (target / "binaries/linux64/box.so").write_bytes(b"tampered".ljust(512))
    with pytest.raises(FmuError, match="holds something else"):
        extract(path, target)
    assert sorted(os.listdir(tmp_path)) == ["box", "box.fmu", "other.fmu"]


EXTRACT = """
import sys
from pathlib import Path
from towage.units import archive, binary

binary.platform_name = lambda: ("linux64", ".so")
for _ in range(20):
    archive.extract(Path(sys.argv[1]), Path(sys.argv[2]))
"""


def test_processes_that_extract_at_once_all_succeed(tmp_path: Path) -> None:
    path = build(tmp_path / "box.fmu", resources__noise=random.Random(1).randbytes(2_000_000))
    command = [sys.executable, "-c", EXTRACT, str(path), str(tmp_path / "box")]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(entry or os.getcwd() for entry in sys.path)}
    workers = [subprocess.Popen(command, env=environment) for _ in range(3)]
    assert [worker.wait(60) for worker in workers] == [0, 0, 0]
    assert sorted(os.listdir(tmp_path)) == ["box", "box.fmu"]


def test_loser_of_a_race_succeeds(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path, target, unpack = build(tmp_path / "box.fmu"), tmp_path / "box", archive._unpack

    def overtaken(fmu: zipfile.ZipFile, scratch: Path) -> None:
        monkeypatch.setattr(archive, "_unpack", unpack)
        extract(path, target)
        unpack(fmu, scratch)

    monkeypatch.setattr(archive, "_unpack", overtaken)
    extract(path, target)
    assert sorted(os.listdir(tmp_path)) == ["box", "box.fmu"]


@pytest.mark.parametrize(("name", "says"), HOSTILE_NAMES)
def test_hostile_names(tmp_path: Path, name: str, says: str) -> None:
    assert_refused(with_entry(tmp_path / "box.fmu", name), says)


def test_nul_in_a_name(tmp_path: Path) -> None:
    path = with_entry(tmp_path / "box.fmu", "resources/aZb")
    path.write_bytes(path.read_bytes().replace(b"resources/aZb", b"resources/a\0b"))
    assert_refused(path, "portable|damaged")


def test_names_that_differ_in_unicode_form_only(tmp_path: Path) -> None:
    assert_refused(with_entry(tmp_path / "box.fmu", "resources/\u00e9", "resources/e\u0301"), "collides")


@pytest.mark.filterwarnings("ignore:Duplicate name")
def test_duplicate_names(tmp_path: Path) -> None:
    """With one content they are taken once, with a warning, as in the Roberts of the Reference-FMUs."""
    assert_refused(with_entry(tmp_path / "box.fmu", "resources/a", "resources/a"), "occurs twice")
    path = with_entry(tmp_path / "sound.fmu", "resources/a", "resources/b", "resources/a")
    with zipfile.ZipFile(path, "a") as fmu:
        fmu.writestr("extra/", b"")
        fmu.writestr("extra/", b"")
    assert "resources/a twice, with the same content: taken once" in "".join(read_description(path).warnings)
    assert "extra" not in "".join(read_description(path).warnings)


@pytest.mark.parametrize(("mode", "says"), [(stat.S_IFLNK, "symbolic link"), (stat.S_IFIFO, "regular file")])
def test_links_and_devices(tmp_path: Path, mode: int, says: str) -> None:
    entry = zipfile.ZipInfo("resources/link")
    entry.external_attr = (mode | 0o777) << 16
    assert_refused(with_entry(tmp_path / "box.fmu", entry), says)


def test_other_compression(tmp_path: Path) -> None:
    entry = zipfile.ZipInfo("resources/a")
    entry.compress_type = zipfile.ZIP_LZMA
    assert_refused(with_entry(tmp_path / "box.fmu", entry), "method 14")


def test_encrypted_entry(tmp_path: Path) -> None:
    path = build(tmp_path / "box.fmu")
    data = bytearray(path.read_bytes())
    data[data.index(b"PK\x01\x02") + 8] |= 1
    path.write_bytes(data)
    assert_refused(path, "encrypted")


def test_too_many_entries(tmp_path: Path) -> None:
    assert_refused(with_entry(tmp_path / "box.fmu", *(f"resources/{i}" for i in range(10_000))), "more than 10000")


def test_bomb_by_size(tmp_path: Path) -> None:
    path = build(tmp_path / "box.fmu", resources__zeros=b"\0" * 1000)
    declare_size(path, b"resources/zeros", 600 * 2**20)
    assert_refused(path, "over 512: refused as a bomb")


def test_bomb_by_ratio(tmp_path: Path) -> None:
    assert_refused(build(tmp_path / "box.fmu", resources__zeros=bytes(20 * 2**20)), "times its size: refused as a bomb")


def test_bomb_that_understates_its_size(tmp_path: Path) -> None:
    path = build(tmp_path / "box.fmu", resources__zeros=bytes(20 * 2**20))
    declare_size(path, b"resources/zeros", 1000)
    assert_refused(path, "damaged", description_too=False)


def test_small_file_of_zeros_is_no_bomb(tmp_path: Path) -> None:
    path = build(tmp_path / "box.fmu", resources__zeros=bytes(4 * 2**20))
    assert 200 * path.stat().st_size < 4 * 2**20
    extract(path, tmp_path / "box")
    assert (tmp_path / "box/resources/zeros").stat().st_size == 4 * 2**20


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16"])
def test_doctype(tmp_path: Path, encoding: str) -> None:
    head, rest = xml().replace("UTF-8", encoding).split("?>", 1)
    assert_refused(build(tmp_path / "box.fmu", (head + "?>" + DOCTYPE + rest).encode(encoding)), "DOCTYPE")


@pytest.mark.parametrize("cut", [0, 10, 100, 400, -1, -30])
def test_truncated_archive(tmp_path: Path, cut: int) -> None:
    path = build(tmp_path / "box.fmu")
    path.write_bytes(path.read_bytes()[:cut])
    assert_refused(path, "damaged or truncated")


def test_crc_error(tmp_path: Path) -> None:
    noise = random.Random(1).randbytes(5000)
    path = build(tmp_path / "box.fmu", resources__noise=noise)
    path.write_bytes(path.read_bytes().replace(noise[2000:2010], bytes(10)))
    assert read_description(path).model_name == "Box"
    assert_refused(path, "damaged or truncated archive .*CRC", description_too=False)


def test_no_file_and_a_directory(tmp_path: Path) -> None:
    for path, says in ((tmp_path / "none.fmu", "no such file"), (tmp_path, "cannot be read")):
        with pytest.raises(FmuError, match=says):
            read_description(path)


def test_missing_description(tmp_path: Path) -> None:
    with zipfile.ZipFile(tmp_path / "box.fmu", "w") as fmu:
        fmu.writestr("sub/modelDescription.xml", xml())
    assert_refused(tmp_path / "box.fmu", r"no modelDescription\.xml")


@pytest.mark.parametrize(("description", "says"), INVALID_DESCRIPTIONS)
def test_invalid_description(tmp_path: Path, description: str, says: str) -> None:
    assert description != xml()
    assert_refused(build(tmp_path / "box.fmu", description), says)


def test_no_binary_for_this_platform(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = build(tmp_path / "box.fmu")
    monkeypatch.setattr(binary, "platform_name", lambda: ("darwin64", ".dylib"))
    with pytest.raises(FmuError, match=r"no binary for darwin64 .*present: linux64\. "):
        check_platform(read_description(path))
    assert_refused(path, "no binary for darwin64", description_too=False)


def test_platforms_count_only_libraries_of_the_model(tmp_path: Path) -> None:
    path = with_entry(tmp_path / "box.fmu", "binaries/win64/box.dll", "binaries/win32/other.dll", "binaries/darwin64/")
    assert read_description(path).platforms == ("linux64", "win64")
    assert check_platform(read_description(path)) == "linux64"


INTEL, ARM = elf(62), elf(183)


@pytest.mark.parametrize(("machine", "libraries", "taken"), [
    ("aarch64", {"linux64": INTEL, "aarch64-linux": ARM}, "aarch64-linux"),
    ("arm64", {"linux64": ARM}, "linux64"),  # as OpenModelica builds it there
    ("aarch64", {"aarch64-linux": ARM}, "aarch64-linux"),
    ("x86_64", {"linux64": INTEL, "aarch64-linux": ARM}, "linux64"),
    ("x86_64", {"x86_64-linux": INTEL}, "x86_64-linux"),
    ("aarch64", {"linux64": INTEL}, "ELF for another processor"),
    ("x86_64", {"aarch64-linux": ARM}, "no binary for linux64 .*box.so or binaries/x86_64-linux/box.so.; present: aarch64-linux"),
    ("aarch64", {"win64": INTEL}, "no binary for aarch64-linux .*box.so or binaries/linux64/box.so.; present: win64"),
])  # fmt: skip
def test_the_library_for_this_processor_is_found_where_tools_put_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, machine: str, libraries: dict[str, bytes], taken: str
) -> None:
    monkeypatch.setattr("platform.machine", lambda: machine)
    path = tmp_path / "box.fmu"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("modelDescription.xml", xml())
        for folder, library in libraries.items():
            archive.writestr(f"binaries/{folder}/box.so", library)
    if taken not in libraries:
        with pytest.raises(FmuError, match=taken):
            extract(path, tmp_path / "unpacked")
        return
    extract(path, tmp_path / "unpacked")
    assert library_of(read_description(path), tmp_path / "unpacked").read_bytes() == libraries[taken]


@pytest.mark.parametrize(("library", "says"), BROKEN_LIBRARIES)
def test_truncated_or_foreign_elf(tmp_path: Path, library: bytes, says: str) -> None:
    assert_refused(build(tmp_path / "box.fmu", library=library), says, description_too=False)


def pe(machine: int = 0x8664, size: int = 512) -> bytes:
    head = (
        b"MZ".ljust(60, b"\0") + struct.pack("<I", 64) + b"PE\0\0" + struct.pack("<HHIIIHH", machine, 1, 0, 0, 0, 0, 0)
    )
    return (head + b".text\0\0\0" + struct.pack("<IIII", 0, 0, 200, 312)).ljust(size, b"\0")


def mach_o(processor: int = 0x01000007, size: int = 512) -> bytes:
    head = struct.pack("<IIIIIIII", 0xFEEDFACF, processor, 3, 6, 1, 72, 0, 0)
    return (head + struct.pack("<II16sQQQQIIII", 0x19, 72, b"", 0, 0, 0, 512, 0, 0, 0, 0)).ljust(size, b"\0")


def fat(*slices: tuple[int, bytes]) -> bytes:
    head, body = struct.pack(">II", 0xCAFEBABE, len(slices)), b""
    for kind, data in slices:
        head += struct.pack(">IIIII", kind, 0, 8 + 20 * len(slices) + len(body), len(data), 0)
        body += data
    return head + body


@pytest.mark.parametrize(
    ("library", "says"),
    [(pe(), ""), (pe(machine=0x14C), "another processor"), (pe()[:400], "truncated"), (elf(), "no PE header"),
     (pe()[:70], "truncated header")],
)  # fmt: skip
def test_windows_libraries(library: bytes, says: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(binary, "platform_name", lambda: ("win64", ".dll"))
    monkeypatch.setattr(platform, "machine", lambda: "AMD64")
    problem = binary.problem(library)
    assert says in problem and bool(says) == bool(problem)


@pytest.mark.parametrize(
    ("library", "says"),
    [(mach_o(0x0100000C), ""), (mach_o(), "another processor"), (mach_o(0x0100000C)[:400], "truncated"),
     (elf(), "no 64-bit Mach-O"), (mach_o(0x0100000C)[:60], "truncated"),
     (fat((0x01000007, mach_o()), (0x0100000C, mach_o(0x0100000C))), ""), (fat((0x01000007, mach_o())), "no slice"),
     (fat((0x01000007, mach_o()), (0x0100000C, mach_o(0x0100000C)))[:-9], "truncated")],
)  # fmt: skip
def test_mac_libraries(library: bytes, says: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(binary, "platform_name", lambda: ("darwin64", ".dylib"))
    monkeypatch.setattr(platform, "machine", lambda: "arm64")
    problem = binary.problem(library)
    assert says in problem and bool(says) == bool(problem)


@pytest.mark.skipif(sys.platform != "linux", reason="looks for an ELF extension module")
def test_real_library_is_accepted_whole_and_refused_in_part() -> None:
    data = next(Path(msgspec.__file__).parent.glob("_core*.so")).read_bytes()
    assert binary.problem(data) == ""
    assert "truncated" in binary.problem(data[: len(data) // 2])


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.data())
def test_any_damage_is_refused_or_harmless(tmp_path: Path, data: st.DataObject) -> None:
    path = tmp_path / "box.fmu"
    whole = bytearray(build(path).read_bytes())
    for _ in range(data.draw(st.integers(1, 4))):
        whole[data.draw(st.integers(0, len(whole) - 1))] = data.draw(st.integers(0, 255))
    path.write_bytes(whole[: data.draw(st.integers(len(whole) // 2, len(whole)))])
    try:
        assert read_description(path).model_identifier
        assert archive.check_platform(read_description(path)) == "linux64"
    except FmuError as error:
        assert str(path) in str(error)


def test_import_is_light() -> None:
    code = (
        "import sys, towage.units.archive, towage.errors, towage.scene.scene, towage.fmus.declare.quantities\n"
        "print([m for m in ('numpy', 'scipy', 'fmpy', 'matplotlib', 'pythonfmu', 'lxml') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
