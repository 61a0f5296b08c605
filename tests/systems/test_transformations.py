"""``[transformations]`` of a scene: what fits, what is refused, and what no longer holds where a value is transformed."""

from __future__ import annotations

import zipfile
from pathlib import Path
from typing import Any

import pytest
from msgspec.structs import replace

from tests.systems.write import archive, bindings, component, link, ssd, system
from tests.zoo.zoo import animal, description, library, run, scene
from towage.errors import SceneError
from towage.ladder.simplest import simplest
from towage.master.bonds import bonds
from towage.scene.compose import unit_of
from towage.scene.parts import Transformation
from towage.scene.resolve import described
from towage.scene.scene import Scene
from towage.units.binary import platform_name
from towage.units.store import locator

MODES = (
    '<TypeDefinitions><SimpleType name="Mode"><Enumeration><Item name="off" value="1"/><Item name="slow" value="2"/>'
    '<Item name="fast" value="6"/></Enumeration></SimpleType></TypeDefinitions>'
)


def moded(path: Path) -> str:
    """A unit of the zoo whose integers are an enumeration: n = 2 n_in."""
    text = description(extra=MODES).replace('<Integer start="0"/>', '<Enumeration declaredType="Mode" start="1"/>')
    text = text.replace("<Integer/>", '<Enumeration declaredType="Mode"/>')
    platform, suffix = platform_name()
    with zipfile.ZipFile(path, "w") as out:
        out.writestr("modelDescription.xml", text)
        out.writestr(f"binaries/{platform}/zoo{suffix}", library(2))
    return str(path)


def test_enumerations_by_the_names_of_their_items(tmp_path: Path) -> None:
    fmu = moded(tmp_path / "a.fmu")
    units = {"a": {"fmu": fmu, "inputs": {"n_in": "off"}}, "b": fmu}
    change = {"a.n -> b.n_in": {"values": {"slow": "fast"}}}
    assert run(units, ["a.n -> b.n_in"], transformations=change)["b.n"][0] == 12.0
    with pytest.raises(
        SceneError, match="'fats' is no Enumeration, as n_in is; did you mean 'fast'.*; expected one of: off, slow"
    ):
        described(scene({"a": {"fmu": fmu, "inputs": {"n_in": "fats"}}}, []), locator())
    with pytest.raises(SceneError, match="'slwo' is no Enumeration of n: expected off, slow, fast"):
        run(units, ["a.n -> b.n_in"], transformations={"a.n -> b.n_in": {"values": {"slwo": "fast"}}})


def test_enumerations_of_ssp(tmp_path: Path) -> None:
    unit = Path(moded(tmp_path / "m.fmu")).read_bytes()
    kind = "ssc:EnumerationMappingTransformation"
    change = f'<{kind}><ssc:MapEntry source="slow" target="fast"/></{kind}>'
    given = '<ssv:Parameter name="n_in"><ssv:Enumeration value="off"/></ssv:Parameter>'
    sets = (
        f'<ssd:ParameterBinding><ssd:ParameterValues><ssv:ParameterSet version="1.0" name="p"><ssv:Parameters>{given}'
    )
    sets += "</ssv:Parameters></ssv:ParameterSet></ssd:ParameterValues></ssd:ParameterBinding>"
    ends = "n:output:Integer n_in:input:Integer"
    one, other = component("a", "m.fmu", ends, bindings(sets)), component("b", "m.fmu", ends)
    path = archive(tmp_path / "s.ssp", ssd(system(one + other, link("a.n", "b.n_in", change))), {"m.fmu": unit})
    read = Scene.load(path)
    assert read.units["a"].inputs == {"n_in": "off"}
    assert read.transformations["a.n -> b.n_in"].values == {"slow": "fast"}
    described(read, locator())


def test_integers_and_enumerations_are_joined_with_a_word(tmp_path: Path) -> None:
    units = {"a": {"fmu": animal(tmp_path / "a.fmu"), "inputs": {"n_in": 3}}, "b": moded(tmp_path / "b.fmu")}
    resolved = described(scene(units, ["a.n -> b.n_in"]), locator())
    assert "joins Integer to Enumeration: the number passes unchanged" in resolved.warnings[0]


@pytest.mark.parametrize(
    ("text", "change", "message"),
    [
        ("a.y -> b.v", {}, "there is no connection 'a.y -> b.v'; did you mean 'a.y -> b.u'"),
        ("a.y -> b.u", {"factor": float("inf")}, "factor and offset must be finite"),
        ("a.y -> b.u", {"values": {"1": 2}}, "values are for Integer, Enumeration, Boolean, and a.y is Real"),
        ("a.n -> b.n_in", {"factor": 2.0}, "factor and offset are for Real, and a.n is Integer"),
        ("a.n -> b.n_in", {"values": {"one": 2}}, "'one' is no Integer of n: expected whole numbers"),
        ("a.n -> b.n_in", {"values": {"1": True}}, "True is no Integer, as n_in is"),
        ("a.b -> b.b_in", {"values": {"yes": True}}, "'yes' is no Boolean of b: expected true, false"),
        ("a.y -> b.u", {"gain": 2.0}, "unknown key.*factor"),
    ],
)
def test_what_is_refused(tmp_path: Path, text: str, change: dict[str, Any], message: str) -> None:
    fmu = animal(tmp_path / "a.fmu")
    with pytest.raises(SceneError, match=message):
        described(
            scene(
                {"a": fmu, "b": fmu}, ["a.y -> b.u", "a.n -> b.n_in", "a.b -> b.b_in"], transformations={text: change}
            ),
            locator(),
        )


def test_what_no_longer_holds() -> None:
    """A transformed force makes no bond, a scene without known physics of its connections no ladder, an offset no unit."""
    plain = replace(Scene.load("sea_cliff"), cases=())
    text = "line.tension -> cradle.line_tension"
    changed = replace(plain, transformations={text: Transformation(offset=1.0)})
    bound = {str(bond.effort) for bond in bonds(described(plain, locator()))}
    assert bound - {str(bond.effort) for bond in bonds(described(changed, locator()))} == {text}
    assert changed.without([text]).transformations == {}
    with pytest.raises(SceneError, match="the ladder is for scenes without"):
        simplest(changed)
    with pytest.raises(SceneError, match="adds an offset or looks values up, which cannot be composed"):
        unit_of(described(changed, locator()), "x")
