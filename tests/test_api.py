"""`towage.run` and its kin: one scene or every case, values in place of its own, in this process or another."""

from __future__ import annotations

import ast
import inspect
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import towage
from towage import cli
from towage.errors import SceneError
from towage.scene.flavour import resolve
from towage.scene.scene import Scene

FEET = 0.3048
SHORT = {"stop_time": "4 s", "coupling.error_estimate": False, "ship.ramp_time": "1 s", "checks.sdof": None}
"""What makes a shipped scene quick to run."""


def run(scene: Any, case: str | None = None, **options: Any) -> towage.Result:
    result = towage.run(scene, case, set={**SHORT, **options.pop("set", {})}, flavour="python", **options)
    assert result.status == "done"
    return result


def test_several_cases_and_none_chosen_is_an_error_that_names_them() -> None:
    for call in (towage.run, towage.Master, lambda scene: towage.Ensemble(scene, {"ship.heave_amplitude": [1.0]})):
        with pytest.raises(SceneError, match="choose one of '8 s wave', '10 s wave'.*run_all") as caught:
            call(Scene.load("sea_cliff"))
        assert caught.value.key == "cases"


def test_a_case_by_name_is_the_case_by_value_and_runs_anywhere() -> None:
    chosen = Scene.load("sea_cliff").case("10 s wave")
    assert chosen.cases == () and chosen.units["ship"].parameters["heave_period"] == "10 s"
    by_name, by_value = run("sea_cliff", "10 s wave"), run(chosen)
    assert by_name.case == by_value.case == "10 s wave"
    assert by_name["cradle.heave"].tobytes() == by_value["cradle.heave"].tobytes()
    assert towage.Master(chosen).scene.chosen == "10 s wave"
    vary = {"ship.heave_amplitude": [1.0]}
    assert len(towage.Ensemble(chosen, vary)) == len(towage.Ensemble("sea_cliff", vary, case="10 s wave")) == 1


def test_the_only_case_needs_no_name(tmp_path: Path) -> None:
    path = tmp_path / "one.toml"
    text = Scene.load("slack").source
    path.write_text(f'{text}\n[[cases]]\nname = "small"\nset = {{ "ship.heave_amplitude" = "1 ft" }}\n')
    result = run(path)
    assert result.case == "small" and np.ptp(result["ship.heave"]) < 3.0 * FEET
    assert result["ship.heave"].tobytes() == run("slack", set={"ship.heave_amplitude": "1 ft"})["ship.heave"].tobytes()


def test_values_prevail_over_those_of_the_case_and_are_told() -> None:
    result = run("sea_cliff", "8 s wave", set={"ship.heave_amplitude": "4 ft"})
    half = run("sea_cliff", "8 s wave", set={"ship.heave_amplitude": 2.0 * FEET})
    assert np.ptp(result["ship.heave"]) == pytest.approx(2.0 * np.ptp(half["ship.heave"]), rel=0.05)  # the rest: reaction
    assert "# set ship.heave_amplitude=4 ft" in result.scene_source
    with pytest.raises(SceneError, match="ship has no variable 'heave_amplitud'; did you mean 'heave_amplitude'"):
        run("sea_cliff", "8 s wave", set={"ship.heave_amplitud": 1.0})
    with pytest.raises(SceneError, match="'coupling.stop' cannot be set") as caught:
        run("sea_cliff", "8 s wave", set={"coupling.stop": 1.0})
    assert caught.value.key == "set"


def test_run_all_runs_every_case_in_order() -> None:
    results = towage.run_all("sea_cliff", set=SHORT, flavour="python")
    assert [result.case for result in results] == [case.name for case in Scene.load("sea_cliff").cases]
    assert [result.case for result in towage.run_all("slack", set=SHORT, flavour="python")] == [""]


def test_another_process_gives_the_same_result() -> None:
    heard: list[str] = []
    here, there = run("slack"), run("slack", isolate=True, report=lambda share, text: heard.append(text))
    timed = run("slack", timeout=60.0)
    for name, values in here.columns.items():
        assert values.tobytes() == there[name].tobytes() == timed[name].tobytes()
    assert heard[-1] == "done"


def test_progress_goes_from_none_to_all_over_every_run() -> None:
    heard: list[tuple[float, str]] = []
    whole = {"stop_time": "16 s", "checks.sdof.settle": 0.0, "coupling.error_estimate": True}
    values = {key: value for key, value in SHORT.items() if not key.startswith("checks")} | whole
    towage.run("slack", set=values, flavour="python", report=lambda share, text: heard.append((share, text)))
    shares = [share for share, _ in heard]
    assert shares == sorted(shares) and shares[0] == 0.0 and shares[-1] == 1.0
    assert list(dict.fromkeys(text for _, text in heard)) == [
        "coupled run", "error estimate", "one-way run", "one-way twin", "done",  # two periods from rest do not repeat
    ]  # fmt: skip
    begin = next(share for share, text in heard if text == "one-way run")
    assert begin == pytest.approx(1.5 / 2.5, abs=0.02)  # weights 1, 0.5 and 1


def test_every_entry_takes_native_fmus_where_they_are_by_default() -> None:
    assert cli.parser().parse_args(["run", "slack"]).flavour == "auto"
    for function in (towage.run, towage.run_all, towage.Master, towage.Sweep, towage.sweep, resolve):
        assert inspect.signature(function).parameters["flavour"].default == "auto", function


def test_names_of_the_top_level_load_when_they_are_used() -> None:
    code = (
        "import sys, towage\nnames = [getattr(towage, name) for name in ('Scene', 'SceneError')]\n"
        "assert not {'numpy', 'fmpy', 'scipy', 'matplotlib'} & set(sys.modules)\n"
        "assert all(callable(getattr(towage, name)) for name in towage.__all__ if name[0] != '_')\n"
        "assert not {'pandas', 'xarray', 'casadi'} & set(sys.modules)\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True, timeout=60)


def test_checkers_and_the_pages_of_the_api_see_every_name() -> None:
    """What is imported on demand is also imported for those who read the source, from the same place."""
    tree = ast.parse(Path(towage.__file__).read_text("utf-8"))
    read = {
        alias.name: (node.module or "").removeprefix("towage.")
        for block in tree.body if isinstance(block, ast.If) for node in block.body if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }  # fmt: skip
    assert read == towage._HOME
