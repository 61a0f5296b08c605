"""Other hosts, each with one scene or unit, and the tables of docs/hosts.md, which `tests.hosts.table` makes with all."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from tests.hosts import table
from tests.hosts.jobs import HOSTS, Host, difference, ours, short, system_job
from towage.fmus import UNITS
from towage.scene.scene import available_scenes

ROUND_OFF = 1e-12
"""Relative to a variable's largest value: a host does the same operations, at times that differ by a rounding."""
STEPS = 40
ZERO_INPUTS = "fmpy SSP"
"""Starts every connected input at zero, so that its first step is another one."""


@pytest.mark.slow
@pytest.mark.parametrize("host", [pytest.param(host, id=host.name) for host in HOSTS])
def test_host_agrees(host: Host, tmp_path: Path) -> None:
    """sea_cliff, coupled as our `jacobi` does it or with errors of order 1; or the reference run of the ship."""
    if host.missing():
        pytest.skip(host.missing())
    if host.takes == "unit":
        cells = dict(table.unit_cells("ship", table.Tried({host.name: ""}, {})))
        assert len(cells) == 2 and all(cell.get("difference", 1.0) < ROUND_OFF for cell in cells.values()), cells
        return
    if host.first_order:
        coarse, fine = error(host, 1, tmp_path), error(host, 2, tmp_path)
        shares = {
            name: coarse[name] / fine[name]
            for name in ("ship.heave", "line.tension", "cradle.heave", "cradle.velocity")
        }
        assert all(1.8 < share < 2.2 for share in shares.values()), shares  # found: 1.95 to 2.03; 2 in the limit
        return
    scene = short("sea_cliff", STEPS)
    result = ours(scene, "jacobi", "native")
    job = system_job(scene, "native", tmp_path, at_start=result)
    version, theirs = host.run(job)
    compared = {name: values for name, values in theirs.items() if not (host.own_order and name in job["direct"])}
    assert version and len(theirs) == len(job["watch"]) and {"ship.heave", "cradle.heave"} <= set(compared)
    share, name = difference(compared, {name: result[name][1:] for name in compared})
    assert share > 1.0 if host.name == ZERO_INPUTS else share < ROUND_OFF, name


def error(host: Host, parts: int, directory: Path) -> dict[str, float]:
    """What a host is off the scene's own scheme in the first steps of sea_cliff, with a ``parts``-th of the step."""
    scene = short("sea_cliff", STEPS * parts, (short("sea_cliff", 1).coupling.step or 0.0) / parts)
    exact = ours(scene, scene.coupling.scheme, "native")
    theirs = host.run(system_job(scene, "native", directory / str(parts)))[1]
    return {
        name: float(np.max(np.abs(values - exact[name][1:])[parts - 1 :: parts])) for name, values in theirs.items()
    }


@pytest.mark.slow
def test_ecos_without_the_parameter_set_is_another_scene(tmp_path: Path) -> None:
    """So the name that all sets share is what brings the values to the units."""
    host = next(host for host in HOSTS if host.name == "Ecos")
    if host.missing():
        pytest.skip(host.missing())
    job = system_job(short("sea_cliff", STEPS), "native", tmp_path)
    with_set, without = host.run(job)[1], host.run(job | {"parameter_set": None})[1]
    weight = job["units"]["cradle"]["start"]["weight_in_water"]
    assert abs(with_set["line.tension"][0] / weight - 1.0) < 1e-3 and without["line.tension"][0] < 0.1 * weight


def test_tables_are_those_of_what_is_kept() -> None:
    kept = json.loads(table.KEPT.read_text("utf-8"))
    assert table.page(kept) in table.PAGE.read_text("utf-8"), "python -m tests.hosts.table --page"
    assert list(kept["scenes"]) == [scene.name for scene in available_scenes()] and list(kept["units"]) == list(UNITS)
    cells = [cell for kind in ("scenes", "units") for row in kept[kind].values() for cell in row.values()]
    assert all(cell["reason"] if "reason" in cell else cell["difference"] >= 0.0 for cell in cells)
    assert list(kept["hosts"]) == [host.name for host in HOSTS]
    assert all(bool(entry["version"]) != bool(entry["reason"]) for entry in kept["hosts"].values())


def test_difference_sees_what_is_no_number_and_what_is_short() -> None:
    same = {"a": np.array([1.0, 2.0])}
    assert difference(same, same) == (0.0, "")
    broken = {"a": np.array([1.0, float("nan")]), "b": np.array([1.0])}
    share, name = difference(broken, same | {"b": np.array([2.0])})
    assert share != share and name == "a"
    with pytest.raises(AssertionError, match="1 values in place of 2"):
        difference({"a": np.array([1.0])}, same)
