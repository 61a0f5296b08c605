"""A scene as an archive of System Structure and Parameterization (SSP 1.0, Modelica Association, 2019).

``SystemStructure.ssd`` holds components, connectors, connections and units, ``resources/`` the FMUs and one parameter set
(.ssv) a unit. A connection between two units of measurement carries its factor itself and forbids the host to convert
once more. The step is in annotations of the Open Simulation Platform and of OMSimulator, because SSP 1.0 has no place for it;
OMSimulator opens no system without its own. Its paths take only identifiers for the names of document and system, so that the
scene's title is the description of the document.

Prefixes are written out, not left to a namespace-aware writer: libcosim reads "ssd:System" as a name.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement

from towage.errors import FmuError, TowageError
from towage.export.export import Export, text
from towage.fmus.declare.quantities import BASES
from towage.fmus.describe.archive import write
from towage.fmus.describe.fmi2 import document
from towage.scene.resolve import ResolvedConnection, ResolvedUnit
from towage.units.description import UnitDefinition, Variable

NAMESPACES = {
    "ssc": "http://ssp-standard.org/SSP1/SystemStructureCommon",
    "ssd": "http://ssp-standard.org/SSP1/SystemStructureDescription",
    "ssv": "http://ssp-standard.org/SSP1/SystemStructureParameterValues",
    "osp": "http://opensimulationplatform.com/SSP/OSPAnnotations",
    "oms": "https://raw.githubusercontent.com/OpenModelica/OMSimulator/master/schema/oms.xsd",
}
PARAMETER_SET = "parameters"
"""Name of the parameter set of every unit: a host that selects sets by name (Ecos) takes those of one name."""
ANNOTATION, OMS_ANNOTATION = "com.opensimulationplatform", "org.openmodelica"
Units = dict[str, UnitDefinition]


def write_ssp(export: Export, path: Path) -> None:
    """Write the archive, replacing a file of that name. Raises `TowageError`."""
    members = {"SystemStructure.ssd": system_structure(export)}
    for name, unit in export.resolved.units.items():
        if unit.parameters:
            members[f"resources/{name}.ssv"] = _parameter_set(unit)
    members |= {f"resources/{file}": content for file, content in export.fmus().items()}
    try:
        write(path, members)
    except OSError as error:
        raise TowageError(f"cannot write {path}: {error.strerror}") from error


def system_structure(export: Export) -> bytes:
    """``SystemStructure.ssd``. Raises `FmuError` where two FMUs mean different things by one unit of measurement."""
    scene = export.resolved.scene
    name = identifier(scene.file.stem if scene.file else scene.title)
    root = _root("ssd:SystemStructureDescription", ("ssd", "ssc", "osp", "oms"), name)
    root.set("description", scene.title)
    system = SubElement(root, "ssd:System", {"name": name, "description": scene.description.strip()})
    elements = SubElement(system, "ssd:Elements")
    units: Units = {}
    for name, unit in export.resolved.units.items():
        component = SubElement(
            elements,
            "ssd:Component",
            {
                "name": name,
                "type": "application/x-fmu-sharedlibrary",
                "source": f"resources/{export.files[name]}",
                "implementation": "CoSimulation",
            },
        )
        _connectors(component, unit, units)
        if unit.parameters:
            bindings = SubElement(component, "ssd:ParameterBindings")
            SubElement(bindings, "ssd:ParameterBinding", {"source": f"resources/{name}.ssv"})
    if export.resolved.connections:
        connections = SubElement(system, "ssd:Connections")
    for c in export.resolved.connections:
        ends = {"startElement": c.source_unit, "startConnector": c.source}
        ends |= {"endElement": c.target_unit, "endConnector": c.target}
        linear = (c.factor, c.offset) != (1.0, 0.0)
        own = {"suppressUnitConversion": "true"} if linear or c.changed else {}
        connection = SubElement(connections, "ssd:Connection", {**ends, **own})
        if linear:
            SubElement(connection, "ssc:LinearTransformation", {"factor": text(c.factor), "offset": text(c.offset)})
        elif c.values:
            _table(connection, c, export.variable(c.source_unit, c.source), export.variable(c.target_unit, c.target))
    step = _annotation(system, OMS_ANNOTATION, "oms:Annotations", "oms:SimulationInformation", "oms:FixedStepMaster")
    step.attrib |= {
        "description": "oms-ma",
        "stepSize": text(export.step),
        "relativeTolerance": "1e-4",
    }  # must be there
    _define(root, "ssd", units)
    experiment = SubElement(root, "ssd:DefaultExperiment", {"startTime": "0", "stopTime": text(scene.stop_time)})
    step = _annotation(experiment, ANNOTATION, "osp:Algorithm", "osp:FixedStepAlgorithm")
    step.set("baseStepSize", text(export.step))
    return document(root)


def _annotation(parent: Element, kind: str, *tags: str) -> Element:
    """An annotation of a tool: the innermost of the elements ``tags``, to be filled."""
    inner = SubElement(SubElement(parent, "ssd:Annotations"), "ssc:Annotation", {"type": kind})
    for tag in tags:
        inner = SubElement(inner, tag)
    return inner


def identifier(name: str) -> str:
    """What OMSimulator takes for the name of a model or system: ASCII letters, digits and "_", a letter first."""
    plain = re.sub(r"[^A-Za-z0-9_]", "_", name)
    return plain if plain[:1].isalpha() else f"scene_{plain}"


def _table(connection: Element, c: ResolvedConnection, source: Variable, target: Variable) -> None:
    """The values of a discrete connection that are looked up."""
    kind = "Boolean" if source.type == "Boolean" else "Integer"
    mapping = SubElement(connection, f"ssc:{kind}MappingTransformation")
    for one, other in c.values:
        known = [bool(v) if variable.type == "Boolean" else int(v) for v, variable in ((one, source), (other, target))]
        SubElement(mapping, "ssc:MapEntry", {"source": text(known[0]), "target": text(known[1])})


def _root(tag: str, prefixes: Iterable[str], name: str) -> Element:
    spaces = {f"xmlns:{prefix}": NAMESPACES[prefix] for prefix in prefixes}
    return Element(tag, {**spaces, "version": "1.0", "name": name})


def _connectors(component: Element, unit: ResolvedUnit, units: Units) -> None:
    """Inputs, outputs and the parameters that the scene sets; ``units`` gathers what they are measured in.

    Enumerations are left out: a scene can neither connect nor set one."""
    wanted = [
        v
        for v in unit.description.variables
        if (v.causality in ("input", "output") or v.name in unit.parameters) and v.type != "Enumeration"
    ]
    connectors = SubElement(component, "ssd:Connectors") if wanted else component
    for v in wanted:
        connector = SubElement(connectors, "ssd:Connector", {"name": v.name, "kind": v.causality})
        SubElement(connector, f"ssc:{v.type}", _measure(v, unit, units))


def _parameter_set(unit: ResolvedUnit) -> bytes:
    """The .ssv document of the values that the scene gives to a unit."""
    root = _root("ssv:ParameterSet", ("ssv", "ssc"), PARAMETER_SET)
    parameters = SubElement(root, "ssv:Parameters")
    variables, units = unit.description.by_name(), Units()
    for name, value in unit.parameters.items():
        v = variables[name]
        parameter = SubElement(parameters, "ssv:Parameter", {"name": name})
        SubElement(parameter, f"ssv:{v.type}", {"value": text(value), **_measure(v, unit, units)})
    _define(root, "ssv", units)
    return document(root)


def _measure(variable: Variable, unit: ResolvedUnit, units: Units) -> dict[str, str]:
    """The attribute ``unit`` of a Real whose unit of measurement the FMU defines; the definition goes to ``units``."""
    name = variable.unit
    definition = unit.description.units.get(name or "")
    if name is None or definition is None or variable.type != "Real":
        return {}
    if units.setdefault(name, definition) != definition:
        raise FmuError(
            f"unit {name!r} is defined otherwise than in another FMU of the scene, and an SSP archive has one definition: "
            "export with --osp",
            file=unit.path,
        )
    return {"unit": name}


def _define(root: Element, prefix: str, units: Units) -> None:
    """The ``Units`` of a document."""
    if not units:
        return
    element = SubElement(root, f"{prefix}:Units")
    for name, definition in units.items():
        powers = {base: str(power) for base, power in zip(BASES, definition.exponents, strict=True) if power}
        scale = {"factor": text(definition.factor)} if definition.factor != 1.0 else {}
        scale |= {"offset": text(definition.offset)} if definition.offset else {}
        scale |= {"offset": text(definition.offset)} if definition.offset else {}
        SubElement(SubElement(element, "ssc:Unit", {"name": name}), "ssc:BaseUnit", powers | scale)
