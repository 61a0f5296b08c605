"""A check and a writer of another package: found by entry points, asked by the run, the report and the command line."""

from __future__ import annotations

import importlib
import json
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import towage
from towage import cli
from towage.errors import SceneError, TowageError
from towage.registry import CHECKS, WRITERS
from towage.scene.scene import Scene

MODULE = '''
import json

import msgspec

from towage.checks.check import Cell, Check, Finished, Part, Start, told
from towage.result.records import Finding, Item
from towage.result.writers import Writer
from towage.scene.parts import Seconds, Variant


class Swing(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """[checks.swing]: the largest swing of a motion that is allowed, m, from a time on."""

    motion: str
    limit: float
    since: Seconds = 0.0


def read(scene, section):
    if section.since >= scene.stop_time:
        raise scene.error("lies behind the end", "checks.swing.since")
    return section


def variants(scene):
    calm = scene.without_comparisons().setting({"ship.heave_amplitude": 0.0}, "checks.swing")
    return [Variant("calm", calm), Variant("calm again", calm)]


def before(start: Start):
    return [Finding("swing", "info", None, None, f"{len(start.system.units)} units by {start.scheme.name}")]


RUNS = []


def after(run: Finished):
    section = run.scene.scene.checks.get("swing")
    values = run.columns[section.motion][run.result.time >= section.since]
    first, second = run.again("calm"), run.again("calm again")
    RUNS.append(first is second)
    rest = first[1][section.motion]
    size = float(values.max() - values.min() - (rest.max() - rest.min()))
    level = "ok" if size <= section.limit else "warning"
    return [Finding("swing", level, size, section.limit, f"{section.motion} swings by {size:.3g} m")]


def item(result):
    found = next((f for f in result.checks if f.name == "swing" and f.value is not None), None)
    if found is None or found.level == "ok":
        return None
    return Item("invalid", found.message, found.value, found.limit, remedy="a calmer sea")


def report(result):
    sizes = [f for f in result.checks if f.name == "swing" and f.value is not None]
    return [Part("Swing <of all>", ("What", "Size"), tuple((f.message, Cell(f.value, "m", True)) for f in sizes))]


CHECK = Check(
    name="swing", description="Does it swing too far?", section=Swing, read=read, variants=variants, before=before,
    after=after, item=item, report=report, summary=lambda result: told(result, "swing"),
)


def write(result, path):
    path.write_text(json.dumps({"title": result.title, "peak": float(result["line.tension"].max())}))


WRITER = Writer("peak", "peak.json", write, "the largest tension")
NO_WRITER = 3
'''
ENTRY_POINTS = """
[towage.checks]
swing = brought_swing:CHECK
[towage.writers]
peak = brought_swing:WRITER
broken = brought_swing:NO_WRITER
"""
SECTION = '\n[checks.swing]\nmotion = "cradle.heave"\nlimit = 0.01\nsince = "1 s"\n'


@pytest.fixture
def package(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """The package, installed: a module and its metadata where Python finds them."""
    place = tmp_path_factory.mktemp("installed")
    (place / "brought_swing.py").write_text(MODULE)
    metadata = place / "brought_swing-1.0.dist-info"
    metadata.mkdir()
    (metadata / "METADATA").write_text("Metadata-Version: 2.1\nName: brought-swing\nVersion: 1.0\n")
    (metadata / "entry_points.txt").write_text(ENTRY_POINTS)
    monkeypatch.syspath_prepend(str(place))
    importlib.invalidate_caches()
    for registry in (CHECKS, WRITERS):
        vars(registry).pop("_foreign", None)
    yield
    sys.modules.pop("brought_swing", None)
    for registry, name in ((CHECKS, "swing"), (WRITERS, "peak")):
        vars(registry).pop("_foreign", None)
        registry._loaded.pop(name, None)


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    """The slack scene, short, with the section of the check."""
    text = Scene.load("slack").source
    head, _, rest = text.partition("[checks.sdof]")
    path = tmp_path / "swinging.toml"
    path.write_text(f"{head}[checks.sdof]{rest}{SECTION}")
    return path


SHORT = {"stop_time": "4 s", "coupling.error_estimate": False, "ship.ramp_time": "1 s", "checks.sdof": None}


def test_the_check_takes_part_where_the_scene_has_its_section(package: None, scene: Path) -> None:
    result = towage.run(scene, set=SHORT, flavour="python")
    (swing,) = [finding for finding in result.checks if finding.name == "swing"]
    assert swing.level == "warning" and swing.value is not None and swing.value > 0.01
    assert (result.verdict.word, result.verdict.reason, result.verdict.limit) == ("invalid", swing.message, 0.01)
    assert importlib.import_module("brought_swing").RUNS == [True], "a second run is made once"
    calm = towage.run(scene, set={**SHORT, "checks.swing.limit": 100.0}, flavour="python")
    assert calm.verdict.word != "invalid"
    without = towage.run("slack", set=SHORT, flavour="python")
    assert not [finding for finding in without.checks if finding.name == "swing"]
    assert without["cradle.heave"].tobytes() == result["cradle.heave"].tobytes()


def test_findings_before_a_run(package: None, scene: Path) -> None:
    master = towage.Master(Scene.load(scene).setting(SHORT, "test"), flavour="python")
    assert "3 units by hermite" in [finding.message for finding in master.check()]


def test_its_part_in_report_and_summary_and_the_writer(
    package: None, scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    options = [text for key in ("stop_time", "ship.ramp_time") for text in ("--set", f"{key}={SHORT[key]}")]
    options += ["--set", "checks.sdof.settle=0", "--set", "coupling.error_estimate=false"]
    options += ["--flavour", "python", "--write", "npz,peak", "--progress", "none"]
    assert cli.main(["run", str(scene), "--out", str(out), *options]) == 0
    assert "  swing           cradle.heave swings by" in capsys.readouterr().out
    assert {file.name for file in out.iterdir()} == {"swinging.npz", "swinging.peak.json", "report.html"}
    written = json.loads((out / "swinging.peak.json").read_text())
    assert written["peak"] == towage.Result.load_npz(out / "swinging.npz")["line.tension"].max()
    page = (out / "report.html").read_text(encoding="utf-8")
    assert "<h3>Swing &lt;of all&gt;</h3>" in page and " m</td>" in page


def test_faults_in_its_section_are_told(package: None, scene: Path) -> None:
    text = scene.read_text()
    for old, new, key, message in (
        ('since = "1 s"', 'since = "1 m"', "checks.swing.since", "s"),
        ('since = "1 s"', 'since = "9 h"', "checks.swing.since", "lies behind the end"),
        ("limit = 0.01", "limits = 0.01", "checks.swing.limits", "did you mean 'limit'"),
        ("[checks.swing]", "[checks.swin]", "checks.swin", "did you mean 'swing'"),
    ):
        scene.write_text(text.replace(old, new))
        with pytest.raises(SceneError, match=message) as caught:
            Scene.load(scene)
        assert caught.value.key == key


def test_without_the_package_its_section_is_unknown(scene: Path) -> None:
    with pytest.raises(SceneError, match="unknown key; expected one of: sdof, simpler, report_only") as caught:
        Scene.load(scene)
    assert caught.value.key == "checks.swing"


def test_writers_that_are_none_are_refused(package: None, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(TowageError, match="brings the writer 'broken', which is a int: expected a Writer"):
        WRITERS.get("broken")
    with pytest.raises(SystemExit) as stop:
        cli.main(["run", "slack", "--write", "npz,cvs"])
    assert stop.value.code == 2
    assert "unknown writer 'cvs'; did you mean 'csv'" in capsys.readouterr().err
