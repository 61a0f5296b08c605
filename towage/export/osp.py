"""A scene as a system of the Open Simulation Platform: ``OspSystemStructure.xml``, the FMUs, and their ports.

Two connections between two units that carry a force one way and a motion the other way are a port: with a velocity
OSP's LinearMechanicalPort, with a displacement its LinearMechanicalQuasiPort. Which variables belong together is no
property of a unit but of the scene, so the ports in ``<model>_OspModelDescription.xml`` are those that the scene uses.

Source: OSP interface specification (OSP-IS) 1.0.0 and the schema OspSystemStructure 0.1, as libcosim reads them.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import NamedTuple
from xml.etree.ElementTree import Element, SubElement

from towage.errors import TowageError
from towage.export.export import Export, text
from towage.files import atomic_write
from towage.fmus.describe.fmi2 import document
from towage.master.bonds import Bond, bonds
from towage.scene.resolve import ResolvedConnection

SYSTEM = "OspSystemStructure.xml"
SYSTEM_NAMESPACE = "http://opensimulationplatform.com/MSMI/OSPSystemStructure"
MODEL_NAMESPACE = "https://open-simulation-platform.com/OspModelDescription/1.0.0"
_FILE_NAME = re.compile(r"\w[\w .+-]*")


class Port(NamedTuple):
    """One side of a bond: variables of one unit."""

    force: str
    motion: str
    velocity: bool

    @property
    def name(self) -> str:
        """Unique in its model, whose variables it names."""
        return f"{self.force}-{self.motion}"


def write_osp(export: Export, directory: Path) -> list[Path]:
    """Write the system; the host is given ``directory``. Files of the same names are replaced. Raises `TowageError`, a
    `SceneError` where values are looked up in a table, for which OSP has no function."""
    if tables := [str(c) for c in export.resolved.connections if c.values]:
        message = "looks values up, for which OSP has no function: export with --ssp"
        raise export.resolved.scene.error(message, f"transformations.{tables[0]}")
    try:
        directory.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise TowageError(f"cannot make the directory {directory}: {error.strerror}") from error
    bound = ports(export)
    files = {SYSTEM: system_structure(export, bound), **_model_descriptions(export, bound), **export.fmus()}
    for name, content in files.items():
        with atomic_write(directory / name) as stream:
            stream.write(content)
    return [directory / name for name in files]


def ports(export: Export) -> list[Bond]:
    """The bonds of the scene that are ports on both sides: forces, not moments. A converted connection is none, because a
    port has one unit."""
    return [
        bond
        for bond in bonds(export.resolved)
        if not bond.turns and (bond.effort.factor, bond.motion.factor) == (1.0, 1.0) and _named(export, bond.effort)
    ]


def _named(export: Export, connection: ResolvedConnection) -> bool:
    """Whether both models have names that files can have, which is how the host finds their ports."""
    units = export.resolved.units
    ends = connection.source_unit, connection.target_unit
    return all(_FILE_NAME.fullmatch(units[end].description.model_name) for end in ends)


def system_structure(export: Export, bound: list[Bond]) -> bytes:
    """``OspSystemStructure.xml``."""
    scene = export.resolved.scene
    root = Element("OspSystemStructure", {"xmlns": SYSTEM_NAMESPACE, "version": "0.1"})
    for key, value in {"StartTime": 0.0, "EndTime": scene.stop_time, "BaseStepSize": export.step}.items():
        SubElement(root, key).text = text(value)
    SubElement(root, "Algorithm").text = "fixedStep"
    simulators = SubElement(root, "Simulators")
    for name, unit in export.resolved.units.items():
        simulator = SubElement(simulators, "Simulator", {"name": name, "source": export.files[name]})
        variables = unit.description.by_name()
        values = SubElement(simulator, "InitialValues") if unit.parameters else None
        for parameter, start in unit.parameters.items():
            assert values is not None
            initial = SubElement(values, "InitialValue", {"variable": parameter})
            SubElement(initial, variables[parameter].type, {"value": text(start)})
    _connect(root, export, bound)
    return document(root)


def _connect(root: Element, export: Export, bound: list[Bond]) -> None:
    """Functions for converted connections, group connections for bonds, variable connections for the rest."""
    links = export.resolved.connections
    converted = {c: f"conversion_{k}" for k, c in enumerate(c for c in links if (c.factor, c.offset) != (1.0, 0.0))}
    while set(converted.values()) & set(export.files):  # functions and units share their names
        converted = {c: f"{name}_" for c, name in converted.items()}
    if converted:
        functions = SubElement(root, "Functions")
        for c, name in converted.items():
            SubElement(functions, "LinearTransformation", {"name": name, "factor": text(c.factor), "offset": text(c.offset)})
    connections = SubElement(root, "Connections") if links else root
    for bond in bound:
        group = SubElement(connections, "VariableGroupConnection")
        for unit, port in _ports(bond):
            SubElement(group, "VariableGroup", {"simulator": unit, "name": port.name})
    grouped = {c for bond in bound for c in (bond.effort, bond.motion)}
    for c in links:
        source = {"simulator": c.source_unit, "name": c.source}
        target = {"simulator": c.target_unit, "name": c.target}
        if c in converted:
            for end, signal in ((source, "in"), (target, "out")):
                connection = SubElement(connections, "SignalConnection")
                SubElement(connection, "Variable", end)
                SubElement(connection, "Signal", {"function": converted[c], "name": signal})
        elif c not in grouped:
            connection = SubElement(connections, "VariableConnection")
            SubElement(connection, "Variable", source)
            SubElement(connection, "Variable", target)


def _ports(bond: Bond) -> tuple[tuple[str, Port], tuple[str, Port]]:
    """The sides of a bond: (unit, port) of the force's source and of its target."""
    force, motion, velocity = bond.effort, bond.motion, bond.velocity
    return (
        (force.source_unit, Port(force.source, motion.target, velocity)),
        (force.target_unit, Port(force.target, motion.source, velocity)),
    )


def _model_descriptions(export: Export, bound: list[Bond]) -> dict[str, bytes]:
    """``<model>_OspModelDescription.xml`` of every model that takes part in a bond; units are those of the FMU."""
    models: dict[str, dict[Port, str]] = {}
    for bond in bound:
        for unit, port in _ports(bond):
            models.setdefault(export.resolved.units[unit].description.model_name, {}).setdefault(port, unit)
    files = {}
    for model, ports in models.items():
        root = Element("OspModelDescription", {"xmlns": MODEL_NAMESPACE, "version": "1.0"})
        groups = SubElement(root, "VariableGroups")
        for port, unit in sorted(ports.items(), key=lambda item: not item[0].velocity):  # the schema's order of kinds
            kind, motion = (
                ("LinearMechanicalPort", "LinearVelocity")
                if port.velocity
                else ("LinearMechanicalQuasiPort", "LinearDisplacement")
            )
            element = SubElement(groups, kind, {"name": port.name})
            for quantity, name in (("Force", port.force), (motion, port.motion)):
                inner = SubElement(element, quantity, {"name": f"{port.name} {quantity}"})
                declared = export.variable(unit, name).unit or ""
                SubElement(inner, "Variable", {"ref": name, "unit": declared})
        files[f"{model}_OspModelDescription.xml"] = document(root)
    return files
