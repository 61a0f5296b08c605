"""No foreign unit gives a wrong number without a word: a unit for each way in which one may."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

import towage
from towage.cli import main
from towage.errors import FmuError, RunError, SceneError
from towage.master.master import run_resolved
from towage.process.worker import run_isolated
from towage.scene.flavour import resolve
from towage.sweeps.report import write_report
from towage.units.archive import read_description

from .zoo import animal, run, scene, told

CHAIN = ["a.y -> b.u"]
"""a's output is x0 + gain t for a constant input 1, b integrates it."""
ONE = {"inputs": {"u": 1.0}}


def chain(tmp_path: Path, manner: str = "sound", first: str = "sound", **about: object) -> dict[str, object]:
    """A sound unit, or one of ``first`` manner, before one of ``manner``."""
    return {
        "a": {"fmu": animal(tmp_path / "a.fmu", first), **ONE},
        "b": {"fmu": animal(tmp_path / "b.fmu", manner, **about)},
    }


# ---- steps -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("scheme", ["auto", "hermite", "extrapolate", "jacobi"])
def test_a_unit_that_commits_a_step_only_where_the_flag_is_true(tmp_path: Path, scheme: str) -> None:
    """libcosim's quarter truck."""
    result = run(chain(tmp_path, "commits", "commits"), CHAIN, coupling={"scheme": scheme})
    assert result["a.y"][-1] == pytest.approx(2.0, rel=1e-12)
    assert result["b.y"][-1] == pytest.approx(2.0, rel=0.06 if scheme == "jacobi" else 1e-12)  # t^2 / 2


def test_a_unit_that_forgets_its_past_where_the_flag_is_true_is_not_taken_back(tmp_path: Path) -> None:
    result = run(chain(tmp_path, "flushes", "flushes"), CHAIN)
    assert result.scheme == "extrapolate"
    assert "a does not restore its state well enough" in told(result, "scheme")
    assert result["b.y"][-1] == pytest.approx(2.0, rel=1e-9)


@pytest.mark.parametrize(("rollback", "scheme"), [(True, "auto"), (False, "auto"), (True, "extrapolate")])
@pytest.mark.parametrize("end", [0.55, 1.0])
def test_a_unit_that_ends_by_itself_ends_the_run(tmp_path: Path, end: float, rollback: bool, scheme: str) -> None:
    """Reference-FMUs Stair: Discard with fmi2Terminated."""
    units = {"a": {"fmu": animal(tmp_path / "a.fmu", "ends", rollback=rollback), "parameters": {"end": end}, **ONE}}
    result = run(units, [], coupling={"scheme": scheme, "error_estimate": True})
    assert result.status == "done"
    assert result.time[-1] == pytest.approx(end, rel=1e-12)
    assert result["a.y"][-1] == pytest.approx(end, rel=1e-9)
    assert f"a, Discard: the unit ended the run at t = {end:g} s, before 2 s" in told(result, "end")
    assert len(result.step_sizes) <= 12
    assert result.coupling_error["a.y"] == pytest.approx(0.0, abs=1e-9)


def test_where_one_of_two_units_ends_both_are_brought_there(tmp_path: Path) -> None:
    units = chain(tmp_path, "ends")
    units["b"]["parameters"] = {"end": 0.55}  # type: ignore[index]
    result = run(units, CHAIN)
    assert (result.status, result.time[-1]) == ("done", pytest.approx(0.55))
    assert result["a.y"][-1] == pytest.approx(0.55)
    assert result["b.y"][-1] == pytest.approx(0.55**2 / 2.0)


def test_where_one_of_two_ends_and_they_cannot_go_back_the_run_ends_before(tmp_path: Path) -> None:
    units = chain(tmp_path, "ends", rollback=False)
    units["b"]["parameters"] = {"end": 0.55}  # type: ignore[index]
    result = run(units, CHAIN)
    assert (result.status, result.time[-1]) == ("done", pytest.approx(0.5))
    assert "the unit ended the run at t = 0.5 s" in told(result, "end")


def test_a_unit_that_does_no_step_across_a_time_fails_there(tmp_path: Path) -> None:
    units = {"a": {"fmu": animal(tmp_path / "a.fmu", "wall"), "parameters": {"end": 0.55}, **ONE}}
    result = run(units, [])
    assert result.status == "failed"
    assert result.message.startswith("t = 0.55 s: no step is short enough for a unit")
    assert len(result.step_sizes) < 100


def test_a_unit_that_forgets_what_was_set_before_the_experiment(tmp_path: Path) -> None:
    """Those of 20-sim: start values are set when the experiment is."""
    units = {"a": {"fmu": animal(tmp_path / "a.fmu", "forgets"), "parameters": {"gain": 3.0, "x0": 1.0}, **ONE}}
    assert run(units, [])["a.y"][-1] == pytest.approx(7.0, rel=1e-12)


@pytest.mark.parametrize("noise", [1e-7, 1e-4])
def test_the_noise_of_a_repeated_step_is_measured_and_what_is_too_much_is_not_repeated(tmp_path: Path, noise: float) -> None:
    """The FMUs of Dymola: a variable-step solver inside."""
    units = chain(tmp_path, "noisy")
    units["b"]["parameters"] = {"noise": noise, "x0": 1.0}  # type: ignore[index]
    result = run(units, CHAIN)
    assert result.status == "done"
    bears = noise < 1e-6
    assert result.scheme == ("hermite" if bears else "extrapolate")
    assert bool(told(result, "noise")) == bears
    assert ("b does not restore its state well enough (y differs by" in told(result, "scheme")) != bears
    assert result["b.y"][-1] == pytest.approx(3.0, abs=25.0 * noise)


def test_a_named_scheme_does_not_take_a_noisy_unit_back_in_silence(tmp_path: Path) -> None:
    units = chain(tmp_path, "noisy")
    units["b"]["parameters"] = {"noise": 1e-4, "x0": 1.0}  # type: ignore[index]
    result = run(units, CHAIN, coupling={"scheme": "hermite"})
    assert result.status == "failed"
    assert "b.y, t = 0 s: does not restore its state" in result.message
    assert "'extrapolate'" in result.message


def test_a_unit_with_a_hidden_state_runs_without_going_back(tmp_path: Path) -> None:
    """y'' = u, of which the velocity is not saved; at rest at first."""
    units = chain(tmp_path, "hidden")
    reference = run(units, CHAIN, coupling={"scheme": "extrapolate", "events": False})
    result = run(units, CHAIN)
    assert result.scheme == "extrapolate"
    assert result["b.y"].tolist() == reference["b.y"].tolist()


@pytest.mark.parametrize(("stated", "tolerance", "wanted"), [("", None, -1.0), ("1e-5", None, 1e-5), ("1e-5", 1e-3, 1e-3)])
def test_the_tolerance_is_given_to_the_unit(
    tmp_path: Path, stated: str, tolerance: float | None, wanted: float
) -> None:
    experiment = f'<DefaultExperiment tolerance="{stated}"/>' if stated else ""
    coupling = {"tolerance": tolerance, "step": None} if tolerance else {}
    result = run({"a": animal(tmp_path / "a.fmu", experiment=experiment)}, [], coupling=coupling)
    assert result["a.tolerance"][-1] == wanted


@pytest.mark.parametrize("stop", [1.0, 0.95])
def test_a_unit_of_one_step_size_stays_on_its_grid(tmp_path: Path, stop: float) -> None:
    units = chain(tmp_path, "fixed", variable_step=False)
    result = run(units, CHAIN, stop, record={"interval": 0.25})
    assert result.status == "done", result.message
    assert set(np.round(result.step_sizes, 12)) == {0.1}
    assert result.time[-1] == pytest.approx(1.0 if stop == 1.0 else 0.9)
    said = told(result, "grid")
    assert said.startswith("b takes communication steps of one size only")
    assert ("the run ends at 0.9 s, not at 0.95 s" in said) == (stop == 0.95)


def test_error_control_gives_way_to_the_grid_of_a_unit(tmp_path: Path) -> None:
    coupling = {"step": None, "tolerance": 1e-4}
    units = chain(tmp_path, "fixed", variable_step=False)
    with pytest.raises(SceneError, match=r"coupling\.tolerance: b takes communication steps of one size only.*give a step"):
        run(units, CHAIN, coupling=coupling)
    units = chain(tmp_path, "fixed", variable_step=False, experiment='<DefaultExperiment stepSize="0.05"/>')
    result = run(units, CHAIN, coupling=coupling)
    assert set(np.round(result.step_sizes, 12)) == {0.05}
    assert "there is no error control" in told(result, "grid")


# ---- values ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("step", [0.2, 0.1])
def test_what_goes_straight_through_to_the_record_is_on_time(tmp_path: Path, step: float) -> None:
    result = run(chain(tmp_path), CHAIN, coupling={"step": step})
    assert result["b.w"] == pytest.approx(result["a.y"], abs=1e-12)
    assert result["b.y"] == pytest.approx(result.time**2 / 2.0, abs=1e-12)


def test_outputs_that_are_made_in_a_step_alone_are_named(tmp_path: Path) -> None:
    result = run(chain(tmp_path, "lazy"), CHAIN)
    assert "outputs of b do not follow its inputs when they are set between steps" in told(result, "late outputs")


NAMES = {"y": "heading", "rate": "heading_rate", "calls": "event_count", "w": "margin_of_profit", "n": "next_event_time"}
DEGREES = (
    '<UnitDefinitions><Unit name="deg"><BaseUnit rad="1" factor="0.017453292519943295"/></Unit>'
    '<Unit name="deg/min"><BaseUnit rad="1" s="-1" factor="0.0002908882086657216"/></Unit></UnitDefinitions>'
)


def test_names_alone_are_no_conventions(tmp_path: Path) -> None:
    """A count that is called event_count, a loss that is called margin_of_profit, a rate without a unit of measure."""
    units = {"a": {"fmu": animal(tmp_path / "a.fmu", names=NAMES), "inputs": {"u": -1.0}}}
    units["b"] = {"fmu": animal(tmp_path / "b.fmu")}
    result = run(units, ["a.heading -> b.u"])
    assert result.events == []
    assert result.margins == []
    assert result.verdict.word != "invalid"
    assert not told(result, "units")
    assert result["b.y"] == pytest.approx(-(result.time**2) / 2.0, abs=1e-12)
    with pytest.raises(SceneError, match=r"'a\.margin_of_profit' is no margin"):
        run(units, ["a.heading -> b.u"], checks={"report_only": ["a.margin_of_profit"]})


@pytest.mark.parametrize("manner", ["per minute", "sound"])
def test_a_rate_whose_unit_of_measure_fits_is_converted_and_named(tmp_path: Path, manner: str) -> None:
    """heading' = u deg/s; the rate is told as 60 u deg/min, and by the sound unit, wrongly here, as u deg/min."""
    reals = {"y": ' unit="deg"', "rate": ' unit="deg/min"'}
    about = {"names": NAMES, "reals": reals, "extra": DEGREES}
    fmu = animal(tmp_path / "a.fmu", manner, **about)
    result = run({"a": {"fmu": fmu, "inputs": {"u": 1.0}}, "b": animal(tmp_path / "b.fmu")}, ["a.heading -> b.u"])
    honest = manner == "per minute"
    taken = "a: heading_rate [deg/min] is taken for the time derivative of heading"
    assert told(result, "units") == (taken if honest else "")
    assert ("what it tells as the rate of heading is not its time derivative" in told(result, "fallback")) != honest
    assert result["b.y"] == pytest.approx(result.time**2 / 2.0, abs=1e-12)


def test_derivatives_of_outputs_are_asked_for_after_a_step_alone(tmp_path: Path) -> None:
    """Dymola answers infinity before."""
    fmu = animal(tmp_path / "a.fmu", options='maxOutputDerivativeOrder="1"')
    result = run({"a": {"fmu": fmu, **ONE}, "b": animal(tmp_path / "b.fmu")}, CHAIN)
    assert result.status == "done", result.message
    assert result["b.y"] == pytest.approx(result.time**2 / 2.0, abs=1e-12)


TEMPERATURES = (
    '<UnitDefinitions><Unit name="degC"><BaseUnit K="1" offset="273.15"/></Unit><Unit name="K"><BaseUnit K="1"/></Unit>'
    '<Unit name="degF"><BaseUnit K="1" factor="0.5555555555555556" offset="255.3722222222222"/></Unit></UnitDefinitions>'
)


@pytest.mark.parametrize(("unit", "value"), [("K", 293.15), ("degF", 68.0), ("degC", 20.0)])
def test_units_of_measure_with_an_offset_are_converted(tmp_path: Path, unit: str, value: float) -> None:
    about = {"extra": TEMPERATURES, "reals": {"y": ' unit="degC"', "u": f' unit="{unit}"'}}
    units = {
        "a": {"fmu": animal(tmp_path / "a.fmu", **about), "parameters": {"x0": 20.0}},
        "b": {"fmu": animal(tmp_path / "b.fmu", **about)},
    }
    result = run(units, CHAIN)
    assert result["b.w"] == pytest.approx(value, rel=1e-12)
    units["b"]["inputs"] = {"u": "20 degC"}  # a text in a unit that the FMU defines
    assert run(units, [])["b.w"][-1] == pytest.approx(value, rel=1e-12)


def test_a_unit_of_measure_that_nobody_defines_is_taken_with_a_warning(tmp_path: Path) -> None:
    units = {
        "a": {"fmu": animal(tmp_path / "a.fmu", reals={"y": ' unit="metre"'}), **ONE},
        "b": animal(tmp_path / "b.fmu", reals={"u": ' unit="m"'}),
    }
    result = run(units, CHAIN)
    assert "'metre' is defined nowhere, so values pass unchanged, as if it were 'm'" in told(result, "units")
    assert result["b.y"][-1] == pytest.approx(2.0)


def test_a_discrete_signal_is_held_over_a_step(tmp_path: Path) -> None:
    """The staircase of whole seconds: 0, 1, 2; a cubic would smear it over the step before."""
    result = run(chain(tmp_path), ["a.stairs -> b.u"], 3.0, coupling={"step": 0.25})
    assert result["b.y"][-1] == pytest.approx(3.0, abs=1e-12)
    assert result["b.w"] == pytest.approx(np.floor(result.time + 1e-9), abs=1e-12)


# ---- files and names -------------------------------------------------------------------------------------------------


def test_a_model_identifier_that_is_no_identifier_of_c(tmp_path: Path) -> None:
    units = {"a": {"fmu": animal(tmp_path / "a.fmu", identifier="watertank-c"), **ONE}}
    result = run(units, [])
    assert result["a.y"][-1] == pytest.approx(2.0)
    assert told(result, "units").startswith("a: modelIdentifier 'watertank-c' is not a C identifier")


def test_a_model_identifier_that_names_no_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(FmuError, match=r"modelIdentifier '-x' is not a C identifier"):
        read_description(Path(animal(tmp_path / "a.fmu", identifier="-x")))


def test_an_archive_with_an_entry_that_ends_in_a_full_stop(tmp_path: Path) -> None:
    fmu = animal(tmp_path / "a.fmu", entries={"resources/notes.": "x"})
    result = run({"a": {"fmu": fmu, **ONE}}, [])
    assert result["a.y"][-1] == pytest.approx(2.0)
    assert "resources/notes." in told(result, "units")


def test_names_with_an_arrow_inside(tmp_path: Path) -> None:
    names = {"y": "tank -&gt; pump.flow", "u": "in -&gt; out"}
    fmu = animal(tmp_path / "a.fmu", names=names)
    units = {"a": {"fmu": fmu, "inputs": {"in -> out": 1.0}}, "b": {"fmu": fmu}}
    result = run(units, ["a.tank -> pump.flow -> b.in -> out"])
    assert result["b.tank -> pump.flow"][-1] == pytest.approx(2.0)
    with pytest.raises(SceneError, match="there is no unit|has no variable"):
        run(units, ["a.tank -> pumps.flow -> b.in -> out"])


# ---- messages --------------------------------------------------------------------------------------------------------


def test_what_a_unit_says_is_kept_and_the_first_error_explains(tmp_path: Path) -> None:
    units = {"a": {"fmu": animal(tmp_path / "a.fmu", "talker"), "parameters": {"end": 0.55}, **ONE}}
    result = run(units, [])
    assert result.status == "failed"
    assert "the valve is stuck" in result.message
    assert "everything else" not in result.message
    assert [m.text for m in result.messages[:3]] == [
        "the first word, a warning", "the valve is stuck", "and so is everything else"
    ]  # fmt: skip
    assert result.messages[0].line() == "t = 0 s, a, Warning, zoo: the first word, a warning"
    assert "first error: t = 0 s, a, Error, zoo: the valve is stuck" in told(result, "messages")


def test_the_log_lies_beside_the_results_and_the_summary_tells(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "talk.toml"
    animal(tmp_path / "a.fmu", "talker", reals={"u": ' unit="metre"'})
    file.write_text(
        'title = "Talk"\nstop_time = 0.3\n[units.a]\nfmu = "a.fmu"\n[units.a.inputs]\nu = 1\n[coupling]\nstep = 0.1\n'
    )
    assert main(["run", str(file), "--out", str(tmp_path / "out"), "--no-report", "--progress", "none"]) == 0
    assert re.search(r"a logged \d+ messages; first error: t = 0 s, a, Error", capsys.readouterr().out)
    lines = (tmp_path / "out" / "talk.log").read_text().splitlines()
    assert lines[1] == "t = 0 s, a, Error, zoo: the valve is stuck"
    assert len(lines) >= 9  # three a step, more where a step is repeated


def test_what_a_unit_said_before_its_process_died_is_kept(tmp_path: Path) -> None:
    units = {"a": {"fmu": animal(tmp_path / "a.fmu", "dies"), "parameters": {"end": 0.55}, **ONE}}
    result = run_isolated(resolve(scene(units, [])))
    assert result.status == "failed"
    assert [m.text for m in result.messages] == ["something is burning"]


def test_validate_tells_what_is_wrong_with_a_unit(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    animal(tmp_path / "a.fmu", identifier="watertank-c")
    (tmp_path / "s.toml").write_text('title = "S"\nstop_time = 1\n[units.a]\nfmu = "a.fmu"\n[coupling]\nstep = 0.1\n')
    assert main(["validate", str(tmp_path / "s.toml")]) == 0
    assert "warning  units: a: modelIdentifier 'watertank-c'" in capsys.readouterr().out


def test_a_scene_of_foreign_units_is_swept_and_reported(tmp_path: Path) -> None:
    table = towage.sweep(scene(chain(tmp_path), CHAIN), "a.gain=1:2:2", workers=1)
    assert table.measures["max:b.y"].tolist() == pytest.approx([2.0, 4.0])
    text = write_report(table, scene(chain(tmp_path), CHAIN), [], tmp_path / "report.html").read_text()
    assert "largest a." in text


# ---- initialisation --------------------------------------------------------------------------------------------------


def test_an_initial_state_that_follows_from_a_connected_input(tmp_path: Path) -> None:
    """x(0) = x0 + u(0): a begins at 5, b at 10 + 5."""
    units = chain(tmp_path, "from input")
    units["a"]["parameters"] = {"x0": 5.0}  # type: ignore[index]
    units["a"]["inputs"] = {"u": 0.0}  # type: ignore[index]
    units["b"]["parameters"] = {"x0": 10.0, "gain": 0.0}  # type: ignore[index]
    for connections in (CHAIN, ["a.w -> b.n"][:0] + CHAIN):
        assert run(units, connections)["b.y"][0] == 15.0


@pytest.mark.parametrize(("gain", "first"), [(0.5, 2.0), (3.0, -0.5)])
def test_a_loop_of_initial_values_is_solved(tmp_path: Path, gain: float, first: float) -> None:
    """a: x = 1 + u and y = x; b: w = gain u. So x = 1 / (1 - gain), by passes or as an equation."""
    units = {
        "a": {"fmu": animal(tmp_path / "a.fmu", "from input"), "parameters": {"x0": 1.0}},
        "b": {"fmu": animal(tmp_path / "b.fmu"), "parameters": {"gain": gain}},
    }
    result = run(units, ["a.y -> b.u", "b.w -> a.u"], 0.1)
    assert result.status == "done", result.message
    assert result["a.y"][0] == pytest.approx(first, rel=1e-9)


def test_a_loop_without_initial_values_says_so(tmp_path: Path) -> None:
    """x = 1 + x."""
    units = {
        "a": {"fmu": animal(tmp_path / "a.fmu", "from input"), "parameters": {"x0": 1.0}},
        "b": {"fmu": animal(tmp_path / "b.fmu")},
    }
    with pytest.raises(RunError, match=r"the initial values along the loop of .* do not stand still after 100 passes"):
        run(units, ["a.y -> b.u", "b.w -> a.u"], 0.1)


# ---- discrete signals ------------------------------------------------------------------------------------------------


def test_integers_truth_values_and_texts_travel_and_are_recorded(tmp_path: Path) -> None:
    """a counts half seconds and says whether the count is odd; b doubles it, a truth value turns round."""
    units = chain(tmp_path, first="counter")
    result = run(units, ["a.n -> b.n_in", "a.s -> b.s_in", "a.b -> b.b_in"])
    count = np.floor(2.0 * result.time + 1e-9)
    assert result["a.n"] == pytest.approx(count)
    assert result["b.n"] == pytest.approx(2.0 * count)
    assert result["b.b"].tolist() == [0.0] * len(count)
    assert result["a.s"].tolist() == ["odd" if n % 2 else "even" for n in count]
    assert result["b.s"].tolist() == result["a.s"].tolist()


def test_a_text_goes_to_every_file_and_comes_back(tmp_path: Path) -> None:
    result = run(chain(tmp_path, first="counter"), ["a.s -> b.s_in"])
    result.save_npz(tmp_path / "r.npz")
    assert type(result).load_npz(tmp_path / "r.npz")["b.s"].tolist() == result["b.s"].tolist()
    result.save_csv(tmp_path / "r.csv")
    assert "odd" in (tmp_path / "r.csv").read_text()
    result.save_mat(tmp_path / "r.mat")


@pytest.mark.parametrize("connection", ["a.n -> b.b_in", "a.s -> b.n_in", "a.y -> b.n_in", "a.n -> b.u"])
def test_kinds_are_joined_like_to_like(tmp_path: Path, connection: str) -> None:
    with pytest.raises(SceneError, match="the types must agree"):
        resolve(scene(chain(tmp_path), [connection]))


def test_no_value_is_lost_between_two_runs_of_one_scene(tmp_path: Path) -> None:
    resolved = resolve(scene(chain(tmp_path, first="counter"), ["a.n -> b.n_in", *CHAIN]))
    first, second = run_isolated(resolved), run_resolved(resolved)
    assert all(np.array_equal(first[name], second[name]) for name in first.columns)
    assert first["b.s"].tolist() == second["b.s"].tolist()
