"""Ways around areas, currents, tables of wind, steps and bounds, against closed forms and independent searches."""

from __future__ import annotations

import json
import math
from importlib.resources import files
from itertools import pairwise

import numpy as np
import pytest
from numpy.typing import NDArray

from towage.models.route import graph as route_graph
from towage.models.route import visibility
from towage.models.route.areas import Area, Disc, Polygon, blocked
from towage.models.route.bound import lower_bound
from towage.models.route.fields import Field, LinearCurrent, StormField, Storms, UniformField
from towage.models.route.grid import Axis, Knots
from towage.models.route.hulls import Table, TablePolar, WindWavePolar
from towage.models.route.maps import FlatMap
from towage.models.route.medium import Medium
from towage.models.route.plan import plan
from towage.models.route.polar import FOOT, KNOT, ConstantPolar, JamesPolar, Polar
from towage.models.route.problem import Problem, RouteError

MILE, HOUR = 1852.0, 3600.0
START, END = (0.0, 0.0), (1000.0 * MILE, 0.0)
CALM = Medium(FlatMap(), UniformField(), ConstantPolar(19.3 * KNOT))
NARROW = (Disc(500.0 * MILE, 272.0 * MILE, 200.0 * MILE), Disc(500.0 * MILE, -140.0 * MILE, 200.0 * MILE))


def hours(areas: tuple[Area, ...], medium: Medium = CALM) -> float:
    return plan(Problem(medium, START, END, areas)).best.duration / HOUR


def square(west: float, south: float, east: float, north: float) -> Polygon:
    return Polygon([(x * MILE, y * MILE) for x, y in ((west, south), (east, south), (east, north), (west, north))])


def tangent_way(discs: tuple[Disc, ...], signs: tuple[int, ...]) -> float:
    """Length of a taut string from start to end that passes discs at the side of each sign (1: above), by summing common
    tangents and arcs; of two discs at most."""
    circles = [(*START, 0.0, 1), *((d.x, d.y, d.radius, s) for d, s in zip(discs, signs)), (*END, 0.0, 1)]
    length, angles = 0.0, []
    for (ax, ay, ar, a), (bx, by, br, b) in pairwise(circles):
        d = math.dist((ax, ay), (bx, by))
        across = a * ar - b * br
        length += math.sqrt(d * d - across * across)
        angles.append(math.atan2(by - ay, bx - ax) - math.asin(across / d))
    turns = [abs(second - first) for first, second in pairwise(angles)]
    return length + sum(c[2] * turn for c, turn in zip(circles[1:-1], turns))


def test_a_passage_narrower_than_the_mesh() -> None:
    found = plan(Problem(CALM, START, END, NARROW))
    assert found.best.kind == "visibility" and found.best.certified
    exact = tangent_way((NARROW[1],), (1,)) / MILE / 19.3  # around the lower disc; the upper one does not touch
    assert found.best.duration / HOUR == pytest.approx(exact, rel=1e-9)
    assert exact < 52.263  # the broken line through (500, 66) nmi
    assert found.lower_bound == found.best.duration


@pytest.mark.parametrize(("method", "medium"), [
    ("graph", CALM),
    ("safeguarded", Medium(FlatMap(), StormField(0.0, 0.5, (500 * MILE, -900 * MILE), 300 * MILE), JamesPolar())),
])  # fmt: skip
def test_the_lattice_finds_the_passage_too(method: str, medium: Medium) -> None:
    found = plan(Problem(medium, START, END, NARROW), method=method)
    assert found.best.kind == "corridor"
    assert found.best.duration / HOUR == pytest.approx(hours(NARROW), rel=1e-3 if method != "graph" else 1e-4)


def test_a_slit_between_polygons() -> None:
    found = plan(Problem(CALM, START, END, (square(400, -100, 600, 50), square(400, 52, 600, 400))))
    assert found.best.duration / HOUR == pytest.approx((2.0 * math.hypot(400.0, 50.0) + 200.0) / 19.3, rel=1e-12)
    # through opposite corners of a square is through the square
    assert hours((square(450, -50, 550, 50),)) == pytest.approx((2.0 * math.hypot(450.0, 50.0) + 100.0) / 19.3, rel=1e-12)


def discs_of(seed: int, count: int) -> tuple[Disc, ...]:
    rng = np.random.default_rng(seed)
    return tuple(
        Disc(*(rng.uniform((120.0, -250.0), (880.0, 250.0)) * MILE), float(rng.uniform(25.0, 100.0)) * MILE) for _ in range(count)
    )


def by_points(discs: tuple[Disc, ...], share: float, around: int = 64) -> float:
    """Length of the shortest way over points at ``share`` of the radii, all pairs that see each other past such discs: an
    independent search, too long for share > 1/cos(pi/around), too short for discs made smaller."""
    from scipy.sparse.csgraph import dijkstra

    angle = 2.0 * math.pi * np.arange(around) / around
    points = np.concatenate([[START, END], *[
        np.column_stack([d.x + share * d.radius * np.cos(angle), d.y + share * d.radius * np.sin(angle)]) for d in discs
    ]])  # fmt: skip
    solid = share * math.cos(math.pi / around) * (1.0 - 1e-9)
    free = np.all([np.hypot(*(points - (d.x, d.y)).T) >= solid * d.radius for d in discs], axis=0)
    points = points[free]
    a, b = points[:, None], points[None]
    length = np.hypot(*np.moveaxis(b - a, -1, 0))
    for d in discs:
        along = np.clip(np.sum((np.array([d.x, d.y]) - a) * (b - a), axis=-1) / np.maximum(length, 1e-9) ** 2, 0.0, 1.0)
        near = np.hypot(*np.moveaxis(a + along[..., None] * (b - a) - (d.x, d.y), -1, 0))
        length = np.where(near < solid * d.radius, np.inf, length)
    return float(dijkstra(np.where(np.isfinite(length), length, 0.0), indices=0)[1])


@pytest.mark.parametrize(("seed", "count"), [(1, 2), (2, 3), (3, 5), *(pytest.param(k, n, marks=pytest.mark.slow) for k, n in (
    (4, 8), (5, 12), (6, 20), (7, 30)))])  # fmt: skip
def test_random_discs_lie_between_an_inner_and_an_outer_search(seed: int, count: int) -> None:
    discs = discs_of(seed, count)
    path = visibility.shortest(CALM, START, END, discs)
    outer, inner = by_points(discs, 1.0 / math.cos(math.pi / 64)), by_points(discs, 1.0)
    if path is None:
        assert math.isinf(outer)
        return
    length = path.duration * 19.3 * KNOT
    assert inner * (1.0 - 1e-12) <= length <= outer * (1.0 + 1e-12)
    assert not any(np.any(np.hypot(path.points[:, 0] - d.x, path.points[:, 1] - d.y) < d.radius * (1.0 - 1e-9)) for d in discs)


@pytest.mark.parametrize("count", [2, 10, pytest.param(30, marks=pytest.mark.slow)])
def test_the_plan_is_the_shortest_of_the_graph_and_the_lattice_is_no_faster(count: int) -> None:
    discs = discs_of(10 + count, count)
    path = visibility.shortest(CALM, START, END, discs)
    assert path is not None
    assert hours(discs) == pytest.approx(path.duration / HOUR, rel=1e-9)
    lattice = route_graph.search(CALM, START, END, discs)
    assert lattice is not None
    fine = route_graph.refine(CALM, lattice, discs)
    assert path.duration * (1.0 - 1e-9) <= fine.duration <= path.duration * (1.0 + 3e-4)  # stated: 1e-4; discs by the dozen, 3e-4
    assert not np.any(blocked(discs, *path.points[:-1].T, *path.points[1:].T)) or path.points.shape[0] > 3


def test_an_even_sea_with_waves_and_a_current_has_its_visibility_graph() -> None:
    medium = Medium(FlatMap(), UniformField(15.0 * FOOT, 0.7), JamesPolar(), LinearCurrent((0.5, -0.8)))
    discs = (Disc(500.0 * MILE, 20.0 * MILE, 150.0 * MILE),)
    found = plan(Problem(medium, START, END, discs))
    corridor = plan(Problem(medium, START, END, discs), method="graph")
    assert found.best.kind == "visibility"
    assert found.best.duration <= corridor.best.duration <= found.best.duration * (1.0 + 1e-4)
    points = np.column_stack([found.best.x, found.best.y])
    assert route_graph.sail(medium, points)[-1] == pytest.approx(found.best.duration, rel=1e-4)  # chords of arcs of 2 degrees


def test_a_wall_of_discs_that_overlap_closes_the_way() -> None:
    wall = tuple(Disc(500.0 * MILE, 60.0 * k * MILE, 40.0 * MILE) for k in range(-3, 4))
    around = hours(wall)  # its ends can be rounded
    assert around > 2.0 * math.hypot(500.0, 180.0) / 19.3
    ring = tuple(Disc(200.0 * MILE * math.cos(a), 200.0 * MILE * math.sin(a), 80.0 * MILE) for a in np.arange(0.0, 6.3, 0.5))
    with pytest.raises(RouteError, match=r"closed by forbidden areas$"):
        plan(Problem(CALM, START, END, ring))


# ---- currents -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("current", [(2.0, 0.0), (1.0, 3.0), (-3.0, -2.0)])
def test_zermelo_in_an_even_current(current: tuple[float, float]) -> None:
    medium = Medium(FlatMap(), UniformField(), ConstantPolar(6.0), LinearCurrent(current))
    found = plan(Problem(medium, START, END))
    u, w = current
    assert found.best.certified
    assert found.best.duration == pytest.approx(END[0] / (u + math.sqrt(36.0 - w * w)), rel=1e-8)
    assert 0.99 * found.best.duration < found.lower_bound <= found.best.duration


def test_zermelo_in_a_linear_shear() -> None:
    """Unit speed, u = -y, headings 105 to 240 degrees: 2 + 2 sqrt(3) (Bryson and Ho, Applied Optimal Control, 1975, 2.7)."""
    cases = json.loads((files("towage") / "reference" / "sea_and_route.json").read_text("utf-8"))["cases"]
    case = next(c["inputs"] for c in cases if c["inputs"].get("map") == "unit")
    length, speed = 100e3, 5.0
    medium = Medium(FlatMap(), UniformField(), ConstantPolar(speed), LinearCurrent(gradient=((0.0, -speed / length), (0.0, 0.0))))
    start, end = ((x * length, y * length) for x, y in (case["start"], case["end"]))
    found = plan(Problem(medium, start, end))
    assert found.best.certified and found.best.kind == "extremal"
    assert found.best.duration * speed / length == pytest.approx(2.0 + 2.0 * math.sqrt(3.0), rel=1e-8)


@pytest.mark.parametrize("current", [LinearCurrent((-8.0, 0.0)), LinearCurrent((-6.0, 0.0), ((0.0, 1e-6), (0.0, 0.0)))])
def test_a_current_stronger_than_the_ship_is_named(current: LinearCurrent) -> None:
    medium = Medium(FlatMap(), UniformField(), ConstantPolar(5.0 * KNOT), current)
    with pytest.raises(RouteError, match=r"the current is stronger than the ship, \d+.* kn at .*, where she makes at most 5"):
        plan(Problem(medium, START, END))


def test_a_table_in_a_current_is_the_formula() -> None:
    round_table = TablePolar([0.0], [0.0, math.pi], [[6.0, 6.0]])
    times = []
    for polar in (round_table, ConstantPolar(6.0)):
        medium = Medium(FlatMap(), UniformField(), polar, LinearCurrent((1.0, 3.0)))
        px, py = np.cos(np.arange(0.0, 6.0, 0.5)), np.sin(np.arange(0.0, 6.0, 0.5))
        times.append(medium.speed_along(0.0 * px, 0.0 * px, 0.0 * px, px, py))
    assert times[0] == pytest.approx(times[1], rel=1e-6)  # a polygon of 7200 sides
    strong = Medium(FlatMap(), UniformField(), round_table, LinearCurrent((7.0, 0.0)))
    against = strong.speed_along(*(np.zeros(1),) * 3, np.array([-1.0]), np.zeros(1))
    assert against[0] == 0.0


# ---- tables ---------------------------------------------------------------------------------------------------------------

ANGLES = [math.radians(a) for a in (52.0, 60.0, 75.0, 90.0, 110.0, 120.0, 135.0, 150.0)]
SPEEDS = [6.0, 6.4, 6.8, 7.0, 7.1, 6.9, 6.2, 5.2]


def test_what_lies_beyond_the_ends_of_a_table() -> None:
    away = np.array([0.0])
    level = np.zeros(1)
    sailing = TablePolar([0.0], ANGLES, [SPEEDS], ends="no-go")
    assert sailing.speed_along(level, away)[0] == pytest.approx(6.0 * math.cos(ANGLES[0]), rel=1e-9)
    assert sailing.own_speed(level, away)[0] == 0.0
    motor = TablePolar([0.0], ANGLES, [SPEEDS], ends="held")
    assert motor.own_speed(level, away)[0] == 6.0 and motor.tack(0.0, 0.0) is None
    upwind = plan(Problem(Medium(FlatMap(), UniformField(1.0), sailing), START, (60.0 * MILE, 0.0)))
    assert upwind.best.duration == pytest.approx(60.0 * MILE / (6.0 * math.cos(ANGLES[0])), rel=1e-6)


def test_the_share_of_tacking_is_that_of_the_legs_in_the_no_go_zone() -> None:
    """Over the corner of a wall to a goal dead upwind of it: the first leg is sailed as it is, the second by tacks."""
    sailing = TablePolar([0.0], ANGLES, [SPEEDS], ends="no-go")
    wall = square(20, -300, 90, 40)
    found = plan(Problem(Medium(FlatMap(), UniformField(1.0), sailing), START, (100.0 * MILE, 40.0 * MILE), (wall,)))
    reach = math.hypot(20.0, 40.0) / float(np.interp(math.atan2(40.0, 20.0), ANGLES, SPEEDS))
    beat = 80.0 / (6.0 * math.cos(ANGLES[0]))
    assert found.best.kind == "visibility" and found.best.duration == pytest.approx((reach + beat) * MILE, rel=1e-6)
    assert found.tacking == pytest.approx(beat / (reach + beat), rel=1e-6)  # directions of the hull are 1/20 degree apart


def wind_and_waves(factors: list[list[float]]) -> WindWavePolar:
    wind = Table([0.0, 10.0], ANGLES, [[0.0] * 8, SPEEDS], "no-go", level="winds")
    return WindWavePolar(wind, Table([0.0, 4.0], [0.0, math.pi], factors, value="factors"))


def test_factors_of_waves_beside_the_wind() -> None:
    sea, wind = UniformField(2.0, 1.0), UniformField(10.0, 0.3)
    px, py = np.cos(np.arange(0.0, 6.0, 0.4)), np.sin(np.arange(0.0, 6.0, 0.4))
    still = np.zeros_like(px)

    def speeds(polar: Polar) -> NDArray[np.float64]:
        return Medium(FlatMap(), sea, polar, wind=wind).speed_along(still, still, still, px, py)

    alone = speeds(TablePolar([0.0, 10.0], ANGLES, [[0.0] * 8, SPEEDS], ends="no-go", over="wind"))
    assert speeds(wind_and_waves([[1.0, 1.0], [1.0, 1.0]])) == pytest.approx(alone, rel=1e-4)  # 720 directions against 7200
    assert speeds(wind_and_waves([[1.0, 1.0], [0.5, 0.5]])) == pytest.approx(0.75 * alone, rel=1e-4)
    assert wind_and_waves([[1.0, 1.0], [1.0, 1.0]]).needs_wind


def test_bad_tables_name_what_they_hold() -> None:
    with pytest.raises(ValueError, match="winds must ascend"):
        TablePolar([1.0, 0.0], [0.0, 1.0], [[1.0, 1.0]] * 2, over="wind")
    with pytest.raises(ValueError, match="factors have shape"):
        Table([0.0], [0.0, 1.0], [[1.0]], value="factors")
    with pytest.raises(ValueError, match=r"speeds have shape \[2, 1\]"):
        Table([0.0, 1.0], [0.0, 1.0], [[1.0, 1.0], [1.0]])


# ---- storms, steps, bounds ------------------------------------------------------------------------------------------------


def in_storm(field: Field, far: float = 1000.0) -> Problem:
    return Problem(Medium(FlatMap(), field, JamesPolar()), START, (far * MILE, 0.0))


def test_several_storms_are_the_sum_of_theirs() -> None:
    one = StormField(1.0, 9.0, (0.0, 0.0), 120 * MILE, (1.0, 4.0), 0.7, swirl=True)
    x, y, t = (np.array([v]) for v in (50.0 * MILE, 80.0 * MILE, 3600.0))
    assert Storms(1.0, (one,), 0.7).at(x, y, t) == one.at(x, y, t)
    far = StormField(0.0, 5.0, (900.0 * MILE, 0.0), 60 * MILE)
    both = Storms(1.0, (one, far), 0.7)
    assert both.at(x, y, t).height == pytest.approx(one.at(x, y, t).height, abs=1e-12)
    assert both.at(x * 0.0 + 900.0 * MILE, y * 0.0, t).height == pytest.approx(6.0, abs=1e-9)
    assert both.detail == 60 * MILE and len(both.centres(0.0)) == 2
    d = 10.0
    for swirl in (True, False):
        two = Storms(1.0, (one, StormField(0.0, 5.0, (100.0 * MILE, 0.0), 90 * MILE, swirl=swirl)), 0.7)
        sea, up, down = two.at(x, y, t), two.at(x + d, y, t), two.at(x - d, y, t)
        assert sea.height_x == pytest.approx((up.height - down.height) / (2 * d), abs=1e-10)
        turn = np.arctan2(up.ky * down.kx - up.kx * down.ky, up.kx * down.kx + up.ky * down.ky)
        assert sea.angle_x == pytest.approx(turn / (2 * d), abs=1e-10)


def test_a_small_storm_is_passed_on_both_sides_with_steps_that_suit_it() -> None:
    """44 ft on 4 ft within 15 nmi, a little to the north of the course: the way to the south is faster."""
    found = plan(in_storm(StormField(4 * FOOT, 40 * FOOT, (500 * MILE, 3 * MILE), 15 * MILE, angle=math.pi / 3)))
    sides = sorted((float(np.interp(500 * MILE, r.x, r.y)), r.duration) for r in (found.best, *found.others))
    assert sides[0][0] < 0.0 < sides[-1][0] and sides[0][1] < sides[-1][1]
    assert found.best.error < 1e-8 * found.best.duration and len(found.best.time) > 128
    track = found.best.track
    assert track is not None and math.dist((track.x[-1], track.y[-1]), END) < 1e-6 * END[0]


@pytest.mark.parametrize("field", [
    StormField(4 * FOOT, 30 * FOOT, (500 * MILE, -250 * MILE), 120 * MILE, (0.0, 8 * KNOT), math.pi / 3),
    pytest.param(Storms(4 * FOOT, (StormField(0.0, 30 * FOOT, (300 * MILE, 50 * MILE), 60 * MILE),
                                   StormField(0.0, 30 * FOOT, (700 * MILE, -60 * MILE), 80 * MILE)), 1.0),
                 marks=pytest.mark.slow),
])  # fmt: skip
def test_bounds_lie_below_and_shares_within_the_whole(field: Field) -> None:
    given = in_storm(field)
    found = plan(given)
    assert 0.9 * found.best.duration < found.lower_bound < found.best.duration
    assert 0.0 <= found.beyond_polar <= 1.0 and 0.0 <= found.tacking <= 1.0
    over = Medium(FlatMap(), UniformField(20.0), JamesPolar())
    assert plan(Problem(over, START, (10.0 * MILE, 0.0))).beyond_polar == pytest.approx(1.0, abs=1e-12)
    # longer voyages are possible in more of the sea: the bound from a worse route is no larger
    assert lower_bound(given, 1.1 * found.best.duration) <= found.lower_bound * (1.0 + 1e-3)


def test_times_at_unequal_distances() -> None:
    even, uneven = Axis(0.0, 2.0, 6), Knots(np.array([0.0, 1.0, 2.0, 5.0, 9.0, 10.0]))
    same = Knots(even.places)
    t = np.array([-1.0, 0.3, 4.9, 7.0, 11.0])
    assert np.array_equal(same.place(t)[0], even.place(t)[0])
    assert same.weights(*same.place(t)) == pytest.approx(even.weights(*even.place(t)), abs=1e-14)
    cell, s = uneven.place(np.array([3.7]))
    places = uneven.places[cell[0] - 1 : cell[0] + 3]
    value = uneven.weights(cell, s)[0] @ (2.0 - 3.0 * places + 0.5 * places**2)
    assert value == pytest.approx(2.0 - 3.0 * 3.7 + 0.5 * 3.7**2, rel=1e-12)  # quadratics are met exactly
    with pytest.raises(ValueError, match="ascend"):
        Knots(np.array([0.0, 1.0, 1.0]))


def test_the_source_with_half_of_its_corrections() -> None:
    """Halved, as on its data card, the iteration ends in a local minimum 1.55 h behind the best."""
    given = in_storm(StormField(4 * FOOT, 30 * FOOT, (500 * MILE, -250 * MILE), 120 * MILE, (0.0, 8 * KNOT), math.pi / 3))
    found = plan(given, method="seed", fraction=0.5)
    assert found.best.duration / HOUR == pytest.approx(58.2673379622, abs=1e-6)
    with pytest.raises(RouteError, match=r"take half of its corrections \(fraction = 0.5\)"):
        plan(given, method="seed")
    with pytest.raises(RouteError, match="fraction 0.5: expected more than 0, at most 1, and method seed"):
        plan(given, fraction=0.5)
