"""Units that crash, exit, hang, fail, refuse or lie: their run ends with what it recorded, and nothing else does.

The units are built with plain PythonFMU, so these are also scenes with foreign FMUs.
"""

from __future__ import annotations

import math
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from msgspec.structs import replace

from tests.held_clock import ANNOUNCE, HUNG, HeldClock, hold
from towage.errors import FmuError, RunError, SceneError, TowageError
from towage.master.master import Master
from towage.master.recorder import Recorder, record_of
from towage.process import child, worker
from towage.process.child import POLL, Died, converse
from towage.process.worker import check_isolated, run_isolated
from towage.result.journal import Journal, read, read_at
from towage.result.result import Event, Result
from towage.scene.flavour import resolve
from towage.scene.scene import Scene, UnitEntry

SCRIPT = '''
import ctypes
import math
import os
import time

from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Real, String


class Hostile(Fmi2Slave):
    """Pulls at the ship with 1 N per second, until its misdeed is due."""

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.misdeed, self.at, self.force, self.heave = "none", 1.0, 0.0, 0.0
        parameter = {"causality": Fmi2Causality.parameter, "variability": Fmi2Variability.fixed}
        self.register_variable(String("misdeed", **parameter))
        self.register_variable(Real("at", start=1.0, **parameter))
        self.register_variable(Real("heave", start=0.0, causality=Fmi2Causality.input))
        self.register_variable(Real("force", causality=Fmi2Causality.output))

    def exit_initialization_mode(self):
        if self.misdeed == "initialisation":
            raise ValueError("no such winch")
        if self.misdeed == "initialisation crash":
            ctypes.string_at(0)

    def terminate(self):
        if self.misdeed == "terminate":
            os._exit(0)

    def do_step(self, t, h):
        self.force = t + h
        if self.misdeed == "chatter":
            print("{\\"done\\": null}", flush=True)
            os.write(1, b"{\\"share\\": 7, \\"text\\": \\"nonsense\\"}\\n\\xff\\x00\\n")
        if self.misdeed.startswith("slow"):
            time.sleep(0.02)
        if t < self.at - 1e-9:
            return True
        if self.misdeed == "crash":
            print("about to dereference NULL", flush=True)
            ctypes.string_at(0)
        if self.misdeed == "abort":
            os.abort()
        if self.misdeed == "exit":
            os._exit(7)
        if self.misdeed == "killed":
            os.kill(os.getpid(), 9)
        if self.misdeed in ("hang", "slow, then hang"):
            announce()
            while True:
                time.sleep(0.01)
        if self.misdeed == "nan":
            self.force = math.nan
        if self.misdeed == "raise":
            raise ArithmeticError("the winch is on fire")
        if self.misdeed == "memory":
            bytearray(1 << 60)
        if self.misdeed == "endless":
            announce()
            while True:
                h = h + 1.0 - 1.0
        return self.misdeed != "refuse"
'''
ENVIRONMENT = {**os.environ, "PYTHONPATH": os.pathsep.join(path or os.getcwd() for path in sys.path)}
PATIENCE = 5000
"""Looks, after 20 ms each, at what should come to pass: a test that fails ends too."""
STOP = 2.0
STEP = 0.1


@pytest.fixture(autouse=True)
def clock(monkeypatch: pytest.MonkeyPatch, tmp_path_factory: pytest.TempPathFactory) -> HeldClock:
    """Time passes for processes that hang, for no others."""
    return hold(monkeypatch, tmp_path_factory.mktemp("hung"))


@pytest.fixture(scope="module")
def hostile(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The foreign FMU."""
    directory = tmp_path_factory.mktemp("hostile")
    (directory / "hostile.py").write_text(SCRIPT + ANNOUNCE)
    command = [sys.executable, "-m", "pythonfmu", "build", "-f", "hostile.py"]
    subprocess.run(command, cwd=directory, check=True, capture_output=True, timeout=60)
    return directory / "Hostile.fmu"


def scene(fmu: Path, misdeed: str, **coupling: object) -> Scene:
    return Scene.from_dict(
        {
            "title": f"A unit that does: {misdeed}",
            "stop_time": STOP,
            "connections": ["winch.force -> ship.reaction", "ship.heave -> winch.heave"],
            "units": {
                "ship": {"fmu": "ship"},
                "winch": {"fmu": str(fmu), "parameters": {"misdeed": misdeed, "at": 1.0}},
            },
            "coupling": {"step": STEP, "error_estimate": False, "scheme": "extrapolate", **coupling},
        }
    )


def assert_partial(result: Result, end: float = 1.0) -> None:
    """Recorded up to ``end``, the foreign unit's output as its script has it."""
    assert result.status == "failed"
    assert result.verdict.word == "not judged"
    assert result.time == pytest.approx(np.arange(round(end / STEP) + 1) * STEP)
    assert result["winch.force"] == pytest.approx(result.time)
    assert np.isfinite(result["ship.heave"]).all()
    assert result.units["ship.heave"] == "m"


def test_foreign_unit_runs_and_equals_the_run_in_this_process(hostile: Path) -> None:
    heard: list[tuple[float, str]] = []
    isolated = run_isolated(resolve(scene(hostile, "none")), report=lambda share, text: heard.append((share, text)))
    here = Master(scene(hostile, "none"), flavour="python").run()
    assert isolated.status == here.status == "done"
    assert isolated.time[-1] == STOP
    assert isolated["winch.force"] == pytest.approx(isolated.time)
    for name, column in here.columns.items():
        assert isolated[name].tobytes() == column.tobytes(), name
    assert heard[:2] == [(0.0, "initialisation"), (0.0, "coupled run")]
    assert heard[-1] == (1.0, "done")
    assert [share for share, _ in heard] == sorted(share for share, _ in heard)


@pytest.mark.parametrize(
    ("misdeed", "said"),
    [
        ("crash", "SIGSEGV"),
        ("abort", "SIGABRT"),
        ("killed", "SIGKILL"),
        ("exit", "exit code 7"),
    ],
)
def test_death_of_the_process_keeps_the_record_and_names_the_unit(hostile: Path, misdeed: str, said: str) -> None:
    result = run_isolated(resolve(scene(hostile, misdeed)))
    assert_partial(result)
    assert result.message.startswith("winch, t = 1 s: ")
    assert said in result.message
    assert "in its step" in result.message
    assert "the record ends at t = 1 s" in result.message
    assert ("hostile.py" in result.message) == (misdeed in ("crash", "abort"))  # where a stack could be written
    assert ("about to dereference NULL" in result.message) == (misdeed == "crash")


def test_death_of_the_process_keeps_the_events(hostile: Path) -> None:
    docking = scene(hostile, "killed")
    docking.units["cradle"] = UnitEntry("cradle", {"docking_time": 0.53, "submersible_mass": 1e4}, {"line_tension": 0.0})
    result = run_isolated(resolve(docking))
    assert_partial(result)
    assert result.events == [Event(0.53, "cradle", "time event", 0)]


@pytest.mark.parametrize("misdeed", ["hang", "endless"])
def test_hang_is_ended_and_its_line_named(hostile: Path, misdeed: str, clock: HeldClock) -> None:
    result = run_isolated(resolve(scene(hostile, misdeed)), timeout=1.5)
    (passed,) = clock.passed.values()
    assert passed >= 1.5
    assert_partial(result)
    assert result.message.startswith("winch, t = 1 s: made no progress for 1.5 s")
    assert "hostile.py" in result.message
    assert "do_step" in result.message


def test_time_that_moves_on_slowly_is_progress(hostile: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """100 steps of at least 20 ms, so that the run is heard of at least every fifth step. Each time the clock moves on by
    less than the longest silence allowed, in all by more."""
    moved = Moved()
    monkeypatch.setattr(child, "CLOCK", moved)
    result = run_isolated(resolve(scene(hostile, "slow", step=0.02)), report=moved.on, timeout=5.0 * POLL)
    assert result.status == "done", result.message
    assert moved.time > 10.0 * POLL


class Moved(child.Clock):
    """Moves on by `POLL` whenever something is heard."""

    time = 0.0

    def on(self, share: float, text: str) -> None:
        self.time += POLL

    def now(self, pid: int) -> float:
        return self.time


def test_nan_names_unit_variable_time_and_last_finite_value(hostile: Path) -> None:
    result = run_isolated(resolve(scene(hostile, "nan")))
    assert_partial(result)
    assert result.message.startswith("winch.force, t = 1.1 s: ")
    assert "nan" in result.message
    assert "last finite value was 1.0" in result.message


@pytest.mark.parametrize(
    ("misdeed", "said"),
    [("refuse", "refused the step"), ("raise", "the winch is on fire"), ("memory", "Fatal")],
)
def test_failing_step_is_a_failed_run(hostile: Path, misdeed: str, said: str) -> None:
    result = run_isolated(resolve(scene(hostile, misdeed)))
    assert_partial(result)
    assert said in result.message


def test_lack_of_memory_is_a_failed_run(hostile: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(worker, "converse", lambda *request: {"memory": True})
    result = run_isolated(resolve(scene(hostile, "none")))
    assert result.status == "failed"
    assert result.message == "ran out of memory; nothing was recorded"


def test_defect_in_the_child_is_not_a_failed_run(hostile: Path) -> None:
    with pytest.raises(RuntimeError, match="not iterable"):
        run_isolated(replace(resolve(scene(hostile, "none")), connections=1))


def test_failing_initialisation_raises_with_the_units_words(hostile: Path) -> None:
    with pytest.raises(RunError, match="no such winch") as caught:
        run_isolated(resolve(scene(hostile, "initialisation")))
    assert caught.value.unit == "winch"
    assert caught.value.time == 0.0


def test_crash_in_initialisation(hostile: Path) -> None:
    result = run_isolated(resolve(scene(hostile, "initialisation crash")))
    assert result.status == "failed"
    assert "winch, t = 0 s: crashed" in result.message
    assert "in its initialisation" in result.message
    assert "nothing was recorded" in result.message
    assert not len(result.time)
    with pytest.raises(RunError, match="SIGSEGV") as caught:
        check_isolated(resolve(scene(hostile, "initialisation crash")))
    assert caught.value.unit == "winch"


def test_exit_in_termination_keeps_the_whole_record(hostile: Path) -> None:
    result = run_isolated(resolve(scene(hostile, "terminate")))
    assert_partial(result, STOP)
    assert "winch: ended the process of the run (exit code 0) in its termination" in result.message


def test_what_a_unit_prints_goes_to_stderr_and_is_no_answer(hostile: Path, capfd: pytest.CaptureFixture[str]) -> None:
    shares: list[float] = []
    result = run_isolated(resolve(scene(hostile, "chatter")), report=lambda share, text: shares.append(share))
    assert result.status == "done"
    assert max(shares) == 1.0
    printed = capfd.readouterr()
    assert printed.out == ""
    assert '{"done": null}' in printed.err


def test_errors_of_the_scene_arrive_with_their_fields(hostile: Path, tmp_path: Path) -> None:
    with pytest.raises(SceneError, match="winch cannot: use 'extrapolate'") as caught:
        run_isolated(resolve(scene(hostile, "none", scheme="hermite")))
    assert caught.value.key == "coupling.scheme"
    broken = tmp_path / "broken.fmu"
    broken.write_bytes(b"PK no archive")
    sound = resolve(scene(hostile, "none"))
    with pytest.raises(FmuError) as refused:
        run_isolated(replace(sound, units={**sound.units, "winch": replace(sound.units["winch"], path=broken)}))
    assert refused.value.file == broken


def test_error_in_report_ends_the_child(hostile: Path) -> None:
    others = set(children())

    def report(share: float, text: str) -> None:
        raise LookupError("the listener's own")

    with pytest.raises(LookupError):
        run_isolated(resolve(scene(hostile, "hang")), report=report)
    assert set(children()) <= others


def test_interruption_keeps_the_record(hostile: Path, request: pytest.FixtureRequest) -> None:
    others = set(children())
    # whoever runs the tests in the background may have had interrupts ignored
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    request.addfinalizer(lambda: signal.signal(signal.SIGINT, before))

    def report(share: float, text: str) -> None:
        if share > 0.2:
            os.kill(os.getpid(), signal.SIGINT)

    with pytest.raises(KeyboardInterrupt) as caught:
        run_isolated(resolve(scene(hostile, "slow, then hang", step=0.02)), report=report)
    assert isinstance(caught.value, worker.Interrupted)
    result = caught.value.result
    assert result.status == "failed"
    assert 0.4 <= result.time[-1] <= 1.0
    assert result.message.startswith("interrupted; the record ends at t = ")
    assert set(children()) <= others


def test_child_ends_with_its_parent(hostile: Path, tmp_path: Path) -> None:
    """A parent that is killed cannot end its child; the child notices, even inside a step that hangs."""
    code = (
        "from test_scene_of_parent import it; from towage.process.worker import run_isolated; "
        "from towage.scene.flavour import resolve; run_isolated(resolve(it))"
    )
    hung = tmp_path / "hung"
    hung.mkdir()
    (tmp_path / "test_scene_of_parent.py").write_text(
        f"from towage.scene.scene import Scene\nit = Scene.from_dict({scene(hostile, 'hang').to_dict()!r})\n"
    )
    with subprocess.Popen(
        [sys.executable, "-c", code], cwd=tmp_path, env={**ENVIRONMENT, HUNG: str(hung)}
    ) as parent:
        becomes_true(lambda: any(hung.iterdir()), "the child hangs")  # so that no report will find the pipe closed
        (offspring,) = children(parent.pid)
        parent.kill()
    becomes_true(lambda: not alive(offspring), "the child ends with its parent")


def test_repeated_progress_is_silence(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As of a run whose time does not move on; a line that is no answer is passed over."""
    (tmp_path / "stuck_child.py").write_text(
        "import time\n"
        "def main():\n"
        "    print('[]\\nnonsense', flush=True)\n"
        "    for k in range(1000):\n"
        '        print(\'{"share": 0.5, "text": ""}\', flush=True)\n'
        "        time.sleep(0.02)\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    heard: list[float] = []
    moved = MovedOnceHeard(heard)
    monkeypatch.setattr(child, "CLOCK", moved)
    with pytest.raises(Died, match=r"no progress for 0\.5 s"):
        converse("stuck_child", b"", lambda share, text: heard.append(share), 0.5)
    assert heard == [0.5]
    assert 0.5 <= moved.time < 0.5 + 2.0 * POLL


class MovedOnceHeard(child.Clock):
    """Moves on by `POLL` at each look, as soon as something was heard: libraries may take their time."""

    def __init__(self, heard: list[float]) -> None:
        self.heard, self.time = heard, 0.0

    def now(self, pid: int) -> float:
        self.time += POLL if self.heard else 0.0
        return self.time


def test_journal_holds_every_row_at_once(tmp_path: Path) -> None:
    names, path = ["a.x", "a.y"], tmp_path / "journal"
    recorder = Recorder(names, Journal(path, names, {"title": "five rows"}, 0.2), 0.2)
    for k in range(5):
        recorder.row(0.1 * k, [[float(k), math.pi]])
    recorder.event(Event(0.4, "a", "slack", -1))
    kept = read_at(path)  # not closed
    assert (kept.about, kept.names, kept.lost) == ({"title": "five rows"}, names, 0)
    times, columns = record_of(kept)
    assert times.tobytes() == recorder.columns()[0].tobytes()
    assert columns["a.x"].tolist() == [0.0, 2.0, 4.0] and len(kept.rows) == 5
    assert kept.events == [Event(0.4, "a", "slack", -1)]
    recorder.close()
    whole = path.read_bytes()
    assert recorder.data.tobytes() == kept.rows.tobytes()
    first = whole.index(b"\n") + 1
    for torn in (whole[:-3], whole[: -len(whole) // 3], whole[: first + 5], whole[: first - 3], b""):
        path.write_bytes(torn)
        with open(path, "rb") as file:
            found = read(file)
        assert (found is None) == (len(torn) < first)
        if found:
            assert found.rows.tobytes() == recorder.data.tobytes()[: found.rows.nbytes]
    flipped = bytearray(whole)
    flipped[first + 29 + 12] ^= 1  # in the second row
    path.write_bytes(flipped)
    assert len(read_at(path).rows) == 1
    with pytest.raises(TowageError, match="none"):
        read_at(tmp_path / "none")


def becomes_true(condition: Callable[[], bool], what: str) -> None:
    """Wait until it holds."""
    for _ in range(PATIENCE):
        if condition():
            return
        time.sleep(0.02)
    raise AssertionError(f"in vain: {what}")


def children(pid: int | None = None) -> list[int]:
    """Processes started by ``pid`` (default: this one) that are not yet reaped."""
    path = Path(f"/proc/{pid or os.getpid()}/task/{pid or os.getpid()}/children")
    if not path.exists():
        pytest.skip("needs /proc with children")
    return [int(child) for child in path.read_text().split()]


def alive(pid: int) -> bool:
    try:
        return "Z" not in Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
    except OSError:
        return False
