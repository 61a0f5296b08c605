"""A model is a value: what its record refuses at import, and how a variable is read from its field."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from types import ModuleType
from typing import Annotated, Any, NamedTuple

import pytest

from towage.fmus import UNITS
from towage.fmus.declare.unit import Unit, load
from towage.models.heave import cradle
from towage.models.numeric.ops import Value
from towage.models.protocol.linear_model import LinearModel
from towage.models.protocol.model import Model, refusal_of
from towage.models.protocol.variables import Rate, input_variable, output, parameter, per_second, quantities


class Empty(NamedTuple):
    """No components."""


@dataclass(frozen=True)
class Parameters:
    """One."""

    mass: Annotated[Value, parameter("kg", 2.0, "Mass", min=1e-9, display="lb")]


class Outputs(NamedTuple):
    """One, and its rate."""

    heave: Annotated[Value, output("m", "Heave", display="ft")]
    heave_rate: Rate


class Lost(NamedTuple):
    """A rate of nothing."""

    heave_rate: Rate


class Bare(NamedTuple):
    """Neither unit nor meaning."""

    heave: Value


FUNCTIONS: dict[str, Any] = {
    "initial": lambda p, ops: (Empty(), Empty()),
    "outputs": lambda t, x, m, u, du, p, ops: Outputs(0.0, 0.0),
}


def record(kind: Any = Outputs, **functions: Any) -> Any:
    return Model("thing", "A thing", Parameters, Empty, Empty, Empty, kind, **(FUNCTIONS | functions))


def test_an_unknown_function_is_refused_with_the_closest_known_one() -> None:
    with pytest.raises(TypeError, match=r"Model has no function derivates: did you mean derivatives\?"):
        record(derivates=lambda t, x, m, u, p, ops: x)
    with pytest.raises(TypeError, match=r"LinearModel has no function obseve: did you mean observe\?"):
        LinearModel("thing", "A thing", obseve=None)  # type: ignore[call-arg]
    with pytest.raises(TypeError, match="no function zzz: expected one of name, description"):
        record(zzz=1)


def test_a_missing_function_is_refused() -> None:
    with pytest.raises(TypeError, match="missing 1 required keyword-only argument: 'outputs'"):
        Model("thing", "A thing", Parameters, Empty, Empty, Empty, Outputs, initial=FUNCTIONS["initial"])  # type: ignore[call-arg]


def test_a_function_that_the_record_leaves_out_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """A module that defines `transition` and forgets to name it would lose its branches without a word."""
    module = ModuleType("forgetful")
    exec("def outputs(): pass\ndef transition(): pass", vars(module))
    monkeypatch.setitem(sys.modules, "forgetful", module)
    with pytest.raises(TypeError, match="forgetful defines transition, but its Model does not name it"):
        record(outputs=vars(module)["outputs"])
    record(outputs=vars(module)["outputs"], transition=vars(module)["transition"])


def test_a_variable_is_read_from_its_field() -> None:
    unit = Unit.of(record())
    (mass,) = unit.parameters
    assert (mass.name, mass.unit, mass.start, mass.min, mass.display) == ("mass", "kg", 2.0, 1e-9, "lb")
    heave, rate = unit.observed
    assert (heave.name, heave.causality, heave.display) == ("heave", "output", "ft")
    assert (rate.name, rate.unit, rate.causality, rate.description) == (
        "heave_rate", "m/s", "local", "Time derivative of heave",
    )  # fmt: skip
    assert [v.name for v in unit.variables] == ["mass", "heave", "heave_rate"]
    assert list(map(len, unit.layout)) == [1, 0, 0, 0, 2, 0, 0, 0]


def test_a_field_without_a_record_and_a_rate_of_nothing_are_refused() -> None:
    with pytest.raises(TypeError, match=r"Bare: heave has no record of unit and meaning"):
        Unit.of(record(Bare))
    with pytest.raises(TypeError, match=r"Lost\.heave_rate is a rate, but there is no output heave"):
        quantities(Lost)


def test_units_of_rates_and_starts_of_inputs() -> None:
    assert [per_second("m"), per_second("m/s"), per_second("m", 3), per_second("N")] == ["m/s", "m/s2", "m/s3", "N/s"]
    assert input_variable("m", "End").start == 0.0 and input_variable("m", "Height", start=2.0).start == 2.0


def test_refusals_are_the_first_requirement_that_is_not_met() -> None:
    assert refusal_of([(1.0, "a"), (float("nan"), "b"), (0.0, "c")]) == "b"
    assert refusal_of([(1.0, "a")]) == ""
    p = cradle.Parameters(**{v.name: v.start for v in load("cradle").parameters} | {"docking_time": 1.0})
    assert "submersible_mass" in cradle.CRADLE.refused(p)


@pytest.mark.parametrize("name", UNITS)
def test_unit_files_hold_what_is_of_fmi_alone(name: str) -> None:
    unit = load(name)
    assert unit.name == name == unit.model.name and unit.description == unit.model.description
    assert len(unit.model.documentation) > 200
    assert set(unit.start) <= {v.name for v in unit.parameters + unit.inputs}
    assert set(unit.reference_inputs) <= {v.name for v in unit.inputs}
