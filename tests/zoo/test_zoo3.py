"""Units of FMI 3.0 in a scene: the same animals, and what only this version has."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from towage.errors import FmuError, RunError, SceneError
from towage.scene.flavour import resolve
from towage.units.archive import read_description

from .zoo import animal, animal3, run, scene, told

CHAIN = ["a.y -> b.u"]
ONE = {"inputs": {"u": 1.0}}


def pair(tmp_path: Path, first: str = "sound", second: str = "sound", **about: object) -> dict[str, object]:
    """Two units of FMI 3.0; the first has the input 1."""
    return {
        "a": {"fmu": animal3(tmp_path / "a.fmu", first, **about), **ONE},
        "b": {"fmu": animal3(tmp_path / "b.fmu", second, **about)},
    }


@pytest.mark.parametrize("rollback", [True, False])
@pytest.mark.parametrize("events", [True, False])
def test_both_versions_give_the_same_run(tmp_path: Path, rollback: bool, events: bool) -> None:
    new = run(pair(tmp_path, rollback=rollback, events=events), CHAIN)
    old_units = {"a": {"fmu": animal(tmp_path / "c.fmu", rollback=rollback), **ONE}}
    old = run({**old_units, "b": animal(tmp_path / "d.fmu", rollback=rollback)}, CHAIN)
    for name in old.columns:
        if not name.endswith(".calls"):
            assert np.array_equal(old[name], new[name]), name
    assert new["b.y"][-1] == pytest.approx(2.0, rel=1e-12)
    assert new["b.w"] == pytest.approx(new["a.y"], abs=1e-12)


def test_a_unit_of_each_version_in_one_scene(tmp_path: Path) -> None:
    units = {"a": {"fmu": animal3(tmp_path / "a.fmu", "counter"), **ONE}, "b": {"fmu": animal(tmp_path / "b.fmu")}}
    result = run(units, [*CHAIN, "a.s -> b.s_in", "a.n -> b.n_in"])
    assert result["b.y"][-1] == pytest.approx(2.0, rel=1e-12)
    assert result["b.s"].tolist() == result["a.s"].tolist()


@pytest.mark.parametrize("manner", ["commits", "from input", "lazy"])
def test_manners_are_met_as_in_fmi_2(tmp_path: Path, manner: str) -> None:
    result = run(pair(tmp_path, second=manner), CHAIN)
    assert result["b.y"][-1] == pytest.approx(2.0, rel=1e-9)
    assert bool(told(result, "late outputs")) == (manner == "lazy")


@pytest.mark.parametrize(("end", "reached"), [(0.55, 0.55), (1.0, 1.0)])
def test_a_unit_that_ends_by_itself(tmp_path: Path, end: float, reached: float) -> None:
    units = pair(tmp_path, second="ends")
    units["b"]["parameters"] = {"end": end}  # type: ignore[index]
    result = run(units, CHAIN)
    assert (result.status, result.time[-1]) == ("done", pytest.approx(reached))
    assert f"the unit ended the run at t = {end:g} s" in told(result, "end")


def test_all_types_and_arrays_travel(tmp_path: Path) -> None:
    units = pair(tmp_path)
    units["a"]["inputs"] = {  # type: ignore[index]
        "array_in[2]": 7.5, "bytes_in": "c0ffee", "single_in": 0.5, "byte_in": -7, "wide_in": 123456789, "n_in": 4,
        "s_in": "hello",
    }  # fmt: skip
    connections = [f"a.array[{k}] -> b.array_in[{k}]" for k in (1, 2, 3)]
    connections += [f"a.{name} -> b.{name}_in" for name in ("bytes", "single", "byte", "wide", "s", "n")]
    result = run(units, connections)
    assert [result[f"b.array[{k}]"][-1] for k in (1, 2, 3)] == [1.0, 7.5, 3.0]
    assert result["b.bytes"][-1] == "c0ffee"
    assert (result["b.single"][-1], result["b.byte"][-1], result["b.wide"][-1]) == (0.5, -7.0, 123456789.0)
    assert (result["b.s"][-1], result["b.n"][-1]) == ("hello", 16.0)


def test_one_element_of_an_array_is_connected_and_the_others_keep_their_start(tmp_path: Path) -> None:
    result = run(pair(tmp_path), ["a.y -> b.array_in[2]"])
    assert [result[f"b.array[{k}]"][-1] for k in (1, 2, 3)] == pytest.approx([1.0, 2.0, 3.0])
    assert result["b.array[2]"] == pytest.approx(result["a.y"], abs=1e-12)


def test_a_number_that_the_target_does_not_hold_is_refused(tmp_path: Path) -> None:
    units = pair(tmp_path)
    units["a"]["inputs"] = {"wide_in": 300}  # type: ignore[index]
    with pytest.raises(RunError, match="b, t = 0 s: byte_in is Int8, which does not hold 300"):
        run(units, ["a.wide -> b.byte_in"])


def test_bytes_are_written_as_hexadecimal_digits(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match="'hello' is no Binary: write hexadecimal digits"):
        resolve(scene({"a": {"fmu": animal3(tmp_path / "a.fmu"), "inputs": {"bytes_in": "hello"}}}, []))


@pytest.mark.parametrize("manner", ["clockwork", "surprise"])
@pytest.mark.parametrize("rollback", [True, False])
def test_event_mode_puts_a_point_on_the_event(tmp_path: Path, manner: str, rollback: bool) -> None:
    """The level falls by 10 at 0.55 s: announced, or by an early return, which a host that cannot go back takes inside a step."""
    result = run(pair(tmp_path, manner, events=True, rollback=rollback), CHAIN)
    assert result.status == "done", result.message
    located = rollback or manner == "clockwork"
    assert (np.min(np.abs(np.cumsum(result.step_sizes) - 0.55)) < 1e-9) == located
    assert result["a.y"][-1] == pytest.approx(2.0 - 10.0, abs=1e-9)
    assert result["b.y"][-1] == pytest.approx(2.0 - 10.0 * 1.45, abs=1e-9 if located else 0.5)


def test_clocks_are_refused(tmp_path: Path) -> None:
    extra = '<Clock name="tick" valueReference="90" causality="input" intervalVariability="triggered"/>'
    with pytest.raises(FmuError, match=r"has clocks \(tick\), which are not supported"):
        read_description(Path(animal3(tmp_path / "a.fmu", extra=extra)))


def test_arrays_of_a_negative_size_are_refused(tmp_path: Path) -> None:
    extra = '<Float64 name="odd" valueReference="90"><Dimension start="-5"/></Float64>'
    with pytest.raises(FmuError, match="an array has a dimension of -5 elements"):
        read_description(Path(animal3(tmp_path / "a.fmu", extra=extra)))


@pytest.mark.parametrize(
    ("connection", "says"),
    [("a.bytes -> b.s_in", "Binary to String"), ("a.byte -> b.u", "Integer to Real"), ("a.array[4] -> b.u", "array")],
)  # fmt: skip
def test_kinds_are_joined_like_to_like(tmp_path: Path, connection: str, says: str) -> None:
    with pytest.raises(SceneError, match=says):
        resolve(scene(pair(tmp_path), [connection]))
