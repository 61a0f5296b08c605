"""Units of other makes where each has a process of its own, and what of their runs is kept on disk."""

from __future__ import annotations

import struct
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from towage.master.checkpoint import Keeper, can_freeze
from towage.master.master import run_resolved
from towage.master.outcome import recovered
from towage.master.plan import started
from towage.process import sandbox
from towage.process.worker import run_isolated
from towage.result.journal import read_at
from towage.result.result import Result
from towage.scene.flavour import resolve
from towage.scene.resolve import ResolvedScene
from towage.units.fmu import Unit

from .zoo import animal, animal3, run, scene

ONE = {"inputs": {"u": 1.0}}


def counted(tmp_path: Path, build: Any = animal, second: str = "sound", **about: Any) -> ResolvedScene:
    """A unit that counts and speaks before another: numbers, truth values and texts travel."""
    units = {
        "a": {"fmu": build(tmp_path / "a.fmu", "counter", **about), **ONE},
        "b": {"fmu": build(tmp_path / "b.fmu", second, **about)},
    }
    return resolve(scene(units, ["a.y -> b.u", "a.n -> b.n_in", "a.s -> b.s_in"]))


def same(one: Result, other: Result) -> None:
    """Two results agree to the bit, whatever the units count or say."""
    assert (one.status, one.message) == (other.status, other.message)
    assert set(one.columns) == set(other.columns)
    for name in one.columns:
        assert np.array_equal(one[name], other[name]), name
    assert {n: t.tolist() for n, t in one.texts.items()} == {n: t.tolist() for n, t in other.texts.items()}
    assert one.messages == other.messages


@pytest.mark.parametrize("events", [False, True])
@pytest.mark.parametrize("build", [animal, animal3])
def test_a_process_a_unit_changes_nothing(tmp_path: Path, build: Any, events: bool) -> None:
    resolved = counted(tmp_path, build, **({"events": events} if build is animal3 else {}))
    alone = run_isolated(resolved, a_process_a_unit=True)
    same(alone, run_resolved(resolved))
    assert len(set(alone["b.s"].tolist())) > 1


@pytest.mark.parametrize("manner", ["ends", "talker"])
def test_what_a_unit_says_and_where_it_ends_come_out_of_its_process(tmp_path: Path, manner: str) -> None:
    units = {"a": {"fmu": animal(tmp_path / "a.fmu", manner), "parameters": {"end": 0.55}, **ONE}}
    resolved = resolve(scene(units, []))
    alone = run_isolated(resolved, a_process_a_unit=True)
    same(alone, run_resolved(resolved))
    assert alone.status == ("done" if manner == "ends" else "failed")
    assert bool(alone.messages) == (manner == "talker")


def test_binaries_leave_the_process_of_a_unit(tmp_path: Path) -> None:
    units = {"a": {"fmu": animal3(tmp_path / "a.fmu"), "inputs": {"bytes_in": "c0ffee"}}, "b": animal3(tmp_path / "b.fmu")}
    result = run_isolated(resolve(scene(units, ["a.bytes -> b.bytes_in"])), a_process_a_unit=True)
    assert result["b.bytes"][-1] == "c0ffee"


def test_a_journal_has_texts_and_messages(tmp_path: Path) -> None:
    resolved = counted(tmp_path, second="talker")
    result = run_resolved(resolved, journal=tmp_path / "journal")
    kept = recovered(read_at(tmp_path / "journal"), "killed")
    assert kept.texts["b.s"].tolist() == result["b.s"].tolist()[: len(kept.time)]
    assert kept.messages[: len(result.messages)] == result.messages
    assert result.messages


def test_texts_and_messages_are_read_back(tmp_path: Path) -> None:
    result = run_resolved(counted(tmp_path, second="talker"))
    result.save_npz(tmp_path / "r.npz")
    again = Result.load_npz(tmp_path / "r.npz")
    same(again, result)
    result.save_netcdf(tmp_path / "r.nc")
    netcdf4 = pytest.importorskip("netCDF4")
    with netcdf4.Dataset(tmp_path / "r.nc") as data:
        assert data["b.s"][:].tolist() == result["b.s"].tolist()


def test_texts_follow_the_record_times(tmp_path: Path) -> None:
    units = {"a": {"fmu": animal(tmp_path / "a.fmu", "counter"), **ONE}}
    every, some = run(units, []), run(units, [], record={"interval": 0.5})
    assert some.time.tolist() == pytest.approx([0.0, 0.5, 1.0, 1.5, 2.0])
    assert some["a.s"].tolist() == every["a.s"].tolist()[::5]
    assert some["a.n"].tolist() == every["a.n"].tolist()[::5]


def test_a_run_begun_again_has_a_fresh_journal(tmp_path: Path) -> None:
    units = {"a": {"fmu": animal(tmp_path / "a.fmu", "hidden"), **ONE}}
    resolved = resolve(scene(units, []))
    result = run_resolved(resolved, journal=tmp_path / "journal")
    kept = read_at(tmp_path / "journal")
    assert kept.rows[0, 0] == 0.0
    assert np.all(np.diff(kept.rows[:, 0]) >= 0.0)
    assert kept.about["scheme"] == result.scheme
    assert not Keeper(tmp_path / "journal").path.exists()


@pytest.mark.parametrize(("events", "can"), [(False, True), (True, False)])
def test_a_unit_with_event_mode_leaves_no_checkpoint(tmp_path: Path, events: bool, can: bool) -> None:
    """Nor does one that sends texts, or that cannot serialise."""
    fmu = animal3(tmp_path / "a.fmu", events=events, serialises=True)
    resolved = resolve(scene({"a": {"fmu": fmu, **ONE}}, [], record={"variables": ["a.y"]}))
    system = started(resolved, Unit)
    try:
        assert can_freeze(system) == can
    finally:
        system.close()
    system = started(counted(tmp_path), Unit)
    try:
        assert not can_freeze(system)
    finally:
        system.close()


def test_a_unit_that_breaks_off_in_its_process_says_so(tmp_path: Path) -> None:
    units = {"a": {"fmu": animal(tmp_path / "a.fmu", "dies"), "parameters": {"end": 0.55}, **ONE}}
    result = run_isolated(resolve(scene(units, [])), a_process_a_unit=True)
    assert result.status == "failed"
    assert "ended its process" in result.message


@pytest.mark.skipif(sys.platform != "linux", reason="landlock and seccomp")
def test_the_process_of_a_unit_has_no_network_and_writes_in_its_folder_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Bits of `zoo_trespass`: 1 and 2 sockets, 4 to 16 files of others, 32 a signal, 64 name spaces, 128 its own folder."""
    (tmp_path / "victim").write_text("kept")
    monkeypatch.setenv("TRESPASS", str(tmp_path / "victim"))
    resolved = resolve(scene({"a": {"fmu": animal(tmp_path / "a.fmu", "trespasses"), **ONE}}, [], 0.2))
    result = run_isolated(resolved, a_process_a_unit=True)
    said = next(check for check in result.checks if check.name == "isolation")
    if said.level != "info":
        pytest.skip(said.message)
    assert (int(result["a.n"][-1]), (tmp_path / "victim").read_text()) == (128, "kept")
    free = run_isolated(resolved)
    assert int(free["a.n"][-1]) & 127 == 127, "the unit would have done it all"
    assert (tmp_path / "victim").read_text() == ""


def test_what_the_system_cannot_deny_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """On an old system, as far as the process of the unit can tell."""
    (tmp_path / "sitecustomize.py").write_text(
        "import ctypes\nclass Old(ctypes.CDLL):\n    syscall = lambda *words: -1\nctypes.CDLL = Old\n"
    )
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    resolved = resolve(scene({"a": {"fmu": animal(tmp_path / "a.fmu"), **ONE}}, [], 0.2))
    result = run_isolated(resolved, a_process_a_unit=True)
    said = next(c for c in result.checks if c.name == "isolation")
    assert said.level == "warning" and "no seccomp" in said.message and "no landlock" in said.message


@pytest.mark.parametrize("machine", ["x86_64", "aarch64"])
def test_the_filter_of_calls_ends_in_one_of_its_answers(machine: str) -> None:
    """Followed as the kernel would: every call of the list is refused, others are not."""
    code = list(struct.iter_unpack("=HBBI", sandbox.program(machine)))

    def answer(number: int, argument: int = 0, architecture: int = sandbox._AUDIT[machine]) -> int:
        seen, place = {0: number, 4: architecture, 16: argument}, 0
        value = 0
        while True:
            kind, yes, no, operand = code[place]
            if kind == 0x06:
                return operand
            if kind == 0x20:
                value, steps = seen[operand], 0
            else:
                test = {0x15: value == operand, 0x35: value >= operand, 0x45: bool(value & operand)}[kind]
                steps = yes if test else no
            place += 1 + steps

    numbers = {pair[machine == "aarch64"] for pair in sandbox.DENIED.values()} - {None}
    clone = sandbox._CLONE[machine]
    refused = {n for n in range(600) if answer(n) == 0x50001}
    assert refused == numbers
    assert answer(435) == 0x50000 | 38
    assert (answer(clone, 0x11), answer(clone, 0x1000_0011)) == (0x7FFF0000, 0x50001)
    assert answer(0, architecture=1) == 0x50001
