"""Limits of what the sea may do along a route: kept by the search, measured on the answer, and refused with a reason."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import towage
from towage.errors import SceneError, TowageError
from towage.models.route import graph as route_graph
from towage.models.route import visibility
from towage.models.route.areas import Disc
from towage.models.route.fields import LinearCurrent, StormField, UniformField
from towage.models.route.limits import SPARE, Limit, error, kept
from towage.models.route.maps import FlatMap
from towage.models.route.medium import Medium
from towage.models.route.plan import plan
from towage.models.route.polar import KNOT, ConstantPolar
from towage.models.route.problem import Problem, RouteError
from towage.models.sea.heave_response import Hull, heave_moments
from towage.routing.file import load

MILE, HOUR = 1852.0, 3600.0
START, END = (0.0, 0.0), (1000.0 * MILE, 0.0)
V = 19.3 * KNOT


def height_limit(most: float) -> Limit:
    return Limit("deck", f"height {most:g} m", np.array([1.0, 99.0]), np.array([0.0, math.pi]), np.full((1, 2, 2), 1.0 / most))


STORM = StormField(0.0, 8.0, (500.0 * MILE, 20.0 * MILE), 100.0 * MILE)
DISC = Disc(*STORM.centre, 100.0 * MILE * math.sqrt(2.0 * math.log(2.0)))
"""Where the storm is higher than 4 m."""


def test_the_lattice_keeps_out_of_a_storm_that_stands_still() -> None:
    exact = visibility.shortest(Medium(FlatMap(), UniformField(), ConstantPolar(V)), START, END, (DISC,))
    medium = Medium(FlatMap(), STORM, ConstantPolar(V), limits=(height_limit(4.0),))
    path = route_graph.search(medium, START, END, cells=10, radius=2)
    assert path is not None and exact is not None
    fine = route_graph.refine(medium, path, levels=(24,), passes=8)
    (one,) = kept(medium, fine.times, *fine.points.T)
    assert exact.duration < fine.duration < 1.01 * exact.duration and 0.9 < one.use <= 1.0


@pytest.mark.slow
def test_a_limit_of_height_in_a_storm_that_stands_still_is_a_disc() -> None:
    field, disc, radius = STORM, DISC, DISC.radius
    exact = plan(Problem(Medium(FlatMap(), field, ConstantPolar(V)), START, END, (disc,))).best
    found = plan(Problem(Medium(FlatMap(), field, ConstantPolar(V), limits=(height_limit(4.0),)), START, END))
    assert exact.kind == "visibility" and found.best.kind == "corridor"
    assert exact.duration * (1.0 - 1e-6) < found.best.duration < exact.duration * (1.0 + 3e-4)  # of a corridor
    (one,) = found.limits
    assert 0.99 < one.use <= 1.0 and math.hypot(one.x - disc.x, one.y - disc.y) == pytest.approx(radius, rel=5e-3)
    assert any("the straight route breaks the limit 'deck'" in note for note in found.notes) and found.straight is None
    assert found.lower_bound <= found.best.duration


def head_seas(sector: float) -> Limit:
    headings = np.radians([0.0, 180.0 - sector, 180.0 - sector + 1e-6, 180.0])
    return Limit("slam", "head seas", np.array([1.0, 99.0]), headings, np.array([[[0.5, 0.5, 9.0, 9.0]] * 2]) / 3.0)


def test_courses_against_the_waves_are_forbidden() -> None:
    """No closer than 30 degrees to head sea: beating, D/(v cos 30)."""
    medium = Medium(FlatMap(), UniformField(3.0, 0.0), ConstantPolar(V), limits=(head_seas(30.0),))
    path = route_graph.search(medium, START, END, cells=20, radius=2)
    assert path is not None
    fine = route_graph.refine(medium, path, levels=(24,), passes=8)
    exact = END[0] / (V * math.cos(math.radians(30.0)))
    assert exact < fine.duration < 1.25 * exact  # legs of the lattice at 45 degrees take 1.22
    assert kept(medium, fine.times, *fine.points.T)[0].use == pytest.approx(0.5)
    assert error(medium) == 1e-2
    # the course through the water counts: a current from the side turns her off the waves
    current = LinearCurrent((0.0, 0.6 * V))
    drifting = Medium(FlatMap(), UniformField(3.0, 0.0), ConstantPolar(V), current, limits=(head_seas(30.0),))
    one = np.ones(1)
    assert drifting.uses(one, one, one, one, 0.0 * one)[0][0] == pytest.approx(0.5)
    assert medium.uses(one, one, one, one, 0.0 * one)[0][0] == pytest.approx(9.0)


def test_the_use_between_and_beyond_the_entries() -> None:
    table = Limit("line", "tension", np.array([5.0, 10.0]), np.array([0.0, math.pi]),
                  np.array([[[0.2, 0.4], [0.3, 0.5]], [[0.6, 0.8], [0.7, 0.9]]]), np.array([1.0, 3.0]))  # fmt: skip
    one = np.ones(1)
    assert table.of(2.0 * one, 7.5 * one, 0.5 * math.pi * one)[0] == pytest.approx(0.55)
    assert math.isinf(table.of(3.1 * one, 7.5 * one, one)[0])
    assert table.of(0.5 * one, 2.0 * one, 0.0 * one)[0] == pytest.approx(0.2)
    assert table.beyond(0.5 * one, 7.5 * one)[0] and not table.beyond(2.0 * one, 7.5 * one)[0]


def test_no_way_within_the_limits_says_where_and_what_to_try() -> None:
    medium = Medium(FlatMap(), UniformField(5.0, 0.0), ConstantPolar(V), limits=(height_limit(4.0),))
    message = r"'deck' \(height 4 m\) is exceeded by 25% at \(0, 0\) m after 0.00 h.*leave later"
    with pytest.raises(RouteError, match=message) as caught:
        plan(Problem(medium, START, END), cells=8, radius=2)
    assert caught.value.reason == "unreachable"


# ---- route files ----------------------------------------------------------------------------------------------------------

ROUTE = (
    '[route]\nstart = [0, 0]\nend = ["300 nmi", "0 nmi"]\n[ship]\nspeed = "10 kn"\n[sea]\nkind = "uniform"\nheight = "3 m"\n'
    'wave_angle = "90 deg"\n[[limits]]\nname = "cage"\n'
)  # fmt: skip
HULL = 'hull = { length = "100 m", breadth = "20 m", draught = "6 m", block_coefficient = 0.8 }\nspeed = "5 m/s"\n'


def limits_of(folder: Path, text: str) -> tuple[Limit, ...]:
    (folder / "r.toml").write_text(ROUTE + text, "utf-8")
    return load(folder / "r.toml").problem.medium.limits


def test_heave_by_the_closed_form(tmp_path: Path) -> None:
    (limit,) = limits_of(tmp_path, HULL + 'motion = "heave"\nstatistic = "most probable maximum"\nlimit = "2 m"\n')
    period, beta = 9.3, math.radians(137.0)
    m0, m2 = heave_moments(1.0, 2.0 * math.pi / period, 5.0, beta, Hull(100.0, 16.0, 6.0), powers=(0, 2))
    exact = math.sqrt(2.0 * m0 * math.log(3.0 * HOUR / (2.0 * math.pi) * math.sqrt(m2 / m0))) / 2.0
    found = limit.of(np.array([1.0]), np.array([period]), np.array([beta]))
    assert found[0] == pytest.approx(exact, rel=2e-2)  # lines between 40 periods and 13 headings
    (half,) = limits_of(tmp_path, HULL + 'motion = "heave"\nstatistic = "significant amplitude"\nlimit = "2 m"\n')
    k = 20
    m0 = heave_moments(1.0, 2.0 * math.pi / float(half.periods[k]), 5.0, math.pi, Hull(100.0, 16.0, 6.0), powers=(0,))[0]
    assert half.use[0, k, -1] == pytest.approx(math.sqrt(m0), rel=5e-3)  # 2 s over 2 m; the components leave out 0.5 % of energy


def test_a_table_of_tensions_and_a_curve_of_heights(tmp_path: Path) -> None:
    rows = [(h, t, d, 100.0 + 50.0 * h * (1.0 if d else 0.5)) for h in (1, 3, 5) for t in (6, 12) for d in (0, 90, 180)]
    (tmp_path / "t.csv").write_text("wave_height [m],wave_period [s],direction [deg],tension [kN]\n"
                                    + "".join(",".join(map(str, row)) + "\n" for row in rows), "utf-8")  # fmt: skip
    head = "wave_period [s],direction [deg],wave_height [m]\n"
    (tmp_path / "h.csv").write_text(head + "6,0,2\n12,0,2\n6,180,4\n12,180,4\n", "utf-8")
    said = 'table = "t.csv"\nvalue = "tension"\nlimit = "400 kN"\ndirection = "from"\n'
    (limit, curve) = limits_of(tmp_path, said + '[[limits]]\nheights = "h.csv"\ndirection = "to"\n')
    one = np.ones(1)
    assert limit.of(3.0 * one, 8.0 * one, math.pi * one)[0] == pytest.approx(175.0 / 400.0)  # 0 deg is a head sea
    assert curve.of(3.0 * one, 8.0 * one, 0.0 * one)[0] == pytest.approx(1.5)
    assert curve.name == "limits[1]"
    (tmp_path / "r.toml").write_text(ROUTE + said, "utf-8")
    found = towage.route(tmp_path / "r.toml", cells=8, radius=2)
    assert found.plan.limits[0].use == pytest.approx(250.0 / 400.0)
    assert "limit 'cage', tension 400 kN: margin 0.375" in found.text()
    assert found.document()["limits"][0]["margin"] == pytest.approx(0.375)
    (tmp_path / "r.toml").write_text(ROUTE + said.replace("400 kN", "200 kN"), "utf-8")
    with pytest.raises(TowageError, match="no route within the limits: on the straight way 'cage'"):
        towage.route(tmp_path / "r.toml", cells=8, radius=2)


@pytest.mark.parametrize(("text", "message"), [
    ("", "expected one of table, heights, responses, hull; got none"),
    ('heights = "n.csv"\n', "limits.0..direction: expected one of: to, from"),
    ('heights = "n.csv"\ndirection = "to"\n', "n.csv: No such file"),
    ('heights = "b.csv"\ndirection = "to"\n', "b.csv: directions from 0 to 90 deg"),
    ('table = "b.csv"\nvalue = "tension"\ndirection = "to"\nlimit = 1\n', "no column 'tension': there are wave_period"),
    ('heights = "b.csv"\ndirection = "to"\nmotion = "z"\n', "motion: does not go with heights"),
    (HULL + 'motion = "roll"\nlimit = "5 deg"\nstatistic = "significant amplitude"\n', "closed form knows heave, pitch and z"),
    (HULL + 'motion = "z"\nlimit = "5 m"\nstatistic = "mean"\n', "statistic: expected one of"),
    (HULL + 'motion = "z"\nlimit = "5 kg"\nstatistic = "significant amplitude"\n', "limits.0..limit"),
    (HULL.replace("draught", "draft"), "did you mean 'draught'|limit: this value is missing|unknown key"),
])  # fmt: skip
def test_limits_that_cannot_be_meant(text: str, message: str, tmp_path: Path) -> None:
    (tmp_path / "b.csv").write_text("wave_period [s],direction [deg],wave_height [m]\n6,0,2\n6,90,2\n", "utf-8")
    with pytest.raises(SceneError, match=message):
        limits_of(tmp_path, text)


@pytest.mark.slow
def test_beating_off_the_waves_is_as_good_as_said() -> None:
    medium = Medium(FlatMap(), UniformField(3.0, 0.0), ConstantPolar(V), limits=(head_seas(30.0),))
    found = plan(Problem(medium, START, END)).best
    exact = END[0] / (V * math.cos(math.radians(30.0)))
    assert exact < found.duration < exact + found.error and found.error == pytest.approx(1e-2 * found.duration)


def test_what_is_spared_is_small() -> None:
    assert 0.0 < SPARE <= 1e-3
