"""The lower bound on all routes: no sample of a cell exceeds what is said of it, and exact answers lie above the bound."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from towage.models.route.bound import lower_bound
from towage.models.route.fields import LinearCurrent, LinearField, StormField, Storms, UniformField
from towage.models.route.grid import Axis, GridCurrent, GridField, Knots
from towage.models.route.hulls import Table, TablePolar, WindWavePolar
from towage.models.route.maps import FlatMap, StereographicMap
from towage.models.route.medium import Medium
from towage.models.route.polar import FOOT, KNOT, ConstantPolar, JamesPolar, ProportionalPolar
from towage.models.route.problem import Problem
from towage.models.route.ranges import Mesh, of_sea
from towage.models.route.rates import ANGLES, of_cells

MILE, HOUR = 1852.0, 3600.0
RNG = np.random.default_rng(7)
SIDE = 40e3
ROW, COLUMN = np.meshgrid(np.arange(8.0), np.arange(7.0), indexing="ij")
MESH = Mesh(SIDE * (0.8 * ROW - 0.6 * COLUMN), SIDE * (0.6 * ROW + 0.8 * COLUMN), np.array([0.0, 1.0, 2.5, 4.0]) * HOUR, SIDE)
SWIRL = Storms(2.0, (StormField(0.0, 7.0, (60e3, 90e3), 90e3, (3.0, 6.0), swirl=True),
                     StormField(0.0, -1.5, (10e3, 250e3), 80e3, (-9.0, 0.0))), 0.4)  # fmt: skip
XA, YA, TA = Axis(-300e3, 50e3, 14), Axis(-60e3, 45e3, 13), Knots(np.array([0.0, 3.0, 5.0, 11.0, 14.0]) * HOUR)
SHAPE = (TA.count, YA.count, XA.count)
GT, GY, GX = np.meshgrid(TA.places / HOUR / 9.0, YA.places / 250e3, XA.places / 200e3, indexing="ij")
NOISE = RNG.uniform(0.0, 0.2, (5, *SHAPE))
WAVES = GridField(XA, YA, TA, 3.0 + 2.0 * np.sin(GX + GT) * np.cos(GY) + NOISE[0], 0.5 + 0.5 * np.sin(GY) + NOISE[1],
                  np.cos(0.5 * GX - GT) + NOISE[2])  # fmt: skip
FLOW = GridCurrent(XA, YA, TA, np.sin(GX - GY) + NOISE[3], np.cos(GX + GT) + NOISE[4])
SAILS = ([0.0, 4.0, 9.0], [0.9, 1.4, 2.2, 2.9], [[0.0] * 4, [3.0, 5.0, 6.0, 4.0], [4.0, 7.0, 7.5, 6.0]])
MEDIA = {
    "storms that swirl": Medium(FlatMap(), SWIRL, JamesPolar()),
    "a linear speed": Medium(FlatMap(), LinearField(8.0, (1e-5, -4e-6)), ProportionalPolar(1.0, 0.7)),
    "a shear": Medium(FlatMap(), UniformField(3.0, 1.0), JamesPolar(), LinearCurrent((0.5, 0.0), ((0.0, 4e-6), (-2e-6, 0.0)))),
    "grids on a sphere": Medium(StereographicMap(), WAVES, JamesPolar(), FLOW),
    "one record": Medium(FlatMap(), replace(WAVES, t=Axis(0.0, 1.0, 1), height=WAVES.height[:1], cos_angle=WAVES.cos_angle[:1],
                                            sin_angle=WAVES.sin_angle[:1]), JamesPolar()),
    "a table over the waves": Medium(FlatMap(), WAVES, TablePolar([0.0, 3.0, 8.0], *SAILS[1:], ends="no-go")),
    "wind and waves": Medium(FlatMap(), SWIRL, WindWavePolar(Table(*SAILS, "no-go", level="winds"), Table(
        [0.0, 5.0], [0.0, math.pi], [[1.0, 1.0], [0.4, 0.8]], value="factors"), samples=90), wind=WAVES),
}  # fmt: skip


@pytest.mark.parametrize("name", MEDIA)
def test_no_sample_of_a_cell_exceeds_its_rate(name: str) -> None:
    medium = MEDIA[name]
    slabs = len(MESH.t) - 1
    for slab in range(slabs) if medium.smooth else (1,):  # tables take long
        possible = np.zeros((slabs, 7, 6), dtype=bool)
        possible[slab] = True
        rates = of_cells(medium, MESH, possible)
        assert rates is not None
        highest: np.ndarray = np.full((7, 6), -math.inf)
        for _ in range(60 if medium.smooth else 4):
            u, v = RNG.uniform(0.0, 1.0, (2, 7, 6))
            i, j = ROW[:-1, :-1] + u, COLUMN[:-1, :-1] + v
            x, y = SIDE * (0.8 * i - 0.6 * j), SIDE * (0.6 * i + 0.8 * j)
            known = medium.inside(x, y)
            now = medium.frozen(np.broadcast_to(RNG.uniform(*MESH.t[slab : slab + 2], (7, 6)), x.shape), x, y)
            for k in (0, 11, 26, 43, 58):
                # the hull of a table is itself taken between 72 directions, `Frozen.support`
                size = math.cos(math.pi / 72.0) if now.axes is None else 1.0
                h = np.where(known, size * now.support(math.cos(ANGLES[k]), math.sin(ANGLES[k])), -math.inf)
                assert np.all(h <= rates[k] * (1.0 + 1e-9))
                highest = np.maximum(highest, h / rates[k])
        assert np.median(highest[np.isfinite(highest)]) > 0.4  # and the bound is no idle one


def test_a_storm_that_passes_between_two_instants_is_in_the_range() -> None:
    fast = StormField(1.0, 8.0, (-400e3, 100e3), 60e3, (80.0, 0.0))
    found = of_sea(fast, MESH)
    assert found is not None
    for t in np.linspace(0.0, MESH.t[1], 40):
        height = fast.at(MESH.x, MESH.y, np.full(MESH.x.shape, t)).height
        assert np.all(height[1:, 1:] <= found.high[0]) and np.all(height[1:, 1:] >= found.low[0])


START, END = (0.0, 0.0), (1000.0 * MILE, 0.0)


def test_a_speed_that_is_linear_across() -> None:
    """Circles: T = acosh(1 + (g d)^2/(2 v1 v2))/g."""
    v, g = 6.0, 4e-6
    field = LinearField(v, (0.0, g))
    exact = math.acosh(1.0 + (g * END[0]) ** 2 / (2.0 * v * v)) / g
    found = lower_bound(Problem(Medium(FlatMap(), field, ProportionalPolar()), START, END), 1.001 * exact)
    assert 0.9 * exact < found <= exact


@pytest.mark.parametrize("current", [(0.0, 0.0), (1.0, 3.0), (-3.0, -2.0)])
def test_an_even_current(current: tuple[float, float]) -> None:
    u, w = current
    exact = END[0] / (u + math.sqrt(36.0 - w * w))
    medium = Medium(FlatMap(), UniformField(), ConstantPolar(6.0), LinearCurrent(current))
    assert 0.99 * exact < lower_bound(Problem(medium, START, END), 1.2 * exact) <= exact * (1.0 + 1e-12)


def test_a_calm_that_sails_with_the_ship() -> None:
    """Waves of 12 m everywhere but around a ship that sails at 19.3 kn: she is never in them, and nodes and instants hardly see
    it."""
    calm = StormField(12.0, -12.0, START, 100.0 * MILE, (19.3 * KNOT, 0.0))
    exact = 1000.0 / 19.3 * HOUR
    problem = Problem(Medium(FlatMap(), calm, JamesPolar()), START, END)
    for worse in (1.001, 1.5):
        assert lower_bound(problem, worse * exact) <= exact * (1.0 + 1e-6)  # 19.30 kn is the print of 19.299999...


def test_a_voyage_of_a_grid_and_a_field_of_another_make() -> None:
    storm = StormField(4 * FOOT, 30 * FOOT, (500 * MILE, -250 * MILE), 150 * MILE, (0.0, 8 * KNOT), 1.0)
    x, y, t = Axis(-300.0 * MILE, 60.0 * MILE, 28), Axis(-600.0 * MILE, 60.0 * MILE, 21), Axis(0.0, 6.0 * HOUR, 12)
    gt, gy, gx = np.meshgrid(t.places, y.places, x.places, indexing="ij")
    sea = storm.at(gx, gy, gt)
    problem = Problem(Medium(FlatMap(), GridField(x, y, t, sea.height, sea.kx, sea.ky), JamesPolar()), START, END)
    best = 59.7388 * HOUR  # of `plan`
    assert 0.9 * best < lower_bound(problem, best) < best

    class Mine(UniformField):
        pass

    class Other:
        inside, detail, horizon = UniformField.inside, math.inf, math.inf
        at, period, centres = UniformField.at, UniformField.period, UniformField.centres
        height, angle = 0.0, 0.0

    assert math.isfinite(lower_bound(Problem(Medium(FlatMap(), Mine(), JamesPolar()), START, END), 3e5))
    assert math.isnan(lower_bound(Problem(Medium(FlatMap(), Other(), JamesPolar()), START, END), 3e5))  # type: ignore[arg-type]
