"""What ``towage export`` writes comes back as a scene that gives the same numbers, to the bit."""

from __future__ import annotations

from pathlib import Path

import msgspec
import numpy as np
import pytest

from tests.systems.write import DEFINED
from tests.zoo.zoo import animal
from towage.errors import SceneError
from towage.export.export import prepare
from towage.export.osp import write_osp
from towage.export.ssp import write_ssp
from towage.master.master import run_resolved
from towage.scene.flavour import resolve
from towage.scene.scene import Checks, Coupling, Record, Scene, available_scenes

STEPS = 20
KINDS = ("ssp", "osp")
LOOSE_STEP = 0.1
"""Step, s, of scenes that leave theirs to the error control."""


def round_trip(name: str, kind: str, folder: Path) -> None:
    scene = Scene.load(name)
    step = scene.coupling.step or LOOSE_STEP
    coupling = Coupling(scene.coupling.scheme, step, error_estimate=False)
    scene = msgspec.structs.replace(
        scene, coupling=coupling, stop_time=STEPS * step, record=Record(interval=step), checks=Checks(), cases=()
    )
    resolved = resolve(scene, flavour="python")
    export = prepare(resolved)
    path = folder / "scene.ssp" if kind == "ssp" else folder / "system"
    write_ssp(export, path) if kind == "ssp" else write_osp(export, path)
    back = Scene.load(path)
    assert back.coupling.step == export.step
    assert [note.text for note in back.notes if note.level == "warning" and note.key != "coupling.scheme"] == []
    coupling = {"coupling.scheme": scene.coupling.scheme, "coupling.step": step, "stop_time": scene.stop_time}
    back = back.with_values({**coupling, "coupling.error_estimate": False, "record.interval": step})
    one, other = run_resolved(resolved), run_resolved(resolve(back))
    assert one.status == other.status == "done"
    assert one.columns.keys() == other.columns.keys()
    assert all(np.array_equal(one[column], other[column]) for column in one.columns)


@pytest.mark.parametrize(("name", "kind"), [("sea_cliff", "ssp"), ("sea_cliff", "osp"), ("slender_stable", "ssp")])
def test_round_trip(name: str, kind: str, tmp_path: Path) -> None:
    round_trip(name, kind, tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("name", [scene.name for scene in available_scenes()])
@pytest.mark.parametrize("kind", KINDS)
def test_round_trip_of_every_scene(name: str, kind: str, tmp_path: Path) -> None:
    round_trip(name, kind, tmp_path)


def test_transformations_come_back(tmp_path: Path) -> None:
    """Factors, tables, and numbers that are not converted; OSP has no tables."""
    ends = {"u": ' unit="m"', "y": ' unit="km"'}
    fmu = animal(tmp_path / "a.fmu", reals=ends, extra=DEFINED)
    entries = {
        "a": {"fmu": fmu, "inputs": {"u": 1.0, "n_in": 1, "b_in": True}},
        "b": {"fmu": fmu},
        "c": {"fmu": fmu, "inputs": {"n_in": 0}},
    }
    links = {
        "a.y -> b.u": {"factor": 2.0, "offset": 1.0}, "b.y -> c.u": {"convert": False}, "a.n -> b.n_in": {"values": {"2": 5}},
        "a.b -> b.b_in": {"values": {"true": False, "false": True}},
    }  # fmt: skip
    tables = {"title": "t", "stop_time": 2.0, "units": entries, "connections": list(links), "transformations": links}
    scene = Scene.from_dict({**tables, "coupling": {"step": 0.1, "error_estimate": False}})
    resolved = resolve(scene)
    write_ssp(prepare(resolved), tmp_path / "s.ssp")
    back = Scene.load(tmp_path / "s.ssp").with_values({"coupling.error_estimate": False})
    one, other = run_resolved(resolved), run_resolved(resolve(back))
    assert all(np.array_equal(one[column], other[column]) for column in one.columns)
    assert (one["b.n"][0], one["b.b"][0], one["b.w"][0]) == (10.0, 0.0, 1.0)
    assert one["b.y"][-1] == pytest.approx(2000.0 * 2.0 + 2.0, rel=1e-12)  # sums of 20 steps in double precision
    with pytest.raises(SceneError, match=r"transformations.a.n -> b.n_in: looks values up.*--ssp"):
        write_osp(prepare(resolved), tmp_path / "osp")
