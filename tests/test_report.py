"""The report: one deterministic file without references, whatever the result holds; what the text summary says."""

from __future__ import annotations

import math
import re
import shutil
import subprocess
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from matplotlib.image import imread

from towage.cli import main
from towage.errors import FileError, TowageError
from towage.report.compare import common, difference, runs_of, write_comparison
from towage.report.format import number, percent, quantity
from towage.report.page import text_summary, write_report
from towage.report.plots import intervals, roles, slack
from towage.report.svg import thin
from towage.result.result import Comparison, Event, Finding, Margin, Result, Verdict

CHROMIUM = next((program for name in ("chromium", "chromium-browser", "google-chrome") if (program := shutil.which(name))), None)
SCENE = """title = "Sea Cliff's cradle under Lulu"
connections = ["ship.heave -> line.heave_top", "line.tension -> cradle.line_tension"]

[units.ship.parameters]
heave_amplitude = "4.4 ft"

[checks.sdof]
cut = ["line.reaction -> ship.reaction"]
driver = "ship.heave"
motion = "cradle.heave"
tension = "line.tension"
"""


def cradle(case="8 s wave", ratio=0.9, zeta=0.15, weight=36e3, samples=1601, error=0.011, word="valid", stop=160.0):
    """Steady motion of the linear twin of the cradle on a line that goes slack, closed form."""
    stiffness, heave, omega = 15.2e3, 1.34, 2.0 * math.pi / 8.0
    time = np.linspace(0.0, stop, samples)
    response = 1.0 / complex(1.0 - ratio**2, -2.0 * zeta * ratio)
    ramp = np.clip(time / 24.0, 0.0, 1.0)

    def motion(gain: complex):
        return ramp * heave * (gain * np.exp(-1j * omega * time)).imag * -1.0

    driver = motion(1.0)
    columns, one_way = {"ship.heave": driver}, {}
    for target, gain in ((columns, response * (1.0 + error)), (one_way, response)):
        target["cradle.heave"] = motion(gain)
        target["line.tension"] = np.maximum(weight + stiffness * (driver - target["cradle.heave"]), 0.0)
    columns["cradle.velocity"] = np.gradient(columns["cradle.heave"], time)
    columns["line.margin_taut"] = np.minimum(1.0, 1.0 + stiffness * (driver - columns["cradle.heave"]) / weight)
    columns["line.margin_breaking"] = 1.0 - np.maximum(columns["line.tension"] - weight, 0.0) / 200e3
    columns["ship.margin_sdof"] = np.full(samples, 0.8) - 0.1 * ramp
    taut = columns["line.tension"] > 0.0
    events = [Event(time[i], "line", "taut", 1 if taut[i] else -1) for i in 1 + np.flatnonzero(taut[1:] != taut[:-1])]
    margins = [
        Margin(name, float(values.min()), float(time[values.argmin()]), name != "line.margin_taut")
        for name, values in columns.items()
        if ".margin_" in name
    ]
    steps = np.full(samples - 1, time[1])
    steps[[int(event.time / time[1]) - 1 for event in events]] *= 0.35
    return Result(
        title="Sea Cliff's cradle under Lulu", case=case, scheme="hermite", status="done", message="", time=time,
        columns=columns, one_way=one_way, events=events, margins=margins, step_sizes=steps, scene_source=SCENE,
        units={"ship.heave": "m", "cradle.heave": "m", "line.tension": "N", "cradle.velocity": "m/s"},
        checks=[
            Finding("sdof closed form", "ok", 0.0093, 0.045, "eps* is below 0.9 of the tolerance"),
            Finding("line.tension -> cradle.line_tension", "warning", None, None, "N converted to kN & back <twice>"),
        ],
        comparison=Comparison(0.05, error, 0.031, error * 1.2, 0.034, 0.0108, 0.0109, 0.0093, 0.02, 0.009, "valid"),
        verdict=Verdict(word, "amplitude changes little when the ship feels the cradle", error, 0.05),
        coupling_error={"cradle.heave": 2.1e-6, "line.tension": 3.4e-6}, power_residual={"ship-line": 1.2e-7},
        statistics={"steps": 1600.0, "rejected": 3.0, "wall_s": 0.3917, "real_time_factor": 408.5},
        response={
            "ratio": np.linspace(0.2, 3.0, 281),
            "amplitude": [1.0 / math.hypot(1.0 - r * r, 2.0 * zeta * r) for r in np.linspace(0.2, 3.0, 281)],
            "operating": [ratio, abs(response)], "label": "one-way, B = 0.3",
        },
    )  # fmt: skip


def foreign(samples=400):
    """A result without tension, margins, comparison or any name the report knows."""
    time = np.linspace(0.0, 20.0, samples)
    columns = {"Motor.w[1]": 100.0 * np.sin(time), "Motor.tau": np.cos(time), "<b>": time, "never": time * 0 + 1e300}
    return Result(
        "Drive & <train>", "", "jacobi", "done", "", time, columns, {"Motor.w[1]": "rad/s", "Motor.tau": "N.m"}
    )


class Page(HTMLParser):
    """Counts and collects what the tests look at; raises where tags do not close in order."""

    VOID = ("meta", "br")
    LEAVES = ("path", "use", "rect", "line", "circle")

    def __init__(self, path: Path):
        super().__init__()
        self.open, self.tags, self.attributes, self.paths, self.words = [], [], [], [], []
        self.feed(path.read_text(encoding="utf-8"))
        self.close()
        assert self.open == []
        self.text = " ".join(self.words)

    def handle_starttag(self, tag, attrs):
        self.handle_startendtag(tag, attrs)
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.tags.append(tag)
        self.attributes += attrs
        self.paths += [value for name, value in attrs if tag == "path" and name == "d"]

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if self.open[-1:] != ["style"]:
            self.words.append(data.strip())


def check_self_contained(path: Path) -> Page:
    page = Page(path)
    assert not {"script", "link", "img", "iframe", "object"} & set(page.tags)
    ids = [value for name, value in page.attributes if name == "id"]
    assert len(ids) == len(set(ids))
    for name, value in page.attributes:
        assert not name.startswith("on") and "http" not in (value or "")
        if name in ("href", "xlink:href", "src"):
            assert value.startswith("#") and value[1:] in ids
        for part in (value or "").split("url(#")[1:]:
            assert part.split(")")[0] in ids
    assert "http" not in path.read_text(encoding="utf-8") and "@import" not in path.read_text(encoding="utf-8")
    assert all(path.strip() for path in page.paths)
    return page


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    return write_report([cradle()], tmp_path_factory.mktemp("report") / "report.html")


def test_report_shows_every_part(written):
    page = check_self_contained(written)
    assert written.name == "report.html"
    assert page.tags.count("svg") == 7
    assert max(d.count(" ") for d in page.paths) > 1000, "the curves have points"
    assert "nan" not in " ".join(page.paths)
    for part in (
        "Sea Cliff's cradle under Lulu", "8 s wave", "valid", "limit 0.05", "0.011", "time [s]", "tension [kN]", "slack",
        "cradle.heave, one-way", "line.margin_taut (worst", "report only", "0.00034 % ", "an identity, it can never fail",
        "passes wrongly in known cases", "N converted to kN & back <twice>", "Events: line.taut", "408", SCENE.strip(),
    ):  # fmt: skip
        assert part.strip() in page.text, part


def test_report_is_deterministic(written, tmp_path):
    assert write_report([cradle()], tmp_path / "again.html").read_bytes() == written.read_bytes()


def test_report_of_a_long_run_stays_small(tmp_path):
    long = write_report([cradle(samples=200_001, stop=400.0)], tmp_path / "long.html")
    assert long.stat().st_size < 400_000, "ten cases stay under 1.5 MB: they are thinned more"
    page = check_self_contained(long)
    assert page.words.count("heave [m]") == 2, "the last ten of fifty cycles have a panel of their own"


def test_report_of_a_sweep_draws_the_gravest_cases(tmp_path, monkeypatch):
    monkeypatch.setattr("towage.report.page._PLOTTED_CASES", 1)
    cases = [foreign(9) for _ in range(5)]
    for index, case in enumerate(cases):
        case.case, case.scene_source = f"case {index}", SCENE
        case.verdict = Verdict("invalid" if index == 3 else "valid", "", None, None)
    page = check_self_contained(write_report(cases, tmp_path / "sweep.html"))
    assert "5 cases: 1 invalid, 4 valid." in page.text
    ids = [value for name, value in page.attributes if name == "id" and "-" in value]
    assert {value.split("-")[0] for value in ids} == {"case", "c4"}
    assert page.tags.count("pre") == 1, "one scene file for all of its cases"


def test_report_of_foreign_units_plots_by_unit_of_measure(tmp_path):
    page = check_self_contained(write_report([foreign()], tmp_path / "report.html"))
    assert page.tags.count("svg") == 3
    assert {"w[1] [rad/s]", "tau [N.m]", "[-]"} <= set(page.words)
    assert "not judged" in page.text and "b" not in page.tags


def test_report_of_a_failed_run_shows_message_and_partial_results(tmp_path):
    failed = cradle(samples=200)
    failed.status, failed.message = "failed", "line.tension is NaN at 12.4 s; <last> finite value 3.1e5"
    failed.response, failed.margins, failed.step_sizes = None, [], np.empty(0)
    failed.comparison, failed.verdict = None, Verdict("not judged", "the run failed", None, None)
    page = check_self_contained(write_report([failed], tmp_path / "report.html"))
    assert "The run failed." in page.text and failed.message in page.text and page.tags.count("svg") >= 3
    assert text_summary(failed).splitlines()[:2] == [
        "Sea Cliff's cradle under Lulu, 8 s wave: failed",
        f"  failure         {failed.message}",
    ]


@pytest.mark.parametrize("samples", [0, 1, 3])
def test_report_of_few_samples(tmp_path, samples):
    result = foreign(samples)
    result.step_sizes = np.diff(result.time)
    result.columns["line.tension"] = np.zeros(samples)
    result.events = [Event(0.0, "line", "taut", 0)]
    page = check_self_contained(write_report([result], tmp_path / "report.html"))
    assert ("No samples were recorded." in page.text) == (samples == 0)


def test_report_of_columns_that_are_not_finite(tmp_path):
    result, broken = cradle(samples=300), math.nan
    for name, values in result.columns.items():
        values[100:110], values[110:115], values[115:120] = math.nan, -math.inf, 1e300
        result.columns[name] = np.full(300, broken) if name == "cradle.heave" else values
    result.margins = [Margin(name, broken, broken, True) for name in result.columns if ".margin_" in name]
    result.comparison = Comparison(0.05, broken, broken, broken, broken, None, None, None, None, None, "not judged")
    result.verdict = Verdict("invalid", "", broken, None)
    result.statistics = {"steps": 3.0, "wall_s": broken}
    page = check_self_contained(write_report([result], tmp_path / "report.html"))
    assert not any("nan" in d or "inf" in d for d in page.paths)
    assert "not available for this scene" in page.text
    assert text_summary(result)


def test_report_shades_slack_from_events_between_samples():
    result = foreign(100)
    result.columns["line.tension"] = np.ones(100)
    result.events = [Event(3.0, "line", "taut", -1), Event(3.1, "line", "taut", 1), Event(19.0, "line", "taut", -1)]
    assert slack(result, "line.tension").tolist() == [[3.0, 3.1], [19.0, 20.0]]


def test_intervals_reach_half_way_to_the_next_sample():
    time, inside = np.arange(6.0), np.array([True, False, True, True, False, True])
    assert intervals(time, inside).tolist() == [[0.0, 0.5], [1.5, 3.5], [4.5, 5.0]]


def test_roles_come_from_the_scene_and_survive_a_scene_that_cannot_be_read():
    result = cradle(samples=10)
    assert (roles(result).driver, roles(result).motion) == ("ship.heave", "cradle.heave")
    result.scene_source = "checks = ["
    assert (roles(result).driver, roles(result).tension) == (None, "line.tension")


def test_thinning_keeps_peaks_ends_and_gaps():
    values = np.sin(np.linspace(0.0, 60.0, 50_000))
    values[[12_345, 23_456]] = 7.0, -7.0
    values[40_000:40_010] = np.nan
    picked = thin(values, 100)
    assert len(picked) <= 302 and (np.diff(picked) > 0).all()
    assert {0, 12_345, 23_456, 49_999} <= set(picked.tolist())
    assert np.isnan(values[picked]).any()


def test_numbers_have_sensible_digits():
    assert [number(value) for value in (0.0, 0.0123456, 1234.5, 123456.0, 1.5e7, -2.5e-6, None, math.nan)] == [
        "0", "0.0123", "1234", "123456", "1.5e7", "−2.5e−6", "–", "–",
    ]  # fmt: skip
    assert (percent(0.01234), quantity(54321.0, "N"), quantity(9.0, "N")) == ("1.23 %", "54.3 kN", "9 N")


def test_text_summary_says_what_decided():
    margin = min(cradle().margins[1:], key=lambda m: m.worst)
    assert text_summary(cradle()).splitlines() == [
        "Sea Cliff's cradle under Lulu, 8 s wave: valid",
        "  verdict         amplitude changes little when the ship feels the cradle (0.011, limit 0.05)",
        f"  worst margin    {margin.worst:.3g} ({margin.variable} at {margin.time:.4g} s)",
        "  coupling error  0.00034 % (line.tension)",
        "  speed           408 x real time, 0.392 s for 160 s",
    ]
    assert text_summary(foreign()).isascii()


def test_report_of_nothing_or_to_nowhere_is_refused(tmp_path):
    with pytest.raises(ValueError, match="at least one result"):
        write_report([], tmp_path / "report.html")
    with pytest.raises(TowageError, match="directory does not exist"):
        write_report([foreign(3)], tmp_path / "missing" / "report.html")


def test_comparison_of_runs_lays_what_they_share_side_by_side(tmp_path):
    shorter = cradle("10 s wave", error=0.2, word="invalid", samples=801, stop=120.0)
    del shorter.columns["cradle.velocity"]
    for name, result in (("a", cradle()), ("b", shorter)):
        result.save_npz(tmp_path / f"{name}.npz")
    runs = runs_of([tmp_path])
    assert [run.name for run in runs] == ["8 s wave", "10 s wave"]
    assert "cradle.velocity" not in common(runs)
    page = check_self_contained(write_comparison(runs, tmp_path / "page.html"))
    assert page.tags.count("svg") == len(common(runs)) == 6
    for part in ("Differences are against 8 s wave", "valid", "invalid", "ship.margin_sdof", "20 %", "1.1 %"):
        assert part in page.text, part
    again = write_comparison(runs_of([tmp_path / "a.npz", tmp_path / "b.npz"]), tmp_path / "again.html")
    assert again.read_bytes() == (tmp_path / "page.html").read_bytes()


def test_differences_are_those_of_the_curves():
    first, other = foreign(401), foreign(101)
    other.columns["Motor.tau"] = other.columns["Motor.tau"] + 0.25
    change = difference(first, other, "Motor.tau")
    assert change.largest == pytest.approx(0.25, abs=0.2**2 / 8)  # linear interpolation of cos over 0.2 s
    assert change.relative == pytest.approx(0.25 / math.sqrt(0.5), rel=0.03)  # 20 s are not whole periods
    assert difference(first, first, "Motor.tau")[:3] == (0.0, 0.0, 0.0)
    other.time = other.time + 100.0
    assert math.isnan(difference(first, other, "Motor.tau").largest), "no time in common"


def test_report_command_names_what_is_not_a_result(tmp_path, capsys):
    (tmp_path / "table.npz").write_text("no")
    assert main(["report", str(tmp_path)]) == FileError.exit_code
    assert "table.npz is not a result of towage" in capsys.readouterr().err
    assert main(["report", str(tmp_path / "absent.npz")]) == FileError.exit_code
    cradle().save_npz(tmp_path / "table.npz")
    assert main(["report", str(tmp_path), "--out", str(tmp_path / "one.html")]) == 0
    check_self_contained(tmp_path / "one.html")


@pytest.mark.skipif(not CHROMIUM, reason="no Chromium to look at the page with")
def test_browser_shows_plots_that_are_not_empty(written, tmp_path):
    """Every diagram alone on a page, as the browser paints it: it has several colours, and much of it is not blank."""
    text = written.read_text(encoding="utf-8")
    head, drawings = text[: text.index("<body>")], re.findall(r"<svg.*?</svg>", text, re.DOTALL)
    assert len(drawings) == 7
    shot, page = tmp_path / "shot.png", tmp_path / "page.html"
    cells = "".join(f'<div style="height:500px;width:1000px;overflow:hidden;background:#fff">{d}</div>' for d in drawings)
    page.write_text(f'{head}<body style="margin:0">{cells}</body></html>', encoding="utf-8")
    photograph(page, shot, 1000, 500 * len(drawings))
    image = imread(shot)[:, :, :3]
    for index in range(len(drawings)):
        part = image[500 * index : 500 * (index + 1)].reshape(-1, 3)
        inked = np.any(np.abs(part - 1.0) > 0.05, axis=1).mean()
        saturated = (part.max(axis=1) - part.min(axis=1) > 0.3).mean()
        assert inked > 0.01, f"diagram {index}: {inked:.2%} of it is painted"
        assert saturated > 0.0005, f"diagram {index}: no curve, {saturated:.3%} of it is coloured"
    photograph(written, shot, 1100, 1600)
    whole = imread(shot)[:, :, :3]
    assert len(np.unique((255 * whole).astype(np.uint8).reshape(-1, 3), axis=0)) > 100, "text, badges and curves"


def photograph(page: Path, shot: Path, width: int, height: int) -> None:
    command = [
        CHROMIUM, "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--force-device-scale-factor=1",
        f"--user-data-dir={shot.parent / 'profile'}", f"--window-size={width},{height}", f"--screenshot={shot}",
        page.as_uri(),
    ]  # fmt: skip
    subprocess.run(command, check=True, capture_output=True, timeout=120)
