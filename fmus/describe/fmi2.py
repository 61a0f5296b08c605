"""``modelDescription.xml`` (FMI 2.0.4) of a unit, from its declaration: co-simulation, for the native flavour model
exchange too."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from importlib import metadata
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from ..declare.interface import Interface
from ..declare.quantities import unit_definition
from ..declare.unit import Unit, Variable

_NOT_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
GENERATION_TOOL = "towage"
AUTHORS = "The towage developers"
LOG_CATEGORIES = {
    "logStatusDiscard": "Steps that could not be computed",
    "logStatusError": "Calls that were refused",
    "logStatusFatal": "Values or calls after which the instance is of no use",
}
BOTH = {
    "needsExecutionTool": "false",
    "canBeInstantiatedOnlyOncePerProcess": "false",
    "canNotUseMemoryManagementFunctions": "true",
    "canGetAndSetFMUstate": "true",
    "canSerializeFMUstate": "true",
    "providesDirectionalDerivative": "true",
}
MODEL_EXCHANGE = BOTH | {"completedIntegratorStepNotNeeded": "true"}
CO_SIMULATION = BOTH | {
    "canHandleVariableCommunicationStepSize": "true",
    "canInterpolateInputs": "true",
    "maxOutputDerivativeOrder": "1",
}
"""What the native flavour can do."""
DEFAULT_EXPERIMENT = {"startTime": "0", "stopTime": "60", "stepSize": "0.1"}


def number(value: float) -> str:
    """Shortest text that reads back to the same double."""
    text = repr(float(value))
    return text[:-2] if text.endswith(".0") else text


def model_description(unit: Unit, identifier: str, guid: str, options: dict[str, str]) -> bytes:
    """The XML document of the Python flavour. ``options`` are the attributes of the ``CoSimulation`` element."""
    root = _root(unit, guid, indicators=0)
    SubElement(root, "CoSimulation", {"modelIdentifier": identifier, **options})
    return _document(root, Interface(unit))


def native_model_description(interface: Interface, identifier: str, guid: str, sources: Sequence[str]) -> bytes:
    """The XML document of the native flavour. ``sources`` are the names of the C files that make the library."""
    root = _root(interface.unit, guid, interface.indicators)
    kinds = (("ModelExchange", MODEL_EXCHANGE), ("CoSimulation", CO_SIMULATION))
    for kind, options in kinds if interface.exchange else kinds[1:]:
        files = SubElement(SubElement(root, kind, {"modelIdentifier": identifier, **options}), "SourceFiles")
        for name in sources:
            SubElement(files, "File", name=name)
    return _document(root, interface)


def root_element(unit: Unit, version: str, **token: str) -> Element:
    """What both versions of FMI begin with. ``token``: guid or instantiationToken."""
    release = metadata.version("towage")
    attributes = {
        "fmiVersion": version, "modelName": unit.name, **token, "description": unit.description,
        "author": AUTHORS, "version": release, "copyright": f"Copyright (c) 2026 {AUTHORS}", "license": "MIT",
        "generationTool": f"{GENERATION_TOOL} {release}", "variableNamingConvention": "structured",
    }  # fmt: skip
    return Element("fmiModelDescription", attributes)


def _root(unit: Unit, guid: str, indicators: int) -> Element:
    root = root_element(unit, "2.0", guid=guid)
    root.set("numberOfEventIndicators", str(indicators))
    return root


def _document(root: Element, interface: Interface) -> bytes:
    preamble(root, interface.variables)
    _annotations(root, interface.unit)
    variables, layout = SubElement(root, "ModelVariables"), interface.layout
    for reference, v in enumerate(interface.variables):
        real = _variable(variables, reference, v)
        if reference in layout.states and interface.reinit[layout.states.index(reference)]:
            real.set("reinit", "true")
        if reference in layout.state_derivatives:
            real.set("derivative", str(layout.states[layout.state_derivatives.index(reference)] + 1))
    _structure(root, interface)
    return document(root)


def document(root: Element) -> bytes:
    """The text of an XML document; letters that XML does not allow, which a title may have, are spelled as in Python."""
    for element in root.iter():
        element.text = element.text and _NOT_XML.sub(_spelled, element.text)
        element.attrib.update({name: _NOT_XML.sub(_spelled, value) for name, value in element.attrib.items()})
    indent(root)
    return b'<?xml version="1.0" encoding="UTF-8"?>\n%b\n' % tostring(root, encoding="utf-8")


def _spelled(found: re.Match[str]) -> str:
    return found[0].encode("unicode_escape").decode()


def preamble(root: Element, variables: Iterable[Variable]) -> None:
    """What comes before the variables, the same in FMI 2 and 3: units, log categories, default experiment."""
    _units(root, variables)
    categories = SubElement(root, "LogCategories")
    for name, text in LOG_CATEGORIES.items():
        SubElement(categories, "Category", name=name, description=text)
    SubElement(root, "DefaultExperiment", DEFAULT_EXPERIMENT)


def _annotations(root: Element, unit: Unit) -> None:
    tool = SubElement(SubElement(root, "VendorAnnotations"), "Tool", name=GENERATION_TOOL)
    annotate(tool, unit)


def annotate(tool: Element, unit: Unit) -> None:
    """For towage, the same in FMI 2 and 3: that names mean what its conventions say, what it means that an input is neither
    connected nor set: ``needed``, or in words, and which parameters are needed. All in one element, as the schemas want it."""
    own = SubElement(tool, "Interface")
    SubElement(own, "Conventions")
    said = [v for v in unit.inputs if v.needed or v.unset]
    if said:
        inputs = SubElement(own, "Inputs")
        for v in said:
            SubElement(inputs, "Input", {"name": v.name, **({"needed": "true"} if v.needed else {"unset": v.unset})})
    needed = [v for v in unit.parameters if v.needed]
    if needed:
        parameters = SubElement(own, "Parameters")
        for v in needed:
            SubElement(parameters, "Parameter", name=v.name, needed="true")


def _units(root: Element, variables: Iterable[Variable]) -> None:
    definitions = SubElement(root, "UnitDefinitions")
    wanted: dict[str, set[str]] = {}
    for v in variables:
        wanted.setdefault(v.unit, set()).update({v.display} if v.display else set())
    for name in sorted(wanted):
        exponents, factor, displays = unit_definition(name)
        element = SubElement(definitions, "Unit", name=name)
        base = {base: str(e) for base, e in exponents.items() if e}
        SubElement(element, "BaseUnit", base if factor == 1.0 else {**base, "factor": number(factor)})
        for display, display_factor in displays:
            if display in wanted[name]:
                # FMI: value in display units = factor * value in SI
                SubElement(element, "DisplayUnit", name=display, factor=number(display_factor))


def _variable(parent: Element, reference: int, v: Variable) -> Element:
    initial = "exact" if v.causality == "parameter" else None if v.causality == "input" else "calculated"
    attributes = {
        "name": v.name, "valueReference": str(reference), "description": v.description, "causality": v.causality,
        "variability": v.variability,
    }  # fmt: skip
    element = SubElement(parent, "ScalarVariable", attributes | ({"initial": initial} if initial else {}))
    real = {"unit": v.unit}
    if v.display:
        real["displayUnit"] = v.display
    for key in ("min", "max", "nominal", "start"):
        value = getattr(v, key)
        if value is not None:
            real[key] = number(value)
    return SubElement(element, "Real", real)


def _structure(root: Element, interface: Interface) -> None:
    structure = SubElement(root, "ModelStructure")
    outputs = [i for i, v in enumerate(interface.variables) if v.causality == "output"]
    layout = interface.layout
    for title, references in (("Outputs", outputs), ("Derivatives", layout.state_derivatives)):
        if references:
            node = SubElement(structure, title)
            for i in references:
                known = "".join(f" {k + 1}" for k in interface.depends(i)).strip()
                SubElement(node, "Unknown", index=str(i + 1), dependencies=known)
    node = SubElement(structure, "InitialUnknowns")
    for i in sorted([*outputs, *layout.calculated, *layout.states, *layout.state_derivatives]):
        SubElement(node, "Unknown", index=str(i + 1))
