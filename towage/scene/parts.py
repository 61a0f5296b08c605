"""The tables of a scene file, and what a check says of the other runs it needs. Plain structures, nothing is checked here."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import msgspec

from towage.units.description import Value

if TYPE_CHECKING:
    from towage.scene.scene import Scene

Seconds = Annotated[float, msgspec.Meta(extra={"unit": "s"})]
"""A time; the file may give it as a text with a unit."""


class UnitEntry(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """``[units.NAME]``: a shipped unit's name or the path of an .fmu, and values as written. ``inputs`` are constants for
    inputs that nothing is connected to; ``parameters`` may hold such constants too, as before there was a table for them.
    ``files``: what a shipped unit is to carry, by kind, each a path or a table with ``file`` and options (`towage.data`)."""

    fmu: str
    parameters: dict[str, Value] = {}
    inputs: dict[str, Value] = {}
    files: dict[str, Any] = {}

    @property
    def values(self) -> dict[str, Value]:
        """All values, of parameters and inputs."""
        return {**self.parameters, **self.inputs}

    def table(self, variable: str) -> str:
        """The table in which ``variable`` stands, or would: ``inputs`` or ``parameters``."""
        return "inputs" if variable in self.inputs else "parameters"


class Transformation(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """``[transformations."a.y -> b.u"]``: what a connection does to the value beyond passing it on. Numbers become ``factor``
    times the value plus ``offset``, after the conversion between two units of measure unless ``convert`` is false. Integers,
    enumerations and truth values are looked up in ``values``, under their text; one that is not there passes unchanged."""

    factor: float = 1.0
    offset: float = 0.0
    convert: bool = True
    values: dict[str, Value] = {}


class Coupling(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """``[coupling]``: exactly one of ``step`` (s) and ``tolerance`` (relative error of the coupling) is given."""

    scheme: str = "auto"
    step: Seconds | None = None
    tolerance: float | None = None
    events: bool = True
    error_estimate: bool = True


class Record(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """``[record]``: interval in s, None for every communication point; variables, None for all numeric outputs."""

    interval: Seconds | None = None
    variables: tuple[str, ...] | None = None


class Checks(msgspec.Struct, frozen=True):
    """``[checks]``: the tables ``[checks.NAME]`` by the name of the check (`towage.registry.CHECKS`), each the structure
    that the check brings; ``report_only`` names margins that do not decide."""

    sections: dict[str, Any] = {}
    report_only: tuple[str, ...] = ()

    def get(self, name: str) -> Any:
        """The section of a check, None if the scene has none."""
        return self.sections.get(name)

    def without(self, *names: str) -> Checks:
        """All but the sections of these checks."""
        rest = {name: section for name, section in self.sections.items() if name not in names}
        return Checks(rest, self.report_only)


class Empty(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The table of a check that takes no values."""


class Case(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """``[[cases]]``: values that replace those of the scene, under "unit.parameter", "unit.files.kind.file",
    "coupling.step", "stop_time"."""

    name: str
    set: dict[str, Any] = {}


class Variant(NamedTuple):
    """Another run of a scene, to compare with: ``name`` as its progress is told; the scene, None for the same one;
    ``coarse``: with doubled communication step, or tenfold tolerance; ``nudged``: a unit, a value of which is changed by
    1e-9 of itself."""

    name: str
    scene: Scene | None
    coarse: bool = False
    nudged: str = ""
