"""Results and their files: bit-exact round trips, and writers that leave the old file or the new one."""

from __future__ import annotations

import csv
import json
import math
import os
import random
import resource
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.io import loadmat

from towage.errors import TowageError
from towage.files import atomic_write
from towage.result.result import Comparison, Event, Finding, Margin, Result, Verdict

ROOT = Path(__file__).parents[1]


def cradle(samples=200):
    """Steady undamped cradle at half its resonance, closed form: amplitude 4/3 of the ship's."""
    clock = np.linspace(0.0, 16.0, samples)
    ship = 1.34 * np.sin(2.0 * math.pi * clock / 8.0)
    columns = {"ship.heave": ship, "cradle.heave": ship / 0.75, "line.tension": 36e3 - 15.2e3 * ship / 3.0}
    return Result(
        title="Cradle", case="8 s", scheme="hermite", status="done", message="", time=clock, columns=columns,
        units={"ship.heave": "m", "cradle.heave": "m", "line.tension": "N"}, one_way={"cradle.heave": ship / 0.76},
        events=[Event(1.0 / 3.0, "line", "taut", -1), Event(0.7, "line", "taut", 1), Event(4.0, "cradle", "docking", 0)],
        checks=[Finding("closed form", "ok", 0.0093, 0.045, "µ/|Ω² − 1|")],
        margins=[
            Margin("line.margin_taut", 0.2, 3.0, False), Margin("line.margin_breaking", 0.6, 4.0, True),
            Margin("ship.margin_sdof", math.nan, 0.0, True),
        ],
        comparison=Comparison(0.05, 0.1 + 0.2, 0.02, 0.01, 0.03, 0.0108, 0.0109, None, 0.02, 0.009, "valid"),
        verdict=Verdict("valid", "amplitude", 0.011, 0.05), coupling_error={"cradle.heave": 2e-6, "line.tension": 3e-6},
        power_residual={"bond": 1e-7}, statistics={"steps": 160, "real_time_factor": math.inf},
        step_sizes=np.full(160, 0.1), scene_source='title = "Cradle"',
        response={"ratio": np.linspace(0.2, 3.0, 5), "amplitude": [1.0] * 5, "operating": (0.5, 4.0 / 3.0), "label": "B"},
    )  # fmt: skip


def assert_equal(first, second):
    """Bit-equal, NaN included."""
    for name, value in vars(first).items():
        other = getattr(second, name)
        if name in ("columns", "one_way"):
            assert list(value) == list(other)
            for key, series in value.items():
                assert series.dtype == other[key].dtype and series.tobytes() == other[key].tobytes()
        elif isinstance(value, np.ndarray):
            assert value.dtype == other.dtype and value.tobytes() == other.tobytes()
        else:
            assert repr(value) == repr(other), name


def test_columns_by_name():
    result = cradle()
    assert result["line.tension"] is result.columns["line.tension"] and result["time"] is result.time
    assert "line.tension" in result and "line.stretch" not in result
    with pytest.raises(KeyError, match=r"no column 'line.tensoin'; did you mean 'line.tension'"):
        result["line.tensoin"]


def test_worst_margin_is_one_that_decides():
    result = cradle()
    assert result.worst_margin().variable == "line.margin_breaking"
    result.margins = result.margins[:1]
    assert result.worst_margin().variable == "line.margin_taut"
    result.margins = []
    assert result.worst_margin() is None
    assert result.worst_coupling_error() == ("line.tension", 3e-6)


def test_npz_round_trip_is_bit_exact(tmp_path):
    result = cradle()
    result.save_npz(tmp_path / "run.npz")
    loaded = Result.load_npz(tmp_path / "run.npz")
    response = {"ratio": np.linspace(0.2, 3.0, 5).tolist(), "amplitude": [1.0] * 5, "operating": [0.5, 4.0 / 3.0]}
    assert loaded.response == {**response, "label": "B"}
    result.response = loaded.response
    assert_equal(result, loaded)
    loaded.save_npz(tmp_path / "again.npz")
    assert (tmp_path / "again.npz").read_bytes() == (tmp_path / "run.npz").read_bytes()


@given(
    names=st.lists(st.text(min_size=1), max_size=4, unique=True),
    values=arrays(np.float64, 7, elements=st.floats(allow_nan=True, allow_infinity=True)),
    number=st.floats(allow_nan=True),
)
def test_npz_round_trip_of_any_names_and_values(tmp_path_factory, names, values, number):
    path = tmp_path_factory.getbasetemp() / "any.npz"
    columns = dict.fromkeys(names, values)
    result = Result("t", "c", "jacobi", "failed", "".join(names), values, columns, {}, one_way=columns)
    result.events, result.statistics = [Event(number, *([*names, "a", "b"])[:2], 0)], {"wall_s": number}
    result.save_npz(path)
    assert_equal(result, Result.load_npz(path))


@pytest.mark.parametrize("content", [b"", b"text", "npy", "zip", "newer"])
def test_what_is_not_a_result_is_refused(tmp_path, content):
    path = tmp_path / "run.npz"
    if isinstance(content, bytes):
        path.write_bytes(content)
    else:
        newer = np.frombuffer(b'{"format": 99}', np.uint8)
        with open(path, "wb") as stream:
            {"npy": lambda: np.save(stream, np.ones(3)), "zip": lambda: np.savez(stream, a=np.ones(3)),
             "newer": lambda: np.savez(stream, metadata=newer)}[content]()  # fmt: skip
    with pytest.raises(TowageError, match=r"run.npz is not a result of towage"):
        Result.load_npz(path)
    with pytest.raises(TowageError, match="cannot read .*missing.npz: No such file"):
        Result.load_npz(tmp_path / "missing.npz")


def test_csv_reads_back_exactly_with_units(tmp_path):
    result = cradle()
    result.columns["cradle.heave"][3] = math.nan
    result.save_csv(tmp_path / "run.csv")
    with open(tmp_path / "run.csv", encoding="utf-8", newline="") as stream:
        head, *rows = csv.reader(stream)
    assert head == ["time [s]", "ship.heave [m]", "cradle.heave [m]", "line.tension [N]", "one_way:cradle.heave [m]"]
    table = np.array(rows, dtype=float)
    expected = np.column_stack((result.time, *result.columns.values(), result.one_way["cradle.heave"]))
    assert table.tobytes() == expected.tobytes()


def test_mat_has_valid_names_and_says_what_they_were(tmp_path):
    result = cradle()
    result.columns |= dict.fromkeys(("line_tension", "end", "1st", "Motor.w[1]", "x" * 80, "x" * 81), result.time)
    result.save_mat(tmp_path / "run.mat")
    content = loadmat(tmp_path / "run.mat", chars_as_strings=True)
    rows = [[cell.item() for cell in row] for row in content["variables"]]
    assert [row[1] for row in rows] == ["time", *result.columns, "one_way.cradle.heave"]
    assert rows[3] == ["line_tension", "line.tension", "N"]
    assert [row[0] for row in rows[4:8]] == ["line_tension_2", "v_end", "v_1st", "Motor_w_1_"]
    assert len({row[0] for row in rows}) == len(rows) and max(len(row[0]) for row in rows) == 63
    for matlab, name, _ in rows[:-1]:
        assert content[matlab].tobytes() == result[name].tobytes()


def test_netcdf_has_units_and_says_where_it_comes_from(tmp_path):
    xarray = pytest.importorskip("xarray", reason="the extra frames is not installed")
    result = cradle()
    result.columns["a/b"] = result.time
    result.flavours = {"line": "native"}
    result.save_netcdf(tmp_path / "run.nc")
    with xarray.open_dataset(tmp_path / "run.nc", decode_timedelta=False) as data:
        assert set(data.variables) == {"time", "ship.heave", "cradle.heave", "line.tension", "a|b", "one_way:cradle.heave"}
        assert data["line.tension"].attrs["units"] == "N" and data["a|b"].attrs == {"units": "1", "long_name": "a/b"}
        assert data["line.tension"].values.tobytes() == result["line.tension"].tobytes()
        assert data.attrs["scene"] == result.scene_source and json.loads(data.attrs["flavours"]) == {"line": "native"}
        assert data.attrs["verdict"] == "valid" and data.attrs["source"].startswith("towage ")
        assert json.loads(data.attrs["coupling_error"]) == result.coupling_error
    with pytest.raises(TowageError):
        result.save_netcdf(tmp_path / "nowhere" / "run.nc")


def test_summary_is_finite_json():
    result = cradle()
    result.columns["nothing"] = np.full(200, math.nan)
    summary = json.loads(json.dumps(result.summary(), allow_nan=False))
    assert summary["events"] == {"line.taut": 2, "cradle.docking": 1}
    assert summary["verdict"] == {
        "word": "valid", "reason": "amplitude", "number": 0.011, "limit": 0.05, "time": None, "remedy": "", "items": [],
    }  # fmt: skip
    assert summary["statistics"] == {"steps": 160, "real_time_factor": None}
    assert (summary["samples"], summary["end_time"]) == (200, 16.0)
    tension = result["line.tension"]
    assert summary["extremes"]["line.tension"]["max"] == tension.max()
    assert summary["extremes"]["line.tension"]["min_time"] == result.time[tension.argmin()]
    assert set(summary["extremes"]["nothing"].values()) == {None}
    empty = Result("t", "", "auto", "failed", "no step", np.empty(0), {"a": np.empty(0)}, {}).summary()
    assert (empty["samples"], empty["end_time"], empty["extremes"]["a"]["max"]) == (0, None, None)


WRITERS = {"npz": Result.save_npz, "csv": Result.save_csv, "mat": Result.save_mat}


@pytest.mark.parametrize("kind", WRITERS)
def test_writers_name_what_cannot_be_written(tmp_path, kind):
    write = WRITERS[kind]
    with pytest.raises(TowageError, match=r"cannot write .*its directory does not exist$"):
        write(cradle(3), tmp_path / "missing" / "run")
    (tmp_path / "file").write_text("")
    with pytest.raises(TowageError, match="a part of its path is not a directory"):
        write(cradle(3), tmp_path / "file" / "run")
    with pytest.raises(TowageError, match="something that is not a file"):
        write(cradle(3), tmp_path)
    assert [entry.name for entry in tmp_path.iterdir()] == ["file"]


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_directory_that_is_not_writable(tmp_path):
    (tmp_path / "run").write_text("old")
    tmp_path.chmod(0o555)
    try:
        with pytest.raises(TowageError, match="not writable; the earlier file is kept"):
            cradle(3).save_npz(tmp_path / "run")
    finally:
        tmp_path.chmod(0o755)
    assert (tmp_path / "run").read_text() == "old"


@pytest.mark.parametrize("kind", WRITERS)
def test_full_disk_keeps_the_old_file(tmp_path, kind):
    """A limit on the file size fails the write half-way, as a full disk does."""
    path = tmp_path / "run"
    path.write_text("old")
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, hard))
    try:
        with pytest.raises(TowageError, match="largest file size allowed here; the earlier file is kept"):
            WRITERS[kind](cradle(5000), path)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert path.read_text() == "old"
    assert [entry.name for entry in tmp_path.iterdir()] == ["run"]


def test_an_error_in_the_block_keeps_the_old_file(tmp_path):
    path = tmp_path / "run"
    path.write_text("old")
    with pytest.raises(ZeroDivisionError), atomic_write(path) as stream:
        stream.write(b"new")
        raise ZeroDivisionError
    assert path.read_text() == "old" and len(list(tmp_path.iterdir())) == 1


def test_a_symbolic_link_stays_one(tmp_path):
    (tmp_path / "real").write_text("old")
    (tmp_path / "link").symlink_to("real")
    with atomic_write(tmp_path / "link") as stream:
        stream.write(b"new")
    assert (tmp_path / "link").is_symlink() and (tmp_path / "real").read_text() == "new"


WRITE_FOREVER = """
import sys
import numpy as np
from towage.result.result import Result
clock = np.linspace(0.0, 1.0, 100_000)
for count in range(1, 10**9):
    columns = {f"a.c{i}": np.full(100_000, float(count)) for i in range(4)}
    Result("t", str(count), "auto", "done", "", clock, columns, {}).save_npz(sys.argv[1])
    print(count, flush=True)
"""


def test_a_kill_in_mid_write_leaves_the_old_file_or_the_new_one(tmp_path):
    path, chance = tmp_path / "run.npz", random.Random(1969)
    for _ in range(10):
        writer = subprocess.Popen(
            [sys.executable, "-c", WRITE_FOREVER, str(path)], stdout=subprocess.PIPE, env={**os.environ, "PYTHONPATH": str(ROOT)}
        )  # fmt: skip
        with writer:
            writer.stdout.readline()
            time.sleep(chance.uniform(0.0, 0.04))
            writer.kill()
            finished = 1 + len(writer.stdout.read().splitlines())
        result = Result.load_npz(path)
        assert int(result.case) in (finished, finished + 1)
        assert all((values == float(result.case)).all() for values in result.columns.values())


# ---- names in npz, tables, plots ------------------------------------------------------------------------------------


def test_npz_columns_carry_their_names(tmp_path):
    result = cradle()
    result.response = None
    result.columns |= {"file": result.time, "a.npy": result.time + 1.0, "time": result.time + 2.0}
    result.save_npz(tmp_path / "run.npz")
    with np.load(tmp_path / "run.npz") as store:
        for name in ("ship.heave", "cradle.heave", "line.tension"):
            assert store[name].tobytes() == result[name].tobytes()
        assert store["one_way:cradle.heave"].tobytes() == result.one_way["cradle.heave"].tobytes()
        assert store["time"].tobytes() == result.time.tobytes()
    assert_equal(result, Result.load_npz(tmp_path / "run.npz"))  # names that numpy would mistake are numbered


def test_npz_of_format_1_still_loads(tmp_path):
    """Columns were numbered, their names in the metadata."""
    result = cradle()
    metadata = json.loads(json.dumps(result.summary()))
    for added in ("events", "samples", "start_time", "end_time", "extremes"):
        del metadata[added]
    metadata |= {"format": 1, "column_names": list(result.columns), "one_way_names": ["cradle.heave"], "response": None}
    metadata |= {"scene_source": "", "events": [vars(event) for event in result.events]}
    metadata["statistics"]["real_time_factor"] = math.inf
    metadata["margins"][2]["worst"] = math.nan
    arrays_ = {f"column_{k}": values for k, values in enumerate(result.columns.values())}
    text = np.frombuffer(json.dumps(metadata).encode(), np.uint8)
    one_way = result.one_way["cradle.heave"]
    with open(tmp_path / "old.npz", "wb") as stream:
        np.savez(stream, metadata=text, time=result.time, step_sizes=result.step_sizes, one_way_0=one_way, **arrays_)
    result.response, result.scene_source = None, ""
    assert_equal(result, Result.load_npz(tmp_path / "old.npz"))


def test_as_a_pandas_table():
    pytest.importorskip("pandas")
    result = cradle()
    table = result.to_dataframe()
    assert list(table.columns) == [*result.columns, "one_way:cradle.heave"] and table.index.name == "time"
    assert table.index.to_numpy().tobytes() == result.time.tobytes()
    assert table["line.tension"].to_numpy().tobytes() == result["line.tension"].tobytes()
    assert table.attrs["units"] == {
        "time": "s", "ship.heave": "m", "cradle.heave": "m", "line.tension": "N", "one_way:cradle.heave": "m"
    }  # fmt: skip
    assert table.attrs["verdict"] == "valid" and table.attrs["case"] == "8 s"


def test_as_an_xarray_dataset():
    pytest.importorskip("xarray")
    result = cradle()
    data = result.to_xarray()
    assert set(data.data_vars) == {*result.columns, "one_way:cradle.heave"}
    assert data["line.tension"].attrs == {"units": "N"} and data["time"].attrs == {"units": "s"}
    assert data["line.tension"].dims == ("time",)
    assert data["line.tension"].values.tobytes() == result["line.tension"].tobytes()
    assert data["line.tension"].sel(time=16.0) == result["line.tension"][-1]
    assert data.attrs["title"] == "Cradle" and data.attrs["verdict"] == "valid"


@pytest.mark.parametrize("kind", ["pandas", "xarray"])
def test_tables_say_what_to_install(kind, monkeypatch):
    monkeypatch.setitem(sys.modules, kind, None)
    with pytest.raises(TowageError, match=rf"this needs {kind} .*: pip install 'towage\[frames\]'"):
        {"pandas": cradle().to_dataframe, "xarray": cradle().to_xarray}[kind]()


def test_a_result_is_told_in_one_line():
    assert repr(cradle()) == "<Result of 'Cradle, 8 s': valid; 3 variables, 200 samples to t = 16 s>"
    failed = Result("T", "", "auto", "failed", "no step", np.empty(0), {}, {})
    assert repr(failed) == "<Result of 'T': failed; 0 variables, 0 samples>"


def test_plot_has_a_panel_a_unit_and_the_one_way_run_dashed():
    result = cradle()
    result.columns |= {"line.margin_taut": result.time, "ship.heave_rate": result.time, "line.event_taut": result.time}
    metres, newtons = result.plot().axes
    assert (metres.get_ylabel(), newtons.get_ylabel(), newtons.get_xlabel()) == ("m", "N", "time, s")
    drawn = [(line.get_label(), line.get_linestyle()) for line in metres.lines]
    assert [style for _, style in drawn] == ["-", "-", "--"]
    assert [label for label, _ in drawn[:2]] == ["ship.heave", "cradle.heave"]
    assert metres.lines[2].get_ydata().tobytes() == result.one_way["cradle.heave"].tobytes()
    (panel,) = result.plot("line.tension").axes
    assert [line.get_label() for line in panel.lines] == ["line.tension"]
    with pytest.raises(KeyError, match="did you mean 'line.tension'"):
        result.plot("line.tensoin")


def test_notebook_shows_the_verdict_and_the_plot():
    result = cradle()
    result.title = "<Cradle>"
    text = result._repr_html_()
    assert "<strong>&lt;Cradle&gt;, 8 s</strong>" in text and ">valid</strong> amplitude" in text
    assert text.count("<svg") == 1 and "<?xml" not in text and "line.tension" in text
    assert text == result._repr_html_()
    failed = Result("T", "", "auto", "failed", "no <step>", np.empty(0), {}, {})
    assert failed._repr_html_() == (
        '<div><p><strong>T</strong>: <strong style="color:#a3121d">failed</strong> no &lt;step&gt;</p></div>'
    )
