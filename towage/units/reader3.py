"""``modelDescription.xml`` of an FMI 3.0 co-simulation FMU as the same plain structures as those of FMI 2.0.

An array becomes its elements, ``y[1]``, ``y[2,3]``, as FMI names them, which share its value reference; their number is that of
the start values of structural parameters. Types of numbers keep their width as ``kind``. Clocks are refused: what they would
tick would stand still.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree

from towage.units.description import Description, Kind, Value, Variable
from towage.units.reader import (
    CAUSALITIES,
    VARIABILITIES,
    DescriptionReader,
    InvalidDescription,
    boolean,
    check_length,
    experiment_of,
    identifier_warnings,
    number_of,
)

_INTEGERS = ("Int8", "UInt8", "Int16", "UInt16", "Int32", "UInt32", "Int64", "UInt64")
_TYPES: dict[str, Kind] = {
    "Float64": "Real", "Float32": "Real", "Boolean": "Boolean", "String": "String", "Binary": "Binary",
    "Enumeration": "Enumeration", **dict.fromkeys(_INTEGERS, "Integer"),
}  # fmt: skip
_KINDS = {"Boolean": "bool", "Enumeration": "Int64"}
_LARGEST = 100_000
"""Elements of all arrays together."""


class DescriptionReader3(DescriptionReader):
    """Reads one parsed model description of FMI 3.0."""

    annotation = "Annotations/Annotation[@type='towage']/Interface"

    def __init__(self, root: ElementTree.Element) -> None:
        super().__init__(root)
        definitions = root.find("TypeDefinitions")
        self.types = {e.get("name", ""): e for e in (() if definitions is None else definitions)}
        self.elements_read = 0
        self.sizes = {
            e.get("valueReference", ""): number_of(e, "start", int) or 0
            for e in root.iterfind("ModelVariables/*") if e.get("causality") == "structuralParameter" and e.tag in _INTEGERS
        }  # fmt: skip

    def description(self, path: Path, names: list[str]) -> Description:
        """The description of the FMU at ``path``, whose archive has entries of these names. Raises `InvalidDescription`."""
        root, unit = self.root, self.co_simulation()
        identifier = unit.get("modelIdentifier", "")
        warnings = identifier_warnings(identifier)
        self.require("modelName", "instantiationToken")
        variables = tuple(v for element in root.iterfind("ModelVariables/*") for v in self.elements(element))
        self.check_names(variables)
        if clocks := [e.get("name", "") for e in root.iterfind("ModelVariables/Clock")]:
            raise InvalidDescription(
                f"has clocks ({', '.join(clocks[:3])}), which are not supported: what they tick would stand still. Export the "
                "model without clocks"
            )
        return Description(
            path=path,
            fmi_version="3.0",
            model_name=root.get("modelName", ""),
            guid=root.get("instantiationToken", ""),
            model_identifier=identifier,
            generation_tool=root.get("generationTool", ""),
            can_get_set_state=self.flag(unit, "canGetAndSetFMUState"),
            can_serialize_state=self.flag(unit, "canSerializeFMUState"),
            can_interpolate_inputs=False,
            max_output_derivative_order=number_of(unit, "maxOutputDerivativeOrder", int) or 0,
            can_handle_variable_step=self.flag(unit, "canHandleVariableCommunicationStepSize"),
            needs_execution_tool=self.flag(unit, "needsExecutionTool"),
            once_per_process=self.flag(unit, "canBeInstantiatedOnlyOncePerProcess"),
            default_experiment=experiment_of(root),
            variables=variables,
            dependencies=self.dependencies(variables),
            units=dict(map(self.unit, root.iterfind("UnitDefinitions/Unit[BaseUnit]"))),
            platforms=self.platforms(identifier, names),
            conventions=self.conventions(),
            warnings=warnings,
            # a unit that keeps the conventions tells the master its events by event_* and next_event_time
            event_mode=self.flag(unit, "hasEventMode") and not self.conventions(),
        )

    def elements(self, element: ElementTree.Element) -> Iterator[Variable]:
        """The variable, or the elements of the array, with what the declared type adds. Raises `InvalidDescription`."""
        if element.tag == "Clock":
            return
        name, tag = element.get("name", ""), element.tag
        reference = number_of(element, "valueReference", int)
        check_length(name)
        if tag not in _TYPES or not name or reference is None or not 0 <= reference < 2**32:
            raise InvalidDescription(f"variable {name!r} ({tag}) needs a name, a known type and a value reference")
        causality = element.get("causality", "local")
        usual = "fixed" if "arameter" in causality else "continuous" if tag.startswith("Float") else "discrete"
        variability = element.get("variability", usual)
        known = ((causality, (*CAUSALITIES, "structuralParameter")), (variability, VARIABILITIES))
        for value, expected in known:
            if value not in expected:
                raise InvalidDescription(f"variable {name!r} has {value!r}, expected {', '.join(expected)}")
        declared = self.types.get(element.get("declaredType", ""))
        attributes = {**(declared.attrib if declared is not None else {}), **element.attrib}
        kind = ElementTree.Element(tag, attributes)
        starts = self.starts(element, tag)
        low, high = self.items(declared)
        lengths = [self.length(dimension) for dimension in element.iterfind("Dimension")]
        count = math.prod(lengths)
        self.elements_read += count if lengths else 0
        if self.elements_read > _LARGEST:
            raise InvalidDescription(
                f"variable {name!r} has {count} elements, with which all arrays together have more than {_LARGEST}: refused"
            )
        places = itertools.product(*(range(1, n + 1) for n in lengths))
        for k, place in enumerate(places):
            whole = f"{name}[{','.join(map(str, place))}]" if lengths else name
            needed, unset = self.meant(whole)
            yield Variable(
                name=whole,
                value_reference=reference,
                type=_TYPES[tag],
                causality=causality,
                variability=variability,
                initial=element.get("initial", ""),
                start=(starts[k] if k < len(starts) else starts[0]) if starts else None,
                unit=kind.get("unit"),
                display_unit=kind.get("displayUnit"),
                min=low if low is not None else number_of(kind, "min", float),
                max=high if high is not None else number_of(kind, "max", float),
                nominal=number_of(kind, "nominal", float),
                description=element.get("description", ""),
                kind="Float64 discrete" if (tag, variability) == ("Float64", "discrete") else _KINDS.get(tag, tag),
                array=count,
                needed=needed,
                unset=unset,
                items=self.items_of(element.get("declaredType")),
            )

    def length(self, dimension: ElementTree.Element) -> int:
        """Of one dimension of an array. Raises `InvalidDescription`."""
        reference = dimension.get("valueReference")
        length = self.sizes.get(reference, 0) if reference else number_of(dimension, "start", int) or 0
        if length < 0:
            raise InvalidDescription(f"an array has a dimension of {length} elements")
        return length

    @staticmethod
    def starts(element: ElementTree.Element, tag: str) -> list[Value]:
        """The start values of a variable, one an element."""
        if tag == "String":
            return [start.get("value", "") for start in element.iterfind("Start")]
        if tag == "Binary":
            return ["".join(start.get("value", "").split()) for start in element.iterfind("Start")]
        parts = element.get("start", "").split()
        read = boolean if tag == "Boolean" else float if tag.startswith("Float") else int
        try:
            return [read(part) for part in parts]
        except ValueError:
            raise InvalidDescription(f"variable {element.get('name')!r} has start={parts}, expected {tag}") from None

    def dependencies(self, variables: tuple[Variable, ...]) -> dict[str, tuple[str, ...] | None]:
        """Direct dependencies of the outputs, on inputs only; elements of an array depend alike."""
        inputs: dict[str, list[str]] = {}
        for v in variables:
            if v.causality == "input":
                inputs.setdefault(str(v.value_reference), []).append(v.name)
        declared = {e.get("valueReference", ""): e.get("dependencies") for e in self.root.iterfind("ModelStructure/Output")}
        result: dict[str, tuple[str, ...] | None] = {}
        for v in variables:
            if v.causality == "output":
                text = declared.get(str(v.value_reference))
                result[v.name] = None if text is None else tuple(n for r in text.split() for n in inputs.get(r, ()))
        return result
