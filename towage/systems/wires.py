"""Connectors, signal dictionaries and connections of system structure descriptions, as nodes and edges of a `Network`."""

from __future__ import annotations

from typing import NamedTuple
from xml.etree.ElementTree import Element

from towage.systems.network import SOURCES, TARGETS, Edge, Network, Node, Path, show
from towage.systems.parameters import TYPES, Document
from towage.systems.source import Files, local
from towage.units.conventions import Definition

CHANGES = (
    "LinearTransformation", "BooleanMappingTransformation", "IntegerMappingTransformation", "EnumerationMappingTransformation",
)  # fmt: skip


class Here(NamedTuple):
    """Where an element stands: its path, the document and the files it is in, the signal dictionaries in sight."""

    path: Path
    document: Document
    files: Files
    dictionaries: dict[str, Path]

    @property
    def place(self) -> str:
        """For messages."""
        return ": ".join((self.document.name, *(".".join(self.path),) * bool(self.path)))


class Wires:
    """What elements are connected by. ``kinds``: of the connectors of all elements; ``elements``: the names in every system;
    ``references``: elements that stand for a signal dictionary, by what its entries are nodes of."""

    def __init__(self, network: Network) -> None:
        self.network = network
        self.kinds: dict[Node, str] = {}
        self.elements: dict[Path, dict[str, None]] = {}
        self.references: dict[Path, Path] = {}

    def connectors(self, group: Element, here: Here) -> None:
        """The connectors of an element."""
        component = self.network.components.get(here.path)
        for _, connector in here.document.children(group, ("Connector",), here.place):
            name, kind = connector.get("name", ""), connector.get("kind", "")
            place = f"{here.place}: connector {name!r}"
            self.kinds[here.path, name] = kind
            for tag, typed in here.document.children(connector, (*TYPES, "Dimension"), place):
                if tag != "Dimension" and (unit := here.document.unit(typed)):
                    self._declare((here.path, name), unit, typed.get("unit", ""), place)
            if component and not self._variables(here.path, name):
                self.network.say("warning", f"{place}: its FMU has no such variable")

    def _declare(self, node: Node, unit: Definition, name: str, place: str) -> None:
        """The unit of measure of a connector, which prevails over that of the FMU."""
        own = self.network.unit(node)
        if own and own != unit:
            text = f"is measured in {name} here and in {getattr(self.network.variable(node), 'unit', '')} by its FMU"
            self.network.say("warning", f"{place}: {text}; taken as the system says, without conversion")
        self.network.units[node] = unit

    def _variables(self, path: Path, name: str) -> list[str]:
        """The variables that a connector of a component stands for: one, or the elements of an array."""
        description = self.network.components[path].description
        known = description.by_name()
        if name in known:
            return [name]
        first = next((f"{name}[{place}]" for place in ("1", "1,1", "1,1,1") if f"{name}[{place}]" in known), None)
        return description.siblings(first) if first else []

    def dictionaries(self, group: Element, here: Here) -> None:
        """The signal dictionaries of a system."""
        for _, element in here.document.children(group, ("SignalDictionary",), here.place):
            name, uri = element.get("name", ""), element.get("source")
            here.dictionaries[name] = (*here.path, f"dictionary {name}")
            document, inner = here.document, element
            if uri is not None:
                file = here.files.name(uri, here.document.name)
                inner = here.files.xml(file, "SignalDictionary")
                document = Document(self.network, file, inner)
            elif nested := [child for child in element if local(child) == "SignalDictionary"]:
                inner = nested[0]
                document = Document(self.network, here.document.name, inner)
            place = f"{here.place}: dictionary {name!r}"
            for _, entry in document.children(inner, ("DictionaryEntry",), place):
                for _, typed in document.children(entry, TYPES, place):
                    if unit := document.unit(typed):
                        self.network.units[here.dictionaries[name], entry.get("name", "")] = unit

    def reference(self, element: Element, here: Here) -> None:
        """A signal dictionary in a system: its connectors are entries, alike for all references."""
        name = element.get("dictionary", "")
        if name not in here.dictionaries:
            raise self.network.fault(f"there is no signal dictionary {name!r}", here.place)
        self.references[here.path] = here.dictionaries[name]
        for _, group in here.document.children(element, ("Connectors",), here.place):
            for _, connector in here.document.children(group, ("Connector",), here.place):
                self.kinds[here.path, connector.get("name", "")] = connector.get("kind", "inout")

    def connection(self, element: Element, here: Here) -> None:
        """A connection of a system. Raises `SceneError`."""
        if element.get("startIndices") or element.get("endIndices"):
            raise self.network.fault("connections of single elements of arrays by indices are not read", here.place)
        ends = [self._end(element, side, here) for side in ("start", "end")]
        place = f"{here.place}: {show(ends[0][0])} -> {show(ends[1][0])}"
        flows = [flow for _, flow in ends]
        if flows[0] == flows[1] and flows[0]:
            both = "give values" if flows[0] == "source" else "take values"
            raise self.network.fault(f"both ends {both}", place)
        if flows == ["", ""]:
            self.network.say(
                "warning", f"{place}: neither end says in which way values go: from the first to the second"
            )
        (source, _), (target, _) = (
            ends if flows[0] == "source" or flows[1] == "target" or not any(flows) else ends[::-1]
        )
        raw, change = (
            here.document.truth(element, "suppressUnitConversion", place),
            here.document.change(element, place),
        )
        list(here.document.children(element, CHANGES, place))
        sources, targets = self._spread(source), self._spread(target)
        if len(sources) != len(targets):
            raise self.network.fault(f"joins {len(sources)} values to {len(targets)}", place)
        for one, other in zip(sources, targets):
            self.network.connect(Edge(one, other, raw, change, place))

    def _end(self, element: Element, side: str, here: Here) -> tuple[Node, str]:
        """A node, and whether values come from it ("source") or go to it ("target"), seen from the connection."""
        child, name = element.get(f"{side}Element") or None, element.get(f"{side}Connector", "")
        path = here.path if child is None else (*here.path, child)
        if child is not None and child not in self.elements[here.path]:
            raise self.network.fault(f"a connection names the element {child!r}, which is not there", here.place)
        node = path, name
        variables = self._variables(path, name) if path in self.network.components else []
        if path in self.network.components and not variables:
            raise self.network.fault(f"{show(node)}: its FMU has no such variable", here.place)
        own = self.network.variable((path, variables[0])) if variables else None
        kind = own.causality if own else self.kinds.get(node, "")
        if not own and node not in self.kinds:
            raise self.network.fault(f"{show(node)}: there is no such connector", here.place)
        gives = kind in SOURCES if child is not None else kind in TARGETS
        takes = kind in TARGETS if child is not None else kind in SOURCES
        return node, "source" if gives else "target" if takes else ""

    def _spread(self, node: Node) -> list[Node]:
        """The nodes of a connector: entries of a dictionary for a reference to it, elements for an array."""
        if node[0] in self.references:
            return [(self.references[node[0]], node[1])]
        if node[0] in self.network.components:
            return [(node[0], name) for name in self._variables(*node)]
        return [node]
