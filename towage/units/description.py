"""``modelDescription.xml`` of an FMI 2.0 co-simulation FMU or FMI 3.0 co-simulation FMU as plain structures."""

from __future__ import annotations

import functools
from pathlib import Path
from typing import Literal

import msgspec

Value = float | int | bool | str
Kind = Literal["Real", "Integer", "Boolean", "String", "Enumeration", "Binary"]


class Variable(msgspec.Struct, frozen=True):
    """A scalar variable, with what its declared type adds; ``start``, ``min``, ... are in ``unit``.

    ``initial`` is "" where FMI forbids it (inputs, time); ``unit`` None means undeclared, not dimensionless. ``needed``: an
    input that a scene has to connect or set, a parameter that it has to set; ``unset``: what it means if it does not, where the
    unit says so (`towage.models.protocol.variables.input_variable`). ``kind`` is the standard's type, by which it is set and
    read; ``array``: the number of elements of the array that it is an element of, which share the value reference; ``items``:
    the values of an enumeration by name.
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
    items: dict[str, int] = {}


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
    standard and is taken all the same. ``event_mode``: the unit has FMI 3's, and no conventions that say the same.
    ``distrusted``: what was found not to be so (`towage.units.doubt`).
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
    event_mode: bool = False
    distrusted: tuple[str, ...] = ()

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


def is_own(description: Description) -> bool:
    """Whether the FMU is one of towage's own, by what it says of itself."""
    return description.generation_tool.split(" ")[0] == "towage"
