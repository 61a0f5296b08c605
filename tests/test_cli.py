"""The command line: what it prints, writes and returns."""

from __future__ import annotations

import csv
import json
import os
import re
import signal
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest

import towage
from towage import cli
from towage.commands import common
from towage.result.result import Result
from towage.scene.scene import Scene, available_scenes

ROOT = Path(towage.__file__).parent.parent
ENVIRONMENT = {**os.environ, "PYTHONPATH": os.pathsep.join(path or os.getcwd() for path in sys.path)}
SCENE = """title = "A short lift"
stop_time = "4 s"
connections = [
    "ship.heave -> line.heave_top",
    "cradle.heave -> line.heave_bottom",
    "line.tension -> cradle.line_tension",
    "line.reaction -> ship.reaction",
]

[units.ship]
fmu = "ship"
[units.ship.parameters]
heave_amplitude = "2 ft"
heave_period = "4 s"
ramp_time = "2 s"
mass = "900 long_ton"
stiffness = "72 tonf_long/ft"

[units.line]
fmu = "spring_line"
[units.line.parameters]
stiffness = "1 tonf_long/ft"
static_tension = "= cradle.weight_in_water"

[units.cradle]
fmu = "cradle"
[units.cradle.parameters]
mass = "35 long_ton"
weight_in_water = "8 tonf_long"

[record]
variables = ["ship.heave", "cradle.heave", "line.tension", "ship.margin_sdof"]

[coupling]
step = "0.1 s"
"""
CASES = """
[[cases]]
name = "4 s wave"

[[cases]]
name = "high/wave"
set = { "ship.heave_amplitude" = "3 ft", "coupling.step" = "0.05 s" }
"""


@pytest.fixture
def short(tmp_path: Path) -> Path:
    """A scene without cases."""
    path = tmp_path / "short.toml"
    path.write_text(SCENE)
    return path


@pytest.fixture
def cases(tmp_path: Path) -> Path:
    """A scene with two cases."""
    path = tmp_path / "lift.toml"
    path.write_text(SCENE + CASES)
    return path


def call(*arguments: object) -> int:
    return cli.main([str(argument) for argument in arguments])


def shell(*arguments: str, code: str = "") -> subprocess.CompletedProcess[str]:
    command = [sys.executable, *(["-c", code] if code else ["-m", "towage"]), *arguments]
    return subprocess.run(command, capture_output=True, text=True, timeout=60, env=ENVIRONMENT)


# ---- the package ----------------------------------------------------------------------------------------------------


def test_public_names() -> None:
    assert set(towage.__all__) == {
        *("Scene", "Master", "Result", "run", "run_all", "__version__"),
        *("Ensemble", "Sweep", "lift_response", "response", "route", "simplest", "stability", "sweep", "write_report"),
        *("TowageError", "SceneError", "FmuError", "RunError"),
    }
    for name in towage.__all__:
        assert getattr(towage, name) is not None
        assert name in dir(towage)
    assert towage.Scene is Scene
    assert towage.Result is Result
    assert issubclass(towage.RunError, towage.TowageError)
    with pytest.raises(AttributeError, match="no attribute 'Scenes'"):
        _ = towage.Scenes


def test_version_is_that_of_the_project(capsys: pytest.CaptureFixture[str]) -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    with pytest.raises(SystemExit) as stop:
        call("--version")
    assert stop.value.code == 0
    assert capsys.readouterr().out == f"towage {project['version']}\n"


HEAVY = ("numpy", "scipy", "fmpy", "matplotlib", "rich", "pythonfmu")


@pytest.mark.parametrize(
    "code",
    [
        "import towage",
        "import towage; towage.Scene, towage.TowageError",
        "from towage.cli import main; import contextlib\nwith contextlib.suppress(SystemExit): main(['--help'])",
        "from towage.cli import main; assert main(['validate', SCENE]) == 0",
    ],
    ids=["import", "names", "help", "validate"],
)
def test_light_commands_load_no_heavy_modules(code: str, short: Path) -> None:
    """Once the FMUs are built: to build one runs its model."""
    assert call("validate", short) == 0
    done = shell(code=f"SCENE = {str(short)!r}\n{code}\nimport sys\nprint([m for m in {HEAVY!r} if m in sys.modules])")
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[-1] == "[]"


def test_help_names_every_command_and_gives_examples(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        call("--help")
    top = capsys.readouterr().out
    for name in cli.COMMANDS:
        assert re.search(rf"^    {name}\s+\w", top, re.MULTILINE)
        with pytest.raises(SystemExit) as stop:
            call(name, "--help")
        assert stop.value.code == 0
        assert re.search(rf"^examples?:\n  towage {name}", capsys.readouterr().out, re.MULTILINE)


@pytest.mark.parametrize("name", cli.COMMANDS)
def test_examples_of_the_help_parse(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    import shlex

    with pytest.raises(SystemExit):
        call(name, "--help")
    example = re.split("^examples?:\n", capsys.readouterr().out, flags=re.MULTILINE)[1].split("\n")[0]
    words = shlex.split(example)
    assert words[:2] == ["towage", name]
    cli.parser().parse_args(words[1:])


# ---- run ------------------------------------------------------------------------------------------------------------


def test_run_writes_files_and_prints_summaries(cases: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "results"
    assert call("run", cases, "--out", out, "--progress", "none", "--mat") == 0
    printed = capsys.readouterr()
    assert printed.err == ""
    assert re.search(r"^A short lift, 4 s wave: \w+", printed.out, re.MULTILINE)
    assert re.search(r"^A short lift, high/wave: \w+", printed.out, re.MULTILINE)
    assert printed.out.count("worst margin") == 2
    assert printed.out.count("coupling error") == 2
    assert printed.out.count("x real time") == 2
    names = {f"{case}.{suffix}" for case in ("4_s_wave", "high_wave") for suffix in ("csv", "npz", "mat")}
    assert {path.name for path in out.iterdir()} == names | {"report.html"}
    report = (out / "report.html").read_text("utf-8")
    assert "4 s wave" in report
    assert "high/wave" in report
    result = Result.load_npz(out / "high_wave.npz")
    assert (result.case, result.status) == ("high/wave", "done")
    assert result.time == pytest.approx(np.arange(81) * 0.05)
    rows = list(csv.reader((out / "high_wave.csv").read_text("utf-8").splitlines()))
    column = next(k for k, name in enumerate(rows[0]) if name.startswith("cradle.heave "))
    assert [float(row[column]) for row in rows[1:]] == result["cradle.heave"].tolist()


def test_run_json_is_one_document(cases: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ("--out", tmp_path / "o", "--json", "--progress", "json", "--no-report", "--case", "4 s wave")
    assert call("run", cases, *arguments, "--flavour", "python") == 0
    printed = capsys.readouterr()
    document = json.loads(printed.out)
    assert [result["case"] for result in document["results"]] == ["4 s wave"]
    assert document["results"][0]["status"] == "done"
    assert document["results"][0]["end_time"] == 4.0
    assert document["results"][0]["flavours"] == {"ship": "python", "line": "python", "cradle": "python"}
    assert document["errors"] == []
    assert {Path(file).name for file in document["files"]} == {"4_s_wave.csv", "4_s_wave.npz"}
    assert all(Path(file).is_file() for file in document["files"])
    last = json.loads(printed.err.splitlines()[-1])
    assert (last["label"], last["state"], last["fraction"]) == ("4 s wave", "done", 1.0)


def test_run_set_prevails_over_scene_and_case(cases: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    settings = ("--set", "ship.heave_amplitude=1 m", "--set", "coupling.tolerance=1e-3", "--set", "ship.ramp_time = 0")
    arguments = ("--case", "high/wave", "--out", tmp_path / "o", "--no-report", "--progress", "none")
    assert call("run", cases, *arguments, *settings, "--set", "record.interval=0.5") == 0
    capsys.readouterr()
    found = Result.load_npz(tmp_path / "o" / "high_wave.npz")
    assert found.time == pytest.approx(np.arange(9) * 0.5)
    expected = SCENE.replace("2 ft", "1 m").replace("2 s", "0 s").replace('step = "0.1 s"', "tolerance = 1e-3")
    (tmp_path / "expected.toml").write_text(expected.replace("[record]", "[record]\ninterval = 0.5"))
    wanted = towage.run(tmp_path / "expected.toml")
    for name, column in wanted.columns.items():
        assert found[name].tobytes() == column.tobytes(), name
    assert "# --set ship.heave_amplitude=1 m\n" in found.scene_source


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("a.b=8", ("a.b", 8)),
        ("a.b = 8.5", ("a.b", 8.5)),
        ("a.b=8 s", ("a.b", "8 s")),
        ('a.b="8 s"', ("a.b", "8 s")),
        ("a.b=true", ("a.b", True)),
        ("a.b== c.d", ("a.b", "= c.d")),
        ("a.b=1979-05-27", ("a.b", "1979-05-27")),
        ("a.b=", ("a.b", "")),
        ("a.b=1\nc=2", ("a.b", "1\nc=2")),
    ],
)
def test_setting(text: str, expected: tuple[str, object]) -> None:
    found = common.setting(text)
    assert found == expected
    assert type(found[1]) is type(expected[1])


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["run", "sea_clif"], "did you mean 'sea_cliff'?"),
        (["run", "LIFT", "--case", "4 s wav"], "did you mean '4 s wave'?"),
        (["run", "LIFT", "--set", "ship.heave_amplitud=1"], "did you mean 'heave_amplitude'"),
        (["run", "LIFT", "--set", "coupling.stp=1"], "--set: 'coupling.stp' cannot be set"),
        (["run", "LIFT", "--set", "stop_time=-4 s"], "--set: stop_time: -4.0 is out of range"),
        (["run", "LIFT", "--fmus", "nowhere"], "units.ship.fmu"),
        (["check", "sea_clif"], "did you mean 'sea_cliff'?"),
        (["validate", "sea_clif"], "did you mean 'sea_cliff'?"),
        (["verify", "nowhere.json"], "nowhere.json"),
        (["verify", "--kind", "nonsense"], "the kinds are"),
    ],
)
def test_bad_input_is_code_2_and_one_message(
    arguments: list[str], said: str, cases: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(cases.parent)
    assert call(*[str(cases) if word == "LIFT" else word for word in arguments]) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert printed.err.startswith("towage: error: ")
    assert said in printed.err
    assert "Traceback" not in printed.err
    assert not (cases.parent / "out").exists()


@pytest.mark.parametrize(
    "arguments",
    [
        [],
        ["rum", "x"],
        ["run"],
        ["run", "x", "--timeout", "0"],
        ["run", "x", "--set", "no value"],
        ["run", "x", "--zz"],
    ],
)
def test_bad_command_line_is_code_2(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as stop:
        call(*arguments)
    assert stop.value.code == 2
    assert "usage: towage" in capsys.readouterr().err


def test_a_refused_case_leaves_the_others(cases: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A line a million times stiffer is beyond every scheme at this step."""
    text = cases.read_text() + '[[cases]]\nname = "rod"\nset = { "line.stiffness" = "1e6 tonf_long/ft" }\n'
    cases.write_text(text.replace('name = "4 s wave"', 'name = "wave"'))
    arguments = (
        "--case",
        "rod",
        "--case",
        "wave",
        "--out",
        tmp_path / "o",
        "--progress",
        "none",
        "--no-report",
        "--json",
    )
    assert call("run", cases, *arguments) == 2
    printed = capsys.readouterr()
    document = json.loads(printed.out)
    assert [result["case"] for result in document["results"]] == ["wave"]
    assert [error["case"] for error in document["errors"]] == ["rod"]
    assert printed.err.startswith("towage: error: rod: ")
    assert (tmp_path / "o" / "wave.csv").is_file()


def test_unwritable_out_is_code_3(short: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "file").write_text("")
    assert call("run", short, "--out", tmp_path / "file") == 3
    assert "cannot make the directory" in capsys.readouterr().err


BAD = """
import os
import time

from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Real


class Bad(Fmi2Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.die, self.force, self.nap = 9.0, 0.0, 0.0
        parameter = {"causality": Fmi2Causality.parameter, "variability": Fmi2Variability.fixed}
        self.register_variable(Real("die", start=9.0, **parameter))
        self.register_variable(Real("nap", start=0.0, **parameter))
        self.register_variable(Real("force", causality=Fmi2Causality.output))

    def exit_initialization_mode(self):
        if self.die < 0.0:
            raise ValueError("dead on arrival")

    def do_step(self, t, h):
        time.sleep(self.nap)
        if t >= self.die:
            os.abort()
        return True
"""


@pytest.fixture(scope="module")
def bad(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A scene with a foreign unit that aborts at a time, fails at once, or is slow."""
    directory = tmp_path_factory.mktemp("bad")
    (directory / "bad.py").write_text(BAD)
    command = [sys.executable, "-m", "pythonfmu", "build", "-f", "bad.py"]
    subprocess.run(command, cwd=directory, check=True, capture_output=True, timeout=60)
    (directory / "bad.toml").write_text(
        'title = "Bad"\nstop_time = 2\nconnections = ["bad.force -> ship.reaction"]\n'
        '[units.ship]\nfmu = "ship"\n[units.bad]\nfmu = "Bad.fmu"\n'
        "[coupling]\nstep = 0.1\nerror_estimate = false\n"
        '[record]\nvariables = ["ship.heave"]\n'
        '[[cases]]\nname = "good"\n[[cases]]\nname = "abort"\nset = { "bad.die" = 1 }\n'
        '[[cases]]\nname = "dead"\nset = { "bad.die" = -1 }\n'
        '[[cases]]\nname = "slow"\nset = { "bad.nap" = 0.05, "stop_time" = 60 }\n'
    )
    return directory / "bad.toml"


def test_failed_runs_are_code_3_and_reported(bad: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    chosen = ("--case", "abort", "--case", "dead", "--case", "good")
    assert call("run", bad, "--out", tmp_path, "--progress", "none", *chosen) == 3
    printed = capsys.readouterr().out
    assert re.search(r"Bad, abort: failed\n +failure +bad, t = 1 s: [^$]*SIGABRT", printed)
    assert re.search(r"Bad, dead: failed\n +failure +bad, t = 0 s: [^$]*dead on arrival", printed)
    assert "Bad, good: " in printed
    partial = Result.load_npz(tmp_path / "abort.npz")
    assert partial.time[-1] == pytest.approx(1.0)
    report = (tmp_path / "report.html").read_text("utf-8")
    assert "SIGABRT" in report
    assert "dead on arrival" in report


def interruptible() -> None:
    """Whoever runs the tests in the background may have had interrupts ignored."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


@pytest.mark.parametrize("stop", [signal.SIGINT, signal.SIGTERM])
def test_interrupted_run_keeps_its_record(stop: signal.Signals, bad: Path, tmp_path: Path) -> None:
    command = [sys.executable, "-m", "towage", "run", str(bad), "--progress", "json", "--out", str(tmp_path / "o")]
    with subprocess.Popen(
        [*command, "--case", "good", "--case", "slow"],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=ENVIRONMENT,
        preexec_fn=interruptible,
    ) as process:  # fmt: skip
        assert process.stderr is not None
        for line in process.stderr:
            said = json.loads(line)
            if said["label"] == "slow" and said["done"] > 0.5:
                break
        process.send_signal(stop)
        out, err = process.communicate(timeout=30)
    assert process.returncode == 130, err
    assert "towage: error: interrupted" in err
    assert "Traceback" not in err
    assert "Bad, slow: failed" in out
    result = Result.load_npz(tmp_path / "o" / "slow.npz")
    assert 0.5 <= result.time[-1] < 60.0
    assert result.message.startswith(f"interrupted by {signal.Signals(stop).name}; the record ends at t = ")
    assert Result.load_npz(tmp_path / "o" / "good.npz").status == "done"
    assert "slow" in (tmp_path / "o" / "report.html").read_text("utf-8")


# ---- the other commands ---------------------------------------------------------------------------------------------


def test_check(cases: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert call("check", cases, "--case", "4 s wave") == 0
    printed = capsys.readouterr().out
    assert printed.startswith("4 s wave\n")
    assert "high/wave" not in printed
    assert re.search(r"^  ok +step: loop line - ship - cradle", printed, re.MULTILINE)
    refusing = ("--case", "high/wave", "--set", "line.stiffness=1e6 tonf_long/ft", "--json")
    assert call("check", cases, *refusing) == 2
    (case,) = json.loads(capsys.readouterr().out)["cases"]
    assert case["case"] == "high/wave"
    assert "refused" in [check["level"] for check in case["checks"]]


def test_check_names_a_unit_that_fails(bad: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert call("check", bad, "--case", "dead", "--case", "good") == 3
    printed = capsys.readouterr()
    assert re.search("towage: error: dead: bad, t = 0 s: [^$]*dead on arrival", printed.err)
    assert "good" in printed.out


def test_validate(short: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    wrong = tmp_path / "wrong.toml"
    wrong.write_text(SCENE.replace("heave_period", "heave_perod"))
    assert call("validate", short) == 0
    assert capsys.readouterr().out == f"{short}: ok\n"
    assert call("validate", wrong, short) == 2
    printed = capsys.readouterr()
    assert printed.out == f"{short}: ok\n"
    assert printed.err.startswith(f"towage: error: {wrong}: units.ship.parameters.heave_perod: ")
    assert "did you mean 'heave_period'" in printed.err


def test_list(capsys: pytest.CaptureFixture[str]) -> None:
    from towage.fmus import UNITS

    assert call("list") == 0
    printed = capsys.readouterr().out
    assert call("list", "--json") == 0
    document = json.loads(capsys.readouterr().out)
    assert [unit["name"] for unit in document["units"]] == list(UNITS)
    assert {scene["name"]: scene["title"] for scene in document["scenes"]} == dict(available_scenes())
    for entry in (*document["units"], *document["scenes"]):
        assert re.search(rf"^  {entry['name']} +{re.escape(entry.get('description') or entry['title'])}", printed, re.M)


def test_verify(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    shipped = json.loads((ROOT / "towage" / "reference" / "cradle.json").read_text())
    chosen = [case for case in shipped["cases"] if case["kind"] == "free_decay"][:1]
    chosen += [case for case in shipped["cases"] if case["kind"] == "two_dof_free"][:1]
    good, wrong = tmp_path / "good.json", tmp_path / "wrong.json"
    good.write_text(json.dumps({"cases": chosen}))
    assert call("verify", good) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[:2] for line in lines[:2]] == [["ok", case["name"]] for case in chosen]
    assert lines[-1].startswith("2 of 2 cases agree")
    assert call("verify", good, "--kind", "free_decay") == 0
    assert capsys.readouterr().out.splitlines()[-1].startswith("1 of 1 cases agree")

    wrong.write_text(re.sub(r"(\d\.\d+)", lambda m: str(float(m[1]) * (1.0 + 1e-3)), json.dumps({"cases": chosen})))
    assert call("verify", wrong, good) == 1
    printed = capsys.readouterr().out
    assert "WRONG" in printed
    assert "2 of 4 cases agree" in printed or "3 of 4 cases agree" in printed
    assert call("verify", wrong, "--json") == 1
    document = json.loads(capsys.readouterr().out)
    assert document["wrong"] >= 1
    assert not all(case["ok"] for case in document["cases"])


# ---- what the outside sees ------------------------------------------------------------------------------------------


def test_module_equals_command() -> None:
    done = shell("validate", "sea_clif")
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith("towage: error: sea_clif: no such file or scene")


def test_defect_is_code_70_with_traceback(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    def broken() -> None:
        raise ZeroDivisionError("an unforeseen division")

    monkeypatch.setattr("towage.scene.scene.available_scenes", broken)
    assert call("list") == 70
    printed = capsys.readouterr().err
    assert printed.startswith("Traceback")
    assert "an unforeseen division" in printed
    assert "Please report" in printed.splitlines()[-1]


def test_interruption_elsewhere_is_code_130(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def stopped() -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("towage.scene.scene.available_scenes", stopped)
    assert call("list") == 130
    assert capsys.readouterr().err == "towage: error: interrupted\n"


def test_closed_pipe_is_quiet() -> None:
    code = "import os, sys; r, w = os.pipe(); os.close(r); os.dup2(w, 1); from towage.cli import main; sys.exit(main())"
    done = shell("list", code=code)
    assert done.returncode == 1
    assert done.stderr == ""
