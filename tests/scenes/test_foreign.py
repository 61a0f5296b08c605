"""A unit of another make, in C: the standard's functions for derivatives are used where there are no variables for them."""

from __future__ import annotations

import shutil
import subprocess
import zipfile
from pathlib import Path

import pytest

from towage.errors import RunError
from towage.master.schemes import EXTRAPOLATE
from towage.master.system import System
from towage.scene.flavour import resolve
from towage.scene.scene import Scene
from towage.units.binary import platform_name

DESCRIPTION = """<fmiModelDescription fmiVersion="2.0" modelName="integrator" guid="g">
<CoSimulation modelIdentifier="integrator" canInterpolateInputs="{inputs}" maxOutputDerivativeOrder="{outputs}"/>
<ModelVariables>
<ScalarVariable name="u" valueReference="0" causality="input" variability="continuous"><Real start="0"/></ScalarVariable>
<ScalarVariable name="y" valueReference="1" causality="output" variability="continuous"><Real/></ScalarVariable>
</ModelVariables>
<ModelStructure><Outputs><Unknown index="2" dependencies=""/></Outputs></ModelStructure></fmiModelDescription>"""
STEP = 0.1


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Path:
    if not (compiler := shutil.which("cc")):
        pytest.skip("needs a C compiler")
    path = tmp_path_factory.mktemp("foreign") / "integrator"
    source = Path(__file__).with_name("foreign.c")
    subprocess.run([compiler, "-std=c99", "-shared", "-fPIC", "-o", path, source], check=True, timeout=60)
    return path


def system(library: Path, inputs: bool, outputs: int) -> System:
    """A ship whose velocity is integrated, and the integral integrated once more; started."""
    platform, suffix = platform_name()
    fmu = library.with_name(f"{inputs}_{outputs}.fmu")
    with zipfile.ZipFile(fmu, "w") as archive:
        archive.writestr("modelDescription.xml", DESCRIPTION.format(inputs=str(inputs).lower(), outputs=outputs))
        archive.write(library, f"binaries/{platform}/integrator{suffix}")
    scene = Scene.from_dict(
        {
            "title": "Integrators",
            "stop_time": 10.0,
            "connections": ["ship.velocity -> first.u", "first.y -> second.u"],
            "units": {
                "ship": {"fmu": "ship", "parameters": {"heave_phase": 0.5}},
                "first": {"fmu": str(fmu)}, "second": {"fmu": str(fmu)},
            },
            "coupling": {"step": STEP, "scheme": "extrapolate"},
        }
    )  # fmt: skip
    running = System(resolve(scene), library.parent / "unpacked")
    running.start(0.0, 10.0)
    return running


def ends(running: System) -> tuple[float, float]:
    """Velocity of the ship at the start and end of the first step, which is done."""
    before = running.signals[0].value
    EXTRAPOLATE.step(running, 0.0, STEP)
    return before, running.signals[0].end_value


def test_derivatives_go_through_the_functions_of_the_standard(library: Path) -> None:
    running = system(library, True, 1)
    try:
        assert running.units[1].outputs == ["y", "y_rate"]
        assert running.signals[1].rated
        v0, v1 = ends(running)
        assert running.units[1].values == pytest.approx([0.5 * STEP * (v0 + v1), v1], rel=1e-14)
        # the rate makes a cubic of the integral, of which the second unit is told the chord
        assert running.signals[1].end_rate == pytest.approx(v1, rel=1e-14)
        assert running.units[2].values[0] == pytest.approx(0.25 * STEP**2 * (v0 + v1), rel=1e-14)
    finally:
        running.close()


def test_a_unit_that_takes_no_derivatives_gets_the_mean(library: Path) -> None:
    running = system(library, False, 0)
    try:
        assert running.units[1].outputs == ["y"]
        assert not running.signals[1].rated
        heave, slot = running.units[0].values, running.units[0].slot["heave"]
        before = heave[slot]
        ends(running)
        travelled = running.units[0].values[slot] - before
        # the mean of a cubic that has value and rate at both ends: its integral is off by h^5/720 of its fourth derivative
        assert running.units[1].values[0] == pytest.approx(travelled, abs=1e-8)
    finally:
        running.close()


def test_a_refused_derivative_ends_the_run(library: Path) -> None:
    running = system(library, True, 1)
    try:
        unit = running.units[1]
        wiring = unit.wiring
        wiring.set_derivatives = wiring.arguments(["u"], unit.input_buffer, 1, [2])  # an order that the unit does not take
        unit.advance = unit._stepper()
        with pytest.raises(RunError, match=r"first, t = 0 s: setting input derivatives returned Error"):
            ends(running)
    finally:
        running.close()
