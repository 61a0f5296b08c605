"""Direct dependence: what the trace of a model finds beside what the model declares."""

from __future__ import annotations

import pytest

from towage.fmus import UNITS
from towage.fmus.declare.dependencies import declared_inputs, dependencies, derived
from towage.fmus.declare.unit import load
from towage.models.protocol.variables import quantities


@pytest.mark.parametrize("name", UNITS)
def test_a_model_declares_only_what_no_trace_finds(name: str) -> None:
    """Forces of the linear tows follow from D and E, which a reduction fills; ``floats_only`` models cannot be traced."""
    unit = load(name)
    found, whole = derived(unit), dependencies(unit)
    declares = {n: declared_inputs(unit, q) for n, q in quantities(unit.model.Outputs).items() if q.also}
    reduced = unit.model.linear is not None and unit.model.linear.study is not None
    assert not declares or unit.model.floats_only or reduced
    for output, inputs in whole.items():
        assert set(inputs) == found[output] | declares.get(output, set())
    # a declaration that the trace finds for every output were none that is needed
    assert not declares or any(more - found[output] for output, more in declares.items())


def test_docking_acts_through_the_event_alone() -> None:
    """The velocity of the submersible is in no formula of the velocity; it comes in with the transition."""
    whole = dependencies(load("cradle"))
    assert whole["heave"] == () and whole["velocity"] == ("submersible_velocity",)
    assert whole["acceleration"] == ("line_tension", "submersible_velocity")


def test_a_rate_alone_counts() -> None:
    """`event_taut_rate` of the cradle on its line: the speed of the lower end jumps when the submersible docks."""
    whole = dependencies(load("cradle_on_line"))
    assert whole["margin_taut"] == ("heave_top",)
    assert whole["tension_rate"] == ("heave_top", "submersible_velocity")
