"""Systems of SSP as scenes: against closed forms of y' = gain u, w = gain u."""

from __future__ import annotations

import zipfile
from pathlib import Path
from typing import Any

import pytest

from tests.systems.write import (
    DEFINED,
    SPACES,
    UNITS,
    archive,
    bindings,
    component,
    link,
    parameters,
    ssd,
    system,
    values,
)  # fmt: skip
from tests.zoo.zoo import animal, told
from towage.cli import main
from towage.errors import SceneError
from towage.master.master import run_resolved
from towage.report.page import text_summary
from towage.result.result import Result
from towage.scene.flavour import resolve
from towage.scene.scene import Scene
from towage.systems.load import system_file

SOUND = 1e-12
"""Relative: sums of at most 20 steps in double precision."""
TWO = component("a") + component("b")


def run(path: Path | str, **values: Any) -> Result:
    scene = Scene.load(path).with_values({"coupling.error_estimate": False, **values})
    result = run_resolved(resolve(scene))
    assert result.status == "done", result.message
    return result


def said(path: Path | str) -> str:
    return "\n".join(note.text for note in Scene.load(path).notes)


def test_a_connection_transforms_values_and_derivatives(tmp_path: Path) -> None:
    """u2 = 2 y1 + 1 with y1 = t, so that y2 = t^2 + t; inputs held at their mean over a step make no error here."""
    change = '<ssc:LinearTransformation factor="2" offset="1"/>'
    one = component("a", inside=bindings(values({"u": 1.0})))
    root = system(one + component("b"), link("b.u", "a.y", change))  # the order of ends says nothing
    result = run(archive(tmp_path / "s.ssp", ssd(root)))
    assert result.time[-1] == 2.0
    assert result["b.y"][-1] == pytest.approx(6.0, rel=SOUND)
    assert result["b.w"].tolist() == pytest.approx((2.0 * result["a.y"] + 1.0).tolist(), rel=SOUND)
    scene = Scene.load(tmp_path / "s.ssp")
    assert scene.transformations["a.y -> b.u"].factor == 2.0
    assert (scene.coupling.step, scene.stop_time, scene.title) == (0.1, 2.0, "A system")


@pytest.mark.parametrize(
    ("about", "ends", "change", "raw", "expected"),
    [
        ({"y": ' unit="degC"', "u": ' unit="K"'}, "", "", False, 1.0 + 273.15),
        (
            {"y": ' unit="degC"', "u": ' unit="K"'},
            "",
            '<ssc:LinearTransformation factor="2"/>',
            False,
            2.0 * (1.0 + 273.15),
        ),
        ({"y": ' unit="degC"', "u": ' unit="K"'}, "", '<ssc:LinearTransformation factor="2"/>', True, 2.0),
        ({"y": ' unit="degC"', "u": ' unit="m"'}, "", "", True, 1.0),
        ({}, "u:input:m y:output:km", "", False, 1000.0),
        ({"y": ' unit="K"', "u": ' unit="m"'}, "u:input:m y:output:km", "", False, 1000.0),
    ],
)
def test_units_of_measure(
    tmp_path: Path, about: dict[str, str], ends: str, change: str, raw: bool, expected: float
) -> None:
    """Of connectors, else of FMUs; a transformation comes after the conversion, or in place of it."""
    ends = ends or "u:input y:output"
    elements = component("a", ends=ends, inside=bindings(values({"x0": 1.0}))) + component("b", ends=ends)
    text = ssd(system(elements, link("a.y", "b.u", change, suppressUnitConversion=str(raw).lower())))
    path = archive(tmp_path / "s.ssp", text, reals=about, extra=DEFINED)
    result = run(path, stop_time=0.1)
    assert result["b.w"][0] == pytest.approx(expected, rel=SOUND)
    if about.get("y") == ' unit="K"':
        assert "connector 'y': is measured in km here and in K by its FMU" in said(path)


def test_units_that_do_not_fit_are_refused(tmp_path: Path) -> None:
    elements = component("a", ends="y:output:m") + component("b", ends="u:input:K")
    path = archive(tmp_path / "s.ssp", ssd(system(elements, link("a.y", "b.u"))))
    with pytest.raises(
        SceneError, match=r"s\.ssp: SystemStructure.ssd: a.y -> b.u: b.u gets \[m\] and measures \[K\].*suppress"
    ):
        Scene.load(path)


def test_nested_systems_are_flattened(tmp_path: Path) -> None:
    """A value goes in by a connector and out by another, with a unit of measure and a change on each edge."""
    first, second = '<ssc:LinearTransformation factor="3"/>', '<ssc:LinearTransformation offset="5"/>'
    inner = system(
        component("c", ends="u:input:m w:output:m"), link("in", "c.u", first) + link("c.w", "out"),
        ends="in:input out:output:km", name="sub",
    )  # fmt: skip
    root = system(
        component("a", ends="y:output:km", inside=bindings(values({"x0": 2.0})))
        + inner
        + component("b", ends="u:input"),
        link("a.y", "sub.in") + link("sub.out", "b.u", second),
    )
    result = run(archive(tmp_path / "s.ssp", ssd(root)), stop_time=0.1)
    assert [result["sub_c.w"][0], result["b.w"][0]] == pytest.approx([6000.0, 11.0], rel=SOUND)


def test_parameters_of_outer_systems_and_of_later_sets_prevail(tmp_path: Path) -> None:
    """Names with a prefix, mapped, of a connector, with a unit of measure, and one that fits nothing."""
    entry = '<ssm:MappingEntry source="{}" target="{}"><ssc:LinearTransformation factor="2" offset="10"/></ssm:MappingEntry>'
    mapping = '<ssd:ParameterMapping source="resources/m.ssm"/>'
    ssm = f'<ssm:ParameterMapping {SPACES} version="1.0">{entry.format("g", "sub.a.gain")}</ssm:ParameterMapping>'
    own = bindings(values({"gain": 1.0, "x0": 1.0, "end": 7.0}), values({"x0": 2.0}))
    sub = system(
        component("a", inside=own) + component("b", ends="u:input:m"), link("level", "b.u"), bindings(values({"a.end": 8.0})),
        ends="level:input:km", name="sub",
    )  # fmt: skip
    outer = bindings(
        values({"sub.a.x0": 3.0}), '<ssd:ParameterBinding source="resources/p.ssv"/>',
        values({"g": 4.0, "sub.a.x0": 9.0}, mapping), values({"a.x0": 5.0, "level:m": 500.0, "x.y": 1.0}, prefix="sub."),
    )  # fmt: skip
    files = {"resources/p.ssv": parameters({"sub.a.x0": 4.0}), "resources/m.ssm": ssm}
    path = archive(tmp_path / "s.ssp", ssd(system(sub, "", outer)), files)
    scene = Scene.load(path)
    assert scene.units["sub_a"].parameters == {"gain": 18.0, "x0": 5.0, "end": 8.0}
    assert scene.units["sub_b"].inputs == {"u": 500.0}
    assert "'sub.x.y' fit nothing in the system" in said(path)
    assert run(path)["sub_b.w"][0] == 500.0


def test_signal_dictionaries(tmp_path: Path) -> None:
    """Two systems meet in one, by other names of it, with a unit of measure of the entry."""
    entry = '<ssb:DictionaryEntry name="depth"><ssc:Real unit="km"/></ssb:DictionaryEntry>'
    ssb = f'<ssb:SignalDictionary {SPACES} version="1.0">{entry}{UNITS.format("ssb")}</ssb:SignalDictionary>'
    bus = '<ssd:SignalDictionaryReference name="bus" dictionary="d">'
    bus += '<ssd:Connectors><ssd:Connector name="depth" kind="inout"/></ssd:Connectors></ssd:SignalDictionaryReference>'
    sets = component("a", ends="y:output:m", inside=bindings(values({"x0": 2000.0})))
    one = system(sets + bus, link("a.y", "bus.depth"), name="one")
    two = system(component("b", ends="u:input") + bus, link("b.u", "bus.depth"), name="two")
    shared = (
        '<ssd:SignalDictionaries><ssd:SignalDictionary name="d" source="resources/d.ssb"/></ssd:SignalDictionaries>'
    )
    path = archive(tmp_path / "s.ssp", ssd(system(one + two, "", shared)), {"resources/d.ssb": ssb})
    assert run(path, stop_time=0.1)["two_b.w"][0] == 2.0


def test_tables_of_discrete_values(tmp_path: Path) -> None:
    """An integer that counts and a truth value are looked up; what is not in the table passes unchanged."""
    ends = "n:output:Integer n_in:input:Integer b:output:Boolean b_in:input:Boolean u:input y:output"
    count = '<ssc:IntegerMappingTransformation><ssc:MapEntry source="1" target="7"/></ssc:IntegerMappingTransformation>'
    turn = '<ssc:BooleanMappingTransformation><ssc:MapEntry source="true" target="false"/></ssc:BooleanMappingTransformation>'
    root = system(
        component("a", ends=ends, inside=bindings(values({"b_in": False}))) + component("b", "resources/b.fmu", ends),
        link("a.n", "b.n_in", count) + link("a.b", "b.b_in", turn),
    )
    twice = Path(animal(tmp_path / "b.fmu")).read_bytes()  # n = 2 n_in
    path = archive(tmp_path / "s.ssp", ssd(root), {"resources/b.fmu": twice}, manner="counter")
    result = run(path)
    assert dict(zip(result["a.n"], result["b.n"])) == {0.0: 0.0, 1.0: 14.0, 2.0: 4.0, 3.0: 6.0, 4.0: 8.0}
    assert set(result["a.b"]) == {1.0}
    assert set(result["b.b"]) == {1.0}  # the unit inverts what it gets: false
    assert Scene.load(path).transformations["a.n -> b.n_in"].values == {"1": 7}


def test_variants_and_systems_within_systems(tmp_path: Path) -> None:
    """Another description of the archive by its name; a description, an archive and an element by reference."""
    inner = archive(
        tmp_path / "inner.ssp", ssd(system(component("a", inside=bindings(values({"x0": 1.0})))), "")
    ).read_bytes()
    part = ssd(system(component("b", source="../resources/a.fmu"), name="part"))
    twin = system(component("t"), name="twin", id="twin")
    elements = (
        component("in", "resources/inner.ssp", "", bindings(values({"a.x0": 3.0})), type="application/x-ssp-package")
        + component("part", "parts/part.ssd", "", type="application/x-ssp-definition")
        + twin + component("again", "#twin", "")
    )  # fmt: skip
    files = {"resources/inner.ssp": inner, "parts/part.ssd": part, "Other.ssd": ssd(system(component("only")))}
    path = archive(tmp_path / "s.ssp", ssd(system(elements)), files)
    scene = Scene.load(path)
    assert list(scene.units) == ["in_a", "part_b", "twin_t", "again_t"]
    assert scene.units["in_a"].parameters == {"x0": 3.0}
    assert "other variants too: s.ssp#Other.ssd" in said(path)
    assert list(Scene.load(f"{path}#Other.ssd").units) == ["only"]


def test_what_is_not_understood_is_on_the_card(tmp_path: Path) -> None:
    odd = component("a", inside='<ssd:Colour/><ssd:Annotations><ssc:Annotation type="org.else"/></ssd:Annotations>')
    nothing = (
        "<ssd:Component name='c'>"
        + '<ssd:Connectors><ssd:Connector name="y" kind="output"/></ssd:Connectors></ssd:Component>'
    )
    root = system(odd + nothing, link("c.y", "a.u"))
    path = archive(tmp_path / "s.ssp", ssd(root, stop="", version="3.0"))
    words = told(run(path), "system")
    for text in (
        "version '3.0' is read as 1.0", "<Colour> is not understood", "'org.else' is ignored", "no stop time: 10 s are run",
        "no communication step: 0.01 s", "c: has no source", "a.u is connected to c.y, which nothing feeds",
    ):  # fmt: skip
        assert text in words
    assert "no stop time" not in told(run(path, stop_time=1.0), "system")
    assert "<Colour> is not understood" in text_summary(run(path))


FMU = "application/x-fmu-sharedlibrary"


@pytest.mark.parametrize(
    ("root", "message"),
    [
        (component("a", "https://example.org/a.fmu"), "'https://example.org/a.fmu' is not fetched"),
        (component("a", "../a.fmu"), r"'\.\./a.fmu' leaves the system"),
        (component("a", "resources/%2e%2e/../../a.fmu"), "leaves the system"),
        (component("a", "/etc/passwd"), "is not fetched"),
        (component("a", "resources/b.fmu"), "no such file in the archive; did you mean 'resources/a.fmu'"),
        (component("a", "SystemStructure.ssd", type=FMU), "SystemStructure.ssd: damaged or truncated archive"),
        (component("a") + component("a"), "an element is called 'a', which is empty or taken"),
        (component("a", implementation="ModelExchange"), "asks for ModelExchange"),
        (component("a", "#b"), "there is no System with id 'b'"),
        (component("a", type="text/x-modelica"), "a component of type 'text/x-modelica' cannot be run"),
        (component("a", "SystemStructure.ssd", type="application/x-ssp-definition"), "more than 20 deep"),
        (component("a", inside=bindings('<ssd:ParameterBinding source="x.ssv"/>')), "x.ssv: there is no such file"),
        (component("a", inside=bindings(values({"gain": "nan"}))), "units.a.parameters.gain: 'nan'"),
    ],
)  # fmt: skip
def test_elements_that_are_refused(tmp_path: Path, root: str, message: str, capfd: pytest.CaptureFixture[str]) -> None:
    path = archive(tmp_path / "s.ssp", ssd(system(root)))
    with pytest.raises(SceneError, match=message):
        resolve(Scene.load(path))
    assert main(["validate", str(path)]) == 2
    assert "s.ssp" in capfd.readouterr().err


@pytest.mark.parametrize(
    ("links", "message"),
    [
        (link("a.y", "b.y"), "both ends give values"),
        (link("a.y", "b.u") + link("a.w", "b.u"), "b.u has two sources: a.y and a.w"),
        (link("a.y", "b.v"), "b.v: its FMU has no such variable"),
        (link("a.y", "c.u"), "names the element 'c', which is not there"),
        (link("a.y", "out"), "out: there is no such connector"),
        (link("a.y", "b.u", '<ssc:LinearTransformation factor="inf"/>'), "factor='inf' is no finite number"),
        (link("a.y", "b.u", startIndices="1"), "by indices are not read"),
        (link("a.y", "b.u", suppressUnitConversion="maybe"), "suppressUnitConversion='maybe' is no truth value"),
    ],
)
def test_connections_that_are_refused(tmp_path: Path, links: str, message: str) -> None:
    with pytest.raises(SceneError, match=message):
        Scene.load(archive(tmp_path / "s.ssp", ssd(system(TWO, links))))


def test_hostile_archives(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """Entries that leave, entities, depth, and names that act on a terminal."""
    good = ssd(system(component("a")))
    slip = archive(tmp_path / "slip.ssp", good, {"../../evil": "x"})
    entity = archive(tmp_path / "entity.ssp", f'<!DOCTYPE a [<!ENTITY b "c">]>{good}')
    deep = archive(tmp_path / "deep.ssp", ssd(system("<ssd:a>" * 200 + "</ssd:a>" * 200)))
    for path, words in ((slip, "leaves the archive's directory"), (entity, "DOCTYPE"), (deep, "levels of elements")):
        assert main(["run", str(path)]) == 2
        assert words in capfd.readouterr().err
    named = archive(tmp_path / "named.ssp", ssd(system(component("a&#133;b&#x202e;c", "x.fmu"))))
    assert main(["run", str(named)]) == 2
    assert "\x85" not in (err := capfd.readouterr().err) and "\u202e" not in err
    assert not (tmp_path.parent / "evil").exists()


def test_a_folder_is_read_and_links_out_of_it_are_not(tmp_path: Path) -> None:
    folder = tmp_path / "system"
    folder.mkdir()
    (folder / "SystemStructure.ssd").write_text(ssd(system(component("a", "a.fmu"))))
    outside = animal(tmp_path / "a.fmu")
    (folder / "a.fmu").symlink_to(outside)
    assert system_file(folder) == folder / "SystemStructure.ssd"
    assert system_file(tmp_path) is None
    with pytest.raises(SceneError, match="is a link that leaves the folder"):
        Scene.load(folder)
    (folder / "a.fmu").unlink()
    animal(folder / "a.fmu")
    assert run(folder).columns.keys() == run(folder / "SystemStructure.ssd").columns.keys()


def test_import_writes_a_scene_that_runs_alike(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    change = '<ssc:LinearTransformation factor="2" offset="1"/>'
    root = system(component("A 1", inside=bindings(values({"u": 1.0}))) + component("b"), link("A 1.y", "b.u", change))
    path, out = archive(tmp_path / "s.ssp", ssd(root)), tmp_path / "scene.toml"
    assert main(["import", str(path), "--out", str(out)]) == 0
    assert "'A 1' is called A_1 here" in capsys.readouterr().err
    text = out.read_text()
    assert "# info: 'A 1' is called A_1 here" in text
    assert 'fmu = "scene_fmus/a.fmu"' in text
    one, other = run(path), run(out)
    assert all((one[name] == other[name]).all() for name in one.columns)
    assert main(["import", str(path), "--out", str(out)]) == 2
    assert "may have been worked on" in capsys.readouterr().err
    assert main(["import", str(out)]) == 2


def test_arrays_of_ssp_2(tmp_path: Path) -> None:
    """Connected and set as a whole, as FMI 3.0 and SSP 2.0 have them."""
    from tests.zoo.zoo import animal3

    path = tmp_path / "s.ssp"
    ends = '<ssd:Connectors><ssd:Connector name="{}" kind="{}"><ssc:Float64/><ssc:Dimension size="3"/></ssd:Connector>'
    ends += "</ssd:Connectors>"
    given = '<ssv:Parameter name="array_in"><ssv:Float64 value="4 5 6"/><ssv:Dimension size="3"/></ssv:Parameter>'
    sets = (
        f'<ssd:ParameterBinding><ssd:ParameterValues><ssv:ParameterSet version="2.0" name="p"><ssv:Parameters>{given}'
    )
    sets += "</ssv:Parameters></ssv:ParameterSet></ssd:ParameterValues></ssd:ParameterBinding>"
    about = '<ssd:Component name="{}" source="a.fmu">{}{}</ssd:Component>'
    elements = about.format("a", ends.format("array", "output"), bindings(sets))
    elements += about.format("b", ends.format("array_in", "input"), "")
    text = ssd(system(elements, link("a.array", "b.array_in")), version="2.0")
    animal3(tmp_path / "a.fmu")
    with zipfile.ZipFile(path, "w") as out:
        out.writestr("SystemStructure.ssd", text)
        out.write(tmp_path / "a.fmu", "a.fmu")
    result = run(path, stop_time=0.3)
    assert (
        [result[f"b.array[{k}]"][-1] for k in (1, 2, 3)]
        == [result[f"a.array[{k}]"][-1] for k in (1, 2, 3)]
        == [4.0, 5.0, 6.0]
    )


@pytest.mark.parametrize(("stop", "step"), [("", 0.25), ("2", 0.1)])
def test_the_step_of_omsimulator_is_read_where_no_other_is_said(stop: str, step: float, tmp_path: Path) -> None:
    master = '<o:SimulationInformation xmlns:o="http://oms"><o:FixedStepMaster stepSize="0.25"/></o:SimulationInformation>'
    note = f'<ssd:Annotations><ssc:Annotation type="org.openmodelica">{master}</ssc:Annotation></ssd:Annotations>'
    path = archive(tmp_path / "s.ssp", ssd(system(component("a"), inside=note), stop=stop))
    assert Scene.load(path).coupling.step == step
    assert ("another step, 0.25 s, which is ignored" in said(path)) == (step == 0.1)
    assert "org.openmodelica" not in said(path)


def test_the_description_of_the_document_is_the_title(tmp_path: Path) -> None:
    text = ssd(system(component("a"))).replace(' name="A system"', ' name="s" description="Two bodies&#10;in a row"')
    assert Scene.load(archive(tmp_path / "s.ssp", text)).title == "Two bodies"
