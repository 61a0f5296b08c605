"""What every FMU carries beside its description and its code: the page, the licences, a reference run, an icon, terminals.

| member | for |
|---|---|
| `documentation/index.html` | people |
| `documentation/licenses/license.txt` | the terms of the unit and of what it is made with (FMI 2.0.4, 2.3; FMI 3.0, 2.5.1.2) |
| `documentation/<unit>_start.ssv`, `_in.csv`, `_ref.opt`, `_ref.csv` | a program that reproduces the reference run |
| `extra/org.fmi-standard.fmi-ls-ref/fmi-ls-manifest.xml` | their roles (FMI-LS-REF 1.0.0-alpha.1) |
| `model.png` (FMI 2), `terminalsAndIcons/` (FMI 3.0, 2.4.9) | drawings in other tools, and which variables are plugged together |
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from importlib import metadata
from pathlib import Path
from typing import NamedTuple
from xml.etree.ElementTree import Element, SubElement

from ..declare.unit import Unit, Variable
from .documentation import documentation_page
from .fmi2 import document, number

ICONS = Path(__file__).resolve().parent / "icons"
HEADERS = Path(__file__).resolve().parents[1] / "native" / "runtime"
LS_REF = "extra/org.fmi-standard.fmi-ls-ref/fmi-ls-manifest.xml"
LS_REF_NAME, LS_REF_VERSION = "org.fmi-standard.fmi-ls-ref", "1.0.0-alpha.1"
LS_REF_TEXT = "Layered Standard providing information on related files included in an FMU."
SSV = "http://ssp-standard.org/SSP1/SystemStructureParameterValues"
ICON_SIZE = 100
"""Width and height of an icon in pixels of its coordinate system."""


class Reference(NamedTuple):
    """A reference run: CSV of what is set at the times of the steps, CSV of the outputs there, and the step in s."""

    inputs: str
    outputs: str
    step: float
    steps: int


def members(
    unit: Unit, variables: Sequence[Variable], fmi: int, reference: Reference | None, made_with: str
) -> dict[str, bytes]:
    """The members by path. ``variables``: those of the flavour; ``reference``: None where the unit has no run that can be
    made with its start values; ``made_with``: the licences that the binaries bring, `python_notice` or `native_notice`."""
    found = {
        "documentation/index.html": documentation_page(unit, variables, reference is not None, icon(unit)).encode(),
        "documentation/licenses/license.txt": f"{_license('towage')}\n{made_with}".encode(),
    }
    if reference:
        found |= _reference_files(unit, reference)
    if fmi == 2:
        found["model.png"] = _icon_file(unit, "png").read_bytes()
    else:
        found["terminalsAndIcons/icon.png"] = _icon_file(unit, "png").read_bytes()
        found["terminalsAndIcons/icon.svg"] = _icon_file(unit, "svg").read_bytes()
        found["terminalsAndIcons/terminalsAndIcons.xml"] = terminals_and_icons(unit)
    return found


def icon(unit: Unit) -> str:
    """The unit's icon as SVG; a plain one where it has none of its own."""
    return _icon_file(unit, "svg").read_text(encoding="utf-8")


def _icon_file(unit: Unit, suffix: str) -> Path:
    own = ICONS / f"{unit.name}.{suffix}"
    return own if own.is_file() else ICONS / f"unit.{suffix}"


def python_notice() -> str:
    """Licence of the bridge in a Python FMU."""
    return f"\nThe libraries in binaries/ are those of PythonFMU:\n\n{_license('pythonfmu')}"


def native_notice(fmi: int) -> str:
    """Licence of the FMI headers that a native FMU is compiled with and carries in its sources."""
    header = (HEADERS / f"fmi{fmi}" / f"fmi{fmi}Functions.h").read_text(encoding="utf-8")
    notice = header[header.index("Copyright") :].partition("*/")[0]
    return f"\nsources/fmi{fmi}*.h are headers of the FMI standard:\n\n{notice.rstrip()}\n"


def _license(distribution: str) -> str:
    """The licence text of an installed package."""
    for file in metadata.files(distribution) or ():
        if file.name.startswith("LICENSE"):
            return Path(str(file.locate())).read_text(encoding="utf-8")
    raise FileNotFoundError(f"{distribution} is installed without its licence, which an FMU must carry: install it again")


def _reference_files(unit: Unit, reference: Reference) -> dict[str, bytes]:
    """The files of the reference run, and the manifest that says what they are."""
    name = unit.name
    options = f"StartTime, 0.0\nStopTime, {reference.step * reference.steps:.12g}\nStepSize, {reference.step:g}\n"
    files = {
        f"{name}_start.ssv": ("application/x-ssp-parameter-set", "parameter", "Parameters of the reference run", _ssv(unit)),
        f"{name}_in.csv": (
            "text/csv", "testcase", "Inputs and their derivatives, to be set before each step", reference.inputs.encode(),
        ),
        f"{name}_ref.opt": ("text/plain", "experiment/smoke-test", "Times and step of the reference run", options.encode()),
        f"{name}_ref.csv": ("text/csv", "result", "Outputs of the reference run", reference.outputs.encode()),
    }  # fmt: skip
    root = Element(
        "fmiReferences",
        {
            "xmlns:fmi-ls": "http://fmi-standard.org/fmi-ls-manifest", "fmi-ls:fmi-ls-name": LS_REF_NAME,
            "fmi-ls:fmi-ls-version": LS_REF_VERSION, "fmi-ls:fmi-ls-description": LS_REF_TEXT,
        },
    )  # fmt: skip
    for file, (kind, role, description, _) in files.items():
        source = f"../../documentation/{file}"
        SubElement(root, "Related", {"type": kind, "source": source, "role": role, "description": description})
    return {f"documentation/{file}": entry[-1] for file, entry in files.items()} | {LS_REF: document(root)}


def _ssv(unit: Unit) -> bytes:
    """The start values of the reference run as a parameter set of SSP 1.0."""
    root = Element("ssv:ParameterSet", {"xmlns:ssv": SSV, "version": "1.0", "name": "reference"})
    parameters = SubElement(root, "ssv:Parameters")
    for name, value in unit.start.items():
        SubElement(SubElement(parameters, "ssv:Parameter", name=name), "ssv:Real", value=number(value))
    return document(root)


def terminals_and_icons(unit: Unit) -> bytes:
    """``terminalsAndIcons.xml``: the icon, and each place where the unit is joined to another with the variables that meet
    there. Members of one name belong together, whatever the variables are called."""
    root = Element("fmiTerminalsAndIcons", fmiVersion="3.0")
    corners = {"x1": "0", "y1": "0", "x2": str(ICON_SIZE), "y2": str(ICON_SIZE)}
    graphics = SubElement(root, "GraphicalRepresentation")
    SubElement(graphics, "CoordinateSystem", {**corners, "suggestedScalingFactorTo_mm": "0.2"})
    SubElement(graphics, "Icon", corners)
    if unit.terminals:
        places = SubElement(root, "Terminals")
        for terminal, variables in unit.terminals.items():
            _terminal(places, terminal, variables)
    return document(root)


def _terminal(parent: Element, name: str, variables: Mapping[str, str]) -> None:
    node = SubElement(parent, "Terminal", {"name": name, "matchingRule": "plug", "terminalKind": "org.towage.bond"})
    for member, variable in variables.items():
        SubElement(node, "TerminalMemberVariable",
                   {"variableName": variable, "memberName": member, "variableKind": "signal"})  # fmt: skip
