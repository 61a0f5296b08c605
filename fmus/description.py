"""``modelDescription.xml`` (FMI 2.0.4, co-simulation) of a unit, from its declaration."""

from __future__ import annotations

from xml.etree.ElementTree import Element, SubElement, indent, tostring

from .quantities import unit_definition
from .unit import Unit, Variable

GENERATION_TOOL = "towage"
LOG_CATEGORIES = {
    "logStatusDiscard": "Steps that could not be computed",
    "logStatusError": "Calls that were refused",
    "logStatusFatal": "Values or calls after which the instance is of no use",
}
DEFAULT_EXPERIMENT = {"startTime": "0", "stopTime": "60", "stepSize": "0.1"}


def number(value: float) -> str:
    """Shortest text that reads back to the same double."""
    text = repr(float(value))
    return text[:-2] if text.endswith(".0") else text


def model_description(unit: Unit, identifier: str, guid: str, options: dict[str, str]) -> bytes:
    """The XML document. ``options`` are the attributes of the ``CoSimulation`` element that differ by flavour."""
    root = Element(
        "fmiModelDescription",
        fmiVersion="2.0",
        modelName=unit.name,
        guid=guid,
        description=unit.description,
        license="MIT",
        generationTool=GENERATION_TOOL,
        variableNamingConvention="structured",
        numberOfEventIndicators="0",
    )
    SubElement(root, "CoSimulation", {"modelIdentifier": identifier, **options})
    _units(root, unit)
    categories = SubElement(root, "LogCategories")
    for name, text in LOG_CATEGORIES.items():
        SubElement(categories, "Category", name=name, description=text)
    SubElement(root, "DefaultExperiment", DEFAULT_EXPERIMENT)
    variables = SubElement(root, "ModelVariables")
    for reference, v in enumerate(unit.variables):
        _variable(variables, reference, v)
    _structure(root, unit)
    indent(root)
    return b'<?xml version="1.0" encoding="UTF-8"?>\n%b\n' % tostring(root, encoding="utf-8")


def _units(root: Element, unit: Unit) -> None:
    definitions = SubElement(root, "UnitDefinitions")
    wanted: dict[str, set[str]] = {}
    for v in unit.variables:
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


def _variable(parent: Element, reference: int, v: Variable) -> None:
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
    SubElement(element, "Real", real)


def _structure(root: Element, unit: Unit) -> None:
    structure = SubElement(root, "ModelStructure")
    outputs = [(i, v) for i, v in enumerate(unit.variables) if v.causality == "output"]
    node = SubElement(structure, "Outputs")
    for i, v in outputs:
        # of the knowns of FMI 2 only inputs act without delay; their derivatives are tunable parameters
        known = [unit.index[name] for name in v.depends]
        SubElement(node, "Unknown", index=str(i + 1), dependencies=" ".join(str(k + 1) for k in known))
    node = SubElement(structure, "InitialUnknowns")
    for i, v in enumerate(unit.variables):
        if v.causality in ("output", "calculatedParameter"):
            SubElement(node, "Unknown", index=str(i + 1))
