"""Parameter bindings of system structure descriptions: whose values they are, and what they are called where they are applied."""

from __future__ import annotations

from collections.abc import Iterator
from xml.etree.ElementTree import Element

from towage.systems.network import Given, Network, Path
from towage.systems.parameters import Document, Entry
from towage.systems.source import Archive, local
from towage.systems.wires import Here, Wires

SETS, MAPPINGS = "application/x-ssp-parameter-set", "application/x-ssp-parameter-mapping"


class Bindings:
    """Applies them, inner elements before outer ones, which prevail so."""

    def __init__(self, network: Network, wires: Wires) -> None:
        self.network, self.wires = network, wires

    def apply(self, group: Element, here: Here) -> None:
        """Apply the bindings of an element, the later ones over the earlier. Raises `SceneError`."""
        for _, binding in here.document.children(group, ("ParameterBinding",), here.place):
            kind, place = binding.get("type", SETS), f"{here.place}: binding"
            if kind != SETS:
                self.network.say("warning", f"{place} of type {kind!r} is not understood: its values are not applied")
                continue
            inside = ("ParameterValues", "ParameterMapping")
            found = dict(here.document.children(binding, inside, place))
            document, values = self._part(binding, found.get("ParameterValues"), "ParameterSet", here)
            prefix = binding.get("prefix", "")
            given = [(prefix + name, value) for name, value in document.parameters(values, document.name)]
            if "ParameterMapping" in found:
                mapping, entries = self._part(
                    found["ParameterMapping"], found["ParameterMapping"], "ParameterMapping", here
                )
                given = list(_mapped(given, mapping.mapping(entries, mapping.name)))
            unknown = [name for name, value in given if not self._set(here.path, name, value)]
            if unknown:
                place = ".".join(here.path) or "the system"
                self.network.say(
                    "info", f"{document.name}: {_few(unknown)} fit nothing in {place}, and are not applied"
                )

    def _part(self, element: Element, inline: Element | None, root: str, here: Here) -> tuple[Document, Element]:
        """A parameter set or mapping: in its own file, in the FMU of the component, or inline."""
        uri = element.get("source")
        if uri is None:
            for child in inline if inline is not None else ():
                if local(child) == root:
                    return Document(self.network, f"{here.place}: {root}", child), child
            raise self.network.fault(f"a binding has neither a source nor a {root} inside", here.place)
        files, base = here.files, here.document.name
        if element.get("sourceBase", "SSD") == "component":
            if here.path not in self.network.components:
                raise self.network.fault(f"{uri!r} is sought in a component, which this is not", here.place)
            component = self.network.components[here.path]
            files, base = Archive(component.files.path(component.fmu)), ""
        name = files.name(uri, base)
        tree = files.xml(name, root)
        return Document(self.network, name, tree), tree

    def _set(self, path: Path, name: str, given: Given) -> bool:
        """Set what is called ``name`` in the element at ``path``, all of it; whether there is anything."""
        if path in self.network.components:
            known = self.network.variable((path, name))
            return bool(known) and self.network.give((path, name), given)
        found = (path, name) in self.wires.kinds and self.network.give((path, name), given)
        inside = self.wires.elements.get(path, {})
        for dot in (k for k, letter in enumerate(name) if letter == "."):  # names of elements may have dots
            if name[:dot] in inside:
                found = self._set((*path, name[:dot]), name[dot + 1 :], given) or found
        return found


def _mapped(given: list[tuple[str, Given]], entries: list[Entry]) -> Iterator[tuple[str, Given]]:
    """The parameters that a mapping names, under their new names."""
    values = dict(given)
    for entry in entries:
        if entry.source in values:
            value = values[entry.source]
            yield entry.target, value._replace(raw=entry.raw, change=value.change.then(entry.change))


def _few(names: list[str]) -> str:
    """The first of some names."""
    more = f" and {len(names) - 3} more" if len(names) > 3 else ""
    return ", ".join(map(repr, names[:3])) + more
