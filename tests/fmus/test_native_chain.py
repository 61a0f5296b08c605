"""Steps of a chain in C against those in Python: the same scheme, so that they differ by what Newton's method leaves."""

from __future__ import annotations

import math
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from towage.models.cable.wire.chain import Chain, Drive
from towage.models.cable.wire.grading import graded_mesh
from towage.models.cable.wire.parts import uniform_flow
from towage.models.cable.wire.rest import Frame, equilibrium, march
from towage.models.cable.wire.stepper import State, Stepper
from towage.models.cable.wire.tableaus import THIRD

pytest.importorskip("casadi")
pytestmark = pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
ROOT = Path(__file__).parents[2]


@pytest.fixture
def wire(monkeypatch: pytest.MonkeyPatch) -> Iterator[ModuleType]:
    """``benchmarks/wire.py``, which compiles and runs the chain in C."""
    monkeypatch.syspath_prepend(str(ROOT / "benchmarks"))
    import wire

    yield wire
    for name in ("wire", "moordyn_tow"):
        sys.modules.pop(name, None)


def test_c_and_python_step_alike_in_a_turn(wire: ModuleType, tmp_path: Path) -> None:
    """In space, to a hundredth of the tolerance that both keep: 1e-5 of the body's place, 1e-4 of the pull."""
    flow, frame = uniform_flow(np.zeros(3)), Frame(np.array([3.0, 0.0, 0.0]))
    shape = march(wire.turn_wire(), flow, frame, 3)
    chain = Chain(wire.turn_wire(), graded_mesh(wire.turn_wire(), shape, 4, 2).mesh, flow, 3)
    nodes = equilibrium(chain, frame, shape.position(chain.mesh.places))

    def drive(t: float) -> Drive:
        angle = 3.0 * t / 60.0
        u = np.array([3.0 * math.cos(angle), 3.0 * math.sin(angle), 0.0])
        place = np.array([60.0 * math.sin(angle), 60.0 * (1.0 - math.cos(angle)), 0.0])
        return Drive(place, u, 0.05 * np.array([-u[1], u[0], 0.0]))

    state = State(nodes, np.broadcast_to(frame.velocity, nodes.shape).copy(), np.zeros_like(nodes))
    stepper, t, rows = Stepper(chain, 1e-4, 2.0, THIRD), 0.0, []
    for stop in (5.0, 12.0, 20.0):
        state, t = stepper.advance(t, stop - t, state, drive), stop
        pull = -chain.needed(state.position, state.velocity, state.acceleration, drive(t))[-1]
        rows.append([*(state.position[0] - drive(t).position), *pull])
    found = wire.bare(
        wire.build(tmp_path), wire.turn_wire(), (2, 4), (1e-4, 2.0, 3), [1.0, 3.0, 60.0, math.pi, 0.0],
        [5.0, 12.0, 20.0],
    )  # fmt: skip
    expected = np.array(rows)
    assert np.abs(found.rows[:, 1:4] - expected[:, :3]).max() < 1e-5 * 150.0
    assert np.abs(found.rows[:, 4:] - expected[:, 3:]).max() < 1e-4 * 6000.0
    steps, _, _, failures, rejections = found.counts
    assert (steps, failures, rejections) == (stepper.steps, stepper.failures, stepper.rejections)
