"""Wave fields, grids, maps and forbidden areas."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest

from towage.models.route.areas import Cells, Disc, Polygon, blocked
from towage.models.route.fields import Field, StormField
from towage.models.route.grid import Axis, GridField
from towage.models.route.maps import FlatMap, StereographicMap

MILE = 1852.0
STORM = StormField(1.0, 9.0, (0.0, 0.0), 120 * MILE, (1.0, 4.0), 0.7, swirl=True)


def sampled(storm: StormField, mesh: float, times: int = 9) -> GridField:
    n = round(800 * MILE / mesh) + 1
    axis = Axis(-400 * MILE, mesh, n)
    time = Axis(0.0, 6 * 3600.0, times)
    t, y, x = np.meshgrid(*(a.start + a.step * np.arange(a.count) for a in (time, axis, axis)), indexing="ij")
    sea = storm.at(x, y, t)
    return GridField(axis, axis, time, sea.height, sea.kx, sea.ky)


@pytest.mark.parametrize("field", [STORM, sampled(STORM, 40 * MILE)], ids=["formula", "grid"])
def test_gradients_are_those_of_the_values(field: Field) -> None:
    x, y = np.array([50.3, -120.1, 200.7]) * MILE, np.array([80.2, 30.9, -150.5]) * MILE
    t, d = np.array([3600.0, 30000.0, 70000.0]), 10.0
    sea = field.at(x, y, t)
    for step, gradients in (((d, 0.0), (sea.height_x, sea.angle_x)), ((0.0, d), (sea.height_y, sea.angle_y))):
        up, down = field.at(x + step[0], y + step[1], t), field.at(x - step[0], y - step[1], t)
        turn = np.arctan2(up.ky * down.kx - up.kx * down.ky, up.kx * down.kx + up.ky * down.ky)
        assert gradients[0] == pytest.approx((up.height - down.height) / (2 * d), abs=1e-10)  # rounding over 20 m
        assert gradients[1] == pytest.approx(turn / (2 * d), abs=1e-10)


def test_interpolation_of_a_storm_converges() -> None:
    rng = np.random.default_rng(1)
    x, y = rng.uniform(-300 * MILE, 300 * MILE, (2, 400))
    t = np.full(400, 6 * 3600.0 * 4)
    storm = StormField(1.0, 9.0, (0.0, 0.0), 120 * MILE)
    errors = [np.max(np.abs(sampled(storm, m * MILE).at(x, y, t).height - storm.at(x, y, t).height)) for m in (40, 20, 10)]
    orders = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    assert np.all(orders > 2.6) and np.all(orders < 4.2)  # Keys: third order, fourth where a difference vanishes


def test_quadratics_are_met_exactly_up_to_the_edge_and_in_time() -> None:
    axis, time = Axis(0.0, 1.0, 6), Axis(0.0, 2.0, 4)
    t, y, x = np.meshgrid(*(a.start + a.step * np.arange(a.count) for a in (time, axis, axis)), indexing="ij")
    grid = GridField(axis, axis, time, 3.0 + x * x - y * y + 0.5 * t * t + x * t, np.ones_like(x), 0.0 * x)
    px, py, pt = np.array([0.2, 4.9, 2.5]), np.array([4.8, 0.1, 3.3]), np.array([0.3, 5.9, 2.2])
    sea = grid.at(px, py, pt)
    assert sea.height == pytest.approx(3.0 + px * px - py * py + 0.5 * pt * pt + px * pt, abs=1e-13)
    assert sea.height_x == pytest.approx(2.0 * px + pt, abs=1e-13)


def test_first_derivatives_are_continuous_at_the_nodes() -> None:
    grid = sampled(STORM, 60 * MILE)
    x = grid.x.start + grid.x.step * np.arange(3, 10)
    y, t = np.full(7, 13.0 * MILE), np.full(7, 5e4)
    left, right = grid.at(x - 1e-3, y, t), grid.at(x + 1e-3, y, t)
    assert left.height_x == pytest.approx(right.height_x, abs=1e-11)


def test_after_the_last_time_the_field_stays() -> None:
    grid = sampled(STORM, 60 * MILE)
    one = np.ones(1)
    assert grid.horizon == 8 * 6 * 3600.0
    assert grid.at(one, one, 2 * grid.horizon * one).height == grid.at(one, one, grid.horizon * one).height
    assert grid.inside(np.array([0.0, 401 * MILE]), np.zeros(2)).tolist() == [True, False]


def test_a_vortex_centre_has_no_direction_and_no_infinities() -> None:
    calm_centre = StormField(1.0, 9.0, (0.0, 0.0), 100.0, swirl=True)
    zero = np.zeros(1)
    assert not calm_centre.at(zero, zero, zero).directed[0]
    assert all(np.all(np.isfinite(v)) for v in calm_centre.at(zero, zero, zero))


def test_bad_grids_are_refused() -> None:
    axis, one = Axis(0.0, 1.0, 3), Axis(0.0, 1.0, 1)
    good = np.ones((1, 3, 3))
    with pytest.raises(ValueError, match="shape"):
        GridField(axis, axis, one, good[0], good, good)
    with pytest.raises(ValueError, match="not finite"):
        GridField(axis, axis, one, good * math.nan, good, good)
    with pytest.raises(ValueError, match="2 x 2"):
        GridField(one, axis, one, np.ones((1, 3, 1)), np.ones((1, 3, 1)), np.ones((1, 3, 1)))


@pytest.mark.parametrize("south", [False, True])
def test_the_plane_round_trips_and_keeps_angles(south: bool) -> None:
    plane = StereographicMap(reference=0.3, south=south)
    latitude, longitude = math.radians(-37.0 if south else 52.0), 2.1
    x, y = plane.to_plane(latitude, longitude)
    assert plane.to_geographic(x, y) == pytest.approx((latitude, longitude), abs=1e-14)
    for bearing in (0.1, 1.9, 4.0):
        d = 1e-7
        there = plane.to_plane(latitude + d * math.cos(bearing), longitude + d * math.sin(bearing) / math.cos(latitude))
        angle = math.atan2(there[1] - y, there[0] - x)
        assert math.cos(angle - plane.direction(x, y, bearing)) == pytest.approx(1.0, abs=1e-9)
        assert plane.bearing(x, y, plane.direction(x, y, bearing)) == pytest.approx(bearing)
        scale = math.dist(there, (x, y)) / (d * plane.radius)
        assert plane.scale(x, y)[0] == pytest.approx(scale, rel=1e-6)  # a step of 0.6 m on the globe


def test_the_map_is_true_to_scale_at_60_degrees() -> None:
    plane = StereographicMap()
    assert plane.scale(*plane.to_plane(math.radians(60.0), 1.0))[0] == pytest.approx(1.0, abs=1e-15)
    assert plane.equator / 381e3 == pytest.approx(31.2042541, abs=1e-6)  # Re in the source's meshes


@pytest.mark.parametrize(
    ("start", "end", "hours"),
    [((60.0, 10.0), (60.0, 190.0), 186.66013043), ((35.0, 140.0), (48.0, -125.0), 210.80314293)],
)
def test_great_circles(start: tuple[float, float], end: tuple[float, float], hours: float) -> None:
    plane = StereographicMap()
    a, b = (tuple(float(v) for v in plane.to_plane(*map(math.radians, place))) for place in (start, end))
    assert plane.distance(a, b) / MILE / 19.3 == pytest.approx(hours, rel=1e-9)  # printed digits
    way = plane.geodesic(a, b, 400)
    assert sum(plane.distance(p, q) for p, q in pairwise(way)) == pytest.approx(plane.distance(a, b), rel=1e-12)


def test_flat_geodesics_are_straight() -> None:
    assert FlatMap().geodesic((0.0, 0.0), (4.0, 2.0), 2) == [(0.0, 0.0), (2.0, 1.0), (4.0, 2.0)]


def test_areas_block_what_goes_through_them() -> None:
    square = Polygon([(1.0, 1.0), (3.0, 1.0), (3.0, 3.0), (1.0, 3.0)])
    mask = np.zeros((5, 5), dtype=bool)
    mask[2, 2] = True
    cells = Cells(0.0, 0.0, 1.0, 1.0, mask)
    disc = Disc(2.0, 2.0, 1.0)
    x0, y0 = np.array([0.0, 0.0, 0.0, 2.0]), np.array([2.0, 0.0, 4.0, 2.0])
    x1, y1 = np.array([4.0, 4.0, 4.0, 2.1]), np.array([2.0, 0.5, 4.0, 2.1])
    for area in (square, cells, disc):
        assert blocked([area], x0, y0, x1, y1).tolist() == [True, False, False, True]
    assert not blocked([disc], np.array([0.0]), np.array([1.0]), np.array([4.0]), np.array([1.0]))[0]  # a tangent
    with pytest.raises(ValueError, match="polygon"):
        Polygon([(0.0, 0.0), (1.0, 1.0)])
