"""Small systems of SSP and OSP, written by hand: units of the zoo (y' = gain u, w = gain u) connected in every way."""

from __future__ import annotations

import zipfile
from collections.abc import Mapping
from pathlib import Path

from tests.zoo.zoo import animal

SPACES = " ".join(
    f'xmlns:{short}="http://ssp-standard.org/SSP1/SystemStructure{name}"'
    for short, name in {
        "ssd": "Description", "ssc": "Common", "ssv": "ParameterValues", "ssm": "ParameterMapping", "ssb": "SignalDictionary",
    }.items()
)  # fmt: skip
UNITS = (
    '<{0}:Units><ssc:Unit name="m"><ssc:BaseUnit m="1"/></ssc:Unit>'
    '<ssc:Unit name="km"><ssc:BaseUnit m="1" factor="1000"/></ssc:Unit>'
    '<ssc:Unit name="K"><ssc:BaseUnit K="1"/></ssc:Unit><ssc:Unit name="degC"><ssc:BaseUnit K="1" offset="273.15"/></ssc:Unit>'
    "</{0}:Units>"
)
"""By the prefix of the document."""
DEFINED = (
    '<UnitDefinitions><Unit name="K"><BaseUnit K="1"/></Unit><Unit name="degC"><BaseUnit K="1" offset="273.15"/></Unit>'
    '<Unit name="m"><BaseUnit m="1"/></Unit><Unit name="km"><BaseUnit m="1" factor="1000"/></Unit></UnitDefinitions>'
)
"""In an FMU."""
STEP = (
    '<ssd:Annotations><ssc:Annotation type="com.opensimulationplatform"><osp:Algorithm xmlns:osp="http://open">'
    '<osp:FixedStepAlgorithm baseStepSize="0.1"/></osp:Algorithm></ssc:Annotation></ssd:Annotations>'
)


def connectors(text: str) -> str:
    """ "u:input y:output:m" as connectors: name, kind, unit of a Real; a type in place of the unit begins with a capital."""
    told = ""
    for word in text.split():
        name, kind, about = (*word.split(":"), "")[:3]
        inner = (
            f"<ssc:{about}/>"
            if about[:1].isupper() and about != "K"
            else f'<ssc:Real unit="{about}"/>'
            if about
            else "<ssc:Real/>"
        )
        told += f'<ssd:Connector name="{name}" kind="{kind}">{inner}</ssd:Connector>'
    return f"<ssd:Connectors>{told}</ssd:Connectors>"


def component(
    name: str, source: str = "resources/a.fmu", ends: str = "u:input y:output w:output", inside: str = "", **about: str
) -> str:
    """A component; ``inside``: its bindings."""
    more = "".join(f' {key}="{value}"' for key, value in about.items())
    return f'<ssd:Component name="{name}" source="{source}"{more}>{connectors(ends)}{inside}</ssd:Component>'


def system(elements: str, links: str = "", inside: str = "", ends: str = "", name: str = "sub", **about: str) -> str:
    """A system; ``inside``: dictionaries and bindings."""
    more = "".join(f' {key}="{value}"' for key, value in about.items())
    joined = f"<ssd:Connections>{links}</ssd:Connections>" if links else ""
    outer = connectors(ends) if ends else ""
    return (
        f'<ssd:System name="{name}"{more}>{outer}<ssd:Elements>{elements}</ssd:Elements>{joined}{inside}</ssd:System>'
    )


def link(start: str, end: str, inside: str = "", **about: str) -> str:
    """A connection "a.y", "b.u"; without an element: a connector of the system."""
    more = "".join(f' {key}="{value}"' for key, value in about.items())
    for side, text in (("start", start), ("end", end)):
        element, _, connector = text.rpartition(".")
        more += (f' {side}Element="{element}"' if element else "") + f' {side}Connector="{connector}"'
    return f"<ssd:Connection{more}>{inside}</ssd:Connection>"


def values(given: Mapping[str, object], mapping: str = "", **about: str) -> str:
    """A binding with the parameters inline; "x:km" is a name with the unit of its value."""
    more = "".join(f' {key}="{value}"' for key, value in about.items())
    inline = f"<ssd:ParameterValues>{parameters(given)}</ssd:ParameterValues>"
    return f"<ssd:ParameterBinding{more}>{inline}{mapping}</ssd:ParameterBinding>"


def parameters(given: Mapping[str, object]) -> str:
    """A parameter set."""
    told = ""
    for key, value in given.items():
        name, _, unit = key.partition(":")
        kind = {bool: "Boolean", int: "Integer", str: "String"}.get(type(value), "Real")
        measured = f' unit="{unit}"' if unit else ""
        told += f'<ssv:Parameter name="{name}"><ssv:{kind} value="{str(value).lower()}"{measured}/></ssv:Parameter>'
    head = f'<ssv:ParameterSet {SPACES} version="1.0" name="p">'
    return f"{head}<ssv:Parameters>{told}</ssv:Parameters>{UNITS.format('ssv')}</ssv:ParameterSet>"


def bindings(*inside: str) -> str:
    """The bindings of an element."""
    return f"<ssd:ParameterBindings>{''.join(inside)}</ssd:ParameterBindings>"


def ssd(root: str, stop: str = "2", version: str = "1.0") -> str:
    """A description whose system is ``root``."""
    experiment = f'<ssd:DefaultExperiment stopTime="{stop}">{STEP}</ssd:DefaultExperiment>' if stop else ""
    head = f'<ssd:SystemStructureDescription {SPACES} version="{version}" name="A system">'
    return f"{head}{root}{UNITS.format('ssd')}{experiment}</ssd:SystemStructureDescription>"


def archive(path: Path, text: str, files: Mapping[str, str | bytes] | None = None, **about: object) -> Path:
    """An archive with a description, a unit of the zoo as resources/a.fmu, and further files; ``about`` goes to `animal`."""
    unit = Path(animal(path.with_suffix(".fmu"), **about)).read_bytes()  # type: ignore[arg-type]
    with zipfile.ZipFile(path, "w") as out:
        for name, content in {"SystemStructure.ssd": text, "resources/a.fmu": unit, **(files or {})}.items():
            out.writestr(name, content)
    return path
