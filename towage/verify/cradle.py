"""The reference cases of ship, spring line and cradle, computed with the models of towage.

The cases are dimensionless: length X0, time 1/omega0, tension K X0. They are the SI models with K = M = X0 = 1,
``water_density`` = 2 B, unit drag area and coefficient, and the weight in water w, null for a line that is never slack.
Each function takes the ``inputs`` of a case and its ``expected`` values and returns what it computed.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from towage.models.heave import cradle, orbits, ship, spring_line
from towage.models.heave.system import Simulation, System
from towage.models.numeric.integrate import Vector

Values = Mapping[str, Any]


def dimensionless_system(
    drag: float,
    omega: float,
    w: float | None,
    *,
    amplitude: float = 1.0,
    stiffness: float = 1.0,
    mass: float = 1.0,
    docked_mass: float | None = None,
    drag_ratio: float = 1.0,
    docking_time: float = -1.0,
    mode: str = "plastic",
    submersible_velocity: float = 0.0,
    hull: tuple[float, float, float] = (1.0, 0.0, 1.0),
    two_way: bool = False,
    force: tuple[float, float] = (0.0, 0.0),
) -> System:
    """The SI models with the numbers of a dimensionless case: ``drag`` is b, ``omega`` the frequency of the ship, ``w`` the
    weight in water (None: the line is never slack), ``hull`` mass, damping and stiffness of the ship, ``force`` amplitude
    and frequency of a force on her. Raises ``ValueError`` for an unknown ``mode`` of docking."""
    if mode not in ("plastic", "continuous"):
        raise ValueError(f"mode is {mode!r}; expected plastic or continuous")
    weight = 0.0 if w is None else w
    return System(
        ship=ship.Parameters(
            heave_amplitude=amplitude, heave_period=2.0 * math.pi / omega, heave_phase=0.0, ramp_time=0.0,
            mass=hull[0], damping=hull[1], stiffness=hull[2], sdof_tolerance=0.05,
        ),
        line=spring_line.Parameters(
            stiffness=stiffness, axial_stiffness=0.0, length=0.0, breaking_load=0.0, mass_per_length=0.0,
            weight_per_length=0.0, wave_speed=0.0, wire_damping=0.0,
            never_slack=float(w is None), freeze_branches=0.0, static_tension=weight,
        ),
        cradle=cradle.Parameters(
            mass=mass, added_mass=0.0, weight_in_water=weight, drag_area=1.0, drag_coefficient=1.0,
            water_density=2.0 * drag, drag_length=1.0, kinematic_viscosity=0.0, critical_reynolds=0.0,
            docking_time=docking_time, submersible_mass=(mass if docked_mass is None else docked_mass) - mass,
            submersible_weight_in_water=0.0,
            docked_drag_area=max(drag_ratio, 1e-300),  # 0 would mean unchanged
            soft_docking=float(mode == "continuous"), heave_start=0.0, velocity_start=0.0,
            linear_damping=0.0,
        ),
        two_way=two_way,
        force_amplitude=force[0],
        force_frequency=force[1],
        submersible_velocity=submersible_velocity,
    )  # fmt: skip


def _extremes(run: Simulation, start: float = 0.0) -> tuple[float, float]:
    """(largest, smallest) heave among the turning points after ``start`` and the end. The start itself does not count,
    at rest or not: that is how the cases of a transient and of a docking are meant."""
    values = [y for t, y in run.turning_points if t - start > 1e-9 * run.t] + [run.state[-2]]
    return max(values), min(values)


def transient(inputs: Values, expected: Values) -> Values:
    """Cradle on a prescribed motion from a given state."""
    w = inputs.get("w")
    run = Simulation(dimensionless_system(inputs["B"], inputs["r"], w), 0.0, (float(inputs["y0"]), float(inputs["v0"])))
    y, v = run.advance(inputs["tau"])
    ymax, ymin = _extremes(run)
    return {
        "y": y, "v": v, "ymax": ymax, "ymin": ymin, "dynamic_tension_max": run.tension_max - (w or 0.0),
        "slack_time": run.slack_time, "slack_events": run.slack_events,
    }  # fmt: skip


def _orbit_values(orbit: orbits.Orbit, state: Vector, w: float | None) -> dict[str, Any]:
    return {
        "period": orbit.period, "y0": state[0], "v0": state[1], "ymax": orbit.heave_max, "ymin": orbit.heave_min,
        "dynamic_tension_max": orbit.tension_max - (w or 0.0), "slack_fraction": orbit.slack_fraction,
        "slack_events": orbit.slack_events,
    }  # fmt: skip


def steady_orbit(inputs: Values, expected: Values) -> Values:
    """The orbit of one period that is reached from rest."""
    w = inputs.get("w")
    orbit = orbits.steady(dimensionless_system(inputs["B"], inputs["r"], w))
    return _orbit_values(orbit, orbit.state, w)


def attractors(inputs: Values, expected: Values) -> Values:
    """All periodic motions reached, each at the section point nearest to the expected one, in the expected order."""
    w = inputs.get("w")
    reached, _ = orbits.attractors(dimensionless_system(inputs["B"], inputs["r"], w), inputs["initial_states"])
    points = [(orbit, point) for orbit in reached for point in orbit.section]
    ordered: list[dict[str, Any]] = []
    for want in expected.get("attractors", ()):
        if not points:
            break
        orbit, point = min(points, key=lambda item: math.dist(item[1], (want["y0"], want["v0"])))
        ordered.append(_orbit_values(orbit, point, w))
        points = [item for item in points if item[0] is not orbit]
    return {"attractors": ordered + [_orbit_values(o, p, w) for o, p in points if p == o.state]}


def sample_table(inputs: Values, expected: Values) -> Values:
    """Heave and its rate at given numbers T of natural periods, in the order given."""
    run = Simulation(
        dimensionless_system(inputs["B"], inputs["r"], inputs.get("w")), 0.0, (float(inputs["y0"]), float(inputs["v0"]))
    )
    states = {T: run.advance(2.0 * math.pi * T) for T in sorted(inputs["T"])}
    return {
        "Y": [states[T][0] for T in inputs["T"]],
        "dY_dT": [2.0 * math.pi * states[T][1] for T in inputs["T"]],
    }


def free_decay(inputs: Values, expected: Values) -> Values:
    """Magnitudes of the successive extrema without forcing; a start at rest is the first."""
    count = len(expected["abs_extrema"]) if "abs_extrema" in expected else 7
    y0, v0 = float(inputs["y0"]), float(inputs["v0"])
    run = Simulation(dimensionless_system(inputs["B"], 1.0, None, amplitude=0.0), 0.0, (y0, v0))
    first = [abs(y0)] if v0 == 0.0 else []
    for half in range(1, 20 * count + 20):  # quadratic drag at any B needs little more than half a period each
        values = first + [abs(y) for t, y in run.turning_points if t > 1e-9]
        if len(values) >= count:
            return {"abs_extrema": values[:count]}
        run.advance(math.pi * half)
    raise ValueError(f"only {len(values)} of {count} extrema within {run.t:.3g}")


def _docked(system: System, start: Vector, t_dock: float, t_end: float) -> tuple[Simulation, dict[str, Any]]:
    run = Simulation(system, 0.0, start)
    y, v = run.advance(t_dock)
    before = run.before_docking
    if before is None:
        raise ValueError("docking must not lie before the start")
    slack = not run.taut
    run.restart()
    y_end, v_end = run.advance(t_end)
    ymax, ymin = _extremes(run, t_dock)
    return run, {
        "slack_at_docking": slack, "y_dock": y, "v_before": before[1], "v_after": v, "ymax": ymax,
        "ymin": ymin, "slack_events": run.slack_events, "y_end": y_end, "v_end": v_end,
    }  # fmt: skip


def docking(inputs: Values, expected: Values) -> Values:
    """A submersible comes aboard a line that is always taut; units s and X0."""
    k, m1 = inputs["K"], inputs["M1"]
    system = dimensionless_system(
        inputs["B1"] * m1, inputs["omega"], None, stiffness=k, mass=m1, docked_mass=inputs["M2"],
        drag_ratio=inputs["b2_over_b1"], docking_time=inputs["t_dock"], mode=inputs["mode"],
        submersible_velocity=inputs.get("v_sub", 0.0),
    )  # fmt: skip
    start = (float(inputs["y0_steady"]), inputs["v0_steady"] * math.sqrt(k / m1))
    run, values = _docked(system, start, inputs["t_dock"], inputs["t_end"])
    return {**values, "dynamic_tension_max": run.tension_max / k}


def docking_slack(inputs: Values, expected: Values) -> Values:
    """The same on a line that may go slack, from the orbit reached from rest; the weight in water does not change."""
    w = inputs["w"]
    system = dimensionless_system(
        inputs["B1"], inputs["r1"], w, docked_mass=inputs["M2_over_M1"], drag_ratio=inputs["b2_over_b1"],
        docking_time=inputs["tau_dock"], mode=inputs["mode"], submersible_velocity=inputs.get("v_sub", 0.0),
    )  # fmt: skip
    start = orbits.steady(replace(system, cradle=replace(system.cradle, docking_time=-1.0))).state
    run, values = _docked(system, start, inputs["tau_dock"], inputs["tau_end"])
    return {**values, "tension_max": run.tension_max, "dynamic_tension_max": run.tension_max - (w or 0.0)}


def _pair(inputs: Values, damping_ratio: float, w: float | None, force: tuple[float, float]) -> Simulation:
    m1, k1 = inputs["m1"], inputs["K1"]
    system = dimensionless_system(
        inputs.get("B", 0.0), 1.0, w, amplitude=0.0, stiffness=inputs["K2"], mass=inputs["m2"],
        hull=(m1, 2.0 * damping_ratio * math.sqrt(k1 * m1), k1), two_way=True, force=force,
    )  # fmt: skip
    start = tuple(float(inputs.get(key, 0.0)) for key in ("x0", "vx0", "y0", "vy0"))
    return Simulation(system, 0.0, start)


def two_dof_free(inputs: Values, expected: Values) -> Values:
    """Two masses on two springs, undamped."""
    for key in ("x0", "vx0", "y0", "vy0"):
        inputs[key]
    run = _pair({**inputs, "B": 0.0}, 0.0, None, (0.0, 0.0))
    return dict(zip(("x", "vx", "y", "vy"), run.advance(inputs["tau"])))


def two_dof_nonlinear(inputs: Values, expected: Values) -> Values:
    """Ship and cradle under a wave force; drag on the cradle is B |y'| y', its line may go slack."""
    force = inputs.get("ship_force") or {}
    wave = (float(force.get("amplitude", 1.0)), float(force["omega"])) if force else (0.0, 0.0)
    run = _pair({**inputs, "B": inputs["B"]}, inputs["zeta1"], inputs.get("w"), wave)
    values = dict(zip(("x", "vx", "y", "vy"), run.advance(inputs["tau"])))
    return {**values, "taut_switches": run.taut_switches, "slack_time": run.slack_time}


SOLVERS: dict[str, Callable[[Values, Values], Values]] = {
    "transient": transient,
    "steady_orbit": steady_orbit,
    "attractors": attractors,
    "sample_table": sample_table,
    "free_decay": free_decay,
    "docking": docking,
    "docking_slack": docking_slack,
    "two_dof_free": two_dof_free,
    "two_dof_nonlinear": two_dof_nonlinear,
}
