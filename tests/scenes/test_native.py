"""Scenes with native units: the verdicts of the Python ones, and the same numbers."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest
from msgspec.structs import replace

from towage.errors import FmuError
from towage.fmus.declare import unit as declared
from towage.fmus.python.build import build
from towage.master.master import Master
from towage.scene import flavour
from towage.scene.flavour import FLAVOURS, Flavour, resolve
from towage.scene.scene import Scene, available_scenes
from towage.units.description import Description
from towage.units.fmu import Unit, UnitFactory
from towage.units.store import native_place
from towage.units.wiring import Wanted

pytest.importorskip("casadi")
if not shutil.which("cc"):
    pytest.skip("needs a C compiler", allow_module_level=True)

EXACT = 1e-9
"""Both flavours take the same steps with the same arithmetic but for the order of a few sums: some 1e-15 of a cradle, 1e-11
of a cable whose matrices are conditioned like 1e5."""
CHAOTIC = {"alvin": (40.0, 1e-5)}
"""s; a chaotic scene is compared up to here only, and to ten times the tolerance of its error control,
which makes other steps of other roundings: 1e-6 of the acceleration by then, the whole of the motion at 300 s."""
QUICK = {"docking": "plastic capture", "sea_cliff": "8 s wave", "slack": None, "stiff_line": None}
CASES = [
    *QUICK.items(),
    *(pytest.param(scene.name, case, marks=pytest.mark.slow)
      for scene in available_scenes() if scene.name not in QUICK
      for case in [c.name for c in Scene.load(scene.name).cases][:2] or [None]),
]  # fmt: skip


def prepared(name: str, case: str | None, chosen: Flavour, make_unit: UnitFactory = Unit) -> Master:
    scene = Scene.load(name)
    return Master(replace(scene, coupling=replace(scene.coupling, error_estimate=False)), case, None, chosen, make_unit)


def apart(master: Master) -> float:
    """By how much the flavours may differ, relative to the largest value: units that reduce their model do so on their
    own, each to within their tolerance of the same gains."""
    tolerances = [
        2.0 * float(unit.parameters.get("tolerance", variables["tolerance"].start or 0.0))
        for unit in master.resolved.units.values() if "reduced" in (variables := unit.description.by_name())
    ]  # fmt: skip
    return max([EXACT, *tolerances])


@pytest.mark.parametrize(("name", "case"), CASES)
def test_verdict_and_values_are_those_of_python_units(name: str, case: str | None) -> None:
    masters = [prepared(name, case, chosen) for chosen in FLAVOURS[1:]]
    python, native = (master.run() for master in masters)
    assert set(python.flavours.values()) == {"python"}
    assert "native" in native.flavours.values()
    assert (native.status, native.verdict.word) == (python.status, python.verdict.word)
    end, limit = CHAOTIC.get(name, (np.inf, apart(masters[0])))
    ours, theirs = ([(e.unit, e.name, e.direction) for e in r.events if e.time < end] for r in (native, python))
    assert ours == theirs
    compared = python.time < end
    differences: dict[tuple[str, str], list[tuple[float, float]]] = {}
    for column, values in python.columns.items():
        if "margin" not in column:
            pair = float(np.max(np.abs(native[column] - values)[compared])), float(np.max(np.abs(values)))
            differences.setdefault((column.partition(".")[0], python.units[column]), []).append(pair)
    for quantity, pairs in differences.items():  # surge and heave of a cable are parts of one vector
        difference, scale = map(max, zip(*pairs))
        assert difference <= limit * scale, quantity


def test_derivatives_by_function_equal_derivatives_by_variable() -> None:
    made = []

    def make(name: str, description: Description, directory: Path, wanted: Wanted) -> Unit:
        made.append(Unit(name, description, directory, wanted._replace(by_function=True)))
        return made[-1]

    by_variable = prepared("sea_cliff", "8 s wave", "native").run()
    by_function = prepared("sea_cliff", "8 s wave", "native", make).run()
    assert len(made) == 6  # three units, coupled and one way
    for name, values in by_variable.columns.items():
        assert by_function[name].tobytes() == values.tobytes(), name


# ---- which FMU ------------------------------------------------------------------------------------------------------

SCENE = Scene.from_dict({"title": "Ship", "stop_time": 1.0, "units": {"ship": {"fmu": "ship"}}, "coupling": {"step": 0.1}})


def used(fmus: Path | None, chosen: Flavour) -> str:
    return resolve(SCENE, fmus, chosen).units["ship"].flavour


@pytest.fixture
def own_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty cache."""
    monkeypatch.setenv("TOWAGE_CACHE", str(tmp_path / "cache"))
    return tmp_path


def test_auto_takes_what_is_there(own_cache: Path) -> None:
    assert used(None, "auto") == "python"
    said: list[str] = []
    native = resolve(SCENE, None, "native", said.append).units["ship"]
    assert said == ["building native ship"]
    assert native.flavour == "native"
    assert native.path == native_place("ship", {})
    assert used(None, "auto") == "native"
    assert used(None, "python") == "python"
    # in a directory the native one stands beside the Python one
    dist = own_cache / "dist"
    build("ship", dist)
    (dist / "native").mkdir()
    shutil.copy(native.path, dist / "native" / "ship.fmu")
    shutil.rmtree(own_cache / "cache" / "native")
    beside = resolve(SCENE, dist, "auto").units["ship"]
    assert (beside.flavour, beside.path) == ("native", dist / "native" / "ship.fmu")
    assert used(dist, "python") == "python"


def test_native_without_means_is_refused_with_the_remedy(own_cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.setenv("PATH", "")
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None if name == "ziglang" else object())
    with pytest.raises(FmuError, match=r"native ship cannot be built: no C compiler.*take the flavour python"):
        used(None, "native")
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(FmuError, match=r"takes CasADi: pip install 'towage\[native\]'"):
        used(None, "native")


def test_a_unit_without_native_flavour_runs_in_python(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(declared.Unit, "not_native", property(lambda unit: "it is not traced" if unit.name == "wire" else ""))
    resolved = resolve(replace(Scene.load("tow_heavy_weather"), cases=()), None, "native")
    assert {name: unit.flavour for name, unit in resolved.units.items()} == {"ship": "native", "tow": "python"}


def test_structure_follows_the_values(monkeypatch: pytest.MonkeyPatch) -> None:
    """Cases that need other sizes get other FMUs; 0 segments are as many as the tolerance needs."""
    built: list[dict[str, float]] = []

    def note(shipped: str, directory: Path, structure: dict[str, float]) -> Path:
        built.append(dict(structure))
        raise FmuError("noted")

    monkeypatch.setattr(flavour, "_build", note)
    monkeypatch.setattr(flavour, "native_place", lambda *_: Path("no/such/place/tow_system.fmu"))
    scene = Scene.load("tow_report_sample")
    scene = replace(scene, connections=(), cases=(), checks=scene.checks.without("sdof"))
    fixed = scene.units["tow"].parameters | {"segments": 7.0, "extensible": 0.0}
    for parameters in (scene.units["tow"].parameters, fixed):
        units = {"tow": replace(scene.units["tow"], parameters=parameters)}
        with pytest.raises(FmuError, match="noted"):
            resolve(replace(scene, units=units), None, "native")
    assert built[1] == {"segments": 7.0, "extensible": 0.0, "grading": 1.0}
    assert built[0]["segments"] >= 6.0
