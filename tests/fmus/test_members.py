"""What an FMU carries beside its description and its code."""

import zipfile
from pathlib import Path
from xml.etree import ElementTree

import fmpy
import lxml.etree
import pytest

from towage.fmus import UNITS
from towage.fmus.declare.unit import load
from towage.fmus.describe.members import ICONS, icon, members, native_notice, terminals_and_icons
from towage.scene.files import declared
from towage.scene.scene import Scene


@pytest.mark.parametrize("name", UNITS)
def test_terminals_name_ports_of_the_unit_and_each_variable_once(name: str) -> None:
    unit = load(name)
    ports = {v.name for v in unit.inputs} | {v.name for v in unit.observed if v.causality == "output"}
    named = [variable for terminal in unit.terminals.values() for variable in terminal.values()]
    assert set(named) <= ports and len(named) == len(set(named))
    assert unit.terminals or not unit.inputs


@pytest.mark.parametrize(
    ("one", "other"),
    [
        (("ship", "line"), ("spring_line", "top")), (("spring_line", "bottom"), ("cradle", "line")),
        (("ship", "line"), ("cradle_on_line", "top")), (("sway_craft", "tow"), ("slender_body", "craft")),
        (("tow_cable", "body"), ("towed_body", "cable")), (("body_force", "body"), ("tow_system", "flow")),
        (("played voyage", "sea"), ("ship_in_sea", "sea")),
    ],
)  # fmt: skip
def test_terminals_of_units_that_are_joined_fit(one: tuple[str, str], other: tuple[str, str]) -> None:
    """The same members, and each is an output of one unit and an input of the other."""
    sides = []
    for name, terminal in (one, other):
        unit = load(name) if name in UNITS else declared(Scene.load("voyage_tow"), "voyage")
        inputs = {v.name for v in unit.inputs}
        sides.append({member: variable in inputs for member, variable in unit.terminals[terminal].items()})
    assert sides[0] == {member: not is_input for member, is_input in sides[1].items()}


@pytest.mark.parametrize("name", [*UNITS, "unit"])
def test_every_unit_has_an_icon_in_both_forms(name: str) -> None:
    assert ElementTree.parse(ICONS / f"{name}.svg").getroot().get("viewBox") == "0 0 100 100"
    assert (ICONS / f"{name}.png").read_bytes().startswith(b"\x89PNG")


def test_a_unit_of_another_package_has_the_plain_icon() -> None:
    class Other:
        name = "no_such_unit"

    assert icon(Other()) == (ICONS / "unit.svg").read_text()


def test_fmi_3_carries_terminals_and_icons_and_fmi_2_a_picture(tmp_path: Path) -> None:
    unit = load("cradle")
    three = members(unit, unit.variables, 3, None, native_notice(3))
    assert {
        "terminalsAndIcons/terminalsAndIcons.xml",
        "terminalsAndIcons/icon.png",
        "terminalsAndIcons/icon.svg",
    } <= set(three)
    assert "model.png" in members(unit, unit.variables, 2, None, native_notice(2))
    place = tmp_path / "terminalsAndIcons.xml"
    place.write_bytes(terminals_and_icons(unit))
    schema = Path(fmpy.__file__).parent / "schema" / "fmi3" / "fmi3TerminalsAndIcons.xsd"
    lxml.etree.XMLSchema(file=str(schema)).assertValid(lxml.etree.parse(place))
    root = ElementTree.parse(place).getroot()
    found = {m.get("memberName"): m.get("variableName") for m in root.iter("TerminalMemberVariable")}
    assert found == {"force": "line_tension", "displacement": "heave"}


def test_the_licences_of_all_parts_are_there(fmus: Path) -> None:
    text = native_notice(2)
    assert "Modelica Association" in text and "Redistribution and use in source and binary forms" in text
    with zipfile.ZipFile(fmus / "cradle.fmu") as archive:
        terms = archive.read("documentation/licenses/license.txt").decode()
    assert (Path(__file__).parents[2] / "LICENSE").read_text() in terms
    assert "The libraries in binaries/ are those of PythonFMU" in terms and "NTNU" in terms


def test_the_page_renders_the_docstring(fmus: Path) -> None:
    with zipfile.ZipFile(fmus / "cradle.fmu") as archive:
        page = archive.read("documentation/index.html").decode()
    assert "<td>heave from the static equilibrium, positive up</td>" in page and "<pre><code>M y'' = T - W" in page
    assert "| symbol |" not in page and "aria-label='Inputs and outputs of cradle'" in page
