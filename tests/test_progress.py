"""Progress on a terminal, in a log and as JSON; that it never ends the work it reports on."""

from __future__ import annotations

import io
import json
import math
import sys
import time

import pytest

from towage.process import progress as module
from towage.process.progress import duration, progress


class Terminal(io.StringIO):
    def isatty(self):
        return True


class Broken(io.StringIO):
    def write(self, text):
        raise BrokenPipeError


@pytest.fixture
def clock(monkeypatch):
    """A clock that moves only when told: ``clock.append(seconds)``."""
    times = [100.0]
    monkeypatch.setattr(module, "CLOCK", lambda: times[-1])
    return times


def work(stream, monkeypatch, clock, seconds, mode="auto", total=160.0):
    monkeypatch.setattr(sys, "stderr", stream)
    with progress(total, "8 s wave", mode) as bar:
        for step in range(1, 161):
            clock.append(100.0 + seconds * step / 160.0)
            bar.update(float(step), "step 0.1 s")
    return stream.getvalue()


def test_json_has_one_finite_object_a_line(monkeypatch, clock):
    lines = [json.loads(line) for line in work(io.StringIO(), monkeypatch, clock, 20.0, "json").splitlines()]
    assert len(lines) == 81, "one every second step of 0.125 s, and one at the end"
    middle = next(line for line in lines if line["done"] == 80.0)
    assert middle == {
        "label": "8 s wave", "done": 80.0, "total": 160.0, "fraction": 0.5, "elapsed_s": 10.0, "rate": 8.0,
        "left_s": 10.0, "text": "step 0.1 s", "state": "running",
    }  # fmt: skip
    assert (lines[-1]["state"], lines[-1]["fraction"]) == ("done", 1.0)


@pytest.mark.parametrize("total", [0.0, math.nan, math.inf])
def test_json_of_unknown_total_has_nulls(monkeypatch, clock, total):
    last = json.loads(work(io.StringIO(), monkeypatch, clock, 16.0, "json", total).splitlines()[-1])
    assert (last["total"], last["fraction"], last["left_s"], last["rate"]) == (None, None, None, 10.0)


def test_log_gets_a_line_every_five_seconds(monkeypatch, clock):
    lines = work(io.StringIO(), monkeypatch, clock, 16.0).splitlines()
    assert len(lines) == 4, "at 5, 10 and 15 s, and at the end"
    assert lines[0] == "8 s wave   31 %  50 of 160  10/s  11 s left  step 0.1 s"


def test_log_of_short_work_stays_empty(monkeypatch, clock):
    assert work(io.StringIO(), monkeypatch, clock, 4.0) == ""


def test_terminal_without_rich_rewrites_one_line(monkeypatch, clock):
    monkeypatch.setitem(sys.modules, "rich.progress", None)
    text = work(Terminal(), monkeypatch, clock, 16.0)
    assert text.count("\n") == 1 and text.endswith("\n")
    assert text.count("\r\x1b[K") == 161
    assert max(len(part) for part in text.split("\r\x1b[K")) <= 80


def test_terminal_with_rich_shows_a_bar(monkeypatch, clock):
    pytest.importorskip("rich")
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setenv("COLUMNS", "120")
    text = work(Terminal(), monkeypatch, clock, 1.0)
    assert "━" in text and "100 %" in text and "160 of 160" in text


def test_none_is_silent(monkeypatch, clock):
    assert work(io.StringIO(), monkeypatch, clock, 16.0, "none") == ""


def test_stopped_work_says_so_and_passes_the_error_on(monkeypatch, capsys):
    with pytest.raises(RuntimeError, match="unit failed"), progress(10.0, "run", "json") as bar:
        bar.update(4.0)
        raise RuntimeError("unit failed")
    last = json.loads(capsys.readouterr().err.splitlines()[-1])
    assert (last["state"], last["done"]) == ("stopped", 4.0)


@pytest.mark.parametrize("mode", ["json", "auto"])
def test_broken_stderr_does_not_end_the_work(monkeypatch, clock, mode):
    assert work(Broken(), monkeypatch, clock, 16.0, mode) == ""


def test_closed_or_missing_stderr_does_not_end_the_work(monkeypatch):
    closed = io.StringIO()
    closed.close()
    for stream in (closed, None):
        monkeypatch.setattr(sys, "stderr", stream)
        for mode in ("auto", "json"):
            with progress(1.0, "run", mode) as bar:
                bar.update(1.0)


def test_unknown_mode_is_refused():
    with pytest.raises(ValueError, match="progress mode 'loud'"):
        progress(1.0, "run", "loud")


def test_durations_read_like_durations():
    assert [duration(value) for value in (0.4, 59.4, 200.0, 7500.0)] == ["0 s", "59 s", "3 min 20 s", "2 h 05 min"]


def test_update_is_cheap_enough_for_every_step():
    """A thousand updates cost less than one second even on a loaded machine; measured: 0.2 ms."""
    start = time.process_time()
    with progress(1000.0, "run", "none") as bar:
        for step in range(1000):
            bar.update(float(step))
    assert time.process_time() - start < 1.0
