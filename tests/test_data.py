"""Files that are given to units: every format gives the same ship, and what cannot be meant is refused with its place."""

from __future__ import annotations

import cmath
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from netCDF4 import Dataset

from towage.data import responses, series, spectra
from towage.errors import SceneError
from towage.models.route.playback import Series
from towage.models.sea.response_table import DOFS, ResponseTable
from towage.reading import Refused
from towage.scene.resolve import described
from towage.scene.scene import Scene
from towage.units.store import locator

G = 9.80665
PERIODS, DIRECTIONS = (5.0, 8.0, 12.5, 20.0), tuple(range(0, 181, 45))


def response(dof: int, omega: float, beta: float) -> complex:
    """Alike on both sides: sway, roll and yaw are odd in beta."""
    odd = math.sin(beta) if dof in (1, 3, 5) else 1.0
    return odd * (0.3 + 0.1 * dof) * cmath.exp(1j * (omega * (dof + 1) - 0.4 * math.cos(beta))) / (1.0 + omega)


def rows() -> list[tuple[float, float, int, complex]]:
    """Period, direction, degree of freedom, H."""
    return [
        (t, d, k, response(k, 2.0 * math.pi / t, math.radians(d)))
        for t in PERIODS
        for d in DIRECTIONS
        for k in range(6)
    ]


def wamit(path: Path, ulen: float = 40.0) -> dict[str, Any]:
    lines = []
    for t, d, k, h in rows():
        h *= ulen if k > 2 else 1.0
        phase = math.degrees(cmath.phase(h))
        lines.append(f" {t:.9E} {d:.9E} {k + 1} {abs(h):.9E} {phase:.9E} {h.real:.9E} {h.imag:.9E}\n")
    path.with_suffix(".4").write_text("".join(lines))
    return {"file": path.with_suffix(".4"), "ulen": ulen}


def capytaine(path: Path) -> dict[str, Any]:
    """As capytaine writes it: Re(X exp(-i w t)), so that X is the conjugate."""
    omega = [2.0 * math.pi / t for t in PERIODS]
    with Dataset(path.with_suffix(".nc"), "w") as data:
        for name, size in (("complex", 2), ("omega", 4), ("wave_direction", 5), ("radiating_dof", 6)):
            data.createDimension(name, size)
        data.createVariable("omega", "f8", ("omega",))[:] = omega
        data.createVariable("wave_direction", "f8", ("wave_direction",))[:] = np.radians(DIRECTIONS)
        for name, words in (("complex", ("re", "im")), ("radiating_dof", [n.capitalize() for n in DOFS])):
            data.createVariable(name, str, (name,))[:] = np.array(words, object)
        h = np.array([[[response(k, w, math.radians(d)) for k in range(6)] for d in DIRECTIONS] for w in omega])
        data.createVariable("RAO", "f8", ("complex", "omega", "wave_direction", "radiating_dof"))[:] = [h.real, -h.imag]
    return {"file": path.with_suffix(".nc")}


def orcaflex(path: Path) -> dict[str, Any]:
    """Blocks a direction, phases lag in degrees, rotations in degrees a metre."""
    head = ["Period (s)"]
    for name in DOFS:
        head += [
            f"{name.capitalize()} Ampl. ({'deg/m' if DOFS.index(name) > 2 else 'm/m'})",
            f"{name.capitalize()} Phase (deg)",
        ]
    lines = ["# vessel type"]
    for d in DIRECTIONS:
        lines += [f"Direction {d}", ",".join(head)]
        for t in PERIODS:
            cells = [f"{t}"]
            for h, k in ((response(k, 2.0 * math.pi / t, math.radians(d)), k) for k in range(6)):
                cells += [f"{math.degrees(abs(h)) if k > 2 else abs(h):.12g}", f"{-math.degrees(cmath.phase(h)):.12g}"]
            lines.append(",".join(cells))
    path.with_suffix(".txt").write_text("\n".join(lines))
    return {"file": path.with_suffix(".txt"), "phase": "lag", "direction": "to"}


def plain(path: Path) -> dict[str, Any]:
    """One row an entry, directions from which the waves come, real and imaginary parts of exp(-iwt), rotations by slope."""
    head = ["frequency [Hz]", "direction [rad]"]
    for name in DOFS:
        unit = "slope" if DOFS.index(name) > 2 else "m/m"
        head += [f"{name}_re [{unit}]", f"{name}_im [{unit}]"]
    lines = [";".join(head)]
    for t in PERIODS:
        for d in DIRECTIONS:
            omega, cells = 2.0 * math.pi / t, [f"{1.0 / t:.15g}", f"{math.radians(d) - math.pi:.15g}"]
            for k in range(6):
                h = response(k, omega, math.radians(d)) * (G / omega**2 if k > 2 else 1.0)
                cells += [f"{h.real:.14g}", f"{-h.imag:.14g}"]
            lines.append(";".join(cells))
    path.with_suffix(".csv").write_text("\n".join(lines))
    return {"file": path.with_suffix(".csv"), "direction": "from", "time": "exp(-iwt)"}


@pytest.mark.parametrize("write", [wamit, capytaine, orcaflex, plain])
def test_every_format_gives_one_ship(write: Any, tmp_path: Path) -> None:
    given, notes = write(tmp_path / "ship"), list[str]()
    table = ResponseTable(**responses.read(given.pop("file"), given, notes))
    assert len(table.headings) == 8 and any("mirror image" in note for note in notes)
    for t, d, k, h in rows():
        omega = (
            2.0 * math.pi / t * (1.0 - 1e-9)
        )  # frequencies are read to 1e-9 rad/s, and above the last the ship lies still
        assert table.at(k, omega, 0.0, math.radians(d)) == pytest.approx(h, abs=1e-7)
        assert table.at(k, omega, 0.0, -math.radians(d)) == pytest.approx(h if k in (0, 2, 4) else -h, abs=1e-7)


GOOD = "period [s], direction [deg], heave_amplitude [m/m], heave_phase [deg]\n" + "".join(
    f"{t}, {d}, 1, 0\n" for t in (6, 9) for d in range(0, 181, 60)
)


@pytest.mark.parametrize(
    ("text", "given", "message"),
    [
        (GOOD, {"direction": "to"}, "phase is not given: 'lead' or 'lag'"),
        (GOOD, {"phase": "lead"}, "direction is not given: 'to'"),
        (GOOD, {"phase": "lead", "direction": "to", "unit": "m"}, "unknown option 'unit'"),
        (GOOD.replace("[deg], heave", "heave", 1), {"phase": "lead", "direction": "to"}, "4"),
        (GOOD.replace("heave_phase [deg]", "heave_phase"), {"phase": "lead", "direction": "to"}, "unit is not given: expected"),
        (GOOD.replace("[m/m]", "[deg/m]"), {"phase": "lead", "direction": "to"}, "its unit is deg/m: expected \\[m/m\\]"),
        (GOOD.replace("9, 60, 1, 0\n", ""), {"phase": "lead", "direction": "to"}, "no heave at 0.698132 rad/s, 60 deg"),
        (GOOD.replace("9, 60, 1, 0", "9, 60, nan, 0"), {"phase": "lead", "direction": "to"}, "line 7, column 'heave_amp.*nan"),
        (GOOD.replace("9, 60, 1, 0", "9, 60, x, 0"), {"phase": "lead", "direction": "to"}, "line 7.*expected a number, got 'x'"),
        (GOOD.replace("9, 60, 1, 0", "9, 60, 1"), {"phase": "lead", "direction": "to"}, "line 7: 3 values for 4 columns"),
        (GOOD + "9, 60, 2, 0\n", {"phase": "lead", "direction": "to"}, "line 10: heave at .* stands there twice, and differs"),
        (GOOD.replace(" 60,", " 170,"), {"phase": "lead", "direction": "to"}, "expected a circle"),
        (GOOD.replace("9,", "0,"), {"phase": "lead", "direction": "to"}, "a period of 0 s"),
        (GOOD.replace("heave_", "bounce_"), {"phase": "lead", "direction": "to"}, "column 'bounce_amplitude': expected"),
    ],
)  # fmt: skip
def test_responses_that_cannot_be_meant_are_refused(
    text: str, given: dict[str, Any], message: str, tmp_path: Path
) -> None:
    path = tmp_path / "ship.csv"
    path.write_text(text)
    with pytest.raises(Refused, match=message):
        responses.read(path, given, [])


def test_a_wamit_file_needs_its_length_and_agrees_with_itself(tmp_path: Path) -> None:
    path = wamit(tmp_path / "ship")["file"]
    with pytest.raises(Refused, match="ULEN"):
        responses.read(path, {}, [])
    lines = path.read_text().splitlines()
    cells = lines[2].split()
    cells[4] = "12.0"
    path.write_text("\n".join([*lines[:2], " ".join(cells), *lines[3:]]))
    with pytest.raises(Refused, match="line 3: modulus .* and phase 12 deg are not those of"):
        responses.read(path, {"ulen": 40.0}, [])


def play(text: str, tmp_path: Path, **given: Any) -> tuple[Series, list[str]]:
    path, notes = tmp_path / "log.csv", list[str]()
    path.write_text(text)
    return Series(**series.read(path, given, notes)), notes


def test_a_series_in_any_file_is_the_same_and_smooth(tmp_path: Path) -> None:
    t = np.array([0.0, 0.5, 1.5, 2.0, 3.5, 4.0])
    x, turn = np.sin(t), np.degrees(0.2 * t)
    text = "time [min], x [ft], turn [deg], flat\n" + "".join(
        f"{a / 60.0:.17g},{b / 0.3048:.17g},{c:.17g},7\n" for a, b, c in zip(t, x, turn)
    )
    one, notes = play(text, tmp_path)
    assert notes == ["flat has no unit: taken for a number without one"]
    np.savez(tmp_path / "log.npz", **{"time": t, "x [m]": x, "turn [rad]": 0.2 * t, "flat": np.full(6, 7.0)})
    with Dataset(tmp_path / "log.nc", "w") as data:
        data.createDimension("n", 6)
        for name, values, unit in (("t", t, "s"), ("x", x, "m"), ("turn", turn, "deg"), ("flat", np.full(6, 7.0), "1")):
            variable = data.createVariable(name, "f8", ("n",))
            variable[:], variable.units = values, unit
    for name in ("log.npz", "log.nc"):
        other = Series(**series.read(tmp_path / name, {}, []))
        assert (other.names, other.units) == (one.names, one.units) == (("x", "turn", "flat"), ("m", "rad", "1"))
        assert np.array(other.values) == pytest.approx(np.array(one.values), abs=1e-14)
        assert np.array(other.slopes) == pytest.approx(np.array(one.slopes), abs=1e-12)
    run = one.kernel().run
    for k in range(1, 5):  # value, rate and second derivative from both sides of every row
        before, after = (run(float(t[k]) + d, 0, 1.0, 0.0, 0.0) for d in (-1e-9, 1e-9))
        assert before == pytest.approx(after, abs=1e-8)
    for at in (0.2, 1.1, 2.9):  # the rate is the derivative of what is played
        ends = [run(at + d, 0, 2.0, 0.1, 2.0)[0] for d in (-1e-5, 1e-5)]
        assert (ends[1] - ends[0]) / 2e-5 == pytest.approx(run(at, 0, 2.0, 0.1, 2.0)[1], abs=1e-9)
    assert [run(s, 2, 1.0, 0.0, 0.0)[:2] for s in (0.3, 3.9)] == [pytest.approx((7.0, 0.0), abs=1e-12)] * 2


def test_a_monotone_series_stays_between_its_rows(tmp_path: Path) -> None:
    text = "t [s], x [m]\n0,0\n1,0\n2,5\n3,5\n4,5.1\n"
    kept, _ = play(text, tmp_path, method="monotone")
    swings, _ = play(text, tmp_path)
    one, other = ([s.kernel().run(0.01 * k, 0, 1.0, 0.0, 0.0)[0] for k in range(401)] for s in (kept, swings))
    assert min(one) == 0.0 and max(one) == 5.1 and min(other) < -0.1 and max(other) > 5.15


def test_a_route_is_played_as_its_csv_says(tmp_path: Path) -> None:
    text = "time_h,heading_deg,wave_height_m\n0,350,2\n1,359,3\n2,8,2.5\n"
    played, notes = play(text, tmp_path, unwrap=["heading"])
    assert played.names == ("heading", "wave_height") and played.times == (0.0, 3600.0, 7200.0)
    assert notes == ["taken is time_h for time in h, heading_deg for heading in deg, wave_height_m for wave_height in m"]
    assert np.degrees(played.values[0]) == pytest.approx([350.0, 359.0, 368.0])
    assert "heading turns by more than half a circle from row 2 to 3" in " ".join(play(text, tmp_path)[1])


@pytest.mark.parametrize(
    ("text", "given", "message"),
    [
        ("t [s], x [m]\n0,0\n2,1\n1,0\n", {}, "line 4: time 1 is before that of line 3, 2"),
        ("t [s], x [m]\n0,0\n\n1,1\n1,0\n", {}, "line 5: time 1 is the same as that of line 4"),
        ("t [s], x [m]\n0,0\n", {}, "line 2: one row: expected two at least"),
        ("t [s], x [m]\n", {}, "no rows of numbers"),
        ("x [m], y [m]\n0,0\n1,1\n", {}, "expected one column time or t, got x, y"),
        ("t [s], x [m]\n0,0\n1,inf\n", {}, "line 3, column 'x \\[m\\]': inf is no value"),
        ("t [s], x [furlong]\n0,0\n1,1\n", {}, "column 'x'"),
        ("t [s], x_rate [m]\n0,0\n1,1\n", {}, "names that end in _rate"),
        ("t [s], x [m], x! [m]\n0,0,0\n1,1,1\n", {}, "two columns would be called x"),
        ("t [s], x [m]\n0,0\n1,1\n", {"columns": ["y"]}, "no column 'y': there are x"),
        ("t [s], x [m]\n0,0\n1,1\n", {"method": "linear"}, "expected 'c2' or 'monotone'"),
        ("0,0\n1,1\n", {}, "line 1: expected the names of the columns"),
    ],
)  # fmt: skip
def test_series_that_cannot_be_meant_are_refused(
    text: str, given: dict[str, Any], message: str, tmp_path: Path
) -> None:
    with pytest.raises(Refused, match=message):
        play(text, tmp_path, **given)


def test_a_spectrum_in_three_forms_is_one_sea(tmp_path: Path) -> None:
    f, density = np.linspace(0.04, 0.4, 30), np.array([4.0 * math.exp(-((k - 8.0) ** 2) / 20.0) for k in range(30)])
    (tmp_path / "hz.csv").write_text(
        "frequency [Hz], density [m2/Hz]\n" + "".join(f"{a},{b}\n" for a, b in zip(f, density))
    )
    (tmp_path / "si.csv").write_text(
        "density [m2 s/rad], frequency [rad/s]\n"
        + "".join(f"{b / (2 * math.pi)},{2 * math.pi * a}\n" for a, b in zip(f, density))
    )
    with Dataset(tmp_path / "wavespectra.nc", "w") as data:
        for name, size in (("time", 1), ("freq", 30), ("dir", 4)):
            data.createDimension(name, size)
        data.createVariable("freq", "f8", ("freq",))[:] = f
        data.createVariable("dir", "f8", ("dir",))[:] = [0.0, 90.0, 180.0, 270.0]
        share = np.array([0.0, 0.5, 0.5, 0.0]) / 90.0  # from the south-east
        data.createVariable("efth", "f8", ("time", "freq", "dir"))[:] = (density[:, None] * share)[None]
    for each in (made := [spectra.read(tmp_path / name, {}, []) for name in ("hz.csv", "si.csv", "wavespectra.nc")]):
        assert each["height"] == pytest.approx(4.0 * math.sqrt(float(np.trapezoid(density, f))), rel=1e-12)
        assert each["frequency"] == pytest.approx(2.0 * math.pi * f[8], rel=1e-12)
    # a quarter more clockwise, as on a compass, is less in the axes of the ship
    energies = {round(math.degrees(mu)): sum(row) for (mu, _), row in zip(made[2]["directions"], made[2]["densities"])}
    assert energies[45] == pytest.approx(energies[-45]) and energies[45] > 0.0 == energies[135] == energies[-135]
    with Dataset(tmp_path / "several.nc", "w") as data:
        for name, size in (("time", 2), ("site", 3), ("freq", 30)):
            data.createDimension(name, size)
        data.createVariable("freq", "f8", ("freq",))[:] = f
        data.createVariable("efth", "f8", ("time", "site", "freq"))[:] = density * np.arange(1.0, 7.0).reshape(2, 3, 1)
    one = spectra.read(tmp_path / "several.nc", {"select": {"time": 1, "site": 0}}, [])
    assert one["height"] == pytest.approx(2.0 * made[0]["height"], rel=1e-12)  # four times the energy
    bad = ({"time": 1}, "3 entries of site: choose one"), ({"time": 2, "site": 0}, "a whole number from 0 to 1")
    for select, message in (*bad, ({"place": 1}, "expected numbers of entries, from 0, of time, site")):
        with pytest.raises(Refused, match=message):
            spectra.read(tmp_path / "several.nc", {"select": select}, [])
    (tmp_path / "bad.csv").write_text("frequency, density\n1,1\n2,2\n3,3\n")
    with pytest.raises(Refused, match="its unit is not given: expected"):
        spectra.read(tmp_path / "bad.csv", {}, [])


SCENE = {
    "title": "played", "stop_time": 3.0, "connections": ["log.heave -> line.heave_top"],
    "units": {"log": {"fmu": "playback"}, "line": {"fmu": "spring_line", "parameters": {"stiffness": 1e5, "static_tension": 1e4},
                                                    "inputs": {"heave_bottom": 0.0}}},
    "coupling": {"step": 0.1},
}  # fmt: skip


def scene(folder: Path, files: dict[str, Any]) -> Scene:
    units = {**SCENE["units"], "log": {"fmu": "playback", "files": files}}  # type: ignore[dict-item]
    return Scene.from_dict({**SCENE, "units": units}, folder / "scene.toml")


def test_a_scene_gives_its_unit_a_file(tmp_path: Path) -> None:
    (tmp_path / "log.csv").write_text("time, heave [m]\n0,0\n1,1\n2,0.5\n4,0\n")
    resolved = described(scene(tmp_path, {"series": "log.csv"}), locator())
    assert [v.name for v in resolved.units["log"].description.variables if v.causality == "output"] == ["heave"]
    assert "log: log.csv: time has no unit: taken for seconds" in resolved.warnings


@pytest.mark.parametrize(
    ("files", "message"),
    [
        ({}, "playback means nothing without a file: give it series"),
        ({"responses": "log.csv"}, "units.log.files.responses: playback takes no file 'responses': it takes series"),
        ({"series": "none.csv"}, "none.csv: No such file"),
        ({"series": 3}, "expected the path of a file, or a table with file"),
        ({"series": {"file": "log.csv", "method": "x"}}, "log.csv: method = 'x'"),
    ],
)  # fmt: skip
def test_files_that_do_not_fit_are_refused(files: dict[str, Any], message: str, tmp_path: Path) -> None:
    (tmp_path / "log.csv").write_text("time, heave [m]\n0,0\n1,1\n")
    with pytest.raises(SceneError) as caught:
        described(scene(tmp_path, files), locator())
    assert message in str(caught.value)
