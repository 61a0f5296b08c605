"""Native FMUs in a C host: nothing but ``dlopen`` and the standard's functions."""

from __future__ import annotations

import math
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

from towage.fmus.declare.unit import load
from towage.fmus.python.instance import Instance

from .cases import NATIVE
from .native_host import ESTIMATED, Unpacked, compile_host, run_of, unpack

ROUNDING = {"tow_cable": 5e-8}
"""The elastic cable's fastest modes turn by 73 rad in a step: seven squarings of an exponential whose entries differ by the
stiffness of a segment, 1e6, and forces that are differences of such. Others: 1e-10."""
Play = Callable[..., str]
VERSIONS = pytest.mark.parametrize("fmi", [2, 3])
NAMES = pytest.mark.parametrize("name", NATIVE)


@pytest.fixture(scope="module")
def unpacked(native: Callable[[str, int], Path], tmp_path_factory: pytest.TempPathFactory) -> Callable[..., Unpacked]:
    return lambda name, fmi, **run: unpack(native(name, fmi), fmi, tmp_path_factory.mktemp(f"{name}{fmi}"), **run)


@pytest.fixture(scope="module")
def host(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return compile_host(tmp_path_factory.mktemp("host"))


@pytest.fixture(scope="module")
def play(host: Path, unpacked: Callable[..., Unpacked]) -> Play:
    """What the host prints for a command."""

    def run(name: str, fmi: int, *words: object, **options: object) -> str:
        fmu = unpacked(name, fmi, **options)
        done = subprocess.run(fmu.command(host, *words), input=fmu.script, capture_output=True, text=True, timeout=300)
        assert done.returncode == 0, done.stderr
        return done.stdout

    return run


@NAMES
def test_run_equals_the_python_instance(name: str, native: Callable[[str, int], Path], play: Play) -> None:
    """FMI 2 and 3 to the last bit of each other, and both the Python flavour but for the rounding of the traced code."""
    runs = [play(name, fmi, "run") for fmi in (2, 3)]
    assert runs[0] == runs[1]
    unit, rows = load(name), [[float.fromhex(v) for v in line.split()] for line in runs[0].splitlines()]
    it, index = Instance(unit), unit.index
    start, sines = run_of(native(name, 2))
    it.set_values([index[n] for n in start], list(start.values()))
    it.enter_initialization()
    it.exit_initialization()
    observed = [index[v.name] for v in unit.observed]
    expected = []
    for k in range(60):
        for entry, (a, w) in sines.items():
            s, c = a * math.sin(w * (k * 0.1)), a * math.cos(w * (k * 0.1))
            values = [s, w * c, -w * w * s, -w * w * w * c]
            it.set_values([index[entry], *(index[f"{entry}_d{order}"] for order in (1, 2, 3))], values)
        it.do_step(k * 0.1, 0.1)
        expected.append(it.get_values(observed))
    assert [row[0] for row in rows] == pytest.approx([0.1 * (k + 1) for k in range(60)], rel=1e-15)
    assert len(rows) == 60
    for i, variable in enumerate(unit.observed):
        column, wanted = [row[i + 1] for row in rows], [row[i] for row in expected]
        scale = max(map(abs, wanted)) or 1.0
        if unit.model.linear and variable.name in ESTIMATED:
            assert all(map(math.isfinite, column))
            continue
        # the same steps of the same integrator; sums in another order, some 1e3 of them, and events located to 1e-12
        assert max(abs(x - y) for x, y in zip(column, wanted)) <= ROUNDING.get(name, 1e-10) * scale, variable.name


@NAMES
@VERSIONS
def test_states_are_bit_equal(name: str, fmi: int, play: Play) -> None:
    """Rollback, serialisation into another and into a new instance, from each of the steps."""
    assert play(name, fmi, "states") == ""


@VERSIONS
def test_a_thousand_instances_at_once(fmi: int, play: Play) -> None:
    """100 000 steps side by side equal those of one alone."""
    assert play("cradle_on_line", fmi, "many", 1000, steps=100, step=0.05) == ""


@VERSIONS
def test_memory_stays(fmi: int, play: Play) -> None:
    """After the first 200 lives, 1800 more with ten states each: a leaked state would be 5 MB, an instance 2 MB."""
    assert int(play("cradle_on_line", fmi, "growth", 2000)) <= 256 * 1024


def test_wrong_token_has_no_instance(host: Path, unpacked: Callable[..., Unpacked]) -> None:
    for fmi in (2, 3):
        fmu = unpacked("ship", fmi)
        command = fmu.command(host, "run")
        command[3] = "{00000000-0000-0000-0000-000000000000}"
        done = subprocess.run(command, input=fmu.script, capture_output=True, text=True, timeout=60)
        assert done.returncode == 1
        assert f"expected {fmu.token}" in done.stderr and "no instance" in done.stderr


@pytest.mark.slow
@VERSIONS
def test_valgrind_finds_nothing(fmi: int, host: Path, unpacked: Callable[..., Unpacked]) -> None:
    """No use of what was not written, no byte left behind."""
    valgrind = shutil.which("valgrind")
    if valgrind is None:
        pytest.skip("valgrind is not installed")
    fmu = unpacked("cradle_on_line", fmi, steps=30)
    checks = [valgrind, "-q", "--error-exitcode=9", "--leak-check=full", "--show-leak-kinds=all"]
    for words in (["run"], ["states"], ["growth", 3]):
        done = subprocess.run([*checks, *fmu.command(host, *words)], input=fmu.script, capture_output=True, text=True,
                              timeout=600)  # fmt: skip
        assert done.returncode == 0, done.stderr[-3000:]
