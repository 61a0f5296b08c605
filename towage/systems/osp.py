"""``OspSystemStructure.xml`` of the Open Simulation Platform as a `Network`.

Values pass as numbers: hosts of OSP convert no units of measure. Functions become nodes on the way; what a scene has no place for
(sums, a step of a simulator's own) is refused or said. Variable groups stand in ``<model>_OspModelDescription.xml`` beside the
description or the FMU; groups within a group are connected in their order.

Source: schema OspSystemStructure 0.1 and OSP interface specification 1.0.0, as libcosim 0.11 reads them.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import parse_qs, urlsplit
from xml.etree.ElementTree import Element

from towage.systems.network import SOURCES, TARGETS, Change, Component, Edge, Given, Network, Node
from towage.systems.parameters import value_of
from towage.systems.source import Files, local

ROOT = "OspSystemStructure"
MAIN = "OspSystemStructure.xml"
FIXED = "fixedStep"
Groups = dict[str, Element]


def read(files: Files, name: str, file: Path) -> Network:
    """The system in the description ``name`` of ``files``, which stand in ``file``. Raises `SceneError`."""
    network = Network(files, file, title=file.stem)
    return Reader(network, name).network


class Reader:
    """Reads a description into a network."""

    def __init__(self, network: Network, name: str) -> None:
        self.network, self.name = network, name
        self.groups: dict[str, Groups] = {}
        root = network.files.xml(name, ROOT, texts=True)
        parts = {local(child): child for child in root}
        for tag, child in parts.items():
            self._part(tag, child)
        self.functions = set(self._functions(parts.get("Functions")))
        for simulator in parts.get("Simulators", ()):
            self._simulator(simulator)
        for connection in parts.get("Connections", ()):
            self._connection(connection)

    def _part(self, tag: str, element: Element) -> None:
        """Times and the algorithm."""
        network = self.network
        if tag == "StartTime":
            network.start = self._number(element.text, tag)
        elif tag == "EndTime":
            network.stop = self._number(element.text, tag)
        elif tag == "BaseStepSize":
            network.step = self._number(element.text, tag)
        elif tag == "EccoConfiguration":
            network.say("info", f"{tag} is not read: error control is coupling.tolerance")
        elif tag == "Algorithm":
            if (word := (element.text or "").strip()) != FIXED:
                network.say(
                    "info", f"the algorithm {word!r} is not one of towage's, which chooses by itself: coupling.scheme"
                )
        elif tag == "Description":
            network.text = (element.text or "").strip()
        elif tag not in ("Simulators", "Functions", "Connections"):
            network.say("warning", f"{self.name}: <{tag}> is not understood, and ignored")

    def _number(self, written: str | None, place: str) -> float:
        value = value_of("Real", (written or "").strip())
        if not isinstance(value, float):
            raise self.network.fault(f"{written!r} is no finite number", f"{self.name}: {place}")
        return value

    def _functions(self, group: Element | None) -> Iterator[str]:
        """The names of linear transformations, which become edges. Raises `SceneError` for other functions."""
        for element in () if group is None else group:
            tag, name = local(element), element.get("name", "")
            place = f"function {name!r}"
            if tag != "LinearTransformation":
                raise self.network.fault(
                    f"is a {tag}, for which a scene has no place: have a unit add the values up",
                    f"{self.name}: {place}",
                )
            factor, offset = (
                self._number(element.get(key, default), place) for key, default in (("factor", "1"), ("offset", "0"))
            )
            node = "function", name
            self.network.connect(
                Edge((node, "in"), (node, "out"), True, Change(factor, offset), f"{self.name}: {place}")
            )
            yield name

    def _simulator(self, element: Element) -> None:
        name, network = element.get("name", ""), self.network
        place = f"{self.name}: simulator {name!r}"
        uri = element.get("source", "")
        if uri.startswith("proxyfmu:"):
            uri = self._unproxied(uri, place)
        fmu = network.files.name(uri, self.name)
        description = network.files.description(fmu)
        network.add(Component((name,), network.files, fmu, description), place)
        if step := element.get("stepSize"):
            own = self._number(step, place)
            if network.step is None or own != network.step:
                network.say(
                    "warning",
                    f"{name} has a step of its own, {own:g} s: all units are coupled at the step of the scene",
                )
        self.groups[name] = self._groups(fmu, description.model_name)
        for values in element:
            for initial in values if local(values) == "InitialValues" else ():
                self._initial(name, initial)

    def _unproxied(self, uri: str, place: str) -> str:
        """The file behind a URI of proxy-fmu on this machine. Raises `SceneError` for another machine."""
        parts = urlsplit(uri)
        files = parse_qs(parts.query).get("file", [])
        if (parts.hostname or "localhost") not in ("localhost", "127.0.0.1") or len(files) != 1:
            raise self.network.fault(f"{uri!r} is not fetched from another machine", place)
        self.network.say(
            "info", "units run in this process, not through proxy-fmu: --isolate gives each one of its own"
        )
        return files[0]

    def _initial(self, name: str, element: Element) -> None:
        variable = element.get("variable", "")
        place = f"{self.name}: initial value of {name}.{variable}"
        node = (name,), variable
        if self.network.variable(node) is None:
            raise self.network.fault("its FMU has no such variable", place)
        for child in element:
            value = value_of(local(child), child.get("value", ""))
            if value is None:
                raise self.network.fault(f"{child.get('value')!r} is no {local(child)}", place)
            self.network.give(node, Given(value, None, True, Change(), place))

    # ---- connections -------------------------------------------------------------------------------------------------

    def _connection(self, element: Element) -> None:
        tag, ends = local(element), [child for child in element if local(child) != "Annotations"]
        place = f"{self.name}: {tag} " + " - ".join(
            f"{e.get('simulator') or e.get('function')}.{e.get('name')}" for e in ends
        )
        if len(ends) != 2:
            raise self.network.fault("a connection has two ends", place)
        if tag == "VariableConnection":
            self._variables(self._variable(ends[0], place), self._variable(ends[1], place), place)
        elif tag == "SignalConnection":
            one, other = (
                self._variable(end, place) if local(end) == "Variable" else self._signal(end, place) for end in ends
            )
            self._variables(one, other, place)
        elif tag == "VariableGroupConnection":
            self._grouped(ends, place)
        else:
            raise self.network.fault(f"<{tag}> has no place in a scene", place)

    def _variable(self, end: Element, place: str) -> Node:
        node = (end.get("simulator", ""),), end.get("name", "")
        if node[0] not in self.network.components:
            raise self.network.fault(f"there is no simulator {end.get('simulator')!r}", place)
        if self.network.variable(node) is None:
            raise self.network.fault(f"the FMU of {node[0][0]} has no variable {node[1]!r}", place)
        return node

    def _signal(self, end: Element, place: str) -> Node:
        function, name = end.get("function", ""), end.get("name", "")
        if function not in self.functions or name not in ("in", "out"):
            raise self.network.fault(f"there is no function {function!r} with a signal {name!r}", place)
        return ("function", function), name

    def _variables(self, one: Node, other: Node, place: str) -> None:
        """Connect two nodes, whichever gives and whichever takes. Raises `SceneError` where neither does, or both."""
        gives = [self._gives(node) for node in (one, other)]
        if gives[0] == gives[1]:
            raise self.network.fault(f"both ends {'give' if gives[0] else 'take'} values", place)
        source, target = (one, other) if gives[0] else (other, one)
        self._say_units(source, target)
        self.network.connect(Edge(source, target, True, Change(), place))

    def _gives(self, node: Node) -> bool:
        variable = self.network.variable(node)
        if variable is None:
            return node[1] == "out"
        if variable.causality not in (*SOURCES, *TARGETS):
            raise self.network.fault(f"{node[0][0]}.{node[1]} is {variable.causality}", self.name)
        return variable.causality in SOURCES

    def _say_units(self, source: Node, target: Node) -> None:
        """A conversion that a scene would make, and a host of OSP does not."""
        one, other = self.network.variable(source), self.network.variable(target)
        if one and other and one.type == "Real" and self.network.unit(source) != self.network.unit(target):
            text = f"{source[0][0]}.{source[1]} [{one.unit}] -> {target[0][0]}.{target[1]} [{other.unit}]"
            if one.unit and other.unit and self.network.unit(source) and self.network.unit(target):
                self.network.say("warning", f"{text}: the number passes unchanged, as hosts of OSP have it")

    # ---- variable groups ---------------------------------------------------------------------------------------------

    def _groups(self, fmu: str, model: str) -> Groups:
        """The variable groups of a model, those within others too."""
        files, file = self.network.files, f"{model}_OspModelDescription.xml"
        if not re.fullmatch(r"[^/\\:\x00-\x1f]+", model):
            return {}
        for place in (files.name(file, fmu), file):
            if (files.root / place).is_file():
                root = files.xml(place, "OspModelDescription")
                groups = (e for top in root if local(top) == "VariableGroups" for e in top.iter() if e.get("name"))
                return {e.get("name", ""): e for e in reversed(list(groups))}  # outer ones prevail
        return {}

    def _grouped(self, ends: list[Element], place: str) -> None:
        """Connect the variables of two groups in their order. Raises `SceneError` where they do not fit."""
        groups = []
        for end in ends:
            simulator, name = end.get("simulator", ""), end.get("name", "")
            if name not in self.groups.get(simulator, {}):
                raise self.network.fault(f"{simulator!r} has no variable group {name!r}", place)
            groups.append([((simulator,), ref) for ref in _references(self.groups[simulator][name])])
        if len(groups[0]) != len(groups[1]):
            raise self.network.fault(f"the groups have {len(groups[0])} and {len(groups[1])} variables", place)
        for one, other in zip(*groups):
            for node in (one, other):
                if self.network.variable(node) is None:
                    raise self.network.fault(f"the FMU of {node[0][0]} has no variable {node[1]!r}", place)
            self._variables(one, other, place)


def _references(group: Element) -> Iterator[str]:
    """The variables of a group, and of the groups in it."""
    for element in group.iter():
        if local(element) == "Variable":
            yield element.get("ref", "")
