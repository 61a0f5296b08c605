"""What ``towage export`` writes: complete, valid, and refused where a host could not run it.

How the exported systems run is in test_other_engine.py; libcosim checks OspSystemStructure.xml against its schema there.
"""

from __future__ import annotations

import shutil
import zipfile
from io import BytesIO
from pathlib import Path
from xml.etree import ElementTree

import msgspec
import pytest
from fmpy.ssp import ssd
from hypothesis import given
from hypothesis import strategies as st
from lxml import etree

from towage import cli
from towage.errors import FmuError, SceneError, TowageError
from towage.export.export import TICKS, Export, host_step, prepare
from towage.export.osp import MODEL_NAMESPACE, SYSTEM_NAMESPACE, write_osp
from towage.export.ssp import NAMESPACES, write_ssp
from towage.scene.flavour import resolve
from towage.scene.scene import Scene, available_scenes
from towage.units.archive import read_description
from towage.units.description import UnitDefinition
from towage.units.store import locator

SYSTEM, MODEL = f"{{{SYSTEM_NAMESPACE}}}", f"{{{MODEL_NAMESPACE}}}"
VELOCITY, DISPLACEMENT = "LinearMechanicalPort", "LinearMechanicalQuasiPort"


def exported(name: str, **parts: object) -> Export:
    """A shipped scene with parts replaced, at 0.1 s where it has no step."""
    scene = msgspec.structs.replace(Scene.load(name), cases=(), **parts)
    coupling = msgspec.structs.replace(scene.coupling, step=scene.coupling.step or 0.1, tolerance=None)
    return prepare(resolve(msgspec.structs.replace(scene, coupling=coupling), flavour="python"))


def osp_connections(directory: Path, export: Export) -> tuple[set[tuple[str, ...]], list[str]]:
    """Read as libcosim reads it: pairs (output, input) with groups taken apart, and the kinds of the ports used."""
    root = ElementTree.parse(directory / "OspSystemStructure.xml").getroot()
    groups, kinds = {}, []
    for unit, file in export.files.items():
        model = read_description(directory / file).model_name
        path = directory / f"{model}_OspModelDescription.xml"
        if path.is_file():
            for group in ElementTree.parse(path).getroot().find(f"{MODEL}VariableGroups"):  # type: ignore[union-attr]
                names = [variable.get("ref", "") for variable in group.iter(f"{MODEL}Variable")]
                groups[unit, group.get("name")] = group.tag.removeprefix(MODEL), [f"{unit}.{name}" for name in names]
    pairs = []
    for connection in root.iterfind(f"{SYSTEM}Connections/*"):
        ends = [(end.get("simulator", ""), end.get("name", "")) for end in connection]
        if connection.tag == f"{SYSTEM}VariableConnection":
            pairs.append(tuple(".".join(end) for end in ends))
        else:
            assert connection.tag == f"{SYSTEM}VariableGroupConnection"
            (kind, first), (other, second) = (groups[end] for end in ends)
            assert kind == other and len(first) == len(second) == 2
            pairs += zip(first, second)
            kinds.append(kind)
    causality = {
        f"{u}.{v.name}": v.causality for u, unit in export.resolved.units.items() for v in unit.description.variables
    }
    for pair in pairs:
        assert sorted(causality[end] for end in pair) == ["input", "output"]
    assert len(pairs) == len(set(pairs))
    return {tuple(sorted(pair, key=lambda end: causality[end] == "input")) for pair in pairs}, kinds


@pytest.mark.parametrize("name", [scene.name for scene in available_scenes()])
def test_osp_has_the_scenes_connections_and_values(name: str, tmp_path: Path) -> None:
    """Each connection once, each value to the last bit."""
    export = exported(name)
    files = write_osp(export, tmp_path)
    assert sorted(files) == sorted(tmp_path.iterdir())
    expected = {tuple(str(c).split(" -> ")) for c in export.resolved.connections}
    assert osp_connections(tmp_path, export)[0] == expected
    root = ElementTree.parse(tmp_path / "OspSystemStructure.xml").getroot()
    assert float(root.findtext(f"{SYSTEM}BaseStepSize") or 0) == export.resolved.scene.coupling.step
    for simulator in root.iterfind(f"{SYSTEM}Simulators/*"):
        values = {
            value.get("variable"): float(value[0].get("value", ""))
            for value in simulator.iterfind(f"{SYSTEM}InitialValues/*")
        }
        assert values == export.resolved.units[simulator.get("name", "")].parameters


@pytest.mark.parametrize(
    ("name", "kinds"),
    [
        ("sea_cliff", [DISPLACEMENT, DISPLACEMENT]),
        ("tow_600ft", [VELOCITY]),
        ("tow_two_units", [VELOCITY] * 4),  # heave with heave, surge with surge, at both ends of the cable
        ("slender_stable", [DISPLACEMENT]),  # the lateral force goes with the lateral motion, not with the tow speed
        ("float_quadrant2", []),  # forces from outside: nothing comes back
    ],
)
def test_ports(name: str, kinds: list[str], tmp_path: Path) -> None:
    export = exported(name)
    write_osp(export, tmp_path)
    assert osp_connections(tmp_path, export)[1] == kinds
    for path in tmp_path.glob("*_OspModelDescription.xml"):
        variables = read_description(tmp_path / f"{path.name.removesuffix('_OspModelDescription.xml')}.fmu").by_name()
        names: list[str | None] = []
        for port in ElementTree.parse(path).getroot().find(f"{MODEL}VariableGroups"):  # type: ignore[union-attr]
            force, motion = (group[0] for group in port)
            assert [group.tag for group in port] == [
                f"{MODEL}Force",
                f"{MODEL}{'LinearVelocity' if port.tag == MODEL + VELOCITY else 'LinearDisplacement'}",
            ]
            assert {variables[end.get("ref", "")].causality for end in (force, motion)} == {"input", "output"}
            assert all(variables[end.get("ref", "")].unit == end.get("unit") for end in (force, motion))
            names += [port.get("name"), *(group.get("name") for group in port)]
        assert len(set(names)) == len(names)  # as OSP-IS demands of one description


def test_where_names_do_not_decide_there_is_no_port(tmp_path: Path) -> None:
    """The body's heave on the cable's surge and the reverse: each force is as near to one motion as to the other."""
    export = exported("tow_two_units")
    crossed = {"body_velocity_heave": "body_velocity_surge", "body_velocity_surge": "body_velocity_heave"}
    links = tuple(c._replace(target=crossed.get(c.target, c.target)) for c in export.resolved.connections)
    export = export._replace(resolved=msgspec.structs.replace(export.resolved, connections=links))
    write_osp(export, tmp_path)
    pairs, kinds = osp_connections(tmp_path, export)
    assert pairs == {tuple(str(c).split(" -> ")) for c in links}
    assert kinds == [VELOCITY] * 2  # those of the ship


def test_ports_of_both_kinds_stand_in_the_order_of_the_schema(tmp_path: Path) -> None:
    """One ship holds a cradle by its heave, another tows by its velocity; OspModelDescription is a sequence of kinds."""
    cradle, tow = Scene.load("sea_cliff"), Scene.load("tow_report_sample")
    units = {**cradle.units, "tug": tow.units["ship"], "tow": tow.units["tow"]}
    towed = ("tug.velocity -> tow.velocity_heave", "tow.reaction_heave -> tug.reaction")
    export = exported("sea_cliff", units=units, connections=(*cradle.connections, *towed))
    write_osp(export, tmp_path)
    groups = ElementTree.parse(tmp_path / "ship_OspModelDescription.xml").getroot()[0]
    assert [group.tag for group in groups] == [MODEL + VELOCITY, MODEL + DISPLACEMENT]
    assert sorted(osp_connections(tmp_path, export)[1]) == [VELOCITY, DISPLACEMENT, DISPLACEMENT]


@pytest.mark.parametrize("name", ["sea_cliff", "tow_two_units", "voyage_tow"])
def test_ssp_is_valid_and_complete(name: str, tmp_path: Path) -> None:
    """Against the schemas of SSP 1.0, as fmpy has them, and against the scene."""
    export = exported(name)
    path = tmp_path / "scene.ssp"
    write_ssp(export, path)
    read = ssd.read_ssd(str(path))  # validates
    assert read.version == "1.0"
    with zipfile.ZipFile(path) as archive:
        root = etree.fromstring(archive.read("SystemStructure.ssd"))
        connectors = set()
        for component in root.iterfind("ssd:System/ssd:Elements/ssd:Component", NAMESPACES):
            unit = export.resolved.units[component.get("name")]
            assert archive.read(component.get("source")) == unit.path.read_bytes()
            connectors |= {(unit.name, c.get("name")) for c in component.iterfind(".//ssd:Connector", NAMESPACES)}
            source = component.find(".//ssd:ParameterBinding", NAMESPACES).get("source")
            parameters = ssd.read_ssv(BytesIO(archive.read(source))).parameters  # validates
            assert {p.name: float(p.value) for p in parameters} == unit.parameters
    connections = [dict(c.attrib) for c in root.iterfind("ssd:System/ssd:Connections/ssd:Connection", NAMESPACES)]
    keys = "startElement", "startConnector", "endElement", "endConnector"
    assert [tuple(c[key] for key in keys) for c in connections] == [tuple(c[:4]) for c in export.resolved.connections]
    assert {(c[a], c[b]) for c in connections for a, b in (keys[:2], keys[2:])} <= connectors
    units = {u.get("name") for u in root.iterfind("ssd:Units/ssc:Unit", NAMESPACES)}
    assert {e.get("unit") for e in root.iterfind(".//ssc:Real[@unit]", NAMESPACES)} == units


def test_two_exports_are_byte_identical(tmp_path: Path) -> None:
    for place in ("first", "second"):
        export = exported("sea_cliff")
        write_osp(export, tmp_path / place)
        write_ssp(export, tmp_path / place / "scene.ssp")
    for path in (tmp_path / "first").iterdir():
        assert path.read_bytes() == (tmp_path / "second" / path.name).read_bytes(), path.name


@given(st.floats(1e-9, 1e4))
def test_host_step_survives_the_cut_to_nanoseconds(step: float) -> None:
    """libcosim converts seconds by truncation."""
    assert int(host_step(step) * TICKS) == max(1, round(step * TICKS))
    assert abs(host_step(step) - step) <= 1e-9


def test_fmus_of_one_file_name_are_kept_apart(tmp_path: Path) -> None:
    scene = Scene.load("sea_cliff")
    units = dict(scene.units)
    for place, unit in (("a", "ship"), ("b", "cradle")):
        (tmp_path / place).mkdir()
        file = tmp_path / place / ("same.fmu" if place == "a" else "Same.fmu")
        shutil.copyfile(locator()(unit), file)
        units[unit] = msgspec.structs.replace(units[unit], fmu=str(file))
    export = exported("sea_cliff", units=units)
    assert len({file.casefold() for file in export.files.values()}) == 3
    write_osp(export, tmp_path / "out")
    assert read_description(tmp_path / "out" / export.files["cradle"]).model_name == "cradle"


def test_error_control_is_refused_with_the_way_out() -> None:
    with pytest.raises(SceneError, match="--set coupling.step") as refused:
        prepare(resolve(Scene.load("alvin"), flavour="python"))
    assert refused.value.exit_code == 2 and refused.value.key == "coupling.tolerance"


def test_one_unit_name_with_two_meanings_is_refused(tmp_path: Path) -> None:
    """SSP has one table of units of measurement; OSP leaves them to the FMUs."""
    export = exported("sea_cliff")
    line = export.resolved.units["line"]
    force = UnitDefinition(line.description.units["N"].exponents, 1000.0, 0.0)
    description = msgspec.structs.replace(line.description, units={**line.description.units, "N": force})
    units = {**export.resolved.units, "line": msgspec.structs.replace(line, description=description)}
    other = export._replace(resolved=msgspec.structs.replace(export.resolved, units=units))
    with pytest.raises(FmuError, match="'N' is defined otherwise"):
        write_ssp(other, tmp_path / "scene.ssp")
    assert not list(tmp_path.iterdir())


def test_a_place_that_cannot_be_written_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    export = exported("sea_cliff")
    for write, place in ((write_osp, tmp_path / "file"), (write_ssp, tmp_path / "file" / "scene.ssp")):
        with pytest.raises(TowageError, match="file"):
            write(export, place)


def test_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    command = ["export", "sea_cliff", "--case", "10 s wave", "--set", "coupling.step=0.25 s", "--flavour", "python"]
    assert cli.main([*command, "--osp", str(tmp_path / "osp")]) == 0
    said = capsys.readouterr().out
    assert "OspSystemStructure.xml" in said and "coupling.scheme=jacobi" in said
    written = (tmp_path / "osp" / "OspSystemStructure.xml").read_text()
    assert "<BaseStepSize>0.25</BaseStepSize>" in written and '<Real value="10" />' in written
    assert cli.main([*command, "--ssp", str(tmp_path / "scene.ssp")]) == 0
    assert cli.main(["export", "alvin", "--ssp", str(tmp_path / "none.ssp")]) == 2
    assert cli.main(["export", "sea_cliff", "--case", "no", "--ssp", str(tmp_path / "none.ssp")]) == 2
    assert not (tmp_path / "none.ssp").exists()
    acting = ["--set", "title=a\x1b]0;b\x07 <c> \ufffe", "--ssp", str(tmp_path / "acting.ssp")]
    assert cli.main([*command, *acting]) == 0
    with zipfile.ZipFile(tmp_path / "acting.ssp") as ssp:
        root = ElementTree.fromstring(ssp.read("SystemStructure.ssd"))
    assert (
        root.get("description") == r"a\x1b]0;b\x07 <c> \ufffe"
        and root[0].get("name") == root.get("name") == "sea_cliff"
    )
    with pytest.raises(SystemExit):
        cli.main(["export", "sea_cliff"])
