"""Exported scenes in libcosim, whose fixed-step algorithm is our ``jacobi``.

libcosim runs in a process of its own, because a crash there would end the tests. It reads what ``towage export`` wrote and
nothing else: values, connections and the step come from the files.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType

import msgspec
import numpy as np
import pytest

from tests.hosts.jobs import HOSTS, ours, short, system_job
from towage.fmus.describe import archive as archive_writer
from towage.scene.flavour import Flavour, resolve
from towage.scene.scene import Scene, available_scenes
from towage.units.store import locator

LIBCOSIM = next(host for host in HOSTS if host.name == "libcosim")
if LIBCOSIM.missing():
    pytest.skip(LIBCOSIM.missing(), allow_module_level=True)

ROUND_OFF = 1e-12
"""Relative to a variable's largest value: both engines do the same operations, only times differ by a rounding."""
AMPLIFIED = {"slender_speed_ramp": 1e-11, "tow_two_units": 1e-11}
"""Where that rounding grows: in a growth rate, an eigenvalue found anew as the speed changes (5.6e-13), and in the force between
a cable and its body, Python flavour (1.2e-12)."""
RESTLESS = {"tow_heavy_weather": 3.0}
"""A wire whose end jumps in velocity at every step iterates another number of times where times differ by a rounding: the other
engine may be off by so many times what a step that is longer by 1e-15 changes in our own run, which is one sample of that (found:
1.0 to 1.12 times)."""
NONE: Mapping[str, float] = MappingProxyType({})
STEPS = 40
LONG = 100
STEADY = {"tow_two_units": 0.02, "voyage_tow": 0.05}
"""Steps, s, at which an order is seen: at 0.25 s of voyage_tow the energy that held inputs make soon rules; at 0.05 s
the stiff cable between two units has not come to its first order yet."""
SCENES = [scene.name for scene in available_scenes()]


def returns(name: str) -> bool:
    """Whether something comes back; where motions or forces are prescribed alone, what is sent has no error."""
    ends = [[end.split(".")[0] for end in text.split(" -> ")] for text in Scene.load(name).connections]
    return bool({source for source, _ in ends} & {target for _, target in ends})


COUPLED = [name for name in SCENES if returns(name)]


def test_jacobi_equals_libcosim_osp(tmp_path: Path) -> None:
    """Ship, line and cradle coupled both ways, their ports as group connections."""
    compare("sea_cliff", STEPS, "python", "osp", tmp_path)


def test_jacobi_equals_libcosim_ssp(tmp_path: Path) -> None:
    """From an archive, with the step in its annotation."""
    compare("slender_stable", STEPS, "python", "ssp", tmp_path)


def test_jacobi_equals_libcosim_native(tmp_path: Path) -> None:
    """FMUs without Python."""
    pytest.importorskip("casadi")
    compare("sea_cliff", STEPS, "native", "osp", tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize(("flavour", "kind"), [("python", "osp"), ("python", "ssp"), ("native", "osp")])
@pytest.mark.parametrize("name", SCENES)
def test_jacobi_equals_libcosim_everywhere(name: str, flavour: Flavour, kind: str, tmp_path: Path) -> None:
    """Every shipped scene; units that have no native flavour run in Python."""
    if flavour == "native":
        pytest.importorskip("casadi")
    compare(name, LONG, flavour, kind, tmp_path)


@pytest.mark.parametrize("kind", ["osp", "ssp"])
def test_converted_connections(kind: str, tmp_path: Path) -> None:
    """A ship whose heave is in feet, on a line in metres: both engines multiply by 0.3048, in the same step."""
    scene = short("sea_cliff", STEPS)
    ship = tmp_path / "ship.fmu"
    members = archive_writer.read(locator()("ship"))
    in_metres = (
        b'causality="output" variability="continuous" initial="calculated">\n      <Real unit="m" displayUnit="ft" />'
    )
    text = members["modelDescription.xml"]
    assert in_metres in text and b'<Unit name="m">' in text
    text = text.replace(in_metres, in_metres.replace(b'unit="m" displayUnit="ft"', b'unit="ft"'))
    foot = b'<Unit name="ft"><BaseUnit m="1" factor="0.3048" /></Unit>'
    members["modelDescription.xml"] = text.replace(b"<UnitDefinitions>", b"<UnitDefinitions>" + foot)
    archive_writer.write(ship, members)
    units = {**scene.units, "ship": msgspec.structs.replace(scene.units["ship"], fmu=str(ship))}
    scene = msgspec.structs.replace(scene, units=units)
    assert resolve(scene, flavour="python").connections[0].factor == 0.3048
    metres = ours(short("sea_cliff", STEPS), "jacobi", "python")
    assert np.max(np.abs(ours(scene, "jacobi", "python")["line.tension"] - metres["line.tension"])) > 1.0  # N
    equal(scene, "python", kind, tmp_path / "exported", ROUND_OFF)


def test_libcosim_has_the_first_order_error_of_held_inputs(tmp_path: Path) -> None:
    """Against the scene's own scheme, at the scene's own step."""
    share = first_order("sea_cliff", 60, tmp_path)
    assert all(1.7 < value < 2.3 for value in share.values()), share  # found: 1.87 to 1.97; 2 in the limit


@pytest.mark.slow
@pytest.mark.parametrize("name", COUPLED)
def test_libcosim_has_the_first_order_error_everywhere(name: str, tmp_path: Path) -> None:
    share = first_order(name, LONG, tmp_path)
    assert all(1.2 < value < 3.0 for value in share.values()), share  # 2, and what the second order adds at these steps


def first_order(name: str, steps: int, directory: Path) -> dict[str, float]:
    """What libcosim is off, over what half the step changes, for the signals of the scene's connections.

    An error C H + D H^2 changes by C H / 2 + 3 D H^2 / 4 when the step is halved: the share is 2 where the first order
    rules, and 4/3 where the second does."""
    scene = short(name, steps, STEADY.get(name))
    exact, half = ours(scene, scene.coupling.scheme, "auto"), ours(scene, "jacobi", "auto", share=0.5)
    found = {}
    for signal, values in libcosim(scene, "auto", "osp", directory).items():
        change = float(np.max(np.abs(values - half[signal][1:])))
        error = float(np.max(np.abs(values - exact[signal][1:])))
        connected = any(text.startswith(f"{signal} ->") for text in scene.connections)
        if connected and error > 1e-9 * float(np.max(np.abs(exact[signal]))):  # prescribed motions have none
            found[signal] = error / change
    assert found
    return found


def compare(name: str, steps: int, flavour: Flavour, kind: str, directory: Path) -> None:
    """The first steps of a shipped scene."""
    scene, noise = short(name, steps), {}
    if name in RESTLESS:
        longer = short(name, steps, (scene.coupling.step or 0.0) * (1.0 + 1e-15))
        one, other = (ours(each, "jacobi", flavour) for each in (scene, longer))
        noise = {k: RESTLESS[name] * float(np.max(np.abs(one[k] - other[k]))) for k in one.columns}
        assert noise["ship.heave"] > 0.0
    equal(scene, flavour, kind, directory, AMPLIFIED.get(name, ROUND_OFF), noise)


def equal(
    scene: Scene, flavour: Flavour, kind: str, directory: Path, tolerance: float, noise: Mapping[str, float] = NONE
) -> None:
    """Every output of every unit, at every step, to ``tolerance`` of its largest value and its own ``noise``."""
    result, theirs = ours(scene, "jacobi", flavour), libcosim(scene, flavour, kind, directory)
    assert theirs
    for name, values in theirs.items():
        expected = result[name][1:]
        assert len(values) == len(expected)
        assert np.max(np.abs(values - expected)) <= tolerance * np.max(np.abs(expected)) + noise.get(name, 0.0), name


def libcosim(scene: Scene, flavour: Flavour, kind: str, directory: Path) -> dict[str, np.ndarray]:
    """All Real outputs at the end of every step."""
    directory.mkdir(exist_ok=True)
    return LIBCOSIM.run(system_job(scene, flavour, directory, kind))[1]
