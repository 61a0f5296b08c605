"""What a unit computes between communication points: events, input derivatives, large steps. The FMU is the same code
to the last bit (test_model_equality), so that this runs in process."""

from __future__ import annotations

import math
import random
from itertools import pairwise
from typing import Any

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from towage.fmus.declare.dependencies import dependencies
from towage.fmus.declare.unit import load
from towage.fmus.python.instance import Instance
from towage.fmus.python.values import CallError, StepError

from .cases import CASES, UNITS

LINE = {"stiffness": 1e4, "mass": 5e3, "added_mass": 1e3, "drag_area": 10.0, "weight_in_water": 2e4}
DOCKING = {"docking_time": 2.345, "submersible_mass": 8e3, "submersible_weight_in_water": 1e3}
Cubic = tuple[float, float, float, float]


ROUNDED = (0.05, 0.21)
"""A start and a later event with start + (event - start) < event."""
assert ROUNDED[0] + (ROUNDED[1] - ROUNDED[0]) < ROUNDED[1]


class Player:
    """A unit by names; inputs are cubics of the time since the start, the same whatever the step."""

    def __init__(self, unit: str, start_time: float = 0.0, **start: float) -> None:
        self.unit = load(unit)
        self.it = Instance(self.unit)
        self.set(start)
        self.it.set_up(start_time, None)
        self.it.enter_initialization()
        self.it.exit_initialization()

    def set(self, values: dict[str, float]) -> None:
        self.it.set_values([self.unit.index[n] for n in values], list(values.values()))

    def get(self, *names: str) -> list[float]:
        return self.it.get_values([self.unit.index[n] for n in names])

    def __getitem__(self, name: str) -> float:
        return self.get(name)[0]

    def set_cubics(self, t: float, cubics: dict[str, Cubic]) -> None:
        for name, (a, b, c, d) in cubics.items():
            self.set({
                name: a + t * (b + t * (c + t * d)), f"{name}_d1": b + t * (2.0 * c + t * 3.0 * d),
                f"{name}_d2": 2.0 * c + 6.0 * t * d, f"{name}_d3": 6.0 * d,
            })  # fmt: skip

    def run(self, end: float, steps: int, **cubics: Cubic) -> Player:
        for k in range(steps):
            begin = end * k / steps
            self.set_cubics(begin, cubics)
            self.it.do_step(begin, end * (k + 1) / steps - begin)
        return self


# 2 m up, 3.5 m down, up again: slack and taut several times while the cradle rides on its line
SWING = (0.0, 5.0, -3.5, 0.45)


@pytest.mark.parametrize("steps", [1, 3, 7, 50])
def test_slack_and_docking_inside_a_step_are_located(steps: int) -> None:
    """Against 6000 steps, each with both events at the ends of its own integration, at a hundredth of the tolerance."""
    common = LINE | DOCKING | {"velocity_start": 0.3}
    reference = Player("cradle_on_line", **common, integration_tolerance=1e-12)
    slack, switches = 0, 0
    reference.it.get_values([0])
    branch = 1.0
    for k in range(6000):
        reference.set_cubics(k * 1e-3, {"heave_top": SWING})
        reference.it.do_step(k * 1e-3, (k + 1) * 1e-3 - k * 1e-3)
        slack += reference["taut"] == 0.0
        switches += reference["taut"] != branch
        branch = reference["taut"]
    assert slack > 500 and switches >= 2 and reference["docked"] == 1.0, "the run has no events to speak of"
    found = Player("cradle_on_line", **common, integration_tolerance=1e-10).run(6.0, steps, heave_top=SWING)
    for name in ("heave", "velocity", "tension"):
        scale = {"heave": 1.0, "velocity": 1.0, "tension": 2e4}[name]
        # 1e-10 per internal step, a few hundred of them; the size of the communication step does not enter
        assert found[name] == pytest.approx(reference[name], abs=1e-7 * scale), name
    assert found.get("taut", "docked") == reference.get("taut", "docked")


@pytest.mark.parametrize("steps", [1, 4, 33])
def test_docking_inside_a_step_is_located(steps: int) -> None:
    """Free of drag under constant forces, motion is a parabola on both sides of a capture in closed form."""
    pull, weight, m1, m2, v_sub, t1, end = 3e4, 2e4, 5e3, 1.3e4, 0.5, 2.345, 4.0
    player = Player("cradle", mass=m1, weight_in_water=weight, docking_time=t1, submersible_mass=m2 - m1)
    player.run(end, steps, line_tension=(pull, 0.0, 0.0, 0.0), submersible_velocity=(v_sub - 0.2 * t1, 0.2, 0.0, 0.0))
    a1, a2 = (pull - weight) / m1, (pull - weight) / m2
    v = (m1 * a1 * t1 + (m2 - m1) * v_sub) / m2
    rest = end - t1
    # the integrator is exact for parabolas, the time of docking is known: round-off of some twenty operations
    assert player["velocity"] == pytest.approx(v + a2 * rest, rel=1e-13)
    assert player["heave"] == pytest.approx(0.5 * a1 * t1**2 + v * rest + 0.5 * a2 * rest**2, rel=1e-13)
    assert player["docked"] == 1.0


@given(time=st.floats(0.0, 0.3), event=st.floats(0.0, 5.0))
@example(*ROUNDED)
def test_docking_happens_once_whatever_the_rounding(time: float, event: float) -> None:
    """``time + (event - time)`` may round to before the event: docking must not wait for the next step."""
    it = Player("cradle", time, mass=1e3, docking_time=event, submersible_mass=1e3, velocity_start=1.0)
    it.it.do_step(time, 6.0)
    assert it["docked"] == 1.0 and it["velocity"] == 0.5


@pytest.mark.parametrize("shift", [-2, -1, 0, 1, 2])
def test_docking_at_a_communication_point_in_spite_of_rounding(shift: int) -> None:
    """A master that lands on the event within round-off finds it happening there."""
    event = 3.0
    for _ in range(abs(shift)):
        event = math.nextafter(event, math.copysign(math.inf, shift))
    it = Player("cradle", mass=1e3, docking_time=event, submersible_mass=1e3, velocity_start=1.0)
    it.it.do_step(0.0, 3.0)
    if event >= 3.0:
        assert it["docked"] == 0.0 and it["velocity"] == 1.0  # from the left
    it.set({"submersible_velocity": 3.0})
    assert it["docked"] == 1.0 and it["velocity"] == 2.0 and it["next_event_time"] == 1e300  # from the right


def test_outputs_at_an_event_are_left_and_right_limits() -> None:
    """A taut line that is let go: its branch holds until the communication point is touched, frozen or not."""
    for frozen in (0.0, 1.0):
        it = Player("spring_line", stiffness=1e4, static_tension=2e4, freeze_branches=frozen)
        it.set({"heave_top": 0.0, "heave_top_d1": -4.0})
        it.it.do_step(0.0, 0.75)
        # e = W/K + x = 2 - 3 m: from the left still the branch of the step where the master looks after it
        assert it["event_taut"] == it["stretch"] == -1.0
        assert it["event_taut_rate"] == -4.0
        assert it.get("taut", "tension", "tension_rate") == ([1.0, -1e4, -4e4] if frozen else [0.0, 0.0, 0.0])
        it.set({"heave_top": -3.0})
        assert it.get("taut", "tension", "tension_rate") == [0.0, 0.0, 0.0]


def test_frozen_branch_holds_through_a_step_and_changes_at_its_end() -> None:
    it = Player("cradle_on_line", **LINE, freeze_branches=1.0, drag_coefficient=0.0)
    it.set({"heave_top": 0.0, "heave_top_d1": -10.0})
    it.it.do_step(0.0, 1.0)
    assert it["taut"] == 1.0 and it["tension"] < 0.0  # extended smoothly below zero
    it.set({"heave_top": -10.0})
    assert it["taut"] == 0.0 and it["tension"] == 0.0


@pytest.mark.parametrize("tolerance", [1e-6, 1e-8, 1e-10])
def test_one_period_in_one_step(tolerance: float) -> None:
    """A free oscillation comes back to where it was: y = y0 cos(omega t)."""
    mass, k = 5e3, 1e4
    omega = math.sqrt(k / mass)
    period = 2.0 * math.pi / omega
    for steps in (1, 2, 16):
        it = Player(
            "cradle_on_line", mass=mass, stiffness=k, weight_in_water=2e4, drag_coefficient=0.0, heave_start=1.0,
            integration_tolerance=tolerance,
        ).run(period, steps, heave_top=(0.0, 0.0, 0.0, 0.0))  # fmt: skip
        # the tolerance bounds the error of each of the 20 to 150 internal steps of a period
        assert abs(it["heave"] - 1.0) < 40 * tolerance
        assert abs(it["velocity"]) < 40 * tolerance * omega


@given(r=st.tuples(*[st.floats(-1e5, 1e5)] * 4), damping=st.sampled_from([0.0, 1e5, 2.53e6, 1e7]))
def test_linear_unit_is_exact_for_cubics_in_any_step(r: Cubic, damping: float) -> None:
    """One step of a period equals two hundred: no step error at all, under-, over- and critically damped."""
    results = []
    for steps in (1, 200):
        it = Player("ship", mass=8e5, stiffness=2e6, damping=damping, heave_amplitude=0.0)
        results.append(it.run(4.0, steps, reaction=r).get("heave", "velocity"))
    scale = sum(abs(a) * 4.0**k for k, a in enumerate(r)) / 2e6
    # 200 steps of round-off; the particular solution is up to 6 c^3/K^3 = 750 times the static one
    assert results[0] == pytest.approx(results[1], rel=1e-10, abs=1e-10 * scale + 1e-300)


@pytest.mark.parametrize("drag", [0.0, 1e-6, 1e-3, 1.0, 1e3])
def test_any_drag(drag: float) -> None:
    """From none to a thousandfold: energy only falls, and the step does not matter."""
    start = LINE | {"weight_in_water": 4.9e4, "drag_area": 10.0 * drag, "velocity_start": 5.0}
    mass, k, energies = 6e3, 1e4, [0.5 * 6e3 * 25.0]
    it = Player("cradle_on_line", **start)
    for n in range(40):
        it.it.do_step(0.25 * n, 0.25)
        y, v = it.get("heave", "velocity")
        energies.append(0.5 * mass * v * v + 0.5 * k * y * y)
    # 1e-8 relative per internal step; without drag energy is constant
    assert all(b <= a * (1.0 + 1e-6) for a, b in pairwise(energies))
    assert (energies[-1] > 0.999 * energies[0]) == (drag < 1e-4)
    once = Player("cradle_on_line", **start).run(10.0, 1, heave_top=(0.0, 0.0, 0.0, 0.0))
    assert once["heave"] == pytest.approx(it["heave"], abs=2e-6)


REST: dict[str, dict[str, float]] = {
    "ship": {"heave_amplitude": 0.0}, "spring_line": {"stiffness": 1e4, "static_tension": 2e4},
    "cradle": {"mass": 5e3, "weight_in_water": 2e4, "drag_area": 10.0, "line_tension": 2e4}, "cradle_on_line": LINE,
    "sway_craft": {"sway_amplitude": 0.0}, "slender_body": {"tow_speed": 0.0}, "tow_system": {},
    "tow_cable": {}, "towed_body": {}, "body_force": {}, "ship_in_sea": {"wave_height": 0.0},
}  # fmt: skip
"""Start values of units at rest; a voyage never rests, and a wire's equilibrium is iterated."""
ERRORS = ("margin_resolution", "margin_inextensible")
"""Margins of a model's own error, which rest does not change."""


@pytest.mark.parametrize("unit", REST)
def test_what_is_at_rest_stays_at_rest(unit: str) -> None:
    """No amplitude, no motion: not even by round-off, and every margin is 1."""
    it = Player(unit, **REST[unit])
    names = [v.name for v in it.unit.observed]
    before = it.get(*names)
    for k in range(50):
        it.it.do_step(0.3 * k, 0.3)
        assert it.get(*names) == before
    assert all(it[n] == 1.0 for n in names if n.startswith("margin_") and n not in ERRORS)
    rates = {f"{n}_rate" for n in names}
    assert all(it[n] == 0.0 for n in names if n in rates or n in ("heave", "velocity", "reaction"))


@pytest.mark.parametrize("order", [1, 2, 3])
def test_input_derivatives_are_those_of_a_taylor_series(order: int) -> None:
    """u(t + s) = u + d_k s^k/k!, seen from the left at the end of a step, with its rate."""
    it, h = Player("spring_line", stiffness=1e4, static_tension=2e4), 0.8
    for name, sign in (("heave_top", 1.0), ("heave_bottom", -1.0)):
        it.set({"heave_top": 0.0, f"{name}_d{order}": 0.6})
        begin = it.it.time
        it.it.do_step(begin, h)
        value = 0.6 * h**order / math.factorial(order)
        rate = 0.6 * h ** (order - 1) / math.factorial(order - 1)
        assert it["stretch"] == pytest.approx(2.0 + sign * value, rel=1e-15)
        assert it["event_taut_rate"] == pytest.approx(sign * rate, rel=1e-15)
        # a new step starts from the value again, as nothing else was set
        it.it.do_step(begin + h, 0.5 * h)
        assert it["stretch"] == pytest.approx(2.0 + sign * value * 0.5**order, rel=1e-15)
        it.set({f"{name}_d{order}": 0.0})


@pytest.mark.parametrize("unit", UNITS)
def test_inputs_without_derivatives_are_held(unit: str) -> None:
    """Zero derivatives, and derivatives that were never set, mean the same constant."""
    case = CASES[unit]
    never, zero = Player(unit, **case.start), Player(unit, **case.start)
    names = [v.name for v in never.unit.observed]
    for k in range(5):
        for name, (centre, size) in case.inputs.items():
            never.set({name: centre + 0.1 * k * size})
            zero.set({name: centre + 0.1 * k * size, **{f"{name}_d{n}": 0.0 for n in (1, 2, 3)}})
        for it in (never, zero):
            it.it.do_step(0.2 * k, 0.2)
        assert never.get(*names) == zero.get(*names)


@pytest.mark.parametrize("name", ["line_tension", "submersible_velocity"])
@pytest.mark.parametrize("order", [1, 2, 3])
def test_input_derivatives_act_inside_the_step(name: str, order: int) -> None:
    """Impulse of a tension that grows as s^k, and the speed of a submersible at the time of docking."""
    it = Player("cradle", mass=1e3, docking_time=0.7, submersible_mass=1e3)
    it.set({f"{name}_d{order}": 1e3 if name == "line_tension" else 1.0})
    it.it.do_step(0.0, 0.7)
    it.set({"line_tension": 0.0, **{f"line_tension_d{k}": 0.0 for k in (1, 2, 3)}})
    if name == "line_tension":
        # halved by the capture; polynomials to the third degree are exact in a fifth-order method
        assert it["velocity"] == pytest.approx(0.5 * 0.7 ** (order + 1) / math.factorial(order + 1), rel=1e-13)
    else:
        again = Player("cradle", mass=1e3, docking_time=0.7, submersible_mass=1e3)
        again.set({f"{name}_d{order}": 1.0})
        again.it.do_step(0.0, 1.0)
        assert again["velocity"] == pytest.approx(0.5 * 0.7**order / math.factorial(order), rel=1e-13)


EVERYTHING = DOCKING | {"breaking_load": 6e4, "wave_speed": 900.0}
"""Parameters without which some output does not depend on what it may depend on."""
WIDER = {"tow_system": {"margin_small_perturbation"},
         # its ends are declared as one: an end moves the force of the other, or a component another, through the wire in time
         "wire": {"tension_least", "margin_slack", "margin_bending", "margin_drag"}
         | {f"{what}_{way}" for what in ("body_velocity", "lower_force") for way in ("surge", "sway", "heave")},
         # all that a sea moves: it is seen at the start and at looks, which are further apart than these steps
         "ship_in_sea": {v.name for v in load("ship_in_sea").observed if v.causality == "output"}
         - {"margin_response"}}  # fmt: skip
"""Outputs that depend on fewer inputs than is declared."""


@pytest.mark.parametrize("unit", UNITS)
def test_declared_dependencies_are_the_real_ones(unit: str) -> None:
    """Every output that an input moves at once is declared to depend on it, and no other is."""
    rng, case = random.Random(5), CASES[unit]
    start = case.start | {name: value for name, value in EVERYTHING.items() if name in load(unit).index}
    it = Player(unit, **start)
    outputs = [v for v in it.unit.observed if v.causality == "output"]
    seen: dict[str, set[str]] = {v.name: set() for v in outputs}
    # an event, a branch, the worst of several margins take luck to meet; units of floats alone have none and are slow
    for k in range(40 if it.unit.not_native else 200):
        if "body_port" in load(unit).index:
            start["body_port"] = k % 2
        cubics = case.cubics(rng)
        values = {name: cubics[name] for name in case.inputs}
        rates = {f"{name}_d1": cubics[f"{name}_d1"] for name in case.inputs}
        it.it.restore(Player(unit, **start).it.state())
        for n in range(rng.randint(1, 4)):
            it.set(values | rates)
            it.it.do_step(0.5 * n, 0.5)
        if k % 2 and "docking_time" in start:
            it.it.do_step(it.it.time, max(start["docking_time"] - it.it.time, 1e-3))
        state = it.it.state()
        it.set(values)
        here = it.get(*(v.name for v in outputs))
        for name in values:
            it.it.restore(state)
            it.set(values | {name: values[name] + case.inputs[name][1] * 0.3})
            for v, a, b in zip(outputs, here, it.get(*(v.name for v in outputs))):
                if a != b:
                    seen[v.name].add(name)
    declared = {name: set(inputs) for name, inputs in dependencies(it.unit).items() if name in seen}
    assert all(seen[name] <= declared[name] for name in seen), "an output depends on what is not declared"
    assert {name for name in seen if seen[name] != declared[name]} == WIDER.get(unit, set())


def test_a_discarded_step_leaves_left_limits_too() -> None:
    """Nothing was set since the last step: outputs are still those from the left, to the last bit."""
    it = Player("cradle_on_line", **LINE)
    it.set({"heave_top": 0.5, "heave_top_d1": -1.0, "heave_top_d2": 3.0})
    it.it.do_step(0.0, 0.5)
    names = [v.name for v in it.unit.observed]
    here, state = it.get(*names), it.it.state()
    with pytest.raises(StepError, match=r"t = 0\.5 .*\(heave, velocity\)"):
        it.it.do_step(0.5, 1e200)
    assert it.get(*names) == here
    assert it.it.state() == state
    it.it.do_step(0.5, 0.5)


def test_refusals_name_the_place() -> None:
    with pytest.raises(CallError, match=r"mass = -1 kg: expected at least 1e-09"):
        Player("cradle", mass=-1.0)
    with pytest.raises(CallError, match=r"soft_docking = 2 1: expected 0 to 1|soft_docking = 2"):
        Player("cradle", soft_docking=2.0)
    with pytest.raises(CallError, match="value reference 4294967295"):
        Player("ship").it.get_values([-1])


def test_states_are_plain_and_compare(tmp_path: Any) -> None:
    """A state is immutable and equal to itself after a round trip: masters may keep and compare it."""
    it = Player("cradle_on_line", **LINE)
    it.set({"heave_top": 1.0})
    it.it.do_step(0.0, 0.3)
    state = it.it.state()
    hash(state)
    other = Player("cradle_on_line", **LINE | {"mass": 7e3})
    other.it.restore(state)
    assert other.it.state() == state
