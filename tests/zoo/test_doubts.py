"""What a unit does not do although its description says so: found in the run, said, and done without for that unit alone."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from towage.errors import SceneError
from towage.process.worker import run_isolated
from towage.scene.flavour import resolve

from .zoo import OUTPUT, animal, animal3, run, scene, told

CHAIN = ["a.y -> b.u"]
ONE = {"inputs": {"u": 1.0}}
RATES = {"options": 'maxOutputDerivativeOrder="1"'}
SLOPES = {"options": 'canInterpolateInputs="true"'}


def circle(directory: Path, third: str = "", **about: object) -> tuple[dict[str, object], list[str]]:
    """a' = -b, b' = a, so that a = cos t; c, of the ``third`` manner, integrates a."""
    fmu = animal(directory / "sound.fmu")
    units: dict[str, object] = {"a": {"fmu": fmu, "parameters": {"gain": -1.0, "x0": 1.0}}, "b": fmu}
    connections = ["a.y -> b.u", "b.y -> a.u"]
    if third:
        units["c"] = {"fmu": animal(directory / "third.fmu", third, **about), "parameters": {"noise": 1e-4, "x0": 1.0}}
        connections.append("a.y -> c.u")
    return units, connections


@pytest.mark.parametrize(("manner", "about"), [("noisy", {}), ("sound", {"rollback": False})])
def test_a_unit_that_is_not_taken_back_costs_the_others_nothing(tmp_path: Path, manner: str, about: dict[str, bool]) -> None:
    alone = run(*circle(tmp_path))
    result = run(*circle(tmp_path, manner, **about))
    assert alone.scheme == result.scheme == "hermite"
    assert result["a.y"].tolist() == alone["a.y"].tolist()
    assert result["c.y"][-1] == pytest.approx(1.0 + np.sin(2.0), abs=2e-3)  # a tenth of a step of noise at most
    noisy = manner == "noisy"
    said = "unit c: does not restore its state well enough (y differs by"
    assert told(result, "fallback").startswith(said) == noisy
    assert ("therefore it is never taken back: it makes every step once" in told(result, "fallback")) == noisy
    assert "a, b can go back" in told(result, "scheme")


def test_one_in_the_loop_that_is_not_taken_back_is_extrapolated(tmp_path: Path) -> None:
    """Without rates: the first step of one that is not corrected has its input held, an error of h^2 / 2."""
    _, connections = circle(tmp_path)
    for stuck, scheme in (("", "hermite"), ("b", "hermite"), ("ab", "extrapolate")):
        fmus = {unit: animal(tmp_path / f"{unit}{stuck}.fmu", rollback=unit not in stuck) for unit in "ab"}
        units = {"a": {"fmu": fmus["a"], "parameters": {"gain": -1.0, "x0": 1.0}}, "b": fmus["b"]}
        result = run(units, connections)
        assert result.scheme == scheme
        assert result["a.y"] == pytest.approx(np.cos(result.time), abs=0.1**2 / 2.0)


@pytest.mark.parametrize(("manner", "why"), [
    ("per minute", "what it tells as the rate of y is not its time derivative"),
    ("no rates", "answers Error where it is asked for the derivatives of outputs that it declares"),
])  # fmt: skip
def test_rates_that_are_none_are_done_without(tmp_path: Path, manner: str, why: str) -> None:
    units = {"a": {"fmu": animal(tmp_path / "a.fmu", manner, **RATES), **ONE}, "b": animal(tmp_path / "b.fmu")}
    result = run(units, CHAIN)
    assert (result.status, result.scheme) == ("done", "hermite")
    assert told(result, "fallback") == f"unit a: {why}, therefore differences take the place of its rates"
    assert result["b.y"] == pytest.approx(result.time**2 / 2.0, abs=1e-12)
    named = run(units, CHAIN, coupling={"scheme": "hermite"})
    assert (named.status, why in named.message) == ("failed", True)
    isolated = run_isolated(resolve(scene(units, CHAIN)), a_process_a_unit=True)
    assert isolated["b.y"].tolist() == result["b.y"].tolist()


@pytest.mark.parametrize("manner", ["listens", "deaf"])
def test_derivatives_of_inputs_that_are_not_heeded_are_not_relied_on(tmp_path: Path, manner: str) -> None:
    """Held at the beginning of a step, an input that rises is half a step late: 1.9 instead of 2."""
    units = {"a": {"fmu": animal(tmp_path / "a.fmu"), **ONE}, "b": animal(tmp_path / "b.fmu", manner, **SLOPES)}
    result = run(units, CHAIN)
    assert result["b.y"] == pytest.approx(result.time**2 / 2.0, abs=1e-12)
    assert ("does nothing with the derivatives of its inputs" in told(result, "fallback")) == (manner == "deaf")


def test_two_names_of_one_variable(tmp_path: Path) -> None:
    """Dymola and OpenModelica write them: both are read, and what comes after them; one of them may be set."""
    smooth, steps = OUTPUT.format("continuous"), OUTPUT.format("discrete")
    more = {
        "y_again": (1, smooth, "<Real/>"), "n_again": (21, steps, "<Integer/>"), "last": (2, smooth, "<Real/>"),
        "u_again": (0, 'causality="input"', '<Real start="0"/>'),
    }  # fmt: skip
    fmu = animal(tmp_path / "a.fmu", more=more)
    result = run({"a": {"fmu": fmu, "inputs": {"u": 1.0, "n_in": 3}}}, [])
    assert result["a.y_again"].tolist() == result["a.y"].tolist()
    assert (result["a.last"][-1], result["a.n_again"][-1], result["a.n"][-1]) == (1.0, 6.0, 6.0)
    with pytest.raises(SceneError, match=r"a\.u and a\.u_again are two names of one variable \(value reference 0\)"):
        resolve(scene({"a": {"fmu": fmu, "inputs": {"u": 1.0, "u_again": 2.0}}}, []))
    with pytest.raises(SceneError, match="two names of one variable"):
        resolve(scene({"a": {"fmu": fmu, "inputs": {"u_again": 1.0}}, "b": fmu}, ["b.y -> a.u"]))


@pytest.mark.parametrize(
    ("manner", "name", "says"),
    [
        ("restless", "reading", "and, read again at once at t = 0.1 s, 0.10"),
        ("ignores", "start values", "a.gain was set to 2 and reads 1: the unit does not take it"),
        ("warns", "warnings", "20 calls of a ended with a warning, first at t = 0 s"),
        ("commas", "process", "a changed the locale, to LC_"),
    ],
)
def test_what_a_unit_does_is_said(tmp_path: Path, manner: str, name: str, says: str) -> None:
    units = {"a": {"fmu": animal(tmp_path / "a.fmu", manner, rollback=False), "parameters": {"gain": 2.0}, **ONE}}
    if manner == "restless":
        units["a"]["parameters"] = {}
    result = run(units, [])
    assert says in told(result, name), [f.message for f in result.checks]


@pytest.mark.parametrize("bounds", ["", ' min="-1" max="1"'])
def test_a_signal_outside_the_bounds_of_its_variable_is_said(tmp_path: Path, bounds: str) -> None:
    units = {"a": {"fmu": animal(tmp_path / "a.fmu"), **ONE}, "b": animal(tmp_path / "b.fmu", "clips", reals={"u": bounds})}
    result = run(units, CHAIN)
    assert told(result, "bounds").startswith("b.u is given 1.") == bool(bounds)
    assert told(result, "bounds").count("b.u") == bool(bounds)


def test_an_enumeration_has_the_values_of_its_items(tmp_path: Path) -> None:
    """n = 2 n_in becomes 8, which its type does not name."""
    items = "".join(f'<Item name="{name}" value="{k}"/>' for k, name in enumerate(("slack", "taut", "broken"), 1))
    extra = f'<TypeDefinitions><SimpleType name="Line"><Enumeration>{items}</Enumeration></SimpleType></TypeDefinitions>'
    more = {"line": (21, OUTPUT.format("discrete"), '<Enumeration declaredType="Line"/>')}
    result = run({"a": {"fmu": animal(tmp_path / "a.fmu", more=more, extra=extra), "inputs": {"n_in": 4}}}, [])
    assert "a.line becomes 8 at t = 0.1 s, outside the 1 to 3 that its unit declares" in told(result, "bounds")


@pytest.mark.parametrize(
    ("manner", "says"),
    [("pending", "Pending: it computes on its own"), ("nan", "y became nan; its last finite value was"),
     ("mute", "no step is short enough for a unit")],
)  # fmt: skip
def test_what_cannot_go_on_fails_and_says_why(tmp_path: Path, manner: str, says: str) -> None:
    result = run({"a": {"fmu": animal(tmp_path / "a.fmu", manner), "parameters": {"end": 0.55}, **ONE}}, [])
    assert (result.status, says in result.message) == ("failed", True), result.message


def test_a_unit_that_lies_of_where_it_ended_ends_the_run_where_it_was(tmp_path: Path) -> None:
    """It ends at 0.55 s, and says at 1.5 s."""
    units = {"a": {"fmu": animal(tmp_path / "a.fmu", "liar"), "parameters": {"end": 0.55}, **ONE}}
    result = run(units, [])
    assert (result.status, result.time[-1]) == ("done", pytest.approx(0.5))
    assert "the unit ended the run at t = 0.5 s, before 2 s" in told(result, "end")


def test_a_stop_time_that_no_unit_is_led_beyond(tmp_path: Path) -> None:
    """Not by the last bit: 3 * 0.1 is more than 0.3."""
    result = run({"a": {"fmu": animal(tmp_path / "a.fmu", "stop"), **ONE}}, [], 0.3)
    assert (result.status, result.time[-1]) == ("done", pytest.approx(0.3)), result.message


def test_truth_has_two_values(tmp_path: Path) -> None:
    """-1 is true for some; passed on and recorded it is 1."""
    units = {"a": animal(tmp_path / "a.fmu", "truthy"), "b": animal(tmp_path / "b.fmu")}
    result = run(units, ["a.b -> b.b_in"])
    assert (set(result["a.b"]), set(result["b.b"])) == ({1.0}, {0.0})


@pytest.mark.parametrize(("manner", "most"), [("decays", 0.06), ("quantum", 0.3)])
def test_what_depends_on_the_step_is_seen_by_the_run_with_longer_steps(tmp_path: Path, manner: str, most: float) -> None:
    """Of first order: the whole difference of the runs is the error, not a fifteenth of it."""
    units = {"a": {"fmu": animal(tmp_path / "a.fmu", manner), "parameters": {"x0": 1.0}, **({} if manner == "decays" else ONE)}}
    result = run(units, [], coupling={"error_estimate": True})
    exact = np.exp(-result.time) if manner == "decays" else 1.0 + result.time
    error = np.max(np.abs(result["a.y"] - exact)) / np.max(np.abs(result["a.y"]))
    estimate = result.coupling_error["a.y"]
    assert estimate > (0.5 * error if manner == "decays" else 0.0)
    assert estimate < most


def test_an_event_that_is_forgotten_where_a_state_is_restored(tmp_path: Path) -> None:
    """Reference-FMUs 0.0.36: the ball falls through the floor where a host goes back for the event."""
    units = {"a": {"fmu": animal3(tmp_path / "a.fmu", "forgets", events=True), **ONE}, "b": animal3(tmp_path / "b.fmu")}
    result = run(units, CHAIN)
    assert result.status == "done", result.message
    assert "unit a: forgets an event at t = 0.55 s when its state is restored, therefore" in told(result, "fallback")
    assert result["a.y"][-1] == pytest.approx(2.0 - 10.0, abs=1e-9)


def test_a_step_that_ends_elsewhere_than_it_says_is_told(tmp_path: Path) -> None:
    """Reference-FMUs Roberts, with steps of its own inside that miss the end."""
    result = run({"a": {"fmu": animal3(tmp_path / "a.fmu", "astray"), **ONE}}, [])
    assert "says that it did the whole step to 0.1 s, and that it came to 0.05 s" in told(result, "warnings")


def test_feedthrough_that_is_not_declared_is_said(tmp_path: Path) -> None:
    fmu = animal(tmp_path / "b.fmu", depends={"w": ""})
    units = {"a": {"fmu": animal(tmp_path / "a.fmu"), **ONE}, "b": fmu}
    result = run(units, CHAIN)
    assert "b.w follows u without delay, and its description declares that it does not" in told(result, "feedthrough")
    assert result["b.y"] == pytest.approx(result.time**2 / 2.0, abs=1e-12)


@pytest.mark.parametrize("manner", ["shares", "alone"])
def test_static_variables_are_those_of_one_unit(tmp_path: Path, manner: str) -> None:
    """Two units of one file, and the run with longer steps after them."""
    fmu = animal(tmp_path / "a.fmu", manner)
    one = run({"a": {"fmu": fmu, **ONE}}, [], 0.5)
    both = run({"a": {"fmu": fmu, **ONE}, "b": {"fmu": fmu, **ONE}}, [], 0.5)
    again = run({"a": {"fmu": fmu, **ONE}}, [], 0.5, coupling={"error_estimate": True})
    assert one["a.y"].tolist() == both["a.y"].tolist() == both["b.y"].tolist() == again["a.y"].tolist()
