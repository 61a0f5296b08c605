"""Polar diagrams: recovered constants, derivatives, hulls and tacking."""

from __future__ import annotations

import math

import numpy as np
import pytest

from towage.models.numeric.ops import FLOATS, arrays
from towage.models.route.hulls import TablePolar
from towage.models.route.polar import FOOT, JAMES_LIMIT, KNOT, JamesPolar, follow_beam_head

NOTCH_ANGLES = np.linspace(0.0, math.pi, 2881)
NOTCH = TablePolar([0.0], NOTCH_ANGLES.tolist(), [(KNOT * 18.0 * (1 - 0.75 * np.exp(-((NOTCH_ANGLES / 0.35) ** 2)))).tolist()])


@pytest.mark.parametrize(
    ("feet", "follow", "beam", "head"),
    [(0, 19.30, 19.30, 19.30), (10, 19.049, 18.537, 18.007), (20, 17.460, 15.499, 13.679), (30, 15.721, 12.114, 9.163),
     (40, 13.952, 8.205, 4.631)],
)  # fmt: skip
def test_published_speeds(feet: float, follow: float, beam: float, head: float) -> None:
    values = [v / KNOT for v in follow_beam_head(JamesPolar(), feet * FOOT, FLOATS)]
    assert values == pytest.approx([follow, beam, head], abs=6e-4)  # printed to a thousandth


def test_largest_speed_is_reached_in_low_following_seas() -> None:
    speeds = [follow_beam_head(JamesPolar(), 0.001 * k * FOOT, FLOATS)[0] / KNOT for k in range(3000, 5500)]
    assert max(speeds) == pytest.approx(19.58864030, abs=1e-7)
    assert 3.0 + 0.001 * int(np.argmax(speeds)) == pytest.approx(4.127, abs=1e-3)


@pytest.mark.parametrize("feet", [0.5, 5.0, 20.0, 47.0])
def test_derivatives_are_those_of_the_axes(feet: float) -> None:
    h, d = feet * FOOT, 1e-5
    up, down = JamesPolar().axes(h + d, FLOATS), JamesPolar().axes(h - d, FLOATS)
    numerical = [(a - b) / (2.0 * d) for a, b in zip(up[:3], down[:3])]
    assert JamesPolar().axes(h, FLOATS)[3:] == pytest.approx(numerical, abs=1e-8)  # rounding over the step


def test_beyond_its_range_the_polar_is_held_and_says_so() -> None:
    held, edge = JamesPolar().axes(1.2 * JAMES_LIMIT, FLOATS), JamesPolar().axes(JAMES_LIMIT, FLOATS)
    assert held[:3] == edge[:3] and held[3:] == (0.0, 0.0, 0.0)
    assert JamesPolar().beyond(1.2 * JAMES_LIMIT) and not JamesPolar().beyond(0.9 * JAMES_LIMIT)
    free = JamesPolar(limit=1e9).axes(51.0 * FOOT, FLOATS)
    assert free[0] < free[2]  # the head speed a - c is negative above 50.2 ft


def test_floats_and_arrays_agree() -> None:
    heights = np.array([0.0, 3.0, 9.0, 20.0])
    batch = JamesPolar().axes(heights, arrays())
    assert [[float(v[k]) for v in batch] for k in range(4)] == [list(JamesPolar().axes(h, FLOATS)) for h in heights.tolist()]


def test_a_notch_is_closed_by_tacking_at_the_published_angle() -> None:
    found = NOTCH.tack(0.0, 0.0)
    assert found is not None
    # 7200 samples: the chord ends on a multiple of 0.05 degrees
    assert [math.degrees(a) for a in found] == pytest.approx([-31.4708, 31.4708], abs=0.03)
    zero = np.zeros(1)
    # 100 nm upwind; the chord between samples is short of the true one by the square of their distance
    assert 100.0 * KNOT / float(NOTCH.speed_along(zero, zero)[0]) == pytest.approx(6.958276591, rel=2e-6)
    assert 100.0 * KNOT / float(NOTCH.own_speed(zero, zero)[0]) == pytest.approx(22.222222, rel=1e-6)


def test_no_tack_where_the_polar_is_convex() -> None:
    assert NOTCH.tack(0.0, math.pi) is None
    assert NOTCH.tack(0.0, 1.0) is None
    theta = np.array([1.0, 2.0, math.pi - 1e-9])
    assert NOTCH.speed_along(0.0 * theta, theta) == pytest.approx(NOTCH.own_speed(0.0 * theta, theta), rel=1e-6)


def test_a_table_of_the_ellipse_gives_its_speeds() -> None:
    heights = [0.0, 3.0, 6.0]
    angles = np.linspace(0.0, math.pi, 181)
    rows = []
    for h in heights:
        a, b, c = JamesPolar().axes(h, FLOATS)[:3]
        q = (np.cos(angles) / a) ** 2 + (np.sin(angles) / b) ** 2
        e = np.cos(angles) * c / a**2
        rows.append(((-e + np.sqrt(e * e - q * ((c / a) ** 2 - 1.0))) / q).tolist())
    table = TablePolar(heights, angles.tolist(), rows)
    assert table.speed_along(np.array([3.0]), np.array([0.0]))[0] == pytest.approx(rows[1][0], rel=1e-6)
    assert table.speed_along(np.array([4.5]), np.array([0.5]))[0] == pytest.approx(
        0.5 * (np.interp(0.5, angles, rows[1]) + np.interp(0.5, angles, rows[2])), rel=1e-4
    )  # the samples lie off the angles of the table
    assert table.beyond(np.array([5.0, 7.0])).tolist() == [False, True]


@pytest.mark.parametrize(
    ("heights", "angles", "speeds", "message"),
    [
        ([0.0], [0.0, 1.0], [[1.0]], "shape"),
        ([0.0], [1.0, 0.5], [[1.0, 1.0]], "ascend"),
        ([1.0, 0.0], [0.0, 1.0], [[1.0, 1.0]] * 2, "heights"),
        ([0.0], [0.0, 4.0], [[1.0, 1.0]], "angles"),
        ([0.0], [0.0, 1.0], [[1.0, -1.0]], "negative"),
        ([0.0], [0.0, 1.0], [[1.0, math.nan]], "finite"),
    ],
)
def test_bad_tables_are_refused(heights: list[float], angles: list[float], speeds: list[list[float]], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        TablePolar(heights, angles, speeds)
