"""``modelDescription.xml`` of an FMI 2.0 co-simulation FMU as plain structures."""

from __future__ import annotations

import functools
import math
import re
from collections.abc import Callable
from pathlib import Path
from typing import Literal, TypeVar
from xml.etree import ElementTree

import msgspec

from towage.fmus.declare.quantities import BASES

_INITIAL = {"parameter": "exact", "calculatedParameter": "calculated", "input": "", "independent": ""}
T = TypeVar("T")
Value = float | int | bool | str
Kind = Literal["Real", "Integer", "Boolean", "String", "Enumeration"]
CAUSALITIES = ("parameter", "calculatedParameter", "input", "output", "local", "independent")
VARIABILITIES = ("constant", "fixed", "tunable", "discrete", "continuous")
_KINDS: dict[str, Kind] = {k: k for k in ("Real", "Integer", "Boolean", "String", "Enumeration")}


class Variable(msgspec.Struct, frozen=True):
    """A scalar variable, with what its declared type adds; ``start``, ``min``, ... are in ``unit``.

    ``initial`` is "" where FMI forbids it (inputs, time); ``unit`` None means undeclared, not dimensionless. ``needed``: an
    input that a scene has to connect or set; ``unset``: what it means if it does not, where the unit says so
    (`towage.models.protocol.variables.input_variable`). ``kind`` is the standard's type, by which it is set and read;
    ``array``: the number of elements of the array that it is an element of, which share the value reference.
    """

    name: str
    value_reference: int
    type: Kind
    causality: str
    variability: str
    initial: str
    start: Value | None = None
    unit: str | None = None
    display_unit: str | None = None
    min: float | None = None
    max: float | None = None
    nominal: float | None = None
    description: str = ""
    needed: bool = False
    unset: str = ""
    kind: str = "Real"
    array: int = 1


class UnitDefinition(msgspec.Struct, frozen=True):
    """SI value = factor * value + offset; exponents in the order of ``quantities.BASES``."""

    exponents: tuple[int, ...]
    factor: float
    offset: float


class DefaultExperiment(msgspec.Struct, frozen=True):
    """Times in s; None: not declared."""

    start_time: float | None = None
    stop_time: float | None = None
    tolerance: float | None = None
    step_size: float | None = None


class Description(msgspec.Struct, frozen=True, dict=True):
    """A modelDescription.xml, and the platforms that the archive has a binary for.

    ``dependencies`` gives the inputs that act on an output without delay; None: not declared, so all of them may.
    ``conventions``: its names mean what `towage.units.conventions` says, as the maker declares. ``warnings``: what breaks the
    standard and is taken all the same.
    """

    path: Path
    fmi_version: str
    model_name: str
    guid: str
    model_identifier: str
    generation_tool: str
    can_get_set_state: bool
    can_serialize_state: bool
    can_interpolate_inputs: bool
    max_output_derivative_order: int
    can_handle_variable_step: bool
    needs_execution_tool: bool
    once_per_process: bool
    default_experiment: DefaultExperiment
    variables: tuple[Variable, ...]
    dependencies: dict[str, tuple[str, ...] | None]
    units: dict[str, UnitDefinition]
    platforms: tuple[str, ...]
    conventions: bool = False
    warnings: tuple[str, ...] = ()

    def by_name(self) -> dict[str, Variable]:
        """The variables under their names."""
        return self._names

    @functools.cached_property
    def _names(self) -> dict[str, Variable]:
        return {variable.name: variable for variable in self.variables}

    def siblings(self, name: str) -> list[str]:
        """The elements of the array of which ``name`` is one, in order; ``name`` alone where it is none."""
        variable = self.by_name()[name]
        if variable.array == 1:
            return [name]
        same = (variable.value_reference, variable.kind)
        return [v.name for v in self.variables if (v.value_reference, v.kind) == same]


class InvalidDescription(Exception):
    """A model description that breaks FMI 2.0."""


def _number(element: ElementTree.Element, key: str, as_type: Callable[[str], T]) -> T | None:
    text = element.get(key)
    try:
        return None if text is None else as_type(text)
    except ValueError:
        where = f"'{element.get('name')}': " if element.get("name") else ""
        raise InvalidDescription(
            f"{where}{element.tag} has {key}={text!r}, expected {as_type.__name__.strip('_')}"
        ) from None


def _boolean(text: str) -> bool:
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


def declares_conventions(root: ElementTree.Element, annotation: str) -> bool:
    """Whether a unit declares the conventions of its names: by the element ``annotation``, or as made by towage."""
    return root.find(annotation) is not None or root.get("generationTool", "").split(" ")[0] == "towage"


_VALUES: dict[str, Callable[[str], Value]] = {
    "Real": float, "Integer": int, "Boolean": _boolean, "String": str, "Enumeration": int,
}  # fmt: skip


class DescriptionReader:
    """Reads one parsed model description."""

    def __init__(self, root: ElementTree.Element) -> None:
        self.root = root
        self.types: dict[str, ElementTree.Element] = {}
        for simple in root.iterfind("TypeDefinitions/SimpleType"):
            self.types |= {simple.get("name", ""): child for child in simple if child.tag in _KINDS}
        said = root.iterfind("VendorAnnotations/Tool[@name='towage']/Inputs/Input")
        self.inputs = {element.get("name", ""): element for element in said}

    def description(self, path: Path, names: list[str]) -> Description:
        """The description of the FMU at ``path``, whose archive has entries of these names. Raises `InvalidDescription`."""
        root = self.root
        if root.tag != "fmiModelDescription":
            raise InvalidDescription(f"root element is {root.tag!r}, expected 'fmiModelDescription'")
        version, unit = root.get("fmiVersion"), root.find("CoSimulation")
        if version != "2.0":
            raise InvalidDescription(
                f"FMI version {version!r} is not supported, expected '2.0': export the model as FMI 2.0"
            )
        if unit is None:
            raise InvalidDescription(
                "no CoSimulation element: model exchange is not supported, export for co-simulation"
            )
        identifier = unit.get("modelIdentifier", "")
        missing = [key for key in ("modelName", "guid") if not root.get(key)]
        if missing:
            raise InvalidDescription(f"required attribute {missing[0]!r} is missing")
        variables = tuple(map(self.variable, root.iterfind("ModelVariables/ScalarVariable")))
        seen: set[str] = set()
        for variable in variables:
            if variable.name in seen:
                raise InvalidDescription(f"variable {variable.name!r} is declared twice")
            seen.add(variable.name)
        experiment = root.find("DefaultExperiment")
        times = () if experiment is None else ("startTime", "stopTime", "tolerance", "stepSize")
        warnings = identifier_warnings(identifier)
        libraries = (re.fullmatch(rf"binaries/([^/]+)/{re.escape(identifier)}(\.so|\.dll|\.dylib)", name) for name in names)
        return Description(
            path=path,
            fmi_version=version,
            model_name=root.get("modelName", ""),
            guid=root.get("guid", ""),
            model_identifier=identifier,
            generation_tool=root.get("generationTool", ""),
            can_get_set_state=self.flag(unit, "canGetAndSetFMUstate"),
            can_serialize_state=self.flag(unit, "canSerializeFMUstate"),
            can_interpolate_inputs=self.flag(unit, "canInterpolateInputs"),
            max_output_derivative_order=_number(unit, "maxOutputDerivativeOrder", int) or 0,
            can_handle_variable_step=self.flag(unit, "canHandleVariableCommunicationStepSize"),
            needs_execution_tool=self.flag(unit, "needsExecutionTool"),
            once_per_process=self.flag(unit, "canBeInstantiatedOnlyOncePerProcess"),
            default_experiment=DefaultExperiment(*(_number(experiment, key, float) for key in times))
            if experiment is not None
            else DefaultExperiment(),
            variables=variables,
            dependencies=self.dependencies(variables),
            units=dict(map(self.unit, root.iterfind("UnitDefinitions/Unit[BaseUnit]"))),
            platforms=tuple(sorted({match[1] for match in libraries if match})),
            conventions=declares_conventions(root, "VendorAnnotations/Tool[@name='towage']/Conventions"),
            warnings=warnings,
        )

    @staticmethod
    def flag(element: ElementTree.Element, key: str) -> bool:
        """A Boolean attribute; false where it is missing."""
        return bool(_number(element, key, _boolean))

    @staticmethod
    def unit(element: ElementTree.Element) -> tuple[str, UnitDefinition]:
        """(name, definition) of a unit of measurement."""
        base = element.find("BaseUnit")
        assert base is not None
        factor, offset = _number(base, "factor", float), _number(base, "offset", float) or 0.0
        exponents = tuple(_number(base, key, int) or 0 for key in BASES)
        if factor == 0.0 or not math.isfinite(factor or 1.0) or not math.isfinite(offset):
            raise InvalidDescription(f"unit {element.get('name')!r} has factor {factor} and offset {offset}")
        return element.get("name", ""), UnitDefinition(exponents, 1.0 if factor is None else factor, offset)

    def variable(self, element: ElementTree.Element) -> Variable:
        """The variable, with what its declared type adds. Raises `InvalidDescription`."""
        name = element.get("name", "")
        kinds = [child for child in element if child.tag in _KINDS]
        reference = _number(element, "valueReference", int)
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
        exact = variability == "constant"
        return Variable(
            name=name,
            value_reference=reference,
            type=_KINDS[own.tag],
            kind="Integer" if own.tag == "Enumeration" else own.tag,
            causality=causality,
            variability=variability,
            initial=element.get("initial") or _INITIAL.get(causality, "exact" if exact else "calculated"),
            start=_number(kind, "start", _VALUES[own.tag]),
            unit=kind.get("unit"),
            display_unit=kind.get("displayUnit"),
            min=_number(kind, "min", float),
            max=_number(kind, "max", float),
            nominal=_number(kind, "nominal", float),
            description=element.get("description", ""),
            needed=name in self.inputs and self.flag(self.inputs[name], "needed"),
            unset=self.inputs[name].get("unset", "") if name in self.inputs else "",
        )

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
