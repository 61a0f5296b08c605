"""System structure descriptions of SSP 1.0 (Modelica Association, 2019), and what 2.0 has alike, as a `Network`.

Nested systems, and components that are descriptions or archives themselves, become paths of names; signal dictionaries become
nodes. Bindings of inner elements are applied first, so that those of outer ones prevail, as the standard wants it.
"""

from __future__ import annotations

from pathlib import Path
from xml.etree.ElementTree import Element

from towage.systems.bindings import Bindings
from towage.systems.network import Component, Network
from towage.systems.parameters import Document
from towage.systems.source import Archive, Files, local
from towage.systems.wires import Here, Wires

ROOT = "SystemStructureDescription"
MAIN = "SystemStructure.ssd"
MAX_NESTED = 20
FMU, SSD, SSP = "application/x-fmu-sharedlibrary", "application/x-ssp-definition", "application/x-ssp-package"


def read(files: Files, name: str, file: Path) -> Network:
    """The system in the description ``name`` of ``files``, which stand in ``file``. Raises `SceneError`."""
    network = Network(files, file)
    reader = Reader(network)
    document = reader.document(files, name)
    root = document.root
    network.title = root.get("description", "").strip().partition("\n")[0] or root.get("name", "")
    for tag, element in document.children(root, ("System", "DefaultExperiment"), name):
        if tag == "DefaultExperiment":
            start = document.number(element, "startTime", 0.0, f"{name}: DefaultExperiment")
            stop = document.number(element, "stopTime", 0.0, f"{name}: DefaultExperiment")
            network.start, network.stop = start, stop or None
            list(document.children(element, (), f"{name}: DefaultExperiment"))
    system = reader.root_of(document)
    network.text = system.get("description", "")
    network.title = network.title or system.get("name", "")
    reader.element(system, Here((), document, files, {}))
    return network


class Reader:
    """Reads elements into a network."""

    def __init__(self, network: Network) -> None:
        self.network = network
        self.wires = Wires(network)
        self.bindings = Bindings(network, self.wires)
        self.nested = 0

    def document(self, files: Files, name: str) -> Document:
        """The description ``name``. Raises `SceneError`."""
        return Document(self.network, name, files.xml(name, ROOT))

    def root_of(self, document: Document) -> Element:
        """Its system. Raises `SceneError`."""
        for child in document.root:
            if local(child) == "System":
                return child
        raise self.network.fault("has no System", document.name)

    def element(self, element: Element, here: Here) -> None:
        """A system with all that is in it. Raises `SceneError`."""
        if len(here.path) > MAX_NESTED:
            raise self.network.fault(f"systems within one another, more than {MAX_NESTED} deep: refused", here.place)
        known = ("Connectors", "Elements", "Connections", "SignalDictionaries", "ParameterBindings")
        parts: dict[str, list[Element]] = {name: [] for name in known}
        for tag, child in here.document.children(element, known, here.place):
            parts[tag].append(child)
        here = here._replace(dictionaries=dict(here.dictionaries))
        self.wires.elements.setdefault(here.path, {})
        for group in parts["SignalDictionaries"]:
            self.wires.dictionaries(group, here)
        for group in parts["Connectors"]:
            self.wires.connectors(group, here)
        for group in parts["Elements"]:
            for tag, child in here.document.children(
                group, ("Component", "System", "SignalDictionaryReference"), here.place
            ):
                self._child(tag, child, here)
        for group in parts["Connections"]:
            for _, connection in here.document.children(group, ("Connection",), here.place):
                self.wires.connection(connection, here)
        for group in parts["ParameterBindings"]:
            self.bindings.apply(group, here)

    def _child(self, tag: str, element: Element, here: Here) -> None:
        name = element.get("name", "")
        if not name or name in self.wires.elements[here.path]:
            raise self.network.fault(f"an element is called {name!r}, which is empty or taken", here.place)
        self.wires.elements[here.path][name] = None
        inner = here._replace(path=(*here.path, name))
        if tag == "System":
            self.element(element, inner)
        elif tag == "Component":
            self._component(element, inner)
        else:
            self.wires.reference(element, inner)

    # ---- components --------------------------------------------------------------------------------------------------

    def _component(self, element: Element, here: Here) -> None:
        """An FMU, or a system that stands in another description or archive."""
        uri = element.get("source")
        kind = element.get("type") or _kind(uri or "")
        if uri is None:
            self.network.say("warning", f"{here.place}: has no source, so that nothing computes its outputs")
            self.element(element, here)
        elif uri.startswith("#"):
            self._again(element, here, self._by_id(here.document, uri[1:]), here.document, here.files)
        elif kind == FMU:
            self._fmu(element, here, uri)
        elif kind == SSD:
            document = self.document(here.files, here.files.name(uri, here.document.name))
            self._again(element, here, self.root_of(document), document, here.files)
        elif kind == SSP:
            name, _, variant = uri.partition("#")
            files = Archive(here.files.path(here.files.name(name, here.document.name)))
            document = self.document(files, files.name(variant or MAIN))
            self._again(element, here, self.root_of(document), document, files)
        else:
            raise self.network.fault(
                f"a component of type {kind!r} cannot be run: expected an FMU, or a system", here.place
            )

    def _again(self, element: Element, here: Here, system: Element, document: Document, files: Files) -> None:
        """A system in the place of a component, whose own bindings come after those of the system."""
        self.nested += 1
        if self.nested > 1000:
            raise self.network.fault("more than 1000 systems by reference: refused", here.place)
        self.element(
            system, Here(here.path, document, files, {} if document is not here.document else here.dictionaries)
        )
        known = ("Connectors", "ParameterBindings")
        for tag, child in here.document.children(element, known, here.place):
            if tag == "Connectors":
                self.wires.connectors(child, here)
            else:
                self.bindings.apply(child, here)

    def _by_id(self, document: Document, wanted: str) -> Element:
        for element in document.root.iter():
            if local(element) == "System" and element.get("id") == wanted:
                return element
        raise self.network.fault(f"there is no System with id {wanted!r}", document.name)

    def _fmu(self, element: Element, here: Here, uri: str) -> None:
        wanted = element.get("implementation", "any")
        if wanted not in ("any", "CoSimulation"):
            raise self.network.fault(f"asks for {wanted}: units for co-simulation are run alone", here.place)
        name = here.files.name(uri, here.document.name)
        component = Component(here.path, here.files, name, here.files.description(name))
        self.network.add(component, here.place)
        for tag, child in here.document.children(element, ("Connectors", "ParameterBindings"), here.place):
            if tag == "Connectors":
                self.wires.connectors(child, here)
            else:
                self.bindings.apply(child, here)


def _kind(uri: str) -> str:
    """What a source is that does not say it: an FMU, unless its name ends otherwise."""
    name = uri.partition("#")[0].lower()
    return SSD if name.endswith(".ssd") else SSP if name.endswith(".ssp") else FMU
