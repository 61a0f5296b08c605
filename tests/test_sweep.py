"""Sweeps: every fault costs one run, a kill costs the runs in flight, and what is resumed has the same bits.

The faults come from a foreign unit, built with plain PythonFMU, that crashes, hangs, exits, turns NaN, refuses to start or
poisons its process for the next run, by the number of its run.
"""

from __future__ import annotations

import csv
import json
import math
import os
import random
import re
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import msgspec
import numpy as np
import pytest

from tests import held_clock
from tests.held_clock import ANNOUNCE, HUNG, hold
from towage import cli
from towage.ensemble.ensemble import Ensemble
from towage.errors import SceneError, TowageError
from towage.files import sealed
from towage.fmus.native.compiler import CompileError, compiler, host
from towage.master.master import Master
from towage.scene.scene import Scene
from towage.sweeps.attractor import APERIODIC, repeats_after
from towage.sweeps.design import grid, parse_vary, sobol
from towage.sweeps.ensemble import by_ensemble
from towage.sweeps.journal import Journal, JournalError
from towage.sweeps.row import Row
from towage.sweeps.sweep import JOURNAL, Sweep
from towage.sweeps.table import Table
from towage.sweeps.workers import Setup, Task, Worker

SCRIPT = '''
import ctypes
import math
import os
import time

from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Real


class Fragile(Fmi2Slave):
    """Heaves; the run ``number`` modulo ``among`` decides what goes wrong."""

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.number, self.among, self.amplitude, self.heave = 0.0, 60.0, 1.0, 0.0
        parameter = {"causality": Fmi2Causality.parameter, "variability": Fmi2Variability.fixed}
        for name, start in (("number", 0.0), ("among", 60.0), ("amplitude", 1.0)):
            self.register_variable(Real(name, start=start, **parameter))
        self.register_variable(Real("heave", causality=Fmi2Causality.output))

    def exit_initialization_mode(self):
        if self.number % self.among == 55:
            raise ValueError("no such winch")

    def terminate(self):
        if self.number % self.among == 12:
            os.environ["TOWAGE_POISON"] = "1"

    def do_step(self, t, h):
        self.heave = self.amplitude * math.sin(t + h)
        fault = self.number % self.among
        if t > 0.45 and "TOWAGE_POISON" in os.environ:
            ctypes.string_at(0)
        if t > 0.45 and fault == 7:
            ctypes.string_at(0)
        if t > 0.45 and fault == 23:
            announce()
            while True:
                time.sleep(0.01)
        if t > 0.45 and fault == 41:
            os._exit(7)
        if fault == 50:
            self.heave = math.nan
        return True
'''
MANY = 10_000
FAULTS = {7: "crashed", 23: "hung", 41: "crashed", 50: "failed", 55: "failed"}
"""Number of the run, modulo ``among`` -> status. 12 harms the run after it only."""
SCENE = """title = "Winch"
stop_time = "1 s"
connections = [
    "winch.heave -> line.heave_top", "cradle.heave -> line.heave_bottom", "line.tension -> cradle.line_tension",
]
[units.winch]
fmu = "Fragile.fmu"
[units.winch.parameters]
among = 60
[units.line]
fmu = "spring_line"
[units.cradle]
fmu = "cradle"
[coupling]
step = "0.1 s"
scheme = "extrapolate"
error_estimate = false
"""
ENVIRONMENT = {**os.environ, "PYTHONPATH": os.pathsep.join(path or os.getcwd() for path in sys.path)}
TIMEOUT = "4"
"""s without progress, by a clock that stands still but for a process that hangs."""
PATIENCE = 5000
"""Looks, after 20 ms each, at a file that should grow: a test that fails ends too."""
RUNS = 60
TABLES = "table.npz", "table.csv", "report.html"


@pytest.fixture(scope="module", autouse=True)
def environment(tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[str, str]]:
    """Of processes in which time passes for those that hang alone, as it does here."""
    with pytest.MonkeyPatch.context() as patch:
        hold(patch, hung := tmp_path_factory.mktemp("hung"))
        yield {**ENVIRONMENT, HUNG: str(hung)}


@pytest.fixture(scope="module")
def winch(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The scene, beside its foreign FMU."""
    directory = tmp_path_factory.mktemp("fragile")
    (directory / "fragile.py").write_text(SCRIPT + ANNOUNCE)
    command = [sys.executable, "-m", "pythonfmu", "build", "-f", "fragile.py"]
    subprocess.run(command, cwd=directory, check=True, capture_output=True, timeout=60)
    (directory / "winch.toml").write_text(SCENE)
    return directory / "winch.toml"


def arguments(winch: Path, out: Path, *more: str, runs: int = RUNS) -> list[str]:
    """Of the command line, for the sweep with faults."""
    return [
        "sweep", str(winch), "--vary", f"winch.number=0:{runs - 1}:{runs}", "--out", str(out), "--timeout", TIMEOUT,
        "--workers", "2", "--progress", "none", "--flavour", "python", *more,
    ]  # fmt: skip


@pytest.fixture(scope="module")
def whole(winch: Path) -> Path:
    """The directory of a sweep that nobody interrupted."""
    out = winch.with_name("whole")
    assert cli.main(arguments(winch, out, "--limit", "line.tension=1e9")) == 4
    return out


def resumed_equals(winch: Path, out: Path, whole: Path) -> None:
    assert cli.main(arguments(winch, out, "--resume", "--limit", "line.tension=1e9")) == 4
    for name in TABLES:
        assert (out / name).read_bytes() == (whole / name).read_bytes(), name


def test_every_fault_costs_one_run_and_says_why(whole: Path) -> None:
    with np.load(whole / "table.npz") as table:
        assert table["index"].tolist() == list(range(RUNS))
        assert {k: str(s) for k, s in enumerate(table["status"]) if s != "done"} == FAULTS
        messages = table["message"].tolist()
        metadata = json.loads(table["metadata"].tobytes())
        measures = dict(zip(metadata["measures"], table["measures"].T, strict=True))
    assert messages[7].startswith("winch, t = 0.5 s: crashed the process of the run (SIGSEGV")
    assert messages[23].startswith("winch, t = 0.5 s: made no progress for 4 s")
    assert messages[41].startswith("winch, t = 0.5 s: ended the process of the run (exit code 7)")
    assert messages[50].startswith("winch.heave, t = 0.1 s: heave became nan")
    assert "no such winch" in messages[55]
    assert np.isnan(measures["max:line.tension"][list(FAULTS)]).all()
    assert np.isfinite(np.delete(measures["max:line.tension"], list(FAULTS))).all()
    assert metadata["measure_units"][metadata["measures"].index("max:line.tension")] == "N"


def test_the_journal_says_where_a_unit_crashed(whole: Path) -> None:
    rows = [json.loads(line) for line in (whole / JOURNAL).read_text().splitlines()[1:]]
    assert sorted(row["index"] for row in rows) == list(range(RUNS))
    assert all("fragile.py" in row["note"] for row in rows if row["index"] in (7, 23))


def test_a_row_is_what_the_master_finds(winch: Path, whole: Path) -> None:
    scene = Scene.load(winch)
    result = Master(scene.setting({"winch.number": 30.0}, "test"), None, None, "python").run()
    with open(whole / "table.csv", newline="") as file:
        row = list(csv.DictReader(file))[30]
    assert float(row["winch.number [-]"]) == 30.0
    assert float(row["max:line.tension [N]"]) == result["line.tension"].max()
    assert float(row["min:cradle.heave [m]"]) == result["cradle.heave"].min()
    assert row["verdict"] == result.verdict.word


def test_report_shows_faults_and_is_self_contained(whole: Path) -> None:
    page = (whole / "report.html").read_text()
    assert "Runs that were not done: 5" in page
    assert "Operability: largest line.tension" in page
    assert "<svg" in page
    assert "http" not in page


def test_killed_sweep_is_resumed_to_the_same_bits(
    winch: Path, whole: Path, tmp_path: Path, environment: dict[str, str]
) -> None:
    command = [sys.executable, "-m", "tests.held_clock", *arguments(winch, tmp_path)]
    with subprocess.Popen(command, env=environment, start_new_session=True, stderr=subprocess.DEVNULL) as process:
        finished = await_lines(tmp_path / JOURNAL, 15)
        os.killpg(process.pid, signal.SIGKILL)
    kept = len((tmp_path / JOURNAL).read_bytes().split(b"\n")) - 1
    assert finished <= kept < RUNS + 1
    before = (tmp_path / JOURNAL).read_bytes()
    resumed_equals(winch, tmp_path, whole)
    after = (tmp_path / JOURNAL).read_bytes()
    assert after.startswith(before[: before.rfind(b"\n") + 1])
    assert len(after.splitlines()) == RUNS + 1  # no run was done twice


def test_terminated_sweep_says_how_to_go_on(winch: Path, tmp_path: Path, environment: dict[str, str]) -> None:
    command = [sys.executable, "-m", "tests.held_clock", *arguments(winch, tmp_path)]
    with subprocess.Popen(command, env=environment, stderr=subprocess.PIPE, text=True) as process:
        await_lines(tmp_path / JOURNAL, 3)
        process.terminate()
        _, said = process.communicate()
    assert process.returncode == cli.INTERRUPTED
    assert "--resume" in said


def test_torn_journal_is_resumed_to_the_same_bits(winch: Path, whole: Path, tmp_path: Path) -> None:
    lines = (whole / JOURNAL).read_bytes().splitlines(keepends=True)
    (tmp_path / JOURNAL).write_bytes(b"".join(lines[:50]) + lines[50][:-20])
    resumed_equals(winch, tmp_path, whole)
    assert len((tmp_path / JOURNAL).read_bytes().splitlines()) == RUNS + 1


def await_lines(path: Path, count: int, patience: int = PATIENCE) -> int:
    """Lines of the file, once it has so many."""
    lines = 0
    for _ in range(patience):
        lines = path.read_bytes().count(b"\n") if path.exists() else 0
        if lines >= count:
            return lines
        time.sleep(0.02)
    raise AssertionError(f"{lines} lines")


def test_workers_that_cannot_start_are_no_fault_of_the_runs(
    winch: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "numpy").mkdir()
    (tmp_path / "numpy" / "__init__.py").write_text("raise ImportError('out of order')")
    sweep = Sweep(Scene.load(winch), grid(Scene.load(winch), ["winch.amplitude=1:3:3"]), flavour="python")
    monkeypatch.syspath_prepend(tmp_path)  # which the children get, too late for this process
    with pytest.raises(TowageError, match="out of order"):
        sweep.run(tmp_path, workers=2)
    assert len((tmp_path / JOURNAL).read_text().splitlines()) == 1


def test_units_that_change_during_a_sweep_end_it(winch: Path) -> None:
    began = dict.fromkeys(("winch", "line", "cradle"), "another digest")
    worker = Worker(Setup(Scene.load(winch), None, "python", 60.0, began))
    with pytest.raises(TowageError, match="the FMUs of winch, line, cradle are not those that the sweep began with"):
        worker.run(Task(0, {}))


# ---- the journal ----------------------------------------------------------------------------------------------------


def test_numbers_read_back_to_the_same_bits(tmp_path: Path) -> None:
    values = [0.1 + 0.2, -0.0, 5e-324, math.inf, -math.inf, math.nan, 1.7976931348623157e308, math.pi]
    row = Row(3, "done", "valid", "µ \n", {str(k): value for k, value in enumerate(values)})
    with Journal(tmp_path / JOURNAL, {"a": 1}, False) as journal:
        journal.append(row)
    with Journal(tmp_path / JOURNAL, {"a": 1}, True) as journal:
        read = journal.rows[3]
    assert np.array([*read.measures.values()]).tobytes() == np.array(values).tobytes()
    assert read.message == row.message


@pytest.mark.parametrize("cut", range(1, 40, 3))
def test_torn_line_is_dropped_and_written_over(tmp_path: Path, cut: int) -> None:
    path = tmp_path / JOURNAL
    with Journal(path, {"a": 1}, False) as journal:
        for k in range(3):
            journal.append(Row(k, "done", measures={"x": k / 3}))
    path.write_bytes(path.read_bytes()[:-cut])
    with Journal(path, {"a": 1}, True) as journal:
        assert list(journal.rows) == [0, 1]
        journal.append(Row(2, "done", measures={"x": 2 / 3}))
    with Journal(path, {"a": 1}, True) as journal:
        assert [row.measures["x"] for row in journal.rows.values()] == [0.0, 1 / 3, 2 / 3]


def test_defects_are_done_again(tmp_path: Path) -> None:
    path = tmp_path / JOURNAL
    with Journal(path, {"a": 1}, False) as journal:
        journal.append(Row(0, "defect"))
    with Journal(path, {"a": 1}, True) as journal:
        assert journal.rows == {}
        journal.append(Row(0, "done"))
    with Journal(path, {"a": 1}, True) as journal:
        assert journal.rows[0].status == "done"


def test_journal_torn_in_its_first_line_begins_anew(tmp_path: Path) -> None:
    (tmp_path / JOURNAL).write_bytes(b'{"sweep": {"a')
    with Journal(tmp_path / JOURNAL, {"a": 1}, True) as journal:
        assert journal.rows == {}
    assert (tmp_path / JOURNAL).read_bytes() == sealed({"sweep": {"a": 1}})


def test_no_flipped_bit_is_taken_for_a_number(tmp_path: Path) -> None:
    """Every row that is read is one that was written; a flip is refused with its line, or cuts the last line off."""
    path, chance = tmp_path / JOURNAL, random.Random(18)
    rows = {k: Row(k, "done", measures={"x": k / 3}) for k in range(20)}
    with Journal(path, {"a": 1}, False) as journal:
        for row in rows.values():
            journal.append(row)
    whole, accepted = path.read_bytes(), 0
    for _ in range(500):
        damaged = bytearray(whole)
        damaged[chance.randrange(len(whole))] ^= 1 << chance.randrange(8)
        path.write_bytes(damaged)
        try:
            with Journal(path, {"a": 1}, True) as journal:
                assert journal.rows.items() <= rows.items()
                accepted += 1
        except JournalError as error:
            assert "line" in str(error)
    assert accepted < 10  # in the last line's end


@pytest.mark.parametrize(
    "fields", [{"index": 7}, {"index": -1}, {"index": "0"}, {"status": "well"}, {"measures": {"x": "1"}}, {"measures": 3}]
)
def test_rows_that_cannot_be_of_the_sweep_are_refused(tmp_path: Path, fields: dict[str, object]) -> None:
    path = tmp_path / JOURNAL
    path.write_bytes(sealed({"sweep": {"a": 1}}) + sealed({**vars(Row(0, "done")), **fields}))
    with pytest.raises(JournalError, match="line 2 is damaged"), Journal(path, {"a": 1}, True, 7):
        pass


def test_journals_that_are_refused(tmp_path: Path) -> None:
    path = tmp_path / JOURNAL
    with Journal(path, {"a": {"b": 1, "c": [2]}}, False) as journal:
        journal.append(Row(0, "done"))
        with pytest.raises(JournalError, match="in use by another sweep"):
            Journal(path, {"a": {"b": 1, "c": [2]}}, True)
    with pytest.raises(JournalError, match="holds a sweep already: continue it with --resume"):
        Journal(path, {"a": {"b": 1, "c": [2]}}, False)
    with pytest.raises(JournalError, match=r"a\.b: 1 there, 3 here"):
        Journal(path, {"a": {"b": 3, "c": [2]}}, True)
    path.write_bytes(path.read_bytes() + b"nonsense\n" + path.read_bytes())
    with pytest.raises(JournalError, match="line 3 is damaged"):
        Journal(path, {"a": {"b": 1, "c": [2]}}, True)


def test_another_sweep_is_told_by_what_differs(
    winch: Path, whole: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = (whole / JOURNAL).read_bytes()
    assert cli.main(arguments(winch, whole, "--resume", "--set", "line.stiffness=1e5")) == 2
    assert "scene.units.line.parameters" in capsys.readouterr().err
    assert cli.main(arguments(winch, whole, "--resume", runs=61)) == 2
    assert "design.points" in capsys.readouterr().err
    assert cli.main(arguments(winch, whole)) == 2
    assert "--resume" in capsys.readouterr().err
    assert (whole / JOURNAL).read_bytes() == before


# ---- the design -----------------------------------------------------------------------------------------------------


def test_grid_runs_through_all_combinations_in_si(winch: Path) -> None:
    design = grid(Scene.load(winch), ["winch.amplitude=1:3:3", "cradle.mass=30 long_ton:40 long_ton:2"])
    mass = [30 * 2240 * 0.45359237, 40 * 2240 * 0.45359237]
    assert design.points.tolist() == [[a, pytest.approx(m, rel=1e-15)] for a in (1.0, 2.0, 3.0) for m in mass]
    assert (design.shape, design.units) == ((3, 2), ("", "kg"))
    assert list(design.values(0)) == ["winch.amplitude", "cradle.mass"]
    keys = grid(Scene.load(winch), ["coupling.step=0.05 s:100 ms:3"])
    assert keys.points.ravel().tolist() == pytest.approx([0.05, 0.075, 0.1])


def test_sobol_is_reproducible_nested_and_inside(winch: Path) -> None:
    ranges = ["winch.amplitude=1:3", "cradle.mass=30 long_ton:40 long_ton"]
    few, many = (sobol(Scene.load(winch), ranges, n, seed=4) for n in (100, 128))
    assert few.points.tobytes() == many.points[:100].tobytes()
    assert many.digest() != sobol(Scene.load(winch), ranges, 128, seed=5).digest()
    share = (many.points[:, 0] - 1.0) / 2.0
    # each of 128 equal parts of the range has exactly one point: what makes the sequence more even than chance
    assert sorted((share * 128).astype(int)) == list(range(128))


@pytest.mark.parametrize(
    ("ranges", "said"),
    [
        (["cradle.mass"], "expected unit.parameter=FROM:TO:COUNT"),
        (["cradle.mass=1 kg:2 kg:x"], "expected unit.parameter"),
        (["cradle.mass=1 kg:2 kg:1"], "at least 2 values"),
        (["cradle.mass=1 kg:2 kg"], "how many values"),
        (["cradle.mass=2 t:2 t:4"], "both ends"),
        (["cradle.mess=1 t:2 t:4"], "did you mean 'mass'"),
        (["cradle.mass=1 m:2 m:4"], "mass"),
        (["cradle.mass=-1 t:2 t:4"], "out of range"),
        (["cradle.mass=1 t:2 t:4", "cradle.mass=1 t:2 t:4"], "varied twice"),
        (["coupling.scheme=jacobi:hermite:2"], "no number"),
        (["cradle.mass=1 t:2 t:2000", "line.stiffness=1e5:2e5:2000"], "more than"),
        (["cradle.mass=1 t:2 t:1000000000"], "more than"),
        ([], "nothing is varied"),
    ],
)
def test_ranges_that_are_refused(winch: Path, ranges: list[str], said: str) -> None:
    with pytest.raises(SceneError, match=said):
        grid(Scene.load(winch), ranges)


def test_vary_reads_units_with_spaces() -> None:
    vary = parse_vary(" ship.heave_amplitude = 2 ft : 6 ft : 9 ")
    assert (vary.target, vary.texts, vary.count) == ("ship.heave_amplitude", ("2 ft", "6 ft"), 9)
    assert parse_vary("ship.heave_amplitude=2 ft, 1 m,5").texts == ("2 ft", "1 m", "5")


def test_a_list_is_a_grid(winch: Path) -> None:
    made = grid(Scene.load(winch), ["winch.amplitude=1,5,2", "winch.number=0:1:2"])
    assert made.shape == (3, 2)
    assert made.points.tolist() == [[1, 0], [1, 1], [2, 0], [2, 1], [5, 0], [5, 1]]


# ---- tables, attractors, the command --------------------------------------------------------------------------------


def test_table_does_not_depend_on_the_order_of_runs(winch: Path) -> None:
    design = grid(Scene.load(winch), ["winch.amplitude=1:3:3"])
    rows = [
        Row(0, "done", measures={"min:a.x": 1.0, "max:a.x": 2.0}), Row(1, "hung"),
        Row(2, "done", measures={"events:a.taut": 2.0, "sdof:rms": 0.1}),
    ]  # fmt: skip
    first, second = (Table.of("t", design, {r.index: r for r in some}, {"a.x": "m"}) for some in (rows, rows[::-1]))
    assert list(first.measures) == list(second.measures) == ["sdof:rms", "max:a.x", "min:a.x", "events:a.taut"]
    assert first.measures["events:a.taut"].tolist() == [0.0, pytest.approx(np.nan, nan_ok=True), 2.0]
    assert list(first.units.values()) == ["1", "m", "m", "1"]
    assert first.done.tolist() == [True, False, True]


def test_the_card_is_in_columns(winch: Path, tmp_path: Path) -> None:
    """Word and number of each item, and the statistics; empty where a run has none."""
    design = grid(Scene.load(winch), ["winch.amplitude=1:2:2"])
    measures = {"item:SDOF": 0.03, "sdof:tension_rms": 0.02, "statistics:share of time slack": 0.01}
    rows = {0: Row(0, "done", "valid", measures=measures, words={"SDOF": "valid", "numerics": "marginal"}), 1: Row(1, "hung")}
    table = Table.of("t", design, rows, {})
    assert table.words == {"SDOF": ("valid", ""), "numerics": ("marginal", "")}
    assert list(table.measures) == ["sdof:tension_rms", "item:SDOF", "statistics:share of time slack"]
    table.save_csv(tmp_path / "t.csv")
    table.save_npz(tmp_path / "t.npz")
    head, first, second = (line.split(",") for line in (tmp_path / "t.csv").read_text().splitlines())
    assert head[4:7] == ["word:SDOF", "word:numerics", "sdof:tension_rms [1]"]
    assert first[4:7] == ["valid", "marginal", "0.02"] and second[4:7] == ["", "", ""]
    with np.load(tmp_path / "t.npz") as arrays:
        assert arrays["words"].tolist() == [["valid", "marginal"], ["", ""]]


def test_attractors_are_told_apart() -> None:
    time = np.arange(0.0, 160.0, 0.1)
    phase = 2.0 * np.pi * time / 8.0
    assert repeats_after(time, np.sin(phase), 8.0) == 1.0
    assert repeats_after(time, np.sin(phase) + 0.3 * np.sin(phase / 2.0), 8.0) == 2.0
    assert repeats_after(time, np.sin(phase) + 0.3 * np.sin(phase / 3.0), 8.0) == 3.0
    assert repeats_after(time, np.sin(phase) + 0.3 * np.sin(phase / np.sqrt(2.0)), 8.0) == APERIODIC
    assert repeats_after(time, np.sin(phase) + 0.003 * np.sin(phase / 2.0), 8.0) == 1.0  # under the tolerance
    short = time < 64.0
    assert repeats_after(time[short], np.sin(phase[short]), 8.0) is None
    long = time < 100.0  # 12.5 periods: not enough to say that it never repeats
    assert repeats_after(time[long], np.sin(phase[long] / np.sqrt(2.0)), 8.0) is None


def test_command_on_a_shipped_scene(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The SDOF error falls as the ship gets stiffer; a map and the share of runs under a limit are made."""
    command = [
        "sweep", "slack", "--vary", "ship.stiffness=72 tonf_long/ft:216 tonf_long/ft:2",
        "--vary", "ship.heave_amplitude=2 ft:4 ft:2",
        "--set", "stop_time=100 s", "--set", "coupling.error_estimate=false", "--limit", "line.tension=170 kN",
        "--out", str(tmp_path), "--workers", "2", "--progress", "none", "--json",
    ]  # fmt: skip
    assert cli.main(command) == 0
    said = json.loads(capsys.readouterr().out)
    with open(tmp_path / "table.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    error = [float(row["sdof:rms [1]"]) for row in rows]
    assert error[0] > error[2] > 0.0
    assert error[1] > error[3] > 0.0
    assert {row["attractor [1]"] for row in rows} == {"1.0"}
    tensions = [float(row["max:line.tension [N]"]) for row in rows]
    assert said["limits"][0]["share"] == np.mean(np.array(tensions) <= 170e3)
    assert 0.0 < said["limits"][0]["share"] < 1.0
    page = (tmp_path / "report.html").read_text()
    assert all(title in page for title in ("SDOF error, rms", "Attractors", "Operability"))


@pytest.mark.parametrize(
    ("more", "said"),
    [
        (["--sobol"], "--samples"),
        (["--limit", "line.tenson=1 kN"], "did you mean 'line.tension'"),
        (["--limit", "line.tension < 1 ft"], "--limit"),
        (["--limit", "line.tension"], "expected UNIT.VARIABLE < VALUE"),
        (["--limit", "line.margin_taut < 1"], "a margin is 1 at rest"),
    ],
)
def test_command_lines_that_are_refused(
    winch: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], more: list[str], said: str
) -> None:
    assert cli.main(arguments(winch, tmp_path / "out", *more)) == 2
    assert said in capsys.readouterr().err


def test_case_must_be_chosen(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["sweep", "sea_cliff", "--vary", "cradle.mass=20 t:30 t:2", "--out", str(tmp_path)]) == 2
    assert "--case" in capsys.readouterr().err


# ---- by an ensemble -------------------------------------------------------------------------------------------------


MASSES = ["slack", "--vary", "cradle.mass=30 t:40 t:2"]


def short(out: Path, engine: str, *more: str) -> list[str]:
    """Six points of the scene whose line goes slack, 40 s each; two of them slack."""
    return [
        "sweep", "slack", "--vary", "ship.heave_amplitude=2 ft:6 ft:3",
        "--vary", "cradle.weight_in_water=6 tonf_long:12 tonf_long:2", "--set", "stop_time=40 s",
        "--set", "checks.sdof.settle=20 s", "--limit", "line.tension=45 kip",
        "--limit", "line.margin_taut > 0", "--engine", engine, "--out", str(out),
        "--progress", "none", *more,
    ]  # fmt: skip


def columns(out: Path) -> tuple[dict[str, np.ndarray], dict[str, list[str]], str]:
    """(measures, words, note) of the table in ``out``."""
    with np.load(out / "table.npz") as table:
        metadata = json.loads(table["metadata"].tobytes())
        words = {name: table[name].tolist() for name in ("status", "verdict", "message")}
        return dict(zip(metadata["measures"], table["measures"].T, strict=True)), words, metadata["note"]


@pytest.fixture
def ensembles() -> None:
    """Skips where there is nothing to trace and compile with."""
    pytest.importorskip("casadi")
    try:
        compiler(host())
    except CompileError as reason:
        pytest.skip(str(reason))


@pytest.mark.usefixtures("ensembles")
def test_both_engines_agree(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for engine in ("runs", "ensemble"):
        assert cli.main(short(tmp_path / engine, engine, "--json")) == 0
    first, second = (said.strip() + "\n}" for said in capsys.readouterr().out.split("\n}\n")[:2])
    runs, words, _ = columns(tmp_path / "runs")
    members, judged, note = columns(tmp_path / "ensemble")
    absent = {name for name in runs if name not in members}
    assert {name.partition(":")[0] for name in absent} == {"sdof", "events", "coupling_error", "item", "margin"}
    assert {n for n in absent if n.startswith("margin:")} == {"margin:line.margin_wire"}
    assert set(members) <= set(runs)
    # the estimate covers accelerations too, the most sensitive of what is recorded; margins are of their size
    tolerance = runs["coupling_error"].max()
    assert 1e-7 < tolerance < 1e-5
    for name, values in members.items():
        largest = np.abs(runs[name]).max()
        if name == "worst_margin":  # of the runs' margins one is the check's own
            values = np.minimum(values, runs["margin:line.margin_wire"])
        np.testing.assert_allclose(values, runs[name], rtol=0.0, atol=tolerance * largest, err_msg=name)
    assert judged["status"] == words["status"]
    assert set(judged["verdict"]) == {"not judged"}  # no deciding margin is negative, and the comparison is not made
    assert "3 of its members" in note
    assert json.loads(first)["limits"] == json.loads(second)["limits"]
    page = (tmp_path / "ensemble" / "report.html").read_text()
    shown = ("worst margin", "largest line.tension", "Operability", "SDOF comparison: left out")
    assert all(title in page for title in shown)
    assert "SDOF error" not in page


@pytest.mark.usefixtures("ensembles")
def test_points_that_are_refused_or_invalid_are_told_apart() -> None:
    """A mass below zero is refused; without its list of margins for show, the slack line makes its points invalid."""
    slack = Scene.load("slack")
    bare = msgspec.structs.replace(slack.checks.without("sdof"), report_only=("ship.margin_sdof",))
    scene = msgspec.structs.replace(slack, stop_time=40.0, checks=bare)
    amplitudes = grid(scene, ["ship.heave_amplitude=2 ft:6 ft:2", "cradle.mass=30 t:40 t:2"])
    points = amplitudes.points.copy()
    points[1, 1] = -1.0
    table = by_ensemble(scene, replace(amplitudes, points=points), {}, sample=1)
    assert table.status == ("done", "refused", "done", "done")
    assert table.verdict == ("valid", "not judged", "invalid", "invalid")
    assert table.message[1].startswith("cradle.mass = -1 kg: expected")
    assert table.message[2] == "line.margin_taut is negative"
    assert np.isnan(table.measures["max:line.tension"]).tolist() == [False, True, False, False]


@pytest.mark.usefixtures("ensembles")
def test_an_ensemble_of_a_case(tmp_path: Path) -> None:
    """The ship's own heave, which nothing acts on, is that of the case: its amplitude, its period."""
    command = [
        "sweep", "sea_cliff", "--case", "8 s wave", "--vary", "ship.heave_amplitude=1:2:2", "--set", "ship.heave_period=5",
        "--set", "ship.ramp_time=0", "--set", "stop_time=60 s", "--set", "checks.sdof.settle=30 s", "--engine", "ensemble",
        "--sample", "1", "--out", str(tmp_path), "--progress", "none",
    ]  # fmt: skip
    assert cli.main(command) == 0
    members, words, _ = columns(tmp_path)
    assert words["status"] == ["done", "done"]
    # samples 0.25 s apart or closer miss a crest by 1 - cos(2 pi 0.125/5) = 1.3 % at most
    np.testing.assert_allclose(members["max:ship.free_heave"], [1.0, 2.0], rtol=0.013)


@pytest.mark.usefixtures("ensembles")
def test_a_sample_that_differs_fails_the_sweep(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    reference = Ensemble.reference
    monkeypatch.setattr(Ensemble, "reference", lambda *a: reference(*a) * (1.0 + 1e-6))
    assert cli.main(short(tmp_path, "ensemble", "--sample", "2", "--seed", "3")) == 3
    said = capsys.readouterr().err
    assert re.search(r"member \d \(ship.heave_amplitude = .*differs from the FMU path by 1.0e-06", said), said
    assert not (tmp_path / "table.npz").exists()


@pytest.mark.parametrize(
    ("more", "said"),
    [
        (["slack", "--vary", "coupling.step=0.1:0.2:2"], "coupling.step is of the master"),
        ([*MASSES, "--resume"], "--resume: an ensemble runs here"),
        ([*MASSES, "--flavour", "python"], "--flavour: an ensemble runs here"),
        ([*MASSES, "--engine", "runs", "--sample", "2"], "--sample: only an ensemble"),
        (["slender_stable", "--case", "20 t craft", "--vary", "craft.speed_start=3:4:2"], "body cannot be composed"),
    ],
)
def test_what_no_ensemble_can_do_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], more: list[str], said: str
) -> None:
    assert cli.main(["sweep", "--engine", "ensemble", "--out", str(tmp_path), "--progress", "none", *more]) == 2
    assert said in capsys.readouterr().err


@pytest.mark.usefixtures("ensembles")
def test_without_a_compiler_the_runs_are_offered(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    def missing(text: object) -> None:
        raise CompileError("no C compiler on this machine")

    monkeypatch.setattr("towage.ensemble.engine._library", missing)
    assert cli.main(short(tmp_path, "ensemble")) == 2
    assert "no C compiler on this machine; or take --engine runs" in capsys.readouterr().err


def test_without_casadi_the_runs_are_offered(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    monkeypatch.setitem(sys.modules, "towage.fmus.native.ensemble.build", None)  # as if what it imports were not there
    assert cli.main(short(tmp_path, "ensemble")) == 2
    said = capsys.readouterr().err
    assert "pip install 'towage[native]'; or take --engine runs" in said


@pytest.mark.usefixtures("ensembles")
def test_tables_of_runs_are_not_lost_to_an_ensemble(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / JOURNAL).write_text("{}\n")
    assert cli.main(short(tmp_path, "ensemble")) == 2
    assert "holds a sweep by runs" in capsys.readouterr().err


# ---- the cluster, and many runs -------------------------------------------------------------------------------------


def test_cluster_gives_the_same_bits_and_loses_nothing_with_a_worker(winch: Path, whole: Path, tmp_path: Path) -> None:
    """Two dask workers in processes of their own; one is killed after 10 runs, and started again by its nanny."""
    distributed = pytest.importorskip("distributed")
    killed: list[int] = []
    with distributed.LocalCluster(
        2, threads_per_worker=1, dashboard_address=":0", silence_logs=50, preload=[held_clock.__file__]
    ) as cluster:

        def kill() -> None:
            await_lines(tmp_path / JOURNAL, 10)
            killed.append(cluster.workers[0].pid)
            os.kill(killed[0], signal.SIGKILL)

        killer = threading.Thread(target=kill)
        killer.start()
        code = cli.main(arguments(winch, tmp_path, "--dask", cluster.scheduler_address))
        killer.join()
        assert cluster.workers[0].pid != killed[0]
    assert code == 4
    for name in TABLES[:2]:
        assert (tmp_path / name).read_bytes() == (whole / name).read_bytes(), name
    assert len((tmp_path / JOURNAL).read_bytes().splitlines()) == RUNS + 1


def test_cluster_that_does_not_answer(winch: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("distributed")
    monkeypatch.setattr("towage.sweeps.dask.ANSWER", 0.5)
    sweep = Sweep(Scene.load(winch), grid(Scene.load(winch), ["winch.amplitude=1:3:3"]), flavour="python")
    with pytest.raises(TowageError, match="no dask scheduler answers"):
        sweep.run(tmp_path, dask="tcp://127.0.0.1:9")


@pytest.mark.slow
def test_ten_thousand_runs_with_faults_in_one_of_sixty(
    winch: Path, tmp_path: Path, environment: dict[str, str]
) -> None:
    """Killed half-way and resumed, against the same sweep left alone; 1 % of the runs crash, hang or exit, 0.7 % fail."""
    among = 300
    more = ["--set", f"winch.among={among}"]
    alone, killed = tmp_path / "alone", tmp_path / "killed"
    assert cli.main(arguments(winch, alone, *more, runs=MANY)) == 4
    command = [sys.executable, "-m", "tests.held_clock", *arguments(winch, killed, *more, runs=MANY)]
    with subprocess.Popen(command, env=environment, start_new_session=True, stderr=subprocess.DEVNULL) as process:
        await_lines(killed / JOURNAL, MANY // 2, 20 * PATIENCE)
        os.killpg(process.pid, signal.SIGKILL)
    assert cli.main(arguments(winch, killed, *more, "--resume", runs=MANY)) == 4
    for name in TABLES:
        assert (killed / name).read_bytes() == (alone / name).read_bytes(), name
    with np.load(alone / "table.npz") as table:
        expected = [FAULTS.get(k % among, "done") for k in range(MANY)]
        assert table["status"].tolist() == expected
