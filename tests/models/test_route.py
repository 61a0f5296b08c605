"""Minimal-time routes: reference cases, basins, certificates, hard cases, reasons."""

from __future__ import annotations

import json
import math
from importlib.resources import files

import numpy as np
import pytest

from towage.models.route import graph as route_graph
from towage.models.route import shooting as route_shooting
from towage.models.route.areas import Disc, Polygon
from towage.models.route.fields import Field, StormField, UniformField
from towage.models.route.grid import Axis, GridField
from towage.models.route.hulls import TablePolar
from towage.models.route.maps import FlatMap, StereographicMap
from towage.models.route.medium import Medium
from towage.models.route.plan import Plan, plan
from towage.models.route.polar import FOOT, KNOT, ConstantPolar, JamesPolar
from towage.models.route.problem import Problem, RouteError
from towage.verify import sea as verify_sea
from towage.verify import verify

MILE, HOUR = 1852.0, 3600.0
CASES = json.loads((files("towage") / "reference" / "sea_and_route.json").read_text("utf-8"))["cases"]
ROUTES = {case["name"]: case for case in CASES if case["kind"] == "route"}
STORMS = [name for name, case in ROUTES.items() if "local_minima_h" in case["expected"]]
START, END = (0.0, 0.0), (1000.0 * MILE, 0.0)
CALM_SPEED = 19.299999999995 * KNOT


def calm(*areas: Disc | Polygon, field: Field | None = None) -> Problem:
    return Problem(Medium(FlatMap(), field or UniformField(), ConstantPolar(CALM_SPEED)), START, END, areas)


def storm(name: str) -> Problem:
    return verify_sea.problem(ROUTES[name]["inputs"])


def on_destination(peak: float, limit: float = 1e9) -> Problem:
    """Head seas that grow towards the end; ``peak`` in feet above 4."""
    field = StormField(4.0 * FOOT, peak * FOOT, END, 120.0 * MILE)
    return Problem(Medium(FlatMap(), field, JamesPolar(limit)), START, END)


@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=pytest.mark.slow) if n in ("P7b static mild", "P8 moving") else n for n in ROUTES]
)
def test_reference_case(name: str) -> None:
    found = verify.check(ROUTES[name])
    assert found.ok, found.message


@pytest.mark.parametrize("name", STORMS)
def test_safeguarded_iteration_ends_in_minima_from_41_headings(name: str) -> None:
    given = storm(name)
    shots = route_shooting.shoot(given.medium, START, END, np.linspace(-1.2, 1.2, 41), np.full(41, 60.0 * HOUR), steps=24)
    assert shots.converged.all()
    assert np.all(shots.j_exact > 0.0)
    minima = ROUTES[name]["expected"]["local_minima_h"]
    nearest = [min(abs(t / HOUR - m) for m in minima) for t in shots.time]
    assert max(nearest) < 1e-6  # 24 steps of order 8; the minima lie 1.5 h apart
    if len(minima) > 1:  # both basins are reached
        assert {int(np.argmin([abs(t / HOUR - m) for m in minima])) for t in shots.time} == {0, 1}


@pytest.mark.parametrize(
    ("name", "converges"),
    [("P7 static", 0), pytest.param("P8 moving", 0, marks=pytest.mark.slow), ("P7b static mild", 41)],
)
def test_the_sources_iteration_fails_where_storms_focus(name: str, converges: int) -> None:
    given = storm(name)
    shots = route_shooting.shoot(given.medium, START, END, np.linspace(-1.2, 1.2, 41), np.full(41, 60.0 * HOUR),
                                 method="seed", steps=12, tolerance=1e-6, iterations=50)  # fmt: skip
    assert int(shots.converged.sum()) == converges
    if not converges:
        with pytest.raises(RouteError, match="did not converge"):
            plan(given, method="seed")


def test_convergence_factor_of_the_sources_iteration() -> None:
    """1 - j_exact/j_seed, from the miss of successive iterations in the mild storm."""
    given = storm("P7b static mild")
    misses = [
        route_shooting.shoot(given.medium, START, END, [0.1], [55.5 * HOUR], method="seed", steps=16, iterations=k, tolerance=0.0)
        for k in (10, 11)
    ]
    j = misses[1].j_exact[0] / misses[1].j_seed[0]
    assert misses[1].miss[0] / misses[0].miss[0] == pytest.approx(1.0 - j, rel=1e-3)  # the next order of the miss
    assert 1.0 - j == pytest.approx(0.5612, abs=3e-3)  # the specification's, whose j is scaled a little differently


def test_newtons_method_ends_in_saddles_and_the_certificate_tells() -> None:
    given = storm("P7 static")
    shots = route_shooting.shoot(given.medium, START, END, np.linspace(-1.2, 1.2, 41), np.full(41, 60.0 * HOUR),
                                 method="exact", fraction=0.5, steps=16, tolerance=1e-7)  # fmt: skip
    saddle = shots.converged & (np.abs(shots.time / HOUR - 63.47843412954978) < 1e-4)
    assert saddle.any()
    tracks = route_shooting.tracks(given.medium, START, shots.alpha[saddle][:1], shots.time[saddle][:1])
    assert not tracks[0].certified


@pytest.mark.parametrize("name", STORMS)
def test_plan_gives_the_global_minimum_with_certificate(name: str) -> None:
    found, expected = plan(storm(name)), ROUTES[name]["expected"]
    assert found.best.kind == "extremal" and found.best.certified and found.best.j_exact > 0.0
    assert found.best.duration / HOUR == pytest.approx(expected["local_minima_h"][0], rel=1e-9)
    assert found.straight is not None and found.saving == pytest.approx(
        1.0 - expected["local_minima_h"][0] / expected["straight_h"], abs=1e-7
    )
    # the track itself takes as long as it says when it is sailed leg by leg
    points = np.column_stack([found.best.x, found.best.y])
    assert route_graph.sail(storm(name).medium, points)[-1] == pytest.approx(found.best.duration, rel=2e-3)


def test_orders_of_the_integration() -> None:
    given = storm("P8 moving")
    shots = route_shooting.shoot(given.medium, START, END, [0.3], [57.0 * HOUR], steps=64, tolerance=1e-13)
    ends = []
    for steps in (8, 12, 16):
        way = route_shooting.tracks(given.medium, START, shots.alpha, shots.time, steps)[0]
        ends.append(math.hypot(way.x[-1] - END[0], way.y[-1]))
    order = math.log(ends[0] / ends[2]) / math.log(2.0)
    assert 6.0 < order < 11.0  # order 8, not yet asymptotic at 8 steps


def test_the_graph_is_bound_by_the_radius_and_not_by_the_mesh() -> None:
    medium = Medium(FlatMap(), UniformField(), ConstantPolar(10.0))
    end = (700.0 * MILE, 0.0)
    goal = (end[0], 0.0)
    rotated = (math.cos(0.2) * goal[0], math.sin(0.2) * goal[0])
    paths = [route_graph.search(medium, START, rotated, cells=c, radius=r) for c, r in ((14, 1), (14, 3), (28, 1))]
    excess = [p.duration * 10.0 / goal[0] - 1.0 for p in paths if p]
    assert excess == pytest.approx([0.0, 0.0, 0.0], abs=1e-9)  # the lattice lies along the course: no excess in calm
    disc = calm(Disc(500.0 * MILE, 0.0, 150.0 * MILE))
    times = [route_graph.search(disc.medium, START, END, disc.areas, radius=r) for r in (1, 3)]
    errors = [t.duration / HOUR / 54.16305687158366 - 1.0 for t in times if t]
    assert errors[0] > 0.03 and 0.0 < errors[1] < 6e-3


@pytest.mark.parametrize(("method", "kind", "within"), [("safeguarded", "visibility", 1e-9), ("graph", "corridor", 1e-4)])
def test_a_forbidden_disc_is_rounded_to_the_accuracy_stated(method: str, kind: str, within: float) -> None:
    found = plan(calm(Disc(500.0 * MILE, 0.0, 150.0 * MILE)), method=method)
    assert found.best.kind == kind and found.best.certified == (method != "graph")
    assert found.best.duration / HOUR == pytest.approx(54.16305687158366, rel=within)
    distance = np.hypot(found.best.x - 500.0 * MILE, found.best.y)
    assert distance.min() > 150.0 * MILE * (1.0 - 1e-9)
    assert found.straight is None and any("crosses a forbidden area" in note for note in found.notes)


@pytest.mark.slow
def test_a_corridor_agrees_with_the_extremal() -> None:
    found = plan(storm("P8 moving"), method="graph")
    assert found.best.duration / HOUR == pytest.approx(56.71651033439211, rel=1e-4)  # its stated accuracy


def test_a_table_polar_tacks_and_says_so() -> None:
    angles = np.linspace(0.0, math.pi, 721)
    speeds = KNOT * 18.0 * (1.0 - 0.75 * np.exp(-((angles / 0.35) ** 2)))
    polar = TablePolar([0.0], angles.tolist(), [speeds.tolist()])
    found = plan(Problem(Medium(FlatMap(), UniformField(), polar), START, (100.0 * MILE, 0.0)))
    assert found.best.duration / HOUR == pytest.approx(6.958276591, rel=1e-5)  # samples of the hull
    # dead upwind every leg tacks: of ways equally fast the straightest counts, and the corridor's own beating is none of them
    assert found.tacking == pytest.approx(1.0, abs=1e-9) and any(note.startswith("tack") for note in found.notes)


# ---- hard cases ---------------------------------------------------------------------------------------------------------


def test_start_and_end_in_one_place_take_no_time() -> None:
    given = calm()
    found = plan(Problem(given.medium, START, START))
    assert found.best.duration == 0.0 and found.best.kind == "none" and found.notes


def test_two_metres_apart() -> None:
    given = calm()
    found = plan(Problem(given.medium, START, (1e-3 * MILE, 0.0)))
    assert found.best.duration / HOUR == pytest.approx(1e-3 / 19.299999999995, rel=1e-9)  # 5.18e-5 h


@pytest.mark.parametrize(
    ("peak", "hours"),
    [
        pytest.param(20, 55.5808, marks=pytest.mark.slow), pytest.param(30, 60.3734, marks=pytest.mark.slow), (40, 70.1241),
        pytest.param(47, 75.9104, marks=pytest.mark.slow), (50, 78.0495),
    ],
)  # fmt: skip
def test_storm_on_the_destination(peak: float, hours: float) -> None:
    found = plan(on_destination(peak))
    assert found.best.duration / HOUR == pytest.approx(hours, abs=6e-5)  # printed digits
    assert found.best.certified
    if peak >= 47:  # the head speed is negative there: the straight course ends, with a reason
        assert found.straight is None and any("no way against the sea" in note for note in found.notes)
        assert found.beyond_polar > 0.0


def test_the_polar_held_at_its_limit_gives_a_flag() -> None:
    found = plan(on_destination(50, limit=48 * FOOT))
    assert found.beyond_polar > 0.01
    assert any("beyond the range" in note for note in found.notes)


def over_the_pole(start: tuple[float, float], end: tuple[float, float]) -> tuple[Problem, Plan]:
    plane = StereographicMap()
    (a, b), (c, d) = (plane.to_plane(*map(math.radians, p)) for p in (start, end))
    given = Problem(Medium(plane, UniformField(), ConstantPolar(19.3 * KNOT)), (float(a), float(b)), (float(c), float(d)))
    return given, plan(given)


@pytest.mark.parametrize(
    ("start", "end", "hours"), [((60.0, 10.0), (60.0, 190.0), 186.66013043), ((35.0, 140.0), (48.0, -125.0), 210.80314293)]
)
def test_the_shortest_way_on_the_sphere(start: tuple[float, float], end: tuple[float, float], hours: float) -> None:
    given, found = over_the_pole(start, end)
    assert found.best.duration / HOUR == pytest.approx(hours, rel=1e-9)
    assert given.medium.map.distance(given.start, given.end) / (19.3 * KNOT) == pytest.approx(found.best.duration, rel=1e-9)


def test_across_the_equator() -> None:
    given, found = over_the_pole((30.0, 10.0), (-20.0, 40.0))
    assert found.best.duration == pytest.approx(given.medium.map.distance(given.start, given.end) / (19.3 * KNOT), rel=1e-9)


def test_a_vortex_between_start_and_end() -> None:
    field = StormField(1.0, 9.0, (500.0 * MILE, 5.0 * MILE), 120.0 * MILE, swirl=True)
    found = plan(Problem(Medium(FlatMap(), field, JamesPolar()), START, END))
    assert found.best.certified and found.straight is not None
    assert found.best.duration < found.straight.duration


def gridded(hours: float, west: float = -300.0) -> GridField:
    """The moving storm on a mesh of 30 nautical miles, forecast for ``hours``."""
    field = storm("P8 moving").medium.field
    x = Axis(west * MILE, 30.0 * MILE, round((1300.0 - west) / 30.0) + 1)
    y, t = Axis(-600.0 * MILE, 30.0 * MILE, 41), Axis(0.0, 6.0 * HOUR, round(hours / 6.0) + 1)
    gt, gy, gx = np.meshgrid(*(a.start + a.step * np.arange(a.count) for a in (t, y, x)), indexing="ij")
    sea = field.at(gx, gy, gt)
    return GridField(x, y, t, sea.height, sea.kx, sea.ky)


def test_a_gridded_storm_gives_nearly_the_time_of_the_formula() -> None:
    found = plan(Problem(Medium(FlatMap(), gridded(66.0), JamesPolar()), START, END))
    assert found.best.certified and found.beyond_horizon == 0.0
    # 1.2e-3 h is what interpolating on 30 nm costs, time steps of 6 h a little more
    assert found.best.duration / HOUR == pytest.approx(56.71651033439211, abs=0.02)


@pytest.mark.slow
def test_past_the_last_forecast_the_field_stays_and_the_share_is_told() -> None:
    found = plan(Problem(Medium(FlatMap(), gridded(30.0), JamesPolar()), START, END))
    assert found.beyond_horizon == pytest.approx(1.0 - 30.0 * HOUR / found.best.duration)
    assert any("last forecast" in note for note in found.notes)


@pytest.mark.parametrize(
    ("given", "reason", "message"),
    [
        (calm(Disc(0.0, 0.0, 1e4, "harbour")), "forbidden", "start .* 'harbour'"),
        (calm(Disc(END[0], 0.0, 1e4)), "forbidden", "end"),
        (calm(field=gridded(6.0, west=100.0)), "outside", "start .* outside the wave data"),
        (Problem(calm().medium, START, (math.nan, 0.0)), "input", "not a place"),
        (calm(*[Disc(END[0] + 3e5 * math.cos(a), 3e5 * math.sin(a), 1.2e5) for a in np.arange(0.0, 6.3, 0.5)]), "unreachable",
         "forbidden areas"),
    ],
)
def test_reasons(given: Problem, reason: str, message: str) -> None:
    with pytest.raises(RouteError, match=message) as caught:
        plan(given)
    assert caught.value.reason == reason


def test_a_sea_that_stops_the_ship_everywhere() -> None:
    zero = TablePolar([0.0, 1.0], [0.0, math.pi], [[5.0, 5.0], [0.0, 0.0]])
    with pytest.raises(RouteError, match="makes no way"):
        plan(Problem(Medium(FlatMap(), UniformField(2.0), zero), START, END))


@pytest.mark.slow
def test_an_extremal_off_the_data_is_dropped_with_a_note() -> None:
    """The strip of data is too narrow for the way around the storm."""
    field = storm("P8 moving").medium.field
    x, y, t = Axis(-90.0 * MILE, 30.0 * MILE, 40), Axis(-60.0 * MILE, 30.0 * MILE, 5), Axis(0.0, 6.0 * HOUR, 12)
    gt, gy, gx = np.meshgrid(*(a.start + a.step * np.arange(a.count) for a in (t, y, x)), indexing="ij")
    sea = field.at(gx, gy, gt)
    narrow = GridField(x, y, t, sea.height, sea.kx, sea.ky)
    found = plan(Problem(Medium(FlatMap(), narrow, JamesPolar()), START, END))
    assert np.all(narrow.inside(found.best.x, found.best.y))
    assert found.best.kind == "corridor" or found.best.certified
    assert found.best.duration / HOUR > 56.8


def test_unknown_methods_are_refused() -> None:
    with pytest.raises(RouteError, match="method"):
        plan(calm(), method="magic")
    with pytest.raises(ValueError, match="method"):
        route_shooting.shoot(calm().medium, START, END, [0.0], [1.0], method="magic")
