"""Nothing of a run is lost: journals, checkpoints, results that prove themselves, processes and folders that stay behind."""

from __future__ import annotations

import contextlib
import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from tests.faults.run_kills import main as kill
from tests.faults.unit_cases import misbehaving
from towage import cli, files
from towage.errors import FileError, RunError, TowageError
from towage.files import claimed, clear, cut, in_use, scratch, sealed, unsealed
from towage.master import checkpoint, simulation
from towage.master.master import run_resolved
from towage.master.recorder import record_of
from towage.process import stop
from towage.process.child import Died, Hung, converse
from towage.process.overseer import Limits
from towage.process.unfinished import left, unfinished
from towage.process.worker import run_isolated
from towage.result.journal import Journal, read_at
from towage.result.result import Result
from towage.routing.forecast.contents import opened
from towage.scene.flavour import resolve
from towage.scene.scene import Scene
from towage.terminal import escaped

SHORT = {"stop_time": 12.0, "coupling.error_estimate": False}
CASES = {
    "slack": SHORT,
    "slack, error control": {**SHORT, "coupling.tolerance": 1e-4},
    "sea_cliff": {**SHORT, "coupling.scheme": "implicit"},
    "docking": SHORT,
    "tow_two_units": SHORT,
}


class Cut(Exception):
    """The end of a run in the midst of it."""


def prepared(name: str) -> Scene:
    scene = Scene.load(name.partition(",")[0])
    scene = scene.case(scene.cases[0].name) if scene.cases else scene
    return scene.without_comparisons().setting(CASES[name], "test")


@pytest.mark.parametrize("name", CASES)
def test_a_run_that_is_cut_goes_on_to_the_same_bits(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    resolved = resolve(prepared(name), flavour="python")
    alone = run_resolved(resolved)
    monkeypatch.setattr(checkpoint, "EVERY", 0.0)
    monkeypatch.setattr(simulation, "REPORT_INTERVAL", 0.0)
    journal = tmp_path / "journal"
    for share in (0.3, 0.7):  # cut twice

        def heard(done: float, what: str, share: float = share) -> None:
            if done > share:
                raise Cut

        with pytest.raises(Cut):
            run_resolved(resolved, heard, journal, resume=journal.exists())
    result = run_resolved(resolved, None, journal, resume=True)
    assert json.loads(journal.with_suffix(checkpoint.SUFFIX).read_bytes())["simulation"]["time"] > 0.5 * alone.time[-1]
    assert result.time.tobytes() == alone.time.tobytes()
    assert result.step_sizes.tobytes() == alone.step_sizes.tobytes()
    for column, values in alone.columns.items():
        assert result.columns[column].tobytes() == values.tobytes(), column
    said = ("events", "checks", "margins", "verdict", "power_residual", "provenance", "status")
    assert {key: getattr(result, key) for key in said} == {key: getattr(alone, key) for key in said}


def test_checkpoints_that_do_not_fit_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(checkpoint, "EVERY", 0.0)
    monkeypatch.setattr(simulation, "REPORT_INTERVAL", 0.0)
    resolved = resolve(prepared("slack"), flavour="python")
    journal = tmp_path / "journal"
    run_resolved(resolved, None, journal)
    kept = journal.with_suffix(checkpoint.SUFFIX)
    data = unsealed(kept.read_bytes())
    kept.write_bytes(sealed({**data, "units": data["units"][:-1]}))
    result = run_resolved(resolved, None, journal, resume=True)
    assert result.status == "failed" and "of another system" in result.message
    assert len(result.time)  # and what was recorded stays
    kept.write_bytes(kept.read_bytes()[:-40])  # torn: as if there were none
    again = run_resolved(resolved, None, journal, resume=True)
    held = read_at(journal)
    assert again.status == "done" and held.lost == 0
    assert record_of(held)[0].tobytes() == again.time.tobytes()


# ---- the commands -------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def done(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A result of ``towage run``."""
    out = tmp_path_factory.mktemp("done")
    assert (
        cli.main(
            ["run", "slack", "--set", "stop_time=90", "--out", str(out), "--progress", "none", "--flavour", "python"]
        )
        == 0
    )
    assert sorted(entry.suffix for entry in out.iterdir()) == [".csv", ".html", ".npz"]
    return out / "slack.npz"


def test_a_result_proves_itself(done: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["verify-result", str(done), "--again"]) == 0
    said = capsys.readouterr().out
    assert "the checksum fits" in said and "every number is the same to the last bit" in said
    result = Result.load_npz(done)
    assert len(result.provenance["fmus"]["ship"]["sha256"]) == 64
    result.provenance["fmus"]["ship"]["sha256"] = "0" * 64
    name = next(iter(result.columns))
    result.columns[name] = result.columns[name] + 1e-9
    result.save_npz(tmp_path / "other.npz")
    assert cli.main(["verify-result", str(tmp_path / "other.npz"), "--again"]) == 1
    said = capsys.readouterr().out
    assert "fmus.ship.sha256: '000" in said and f"differs  {name}: " in said


def test_a_result_that_was_changed_is_refused(done: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with np.load(done) as store:
        arrays = dict(store)
    arrays["time"] = arrays["time"] + 1e-12
    np.savez(tmp_path / "changed.npz", **arrays)
    with pytest.raises(FileError, match="its checksum does not fit"):
        Result.load_npz(tmp_path / "changed.npz")
    for command in ("verify-result", "report"):
        assert cli.main([command, str(tmp_path / "changed.npz")]) == 2
        assert "changed.npz is not a result of towage: its checksum" in capsys.readouterr().err
    Result("", "", "", "done", "", np.zeros(1), {}, {}).save_npz(tmp_path / "bare.npz")
    assert cli.main(["verify-result", str(tmp_path / "bare.npz")]) == 2
    assert "does not name its inputs" in capsys.readouterr().err


def test_recover_where_there_is_nothing(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["recover", str(tmp_path)]) == 2
    assert "no folder *.unfinished" in capsys.readouterr().err
    (tmp_path / "a.unfinished").mkdir()
    (tmp_path / "a.unfinished" / "journal").write_bytes(b"nonsense")
    assert cli.main(["recover", str(tmp_path)]) == 0
    assert "nothing was recorded" in capsys.readouterr().out
    assert not list(tmp_path.iterdir())


def test_a_journal_with_a_damaged_head_is_put_aside(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = tmp_path / "slack.unfinished"
    folder.mkdir()
    run_resolved(resolve(prepared("slack"), flavour="python"), None, folder / "journal")
    data = bytearray((folder / "journal").read_bytes())
    data[40] ^= 1
    (folder / "journal").write_bytes(data)
    command = ["run", "slack", "--out", str(tmp_path), "--progress", "none", "--no-report", "--flavour", "python", "--resume"]
    assert cli.main(command) == 2
    assert "slack.unfinished is damaged" in capsys.readouterr().err
    (tmp_path / "slack.damaged").mkdir()
    assert cli.main(["recover", str(tmp_path)]) == 0
    assert "it is kept as" in capsys.readouterr().err
    assert (tmp_path / "slack.damaged_2" / "journal").read_bytes() == data


def test_a_journal_that_no_memory_holds(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "a.unfinished").mkdir()
    about = Result("", "", "", "done", "", np.zeros(1), {}, {}).metadata()
    journal = Journal(tmp_path / "a.unfinished" / "journal", ["a.x"], about, 1e-15)
    journal.row(np.array([100.0, 1.0]).tobytes(), True)
    journal.close()
    assert cli.main(["recover", str(tmp_path)]) == 2
    assert "a.unfinished/journal: a journal up to t = 100 s with a record every 1e-15 s" in capsys.readouterr().err
    assert left(tmp_path)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="POSIX")
def test_a_pipe_in_the_place_of_a_file_holds_nobody_up(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "a.unfinished").mkdir()
    os.mkfifo(tmp_path / "a.unfinished" / "journal")
    os.mkfifo(tmp_path / "waves.nc")
    with pytest.raises(TowageError, match=r"waves\.nc: cannot be read: it is no file"), opened(tmp_path / "waves.nc", []):
        pass
    assert cli.main(["recover", str(tmp_path)]) == 0


def test_a_journal_of_another_run_is_not_gone_on_with(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = tmp_path / "slack.unfinished"
    folder.mkdir()
    run_resolved(resolve(prepared("slack"), flavour="python"), None, folder / "journal")
    command = ["run", "slack", "--out", str(tmp_path), "--progress", "none", "--no-report", "--flavour", "python"]
    assert cli.main([*command, "--resume"]) == 2
    said = capsys.readouterr().err
    assert "is of another run" in said and "scene.stop_time: 12.0 there" in said
    assert cli.main([*command, "--set", "stop_time=90"]) == 0  # and without the option it is kept
    assert "kept as" in capsys.readouterr().err
    assert Result.load_npz(tmp_path / "slack.recovered.npz").time[-1] == pytest.approx(12.0)
    assert not left(tmp_path)


def test_two_runs_do_not_share_a_folder(tmp_path: Path) -> None:
    with unfinished(tmp_path, "a") as first:
        assert first.path and left(tmp_path) == []
        with pytest.raises(TowageError, match="belongs to a run that is under way"), unfinished(tmp_path, "a"):
            pass
    assert left(tmp_path) == [first.path]


@pytest.mark.parametrize("count", [3, pytest.param(60, marks=pytest.mark.slow)])
def test_runs_and_sweeps_that_are_killed(count: int) -> None:
    assert sum(kill(count, count, 240.0).values()) > 0


# ---- signals, processes, limits -----------------------------------------------------------------------------------------


def test_a_signal_leaves_a_note_until_it_is_looked_at() -> None:
    with stop.heeded():
        for name in ("SIGTERM", "SIGHUP", "SIGINT"):
            os.kill(os.getpid(), getattr(signal, name))
        assert stop.asked() == "SIGTERM"
        with pytest.raises(KeyboardInterrupt):
            stop.look()
    assert stop.asked() == ""
    stop.look()
    with pytest.raises(KeyboardInterrupt), stop.heeded(at_once=True):
        os.kill(os.getpid(), signal.SIGTERM)
        time.sleep(1.0)


SPIN = "def main():\n    while True:\n        pass\n"
GLUTTON = "def main():\n    kept = bytearray(1 << 33)\n"
PRINTS = "def main():\n    import time\n    for k in range(10**6):\n" + (
    '        print(\'{"share": %g, "text": ""}\' % (k / 1e6), flush=True)\n        time.sleep(0.01)\n'
)


@pytest.mark.parametrize(
    ("program", "limits", "kind", "says"),
    [
        (SPIN, Limits(processor=1.0), Died, r"SIGXCPU.*--max-cpu"),
        (GLUTTON, Limits(memory=1 << 30), Died, "exit code 1"),
        (PRINTS, Limits(total=1.0), Hung, "longer than its limit of 1 s in all"),
    ],
)
def test_limits(
    program: str, limits: Limits, kind: type[Died], says: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "limited_child.py").write_text(program)
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(kind, match=says):
        converse("limited_child", b"", None, 60.0, limits)


def test_limits_of_the_command_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    command = ["run", "sea_cliff", "--case", "8 s wave", "--set", "stop_time=1e5", "--flavour", "python", "--no-report"]
    assert cli.main([*command, "--out", str(tmp_path), "--progress", "none", "--max-time", "4"]) == 3
    assert "took longer than its limit of 4 s in all" in capsys.readouterr().out
    with pytest.raises(SystemExit):
        cli.main([*command, "--max-memory", "none"])


# ---- folders and lines --------------------------------------------------------------------------------------------------


def test_what_a_killed_process_left_is_cleared_and_nothing_else(tmp_path: Path) -> None:
    for name in ("towage-old", "towage-used", "towage-new", "other"):
        (tmp_path / name).mkdir()
        if name != "towage-new":
            os.utime(tmp_path / name, (0, 0))
    with claimed(tmp_path / "towage-used"):
        assert in_use(tmp_path / "towage-used")
        os.utime(tmp_path / "towage-used", (0, 0))
        with scratch(parent=tmp_path) as folder:
            assert folder.is_dir() and in_use(folder)
    assert not in_use(tmp_path / "towage-used")
    assert sorted(entry.name for entry in tmp_path.iterdir()) == ["other", "towage-new", "towage-used"]
    clear(tmp_path / "none", "towage-")


def test_temporary_files_of_killed_writers_are_cleared(tmp_path: Path) -> None:
    stale = tmp_path / ".a.csv.0123456789ab.tmp"
    stale.write_bytes(b"half")
    os.utime(stale, (0, 0))
    with files.atomic_write(tmp_path / "a.csv") as stream:
        stream.write(b"whole")
    assert [entry.name for entry in tmp_path.iterdir()] == ["a.csv"]
    long = tmp_path / ("瀬" * 80 + ".csv")  # 244 bytes
    with files.atomic_write(long) as stream:
        stream.write(b"whole")
    assert long.read_bytes() == b"whole"
    assert cut("瀬" * 80, 100) == "瀬" * 33


def test_sealed_lines() -> None:
    line = sealed({"a": [1.5, None], "b": "ä\n"})
    assert json.loads(line)["a"] == [1.5, None]
    assert unsealed(line) == {"a": [1.5, None], "b": "ä\n"}
    for place in range(len(line) - 1):
        with pytest.raises(ValueError):
            unsealed(line[:place] + bytes([line[place] ^ 4]) + line[place + 1 :])


def test_nothing_acts_on_the_terminal() -> None:
    assert escaped("a\x1b[2J\x07\u202eb\tc\nä") == "a\\x1b[2J\\x07\\u202eb\tc\nä"
    assert len(escaped("x" * 10_000, longest=100)) < 150
    code = (
        "import sys; from towage.terminal import Plain; sys.stdout = Plain.of(sys.stdout); print('a\\x1bb'); print('c')"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, check=True)
    assert done.stdout == b"a\\x1bb\nc\n"


@pytest.mark.parametrize(
    ("redirection", "says"), [(">&-", "standard output is closed"), ("> /dev/full", "the disk is full")]
)
def test_standard_output_that_takes_nothing(redirection: str, says: str) -> None:
    with contextlib.suppress(FileNotFoundError):
        done = subprocess.run(
            f"{sys.executable} -m towage list {redirection}", shell=True, capture_output=True, text=True
        )
        assert done.returncode == 2
        assert says in done.stderr and "Traceback" not in done.stderr


def test_no_home_directory(monkeypatch: pytest.MonkeyPatch) -> None:
    from towage.units.store import cache

    def none() -> Path:
        raise RuntimeError("no home")

    for name in ("TOWAGE_CACHE", "XDG_CACHE_HOME"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(Path, "home", none)
    with pytest.raises(TowageError, match="TOWAGE_CACHE may name a place"):
        cache()


# ---- a process a unit ---------------------------------------------------------------------------------------------------


def test_units_in_processes_of_their_own_give_the_same_bits(tmp_path: Path) -> None:
    resolved = resolve(prepared("slack"), flavour="python")
    alone, apart = run_resolved(resolved), run_isolated(resolved, a_process_a_unit=True)
    assert apart.status == "done"
    for column, values in alone.columns.items():
        assert apart.columns[column].tobytes() == values.tobytes(), column


@pytest.mark.parametrize(
    ("misdeed", "says"),
    [
        ("step:segv@1", r"winch, t = 1 s: ended its process \(SIGSEGV\)"),
        ("step:leave@1", r"winch, t = 1 s: ended its process \(exit code 0\)"),
        ("step:error@1", "no step is short enough for a unit .*winch, Error"),
        ("step:nan@1", r"winch\.y, t = 1.1 s: y became nan"),
        ("step:close@1", "winch, t = 1 s: (ended|closed)"),
        ("instantiate:error", "winch: could not be instantiated"),
    ],
)
def test_what_a_unit_in_a_process_of_its_own_does_ends_its_run_alone(misdeed: str, says: str, tmp_path: Path) -> None:
    path = misbehaving(misdeed)(tmp_path)
    try:
        result = run_isolated(resolve(Scene.load(path)), a_process_a_unit=True)
    except RunError as error:
        assert re.search(says, str(error))
        return
    assert re.search(says, result.message), result.message
    assert result.time[-1] == pytest.approx(1.0)


def test_a_sandbox_keeps_a_process_from_writing_elsewhere(tmp_path: Path) -> None:
    (tmp_path / "own").mkdir()
    code = (
        "import socket, sys; from pathlib import Path; from towage.process.sandbox import confine\n"
        "own, other = map(Path, sys.argv[1:])\nif confine(str(own)): sys.exit(3)\n(own / 'a').write_text('a')\n"
        "open('/dev/null', 'w').write('a')\nfor act in (socket.socket, lambda: (other / 'b').write_text('b')):\n"
        "    try: act()\n    except PermissionError: continue\n    sys.exit(1)"
    )
    done = subprocess.run([sys.executable, "-c", code, str(tmp_path / "own"), str(tmp_path)])
    if done.returncode == 3:
        pytest.skip("this system lacks landlock or seccomp")
    assert done.returncode == 0
    assert (tmp_path / "own" / "a").exists() and not (tmp_path / "b").exists()
