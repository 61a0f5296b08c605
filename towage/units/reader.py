"""Reads the model description of an FMI 2.0 co-simulation FMU; what FMI 3.0 has otherwise is in `reader3`."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar
from xml.etree import ElementTree

from towage.fmus.declare.quantities import BASES
from towage.units.description import DefaultExperiment, Description, Kind, UnitDefinition, Value, Variable

_INITIAL = {"parameter": "exact", "calculatedParameter": "calculated", "input": "", "independent": ""}
T = TypeVar("T")
LONGEST_NAME = 1000
"""Letters of the name of a variable: names go into messages, headers and the legends of diagrams."""
CAUSALITIES = ("parameter", "calculatedParameter", "input", "output", "local", "independent")
VARIABILITIES = ("constant", "fixed", "tunable", "discrete", "continuous")
_KINDS: dict[str, Kind] = {k: k for k in ("Real", "Integer", "Boolean", "String", "Enumeration")}


class InvalidDescription(Exception):
    """A model description that breaks FMI 2.0."""


def number_of(element: ElementTree.Element, key: str, as_type: Callable[[str], T]) -> T | None:
    """An attribute as a number or truth value, None where it is missing. Raises `InvalidDescription` where it is none."""
    text = element.get(key)
    try:
        return None if text is None else as_type(text)
    except ValueError:
        where = f"'{element.get('name')}': " if element.get("name") else ""
        raise InvalidDescription(
            f"{where}{element.tag} has {key}={text!r}, expected {as_type.__name__.strip('_')}"
        ) from None


def check_length(name: str) -> None:
    """Raises `InvalidDescription` for the name of a variable that is too long."""
    if len(name) > LONGEST_NAME:
        raise InvalidDescription(f"a variable's name has {len(name)} letters, more than {LONGEST_NAME}: refused")


def boolean(text: str) -> bool:
    """A truth value as XML Schema spells it. Raises ``ValueError``."""
    if text not in ("true", "false", "1", "0"):
        raise ValueError
    return text in ("true", "1")


def identifier_warnings(identifier: str) -> tuple[str, ...]:
    """What to say of a model identifier that names a file but is no identifier of C. Raises `InvalidDescription` for one that
    names no file."""
    if re.fullmatch("[A-Za-z_][A-Za-z0-9_]*", identifier):
        return ()
    if not re.fullmatch(r"[A-Za-z0-9_][\w.+ -]*", identifier, re.ASCII):
        raise InvalidDescription(f"modelIdentifier {identifier!r} is not a C identifier")
    return (f"modelIdentifier {identifier!r} is not a C identifier, as FMI wants it: taken as the name of the library",)


def experiment_of(root: ElementTree.Element) -> DefaultExperiment:
    """What the description says of a run."""
    element = root.find("DefaultExperiment")
    if element is None:
        return DefaultExperiment()
    return DefaultExperiment(*(number_of(element, key, float) for key in ("startTime", "stopTime", "tolerance", "stepSize")))


_VALUES: dict[str, Callable[[str], Value]] = {
    "Real": float, "Integer": int, "Boolean": boolean, "String": str, "Enumeration": int,
}  # fmt: skip


class DescriptionReader:
    """Reads one parsed model description."""

    annotation = "VendorAnnotations/Tool[@name='towage']/Interface"
    """What is written for towage."""

    def __init__(self, root: ElementTree.Element) -> None:
        self.root = root
        self.types: dict[str, ElementTree.Element] = {}
        for simple in root.iterfind("TypeDefinitions/SimpleType"):
            self.types |= {simple.get("name", ""): child for child in simple if child.tag in _KINDS}
        self.enumerations: dict[str, dict[str, int]] = {}
        said = (e for kind in ("Inputs/Input", "Parameters/Parameter") for e in root.iterfind(f"{self.annotation}/{kind}"))
        self.said = {element.get("name", ""): element for element in said}

    def description(self, path: Path, names: list[str]) -> Description:
        """The description of the FMU at ``path``, whose archive has entries of these names. Raises `InvalidDescription`."""
        root, unit = self.root, self.co_simulation()
        identifier = unit.get("modelIdentifier", "")
        warnings = identifier_warnings(identifier)
        self.require("modelName", "guid")
        variables = tuple(map(self.variable, root.iterfind("ModelVariables/ScalarVariable")))
        self.check_names(variables)
        return Description(
            path=path,
            fmi_version="2.0",
            model_name=root.get("modelName", ""),
            guid=root.get("guid", ""),
            model_identifier=identifier,
            generation_tool=root.get("generationTool", ""),
            can_get_set_state=self.flag(unit, "canGetAndSetFMUstate"),
            can_serialize_state=self.flag(unit, "canSerializeFMUstate"),
            can_interpolate_inputs=self.flag(unit, "canInterpolateInputs"),
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
        )

    def co_simulation(self) -> ElementTree.Element:
        """The element CoSimulation. Raises `InvalidDescription` where there is none."""
        unit = self.root.find("CoSimulation")
        if unit is None:
            kinds = {"ModelExchange": "model exchange", "ScheduledExecution": "scheduled execution"}
            has = " and ".join(word for tag, word in kinds.items() if self.root.find(tag) is not None) or "no interface"
            raise InvalidDescription(f"no CoSimulation element, but {has}, which is not supported: export for co-simulation")
        return unit

    def require(self, *keys: str) -> None:
        """Raises `InvalidDescription` for the first of these attributes that is missing."""
        missing = [key for key in keys if not self.root.get(key)]
        if missing:
            raise InvalidDescription(f"required attribute {missing[0]!r} is missing")

    @staticmethod
    def check_names(variables: tuple[Variable, ...]) -> None:
        """Raises `InvalidDescription` for a name that two variables have."""
        seen: set[str] = set()
        for variable in variables:
            if variable.name in seen:
                raise InvalidDescription(f"variable {variable.name!r} is declared twice")
            seen.add(variable.name)

    @staticmethod
    def platforms(identifier: str, names: list[str]) -> tuple[str, ...]:
        """The platforms for which there is a library of that name."""
        libraries = (re.fullmatch(rf"binaries/([^/]+)/{re.escape(identifier)}(\.so|\.dll|\.dylib)", name) for name in names)
        return tuple(sorted({match[1] for match in libraries if match}))

    def conventions(self) -> bool:
        """Whether the unit declares what its names mean: by an annotation, or as made by towage."""
        return (
            self.root.find(f"{self.annotation}/Conventions") is not None
            or self.root.get("generationTool", "").split(" ")[0] == "towage"
        )

    def meant(self, name: str) -> tuple[bool, str]:
        """Of an input or a parameter: (whether it is needed, what it means to leave it open)."""
        said = self.said.get(name)
        return (False, "") if said is None else (self.flag(said, "needed"), said.get("unset", ""))

    def items_of(self, declared: str | None) -> dict[str, int]:
        """The values of an enumeration by name; the same dictionary for all variables of a type, as there may be many."""
        if declared is None or declared not in self.types:
            return {}
        if declared not in self.enumerations:
            found = self.types[declared].iterfind("Item")
            values = {item.get("name", ""): number_of(item, "value", int) for item in found}
            self.enumerations[declared] = {name: value for name, value in values.items() if name and value is not None}
        return self.enumerations[declared]

    @staticmethod
    def flag(element: ElementTree.Element, key: str) -> bool:
        """A Boolean attribute; false where it is missing."""
        return bool(number_of(element, key, boolean))

    @staticmethod
    def unit(element: ElementTree.Element) -> tuple[str, UnitDefinition]:
        """(name, definition) of a unit of measurement."""
        base = element.find("BaseUnit")
        assert base is not None
        factor, offset = number_of(base, "factor", float), number_of(base, "offset", float) or 0.0
        exponents = tuple(number_of(base, key, int) or 0 for key in BASES)
        if factor == 0.0 or not math.isfinite(factor or 1.0) or not math.isfinite(offset):
            raise InvalidDescription(f"unit {element.get('name')!r} has factor {factor} and offset {offset}")
        return element.get("name", ""), UnitDefinition(exponents, 1.0 if factor is None else factor, offset)

    def variable(self, element: ElementTree.Element) -> Variable:
        """The variable, with what its declared type adds. Raises `InvalidDescription`."""
        name = element.get("name", "")
        kinds = [child for child in element if child.tag in _KINDS]
        reference = number_of(element, "valueReference", int)
        check_length(name)
        if not name or reference is None or not 0 <= reference < 2**32 or len(kinds) != 1:
            raise InvalidDescription(
                f"variable {name!r} needs a name, a value reference from 0 to 2^32 - 1 and exactly one type"
            )
        own, causality = kinds[0], element.get("causality", "local")
        variability = element.get("variability", "continuous")
        for word, value, known in (("causality", causality, CAUSALITIES), ("variability", variability, VARIABILITIES)):
            if value not in known:
                raise InvalidDescription(f"variable {name!r} has {word} {value!r}, expected {', '.join(known)}")
        declared = own.get("declaredType")
        if declared is not None and (declared not in self.types or self.types[declared].tag != own.tag):
            raise InvalidDescription(
                f"variable {name!r} has declaredType {declared!r}, which is no {own.tag} of TypeDefinitions"
            )
        kind = ElementTree.Element(own.tag, {**(self.types[declared].attrib if declared else {}), **own.attrib})
        kind.attrib.pop("name", None)
        low, high = self.items(self.types[declared]) if declared else (None, None)
        exact = variability == "constant"
        return Variable(
            name=name,
            value_reference=reference,
            type=_KINDS[own.tag],
            kind="Integer" if own.tag == "Enumeration" else own.tag,
            causality=causality,
            variability=variability,
            initial=element.get("initial") or _INITIAL.get(causality, "exact" if exact else "calculated"),
            start=number_of(kind, "start", _VALUES[own.tag]),
            unit=kind.get("unit"),
            display_unit=kind.get("displayUnit"),
            min=low if low is not None else number_of(kind, "min", float),
            max=high if high is not None else number_of(kind, "max", float),
            nominal=number_of(kind, "nominal", float),
            description=element.get("description", ""),
            needed=self.meant(name)[0],
            unset=self.meant(name)[1],
            items=self.items_of(declared),
        )

    @staticmethod
    def items(declared: ElementTree.Element | None) -> tuple[float | None, float | None]:
        """The least and the largest value that a type names, which has values of its own: an enumeration; None for others."""
        found = () if declared is None else declared.iterfind("Item")
        values = [value for item in found if (value := number_of(item, "value", float)) is not None]
        return (min(values), max(values)) if values else (None, None)

    def dependencies(self, variables: tuple[Variable, ...]) -> dict[str, tuple[str, ...] | None]:
        """Direct dependencies of the outputs, on inputs only."""

        def at(index: str) -> Variable:
            """The variable of an index of ModelStructure, which begins at 1."""
            if not index.isdecimal() or not 1 <= int(index) <= len(variables):
                raise InvalidDescription(f"ModelStructure names variable {index!r}, expected 1 to {len(variables)}")
            return variables[int(index) - 1]

        result: dict[str, tuple[str, ...] | None] = {v.name: None for v in variables if v.causality == "output"}
        for unknown in self.root.iterfind("ModelStructure/Outputs/Unknown"):
            output, declared = at(unknown.get("index", "")), unknown.get("dependencies")
            if output.name not in result:
                raise InvalidDescription(f"ModelStructure lists {output.name!r} as an output, but its causality is not")
            if declared is not None:
                known = map(at, declared.split())
                result[output.name] = tuple(v.name for v in known if v.causality == "input")
        return result
