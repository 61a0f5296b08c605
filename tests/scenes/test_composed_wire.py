"""A wire in a scene that is one unit: its own equations with explicit steps, against its implicit ones; in ensembles."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import towage
from towage.errors import SceneError
from towage.fmus.declare.unit import Unit, load
from towage.fmus.native.build import build_unit
from towage.fmus.python.instance import Instance
from towage.models.cable.units.wire import WIRE
from towage.models.cable.units.wire_seen import prepare
from towage.models.numeric.ops import FLOATS
from towage.scene.compose import unit_of
from towage.scene.resolve import described
from towage.scene.scene import Scene
from towage.units.store import locator

WIRE_OF: dict[str, Any] = {
    "in_space": 0, "wire_length": 60, "wire_axial_stiffness": 2e5, "degree": 3, "elements": 2, "velocity_tolerance": 1e-6,
}  # fmt: skip
SCENE: dict[str, Any] = {
    "title": "A wire under a ship",
    "stop_time": 4.0,
    "units": {
        "ship": {"fmu": "ship", "parameters": {"heave_amplitude": 0.4, "heave_period": 4, "ramp_time": 1}},
        "wire": {"fmu": "wire", "parameters": WIRE_OF},
    },
    "connections": ["ship.velocity -> wire.velocity_heave"],
    "coupling": {"step": 0.05},
}


def composed(scene: dict[str, Any] = SCENE) -> Unit:
    return unit_of(described(Scene.from_dict(scene), locator(), open_ends=True), "wired")


def at_end(unit: Unit, names: list[str], until: float = 4.0) -> list[float]:
    it = Instance(unit)
    it.set_up(0.0, None)
    it.enter_initialization()
    it.exit_initialization()
    it.do_step(0.0, until)
    return it.get_values([unit.index[name] for name in names])


SEEN = ["wire.tension_top", "wire.reaction_heave", "wire.depth", "wire.layback", "wire.tension_least", "wire.margin_resolution"]


def test_a_wire_in_a_scene_of_one_unit_moves_as_by_its_own_steps() -> None:
    unit = composed()
    whole = at_end(unit, SEEN, 2.0)
    coupled = towage.run(Scene.from_dict({**SCENE, "stop_time": 2.0}))
    # 1e-3: the coupling's and the implicit steps' errors, relative to each output
    for name, value in zip(SEEN, whole):
        assert value == pytest.approx(coupled[name][-1], rel=1e-3), name


def test_a_part_sees_what_the_unit_sees() -> None:
    """Outputs and accelerations in space, with tail, clump, sheared current, damping and payout."""
    given = {
        "in_space": 1.0, "elements": 3.0, "degree": 2.0, "tail_length": 40.0, "clump_mass": 20.0, "clump_weight": 100.0,
        "current_surge": 0.3, "current_sway": 0.2, "current_depth": 50.0, "wire_damping": 1e4,
    }  # fmt: skip
    p = WIRE.Parameters(**{**{v.name: v.start for v in load("wire").parameters}, **given})
    assert WIRE.part is not None
    part, nodes, d = WIRE.part(p), prepare(p).nodes, 3
    rng = np.random.default_rng(1)
    x = np.array(part.initial(p, FLOATS)[0])
    x = x + 0.02 * rng.standard_normal(len(x))
    u, du = rng.standard_normal((2, 10)).tolist()
    du[3] = 0.0
    size = d * (len(nodes) - 1)
    r, v = (np.vstack([x[k * size : (k + 1) * size].reshape(-1, d), end]) for k, end in ((0, x[-d:]), (1, u[:3])))
    rates = np.array(part.derivatives(0.0, x.tolist(), (), u, p, FLOATS))
    a = np.vstack([rates[size : 2 * size].reshape(-1, d), du[:3]])
    zero = np.zeros_like(a)
    state = np.concatenate([*(k.ravel() for k in (r, v, a, zero, zero, zero, zero)), [0.0] * 6, x[-d - 1 :]]).tolist()
    seen = np.array(WIRE.outputs(0.0, state, (), u, du, p, FLOATS))
    np.testing.assert_allclose(part.outputs(0.0, x.tolist(), (), u, du, p, FLOATS), seen, rtol=1e-9, atol=1e-9)


def test_both_flavours_of_the_scene_agree(tmp_path: Path) -> None:
    import fmpy

    small = {**SCENE, "units": {**SCENE["units"], "wire": {"fmu": "wire", "parameters": {**WIRE_OF, "degree": 1}}}}
    unit = composed(small)
    path, _ = build_unit(unit, tmp_path)
    result = fmpy.simulate_fmu(path, stop_time=0.5, output_interval=0.5, output=SEEN, fmi_type="CoSimulation")
    assert [result[name][-1] for name in SEEN] == pytest.approx(at_end(unit, SEEN, 0.5), rel=1e-8)


def test_a_winch_that_is_driven_is_refused() -> None:
    scene = {**SCENE, "connections": [*SCENE["connections"], "ship.velocity -> wire.payout_speed"]}
    with pytest.raises(SceneError, match="takes it as constant in a composition"):
        composed(scene)


@pytest.mark.slow
def test_members_of_an_ensemble_have_their_own_seas() -> None:
    ensemble = towage.Ensemble(Scene.from_dict(SCENE), {"ship.heave_amplitude": np.array([0.1, 0.2, 0.4])})
    members = ensemble.run(series=["wire.tension_top"], samples=1, tolerance=1e-6)
    assert members.refused.sum() == 0
    swing = np.ptp(members.series["wire.tension_top"], axis=1)
    assert swing[2] > 1.9 * swing[1] > 3.6 * swing[0]


BODY = {"mass": 800, "added_mass_surge": 300, "added_mass_heave": 300, "drag": 0.5 * 1025 * 0.3 * 9, "tow_speed": 3}
PORT: dict[str, Any] = {
    **SCENE,
    "units": {
        "ship": SCENE["units"]["ship"],
        "wire": {"fmu": "wire", "parameters": {**WIRE_OF, "body_port": 1}},
        "body": {"fmu": "towed_body", "parameters": BODY},
    },
    "connections": [
        "ship.velocity -> wire.velocity_heave",
        "wire.lower_force_surge -> body.force_surge", "wire.lower_force_heave -> body.force_heave",
        "body.velocity_surge -> wire.lower_velocity_surge", "body.velocity_heave -> wire.lower_velocity_heave",
    ],
}  # fmt: skip


def test_a_body_of_its_own_moves_as_the_one_on_board() -> None:
    """As one unit, where nothing is coupled, to rounding; by the master to the error of the coupling."""
    assert at_end(composed(PORT), SEEN, 0.25) == pytest.approx(at_end(composed(), SEEN, 0.25), rel=1e-7)
    on_board, coupled = (towage.run(Scene.from_dict({**scene, "stop_time": 2.0})) for scene in (SCENE, PORT))
    for name in SEEN:
        # the error of the coupling: measured 5e-4 at steps of 0.05 s
        assert coupled[name][-1] == pytest.approx(on_board[name][-1], rel=1e-3), name
