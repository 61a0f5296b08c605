"""What `towage vet` finds of the animals, and that the master heeds it."""

from __future__ import annotations

import json
import pickle
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

import pytest

from towage.cli import main
from towage.errors import SceneError
from towage.process.child import converse
from towage.scene.flavour import resolve
from towage.units import vetted
from towage.units.archive import read_description
from towage.units.vetted import HEED, heeded
from towage.vet import process
from towage.vet.bench import Bench, Trial
from towage.vet.trials import TRIALS, tried
from towage.vet.vet import Vetted, vet

from .zoo import animal, animal3, run, scene, told

EXPERIMENT = {"experiment": '<DefaultExperiment stepSize="0.06"/>'}


@pytest.fixture(autouse=True)
def own_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TOWAGE_CACHE", str(tmp_path / "cache"))


def levels(name: str, fmu: str) -> dict[str, str]:
    """What a trial found, by what it is called."""
    return {trial.name: trial.level for trial in tried(name, Path(fmu))}


@pytest.mark.parametrize("make", [animal, animal3])
def test_a_sound_unit_is_sound(tmp_path: Path, make: object, monkeypatch: pytest.MonkeyPatch) -> None:
    fmu = make(tmp_path / "a.fmu")  # type: ignore[operator]
    monkeypatch.setattr(process, "LEAK_STEPS", 5000)
    for name in TRIALS:
        assert set(levels(name, fmu).values()) <= {"ok", "note"}, (name, tried(name, Path(fmu)))


@pytest.mark.parametrize(
    ("manner", "trial", "found", "level"),
    [
        ("commits", "flag", "flag", "note"),
        ("hidden", "rollback", "state", "warning"),
        ("lazy", "feedthrough", "feedthrough", "note"),
        ("wanders", "environment", "environment", "fault"),
        ("forks", "environment", "environment", "fault"),
        ("rounds", "environment", "environment", "fault"),
        ("shares", "determinism", "two instances", "fault"),
        ("alone", "determinism", "two instances", "fault"),
        ("chance", "determinism", "determinism", "fault"),
        ("opens", "environment", "environment", "warning"),
    ],
)
def test_what_a_unit_does_is_found(tmp_path: Path, manner: str, trial: str, found: str, level: str) -> None:
    fmu = animal(tmp_path / "a.fmu", manner)
    answer = vet_one(trial, fmu)
    assert answer[found][0] == level, answer


INTERPOLATES = {"options": 'canInterpolateInputs="true"'}
SERIALISES = {"options": 'canSerializeFMUstate="true"'}


@pytest.mark.parametrize(
    ("manner", "trial", "about", "says"),
    [
        ("deaf", "slopes", INTERPOLATES, "takes derivatives of its inputs and does nothing with them"),
        ("forgetful", "serialisation", SERIALISES, "it is not complete"),
        ("restless", "reading", {}, "where it is read again alone"),
        ("behind", "delay", {}, "inputs reach y a step late"),
        ("ignores", "start", {}, "reads something else than was set: gain"),
        ("quantum", "step size", EXPERIMENT, "y differs by"),
        ("thread", "threads", {}, "differs in another thread, most in y"),
    ],
)
def test_what_a_unit_does_is_found_and_a_scene_says_what_follows(
    tmp_path: Path, manner: str, trial: str, about: dict[str, str], says: str
) -> None:
    """Where it is said: what the trial found, and the warning before the run, which ends with what the master does about it."""
    fmu = Path(animal(tmp_path / "a.fmu", manner, **about))
    tried_in = "rollback" if trial == "serialisation" else trial
    (found,) = (each for each in tried(tried_in, fmu) if each.name == trial)
    assert found.level in ("warning", "fault") and says in found.message
    vetted.write(fmu, {"trials": [found._asdict()]})
    description = heeded(fmu, read_description(fmu))
    assert [w.startswith("was vetted: ") and w.endswith(f", therefore {HEED[trial]}") for w in description.warnings] == (
        [True] if trial in HEED else []
    )
    assert not description.can_serialize_state
    assert description.can_interpolate_inputs == (False if trial == "slopes" else bool(about == INTERPOLATES))


@pytest.mark.parametrize(("manner", "trial", "about"), [
    ("listens", "slopes", INTERPOLATES), ("sound", "rollback", SERIALISES), ("decays", "step size", {}),
])  # fmt: skip
def test_what_is_sound_is_not_blamed(tmp_path: Path, manner: str, trial: str, about: dict[str, str]) -> None:
    fmu = animal(tmp_path / "a.fmu", manner, **about)
    assert set(levels(trial, fmu).values()) <= {"ok", "note"}, tried(trial, Path(fmu))


def test_feedthrough_that_is_not_declared_is_taken_for_granted_once_vetted(tmp_path: Path) -> None:
    """A loop through w is seen then."""
    fmu = animal(tmp_path / "a.fmu", depends={"w": ""})
    units = {"a": fmu, "b": {"fmu": fmu, "parameters": {"gain": -0.5}}}
    loop = ["a.w -> b.u", "b.w -> a.u"]
    assert resolve(scene(units, loop)).loops == ()
    vetted.write(Path(fmu), {"trials": [each._asdict() for each in tried("feedthrough", Path(fmu))]})
    with pytest.raises(SceneError, match=r"algebraic loop a\.w -> b\.u -> b\.w"):
        resolve(scene(units, loop))
    warnings = resolve(scene(units, loop[:1])).warnings
    assert any("each of its outputs counts as depending on each of its inputs" in text for text in warnings)


LEAKS = """import json, sys
from pathlib import Path
from towage.vet import process
from towage.vet.trials import tried
process.LEAK_STEPS = int(sys.argv[2])
(found,) = tried("leaks", Path(sys.argv[1]))
print(json.dumps([found.level, found.value, found.message]))
"""


@pytest.mark.parametrize("steps", [5000, pytest.param(100_000, marks=pytest.mark.slow)])
def test_a_leak_is_found(tmp_path: Path, steps: int) -> None:
    """In a process of its own, as the command does it: the heap of this one may have room for all that is lost."""
    unit = animal(tmp_path / "a.fmu", "leaks")
    said = subprocess.run([sys.executable, "-c", LEAKS, unit, str(steps)], capture_output=True, text=True, check=True).stdout
    level, value, message = json.loads(said.splitlines()[-1])
    assert level == "warning"
    assert (100.0 if steps < 100_000 else 900.0) < value < 1100.0  # the heap had room for the first
    assert f"over {9 * steps // 10} steps" in message


def vet_one(trial: str, fmu: str) -> dict[str, tuple[str, str]]:
    """One trial in a process of its own, because the unit may change this one."""
    answer = converse("towage.vet.vet", pickle.dumps((trial, Path(fmu))), None, 120.0)
    return {name: (level, message) for name, level, message, _ in answer["trials"]}


def test_undeclared_feedthrough_is_a_fault(tmp_path: Path) -> None:
    fmu = animal(tmp_path / "a.fmu", depends={"w": ""})
    (trial,) = tried("feedthrough", Path(fmu))
    assert (trial.level, "u -> w" in trial.message) == ("fault", True)


def test_a_rate_that_is_none_is_found(tmp_path: Path) -> None:
    """y_rate = gain u fits y' = gain u; called so of w, it does not."""
    units = (
        '<UnitDefinitions><Unit name="m"><BaseUnit m="1"/></Unit><Unit name="m/s"><BaseUnit m="1" s="-1"/></Unit>'
        "</UnitDefinitions>"
    )
    about = {"extra": units, "reals": {"y": ' unit="m"', "rate": ' unit="m/s"'}}
    sound = animal(tmp_path / "a.fmu", names={"rate": "y_rate"}, **about)
    assert levels("rates", sound)["rates"] == "ok"
    about["reals"] = {"w": ' unit="m"', "rate": ' unit="m/s"'}
    wrong = animal(tmp_path / "b.fmu", names={"rate": "w_rate"}, **about)
    assert levels("rates", wrong)["rates"] == "fault"


def test_the_command_writes_what_it_found_and_the_master_heeds_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("towage.vet.vet.TRIALS", ("runs", "flag", "rollback"))
    fmu = animal(tmp_path / "a.fmu", "hidden")
    assert main(["vet", fmu, "--out", str(tmp_path / "out")]) == 0
    shown = capsys.readouterr().out
    assert shown.startswith("a.fmu: to be used with care")
    assert "warning  state: 50 steps from a saved state differ by" in shown
    document = json.loads((tmp_path / "out" / "vetted.json").read_text())
    assert {trial["name"] for trial in document["trials"]} == {"runs", "flag", "noise", "state"}
    settings = (tmp_path / "out" / "settings.toml").read_text()
    assert "heeds this by itself, for this unit alone: it is never taken back" in settings
    assert tomllib.loads(settings) == {"coupling": {}}  # a step, which no description names
    assert "to be used with care" in (tmp_path / "out" / "vetted.html").read_text()
    result = run({"a": fmu}, [])
    assert result.scheme == "extrapolate"
    assert "a was vetted: a repeated step differs by" in told(result, "scheme")
    sound = animal(tmp_path / "b.fmu")
    result = run({"a": fmu, "b": sound}, ["a.y -> b.u"])
    assert result.scheme != "extrapolate"
    assert "b can go back" in told(result, "scheme") and "unit a" in told(result, "fallback")


@pytest.mark.parametrize(("about", "against", "settings", "says"), [
    ({}, "", {}, "no settings"),
    (EXPERIMENT, "slopes", {}, "for this unit alone: its inputs are held at their mean"),
    (EXPERIMENT, "noise", {"coupling": {"step": 0.06}}, "for this unit alone: it is never taken back"),
    (EXPERIMENT | {"rollback": False}, "", {"coupling": {"step": 0.06}}, "it is never taken back"),
    (EXPERIMENT | {"variable_step": False}, "", {"coupling": {"step": 0.06}}, "of one size only"),
    ({"variable_step": False}, "", {"coupling": {}}, "step = ..., its description names none"),
])  # fmt: skip
def test_settings_are_what_the_master_does_not_do_by_itself(
    tmp_path: Path, about: dict[str, Any], against: str, settings: dict[str, Any], says: str
) -> None:
    fmu = Path(animal(tmp_path / "a.fmu", **about))
    trials = (Trial(against, "warning", "found"),) if against else ()
    text = Vetted(fmu, "", trials).settings()
    assert tomllib.loads(text) == settings and says in text
    assert run({"a": str(fmu)}, [], 1.0, **tomllib.loads(text)).status == "done"


def test_a_unit_that_kills_its_process_is_faulty_and_the_other_trials_go_on(tmp_path: Path) -> None:
    found = vet(Path(animal(tmp_path / "a.fmu", "dies at once")))
    assert found.word == "faulty"
    assert "SIGABRT" in found.trials[0].message
    assert len(found.trials) >= len(TRIALS)


def test_what_is_no_fmu_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "a.fmu").write_text("no archive")
    assert main(["vet", str(tmp_path / "a.fmu")]) == 2
    assert "damaged or truncated archive" in capsys.readouterr().err


def test_inputs_stay_inside_their_bounds(tmp_path: Path) -> None:
    bench = Bench(Path(animal(tmp_path / "a.fmu", reals={"u": ' max="0" min="0"'})))
    with bench.unit() as unit:
        bench.excite(unit, 0.3)
        assert list(unit.input_buffer) == [0.0]
