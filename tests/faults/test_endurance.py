"""Long runs and many units: what a run holds on to does not grow with its length."""

from __future__ import annotations

import itertools
import re
import sys
from pathlib import Path

import pytest
from msgspec.structs import replace

from tests.foreign.units import hostile
from towage.master.master import Master
from towage.result.result import Result
from towage.scene.scene import Scene

from .survival import scene
from .unit_cases import misbehaving

pytestmark = pytest.mark.slow
STEPS = 1_000_000
STEP = 1e-3
STEP_RECORD = 8
"""Bytes that a step leaves behind on purpose: its length (``Result.step_sizes``)."""
ALLOCATOR = 6 << 20
"""Doubling of the array of the step lengths and pages that the allocator has not given back, bytes."""
UNITS = 1000


def _resident() -> int:
    """Memory of this process, bytes."""
    text = Path("/proc/self/status").read_text(encoding="ascii")
    size = re.search(r"VmRSS:\s+(\d+) kB", text)
    assert size
    return int(size[1]) << 10


@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
@pytest.mark.parametrize("scheme", ["extrapolate", "hermite"])
def test_memory_does_not_grow_over_a_million_steps(tmp_path: Path, scheme: str) -> None:
    loaded = Scene.load(misbehaving("none")(tmp_path))
    coupling = replace(loaded.coupling, step=STEP, scheme=scheme)
    stop = STEP * STEPS
    long = replace(loaded, coupling=coupling, stop_time=stop, record=replace(loaded.record, interval=stop / 10.0))
    seen: list[tuple[float, int]] = []
    result = Master(long, flavour="python").run(lambda share, text: seen.append((share, _resident())))
    assert result.status == "done", result.message
    assert result.statistics["steps"] == STEPS
    early = next(size for share, size in seen if share > 0.1)
    late = seen[-2][1]
    print(f"{scheme}: {(late - early) / (0.9 * STEPS):.2f} bytes a step")
    assert late - early < 0.9 * STEPS * STEP_RECORD + ALLOCATOR


def test_a_thousand_units(tmp_path: Path) -> None:
    """A chain: each integrates the one before it."""
    fmu = hostile(tmp_path / "link.fmu")
    names = [f"u{k}" for k in range(UNITS)]
    connections = [f"{a}.y -> {b}.u" for a, b in itertools.pairwise(names)]
    first = {"units.u0.parameters": "x0 = 1.0"}
    result: Result = Master(Scene.load(scene(tmp_path, dict.fromkeys(names, fmu), connections, **first)), flavour="python").run()
    assert result.status == "done", result.message
    t = result.time[-1]
    assert result["u1.y"][-1] == pytest.approx(t, rel=1e-12)
    assert result["u2.y"][-1] == pytest.approx(0.5 * t * t, rel=1e-12)  # a straight line is passed on exactly
    print(f"{result.statistics['wall_s'] / result.statistics['steps'] / UNITS * 1e6:.1f} us a unit and step")
