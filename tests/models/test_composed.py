"""Models joined into one: order, loops, rates, transitions, the same in every spelling; and the tools that it takes."""

from __future__ import annotations

import math
import random
from dataclasses import make_dataclass
from typing import Any, NamedTuple

import numpy as np
import pytest

from towage.models.cable.body_force import BODY_FORCE
from towage.models.cable.towed_body import TOWED_BODY
from towage.models.compose.model import compose, eliminated
from towage.models.compose.plan import CompositionError, Connection
from towage.models.heave.cradle import CRADLE
from towage.models.heave.cradle_on_line import CRADLE_ON_LINE
from towage.models.heave.ship import SHIP
from towage.models.heave.spring_line import SPRING_LINE
from towage.models.numeric.dependence import TRACED, Traced, bent, joined
from towage.models.numeric.dual_ops import output_rates
from towage.models.numeric.ops import FLOATS, NEVER, arrays, symbols
from towage.models.protocol.model import AnyModel, Model
from towage.models.protocol.variables import quantities
from towage.models.slender.sway_craft import SWAY_CRAFT

MODELS = (SHIP, SPRING_LINE, CRADLE, CRADLE_ON_LINE, TOWED_BODY, BODY_FORCE, SWAY_CRAFT)
WIRING = (
    Connection(("ship", "heave"), ("line", "heave_top")),
    Connection(("cradle", "heave"), ("line", "heave_bottom")),
    Connection(("line", "tension"), ("cradle", "line_tension")),
    Connection(("line", "reaction"), ("ship", "reaction")),
)


Names = tuple[str, ...]


def model(name: str, entries: Names, observed: Names, states: Names = (), modes: Names = (), **functions: Any) -> Any:
    """A model without parameters, made of functions."""
    kinds = [NamedTuple(kind, [(n, Any) for n in names]) for kind, names in (
        ("State", states), ("Modes", modes), ("Inputs", entries), ("Outputs", observed)
    )]  # fmt: skip
    return Model(
        name, "made for a test", make_dataclass("Parameters", [], frozen=True), *kinds,
        initial=lambda p, ops: (kinds[0](*(0.0 for _ in states)), kinds[1](*(0.0 for _ in modes))), **functions,
    )  # fmt: skip


def suspended() -> AnyModel:
    return compose({"ship": SHIP, "line": SPRING_LINE, "cradle": CRADLE}, WIRING)


def random_values(kind: Any, seed: int = 1) -> Any:
    """Parameters of a model, all different, positive."""
    draw = random.Random(seed)
    return kind(**{n: draw.uniform(0.5, 2.0) for n in quantities(kind) if n != "freeze_branches"} | held(kind))


def held(kind: Any) -> dict[str, float]:
    return {n: 1.0 for n in quantities(kind) if n == "freeze_branches"}


@pytest.mark.parametrize("it", MODELS, ids=lambda m: m.name)
def test_directional_derivatives_equal_the_rates_that_models_state(it: Any) -> None:
    p, draw = random_values(it.Parameters), random.Random(2)
    compared = 0
    for _ in range(20):
        x, m, u, du = (
            kind(*(draw.uniform(0.1, 1.0) for _ in kind._fields)) for kind in (it.State, it.Modes, it.Inputs, it.Inputs)
        )
        m = it.Modes(*(1.0 for _ in m))
        t = draw.uniform(0.0, 0.4)  # within the smooth start, whose rate is the intricate one
        stated = dict(zip(it.Outputs._fields, it.outputs(t, x, m, u, du, p, FLOATS)))
        derived = dict(zip(it.Outputs._fields, output_rates(it, t, x, m, u, du, [0.0] * len(u), p, FLOATS)))
        for name in stated:
            if f"{name}_rate" in stated:
                compared += 1
                # some tens of operations on numbers of size 1 to 100
                assert derived[name] == pytest.approx(stated[f"{name}_rate"], rel=1e-12, abs=1e-12), name
    assert compared


def test_dependence_tells_linear_from_otherwise() -> None:
    v, w, p = Traced({"v": 1}), Traced({"w": 1}), Traced()
    assert (p * v + w / p - 3.0).degrees == {"v": 1, "w": 1}
    assert (v * w).degrees == (p / v + w * w).degrees == {"v": 2, "w": 2}
    assert (p / v).degrees == {"v": 2}
    assert TRACED.where(v > 0.0, w, p).degrees == {"v": 2, "w": 1}
    assert TRACED.where(True, w, v) is w
    assert joined(v, bent(v)).degrees == {"v": 2}


def test_elimination_solves() -> None:
    draw = np.random.default_rng(3)
    a = np.eye(5) + 0.15 * draw.standard_normal((5, 5))
    b = draw.standard_normal(5)
    assert eliminated(a.tolist(), b.tolist()) == pytest.approx(np.linalg.solve(a, b), rel=1e-12)  # well conditioned


def test_names_open_inputs_and_slices() -> None:
    it = suspended()
    assert it.State._fields == ("ship.response", "ship.response_rate", "cradle.heave", "cradle.velocity")
    assert it.Modes._fields == ("line.taut", "cradle.docked")
    assert it.Inputs._fields == ("cradle.submersible_velocity",)
    assert it.Outputs._fields[-1] == "next_event_time" and "line.event_taut_rate" in it.Outputs._fields


def values() -> tuple[float, list[float], list[float], list[float], list[float], list[float]]:
    """A point at which nothing is zero, and parameters in the order of the parts; the line is one that can go slack."""
    draw = random.Random(5)
    names = [name for part in (SHIP, SPRING_LINE, CRADLE) for name in quantities(part.Parameters) if name != "freeze_branches"]
    p = [0.0 if name == "never_slack" else draw.uniform(0.5, 2.0) for name in names]
    return 3.1, [0.1, 0.2, -0.3, 0.4], [1.0, 0.0], [0.5], [0.7], p


def test_floats_arrays_and_symbols_agree() -> None:
    import casadi as ca

    it = suspended()
    t, x, m, u, du, p = values()
    own = it.Parameters(*p)
    many = it.Parameters(*(np.full(3, v) for v in p))
    columns = [[np.full(3, v) for v in part] for part in (x, m, u, du)]
    names = [ca.SX.sym(n, len(v)) for n, v in zip("tpxmuv", ([t], p, x, m, u, du))]
    st, sp, sx, sm, su, sdu = ([v[i] for i in range(v.numel())] for v in names)
    for name, rates in (("outputs", True), ("derivatives", False), ("indicators", False), ("transition", False)):
        call = getattr(it, name)
        exact = call(t, x, m, u, *((du,) if rates else ()), own, FLOATS)
        batch = call(np.full(3, t), *columns[:3], *columns[3:][: int(rates)], many, arrays())
        symbolic = call(st[0], sx, sm, su, *((sdu,) if rates else ()), it.Parameters(*sp), symbols())
        if name == "transition":
            exact, batch, symbolic = ((*each[0], *each[1]) for each in (exact, batch, symbolic))
        traced = ca.Function(name, names, [ca.vertcat(*symbolic)])(t, p, x, m, u, du)
        # the same operations, of which compilers and libraries may round sin and exp differently
        assert np.array(traced).ravel() == pytest.approx(list(exact), rel=1e-13), name
        assert np.array([np.broadcast_to(v, 3) for v in batch])[:, 1] == pytest.approx(list(exact), rel=1e-13), name


def test_mass_and_apparent_mass_make_a_heavier_mass() -> None:
    """F = M a + R, R = m a + k v: the loop through the acceleration is linear and closed exactly."""
    mass, apparent, stiffness = 3.0, 5.0, 0.7
    hull = model(
        "hull", ("reaction",), ("velocity", "velocity_rate"), ("velocity",),
        derivatives=lambda t, x, m, u, p, ops: ((ops.sin(t) - u.reaction) / mass,),
        outputs=lambda t, x, m, u, du, p, ops: (x.velocity, (ops.sin(t) - u.reaction) / mass),
    )  # fmt: skip
    tow = model(
        "tow", ("velocity",), ("reaction", "reaction_rate"),
        outputs=lambda t, x, m, u, du, p, ops: (apparent * du.velocity + stiffness * u.velocity, 0.0),
    )  # fmt: skip
    it = compose(
        {"hull": hull, "tow": tow},
        (
            Connection(("hull", "velocity"), ("tow", "velocity"), 2.0),
            Connection(("tow", "reaction"), ("hull", "reaction"), 0.5),
        ),
    )
    t, v = 0.4, 1.3
    (rate,) = it.derivatives(t, (v,), (), (), it.Parameters(), FLOATS)
    assert rate == pytest.approx((math.sin(t) - stiffness * v) / (mass + apparent), rel=1e-15)


def spring(power: int) -> Any:
    """A force that follows its input without delay."""

    def outputs(t: Any, x: Any, m: Any, u: Any, du: Any, p: Any, ops: Any) -> tuple[Any, ...]:
        return (0.5 * (u.end if power == 1 else u.end * u.end) + 1.0,)

    return model("spring", ("end",), ("force",), outputs=outputs)


def test_loop_that_is_not_linear_is_refused_by_name() -> None:
    ring = (Connection(("a", "force"), ("b", "end")), Connection(("b", "force"), ("a", "end")))
    linear = compose({"a": spring(1), "b": spring(1)}, ring)
    assert linear.outputs(0.0, (), (), (), (), linear.Parameters(), FLOATS) == pytest.approx((2.0, 2.0), rel=1e-15)
    with pytest.raises(CompositionError, match=r"through b\.force -> a\.end, a\.force -> b\.end: it is not linear"):
        compose({"a": spring(1), "b": spring(2)}, ring)


def test_missing_rate_is_derived_exactly() -> None:
    """`stretch` has no stretch_rate: its rate follows from the line's equations."""
    sensor = model("sensor", ("input",), ("speed",), outputs=lambda t, x, m, u, du, p, ops: (du.input,))
    it = compose(
        {"ship": SHIP, "line": SPRING_LINE, "cradle": CRADLE, "sensor": sensor},
        (*WIRING, Connection(("line", "stretch"), ("sensor", "input"), 3.0)),
    )
    t, x, m, u, du, p = values()
    found = dict(zip(it.Outputs._fields, it.outputs(t, x, m, u, du, it.Parameters(*p), FLOATS)))
    assert found["sensor.speed"] == pytest.approx(3.0 * found["line.event_taut_rate"], rel=1e-14)


def test_change_runs_through_a_chain_in_one_transition() -> None:
    """Each part switches on when its input exceeds 0.5; the order of the parts is that of the chain or the reverse."""
    relay = model(
        "relay", ("signal",), ("on",), modes=("on",),
        outputs=lambda t, x, m, u, du, p, ops: (m.on,),
        transition=lambda t, x, m, u, p, ops: (x, (ops.where(u.signal > 0.5, 1.0, 0.0),)),
    )  # fmt: skip
    for order in (("a", "b", "c"), ("c", "b", "a")):
        chain = tuple(Connection((one, "on"), (two, "signal")) for one, two in (("a", "b"), ("b", "c")))
        it = compose(dict.fromkeys(order, relay), chain)
        assert it.transition(0.0, (), (0.0, 0.0, 0.0), (1.0,), it.Parameters(), FLOATS)[1] == (1.0, 1.0, 1.0)


def test_next_event_is_the_earliest_and_requirements_carry_the_part() -> None:
    it = compose({"a": CRADLE, "b": CRADLE}, ())
    names = list(quantities(CRADLE.Parameters))
    given = {f"{part}.{n}": 1.0 for part in "ab" for n in names}
    p = it.Parameters(**given | {"a.docking_time": 5.0, "b.docking_time": 2.0, "b.submersible_mass": 0.0})
    assert it.next_event_time(0.0, (0.0, 0.0), p, FLOATS) == 2.0
    assert it.next_event_time(0.0, (0.0, 1.0), p, FLOATS) == 5.0
    assert it.next_event_time(0.0, (1.0, 1.0), p, FLOATS) == NEVER
    assert [text.partition(":")[0] for value, text in it.requirements(p, FLOATS) if not value > 0.0] == ["b"]
