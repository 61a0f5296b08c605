"""The thesis on the docking platform: every table, figure and example of ``cradle.toml``.

Steady motions are periodic orbits found by shooting; `Answer.methods` compares some of them with a long transient, and closed
forms with the integrated equation. Lengths over X0, r = omega/omega0, B = b X0/M, w = W/(K X0).
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from towage.models.heave import linear, orbits, sdof
from towage.models.heave.system import Simulation
from towage.reproduce import plots
from towage.reproduce.cradle_orbits import (
    DRAGS,
    RATIOS,
    TURN,
    as_complex,
    by_transients,
    curve,
    first_integral,
    largest,
    line_tension,
    linear_motion,
    linear_system,
    listed,
    orbit,
    sdof_error,
    short,
)
from towage.reproduce.items import Answer, Column
from towage.verify.cradle import dimensionless_system

Array = NDArray[np.float64]
BREAKS = 53000.0
"""lb."""
BY = "orbits by shooting and long transients"
INTEGRATED = "the closed form and the integrated equation"
G = 32.174
"""ft/s2."""
ZETAS = (0.05, 0.1, 0.15, 0.25, 0.4, 0.7)


def figures_3_and_4() -> Answer:
    """The linear transient of figure 7 in closed form, beside the eighth-order integration of the same equation."""
    return replace(figure_7(), numbers={})


def figure_5() -> Answer:
    """Largest displacement of the steady orbit over frequency."""
    curves = {f"B = {b:g}": np.array([o.heave_max for o in curve(b)]) for b in DRAGS}
    columns: dict[str, Column] = {"r": RATIOS, **curves}
    numbers = {f"Ymax at r = 1, B = {short(b)}": orbit(b, 1.0).heave_max for b in (0.294, 0.3)}
    numbers |= {"largest Ymax, B = .3": largest(0.3)[1], "Ymax at r = 2.075, B = .3": orbit(0.3, 2.075).heave_max}
    draw = partial(plots.curves, title="Transmissibility, quadratic drag", across="omega/omega0", up="Ymax/X0", columns=columns)
    return Answer(as_complex(numbers), columns, draw, by_transients(), BY)


def figure_6() -> Answer:
    """1/sqrt((1 - r^2)^2 + (2 zeta r)^2)."""
    columns: dict[str, Column] = {"r": RATIOS}
    columns |= {f"zeta = {z:g}": np.array([linear_motion(z, r)[0] for r in RATIOS]) for z in ZETAS}
    draw = partial(plots.curves, title="Transmissibility, linear drag", across="omega/omega0", up="Ymax/X0", columns=columns)
    return Answer({"Ymax at r = 1, zeta = .25": complex(linear_motion(0.25, 1.0)[0])}, columns, draw)


def figure_7() -> Answer:
    """The transient part is exp(-zeta tau) (A1 sin + A2 cos) at the damped frequency."""
    zeta, r, start = 0.3, 1.2, 2.24
    size, lag = linear_motion(zeta, r)
    damped = math.sqrt(1.0 - zeta * zeta)
    a2 = start + size * math.sin(lag)
    a1 = (zeta * a2 - size * r * math.cos(lag)) / damped
    turns = np.linspace(0.0, 5.0, 501)
    exact = np.array([linear.transient(TURN * t, 1.0, 2.0 * zeta, 1.0, 1.0, r, start)[0] for t in turns])
    run = Simulation(linear_system(zeta, r), 0.0, (start, 0.0))
    integrated = np.array([run.advance(TURN * float(t))[0] for t in turns])
    columns: dict[str, Column] = {"T": turns, "Y, exact": exact, "Y, integrated": integrated}
    difference = float(np.max(np.abs(exact - integrated)) / np.max(np.abs(exact)))
    draw = partial(plots.curves, title="Linear, r = 1.2, zeta = .3", across="T", up="Y", columns=columns)
    return Answer({"A1": complex(a1), "A2": complex(a2)}, columns, draw, difference, INTEGRATED)


def figure_8() -> Answer:
    """Lag of the linear motion, and of the component of the orbit at the forcing frequency."""
    lags = {f"zeta = {z:g}": np.array([math.degrees(linear_motion(z, r)[1]) for r in RATIOS]) for z in (0.1, 0.25)}
    lags |= {f"B = {b:g}": np.array([math.degrees(o.lag) % 360.0 for o in curve(b)]) for b in (0.1, 0.3, 1.0)}
    columns: dict[str, Column] = {"r": RATIOS, **lags}
    draw = partial(plots.curves, title="Phase lag", across="omega/omega0", up="lag of the cradle, deg", columns=columns)
    note = f"With B = .3 the component at r = 1 lags by {math.degrees(orbit(0.3, 1.0).lag):.3f} deg."
    number = complex(math.degrees(linear_motion(0.25, 1.0)[1]))
    return Answer({"lag at r = 1, linear": number}, columns, draw, by_transients(), BY, note)


def figure_9() -> Answer:
    """From rest at Y = 1, without forcing."""
    drag = 0.3
    run = Simulation(dimensionless_system(drag, 1.0, None, amplitude=0.0), 0.0, (1.0, 0.0))
    turns = np.linspace(0.0, 5.0, 501)
    decay = np.array([run.advance(TURN * float(t))[0] for t in turns])
    envelope = np.array([linear.minorsky_envelope(TURN * float(t), 1.0, drag, 1.0, 1.0) for t in turns])
    columns: dict[str, Column] = {"T": turns, "Y": decay, "Minorsky's envelope": envelope, "- envelope": -envelope}
    worst = max(
        abs(abs(y) / linear.minorsky_envelope(t, 1.0, drag, 1.0, 1.0) - 1.0) for t, y in run.turning_points if t > 0.0
    )
    extrema = [abs(y) for t, y in run.turning_points if t > 0.0]
    exact = first_integral(drag, len(extrema))
    difference = max(abs(a - b) for a, b in zip(extrema, exact))
    note = f"The envelope is {100.0 * worst:.3f} % off the extrema at most: 'excellent', as the thesis says."
    draw = partial(plots.curves, title="Free decay, B = .3", across="T", up="Y/Y(0)", columns=columns)
    return Answer({}, columns, draw, difference, "the integrated equation and the first integral between extrema", note)


def figure_10() -> Answer:
    """One period of both steady motions; the error of the drag of equal energy loss over the thesis' range of B and r."""
    drag, zeta = 0.294, 0.25
    steady, system = orbit(drag, 1.0), dimensionless_system(drag, 1.0, None)
    turns = np.linspace(0.0, 1.0, 201)
    run = Simulation(system, 0.0, steady.state)
    quadratic = np.array([run.advance(TURN * float(t))[0] for t in turns])
    size, lag = linear_motion(zeta, 1.0)
    columns: dict[str, Column] = {"T": turns, "B = .294": quadratic, "zeta = .25": size * np.sin(TURN * turns - lag)}
    errors = [
        abs(linear.lorentz(1.0, b, 1.0, 1.0, float(r))[0] / o.heave_max - 1.0) for b in DRAGS for r, o in zip(RATIOS, curve(b))
    ]
    numbers = {
        "Ymax at r = 1, B = .294": steady.heave_max, "Ymax at r = 1, zeta = .25": size,
        "largest error of equal energy loss in the amplitude, B up to 1": 100.0 * max(errors),
    }  # fmt: skip
    draw = partial(plots.curves, title="Quadratic and linear drag, r = 1", across="T", up="Y", columns=columns)
    return Answer(as_complex(numbers), columns, draw, by_transients(), BY)


def example_1() -> Answer:
    """With the rounded masses of the thesis, as it computed."""
    m1, m2, k1, k2 = 28.0, 1.617, 72.0, 1.0
    upper, lower = sdof.modes(m1, k1, m2, k2)
    alone = math.sqrt(k2 / m2)
    numbers = {
        "m1, 900 tons": 900.0 / G, "m2, 52 tons": 52.0 / G, "omega 1": upper.omega, "omega 2": lower.omega,
        "x2/x1 in mode 1": upper.shape, "x1/x2 in mode 2": 1.0 / lower.shape, "omega of Lulu alone": math.sqrt(k1 / m1),
        "omega of Sea Cliff alone": alone, "omega 1 over omega 2": upper.omega / lower.omega,
        "transmissibility at omega 1": 1.0 / ((upper.omega / alone) ** 2 - 1.0),
    }  # fmt: skip
    stiffness, masses = np.array([[k1 + k2, -k2], [-k2, k2]]), np.array([m1, m2])
    other = np.sqrt(np.sort(np.linalg.eigvals(stiffness / masses[:, None]).real))
    difference = float(np.max(np.abs(other / (lower.omega, upper.omega) - 1.0)))
    ratio, error, _ = sdof_error()
    note = (
        f"What the assumption costs: the amplitude of the cradle is at most {100.0 * error:.1f} % off for r from 0.2 to 4, at "
        f"r = {ratio:.3f}, near the ship's own resonance (zeta1 = .05, B = .3)."
    )
    return Answer(as_complex(numbers), listed(numbers), None, difference, "the closed form and an eigenvalue solver", note)


def figure_12() -> Answer:
    """From Y = -2 at rest, T = 0 to 5, with slack and without."""
    turns = np.linspace(0.0, 5.0, 501)
    columns: dict[str, Column] = {"T": turns}
    for name, w in (("may go slack", 1.6), ("never slack", None)):
        run = Simulation(dimensionless_system(0.3, 1.0, w), 0.0, (-2.0, 0.0))
        columns[f"Y, {name}"] = np.array([run.advance(TURN * float(t))[0] for t in turns])
    slack, taut = orbit(0.3, 1.0, 1.6), orbit(0.3, 1.0)
    note = (
        f"Slack reduces the motion from peak to peak from {taut.heave_max - taut.heave_min:.4f} to "
        f"{slack.heave_max - slack.heave_min:.4f}, as the thesis says, and here the dynamic tension too, from "
        f"{taut.tension_max:.4f} to {slack.tension_max - 1.6:.4f}, which the thesis expects to grow."
    )
    draw = partial(plots.curves, title="A cable that goes slack", across="T", up="Y", columns=columns)
    return Answer({"Ymax without slack": complex(taut.heave_max)}, columns, draw, by_transients(((0.3, 1.0, 1.6),)), BY, note)


def figure_14() -> Answer:
    """Steady motion of the cradle until T = 0, then with the submersible, which moves with the cradle as the thesis takes it."""
    k, m1, m2, omega = 1000.0, 450.0, 3361.0, TURN / 10.0
    alone, docked = math.sqrt(k / m1), math.sqrt(k / m2)
    numbers = {
        "omega with the cradle alone": alone, "omega with the submersible": docked,
        "r with the cradle alone": omega / alone, "r with the submersible": omega / docked,
    }  # fmt: skip
    system = dimensionless_system(0.3, omega / alone, None, docked_mass=m2 / m1, docking_time=0.0, mode="continuous")
    start = orbits.steady(replace(system, cradle=replace(system.cradle, docking_time=-1.0)))
    turns = np.linspace(0.0, 20.0, 801)
    run = Simulation(system, 0.0, start.state)
    motion = np.array([run.advance(TURN * float(t))[0] for t in turns])
    before = Simulation(replace(system, cradle=replace(system.cradle, docking_time=-1.0)), 0.0, start.state)
    columns: dict[str, Column] = {"T": turns, "with the submersible": motion}
    columns["without"] = np.array([before.advance(TURN * float(t))[0] for t in turns])
    note = "B is not stated; .3 here, of the cradle alone. The drag does not change with the submersible."
    draw = partial(plots.curves, title="Docking at T = 0", across="T of the cradle alone", up="Y", columns=columns)
    return Answer(as_complex(numbers), columns, draw, note=note)


def table_1() -> Answer:
    """2 pi sqrt(2200 L/(1040 100)), with the thesis' mass."""
    numbers = {f"{length} ft": TURN * math.sqrt(2200.0 * length / (1040.0 * 100.0)) for length in
               (10, 25, 50, 100, 200, 300, 500, 1000, 2000, 5000)}  # fmt: skip
    return Answer(as_complex(numbers), listed(numbers))


def example_4() -> Answer:
    """The chain of numbers; from the mass on with the thesis' own, since each is taken further there."""
    b = 0.5 * 1.9905 * 150.0
    numbers = {
        "weight of the mass": 33050.0 + 8100.0 + 18850.0, "mass": 60000.0 / G,
        "weight over breaking load": 100.0 * 8100.0 / BREAKS, "omega0 at 100 ft": math.sqrt(1040.0 / 2200.0), "b": b,
        "B": b * 4.4 / 2200.0, "largest Ymax, B = .3": largest(0.3)[1], "largest motion": 4.4 * largest(0.3)[1],
    }  # fmt: skip
    return Answer(as_complex(numbers), listed(numbers))


def breaking_envelope() -> Answer:
    """Largest tension over r from .6 to 1.4 on the thesis' mass and drag (B = .3). On short lines the motion may be chaotic or
    have several periods: every run begins at rest and counts for `COUNTED` periods after as many."""
    lengths, ratios = (10.0, 15.0, 25.0, 50.0, 100.0, 200.0, 300.0), np.linspace(0.6, 1.4, 9)
    table = np.array([[line_tension(length, float(r)) for r in ratios] for length in lengths])
    columns: dict[str, Column] = {
        "length, ft": np.array(lengths), "largest tension, lb": table.max(axis=1),
        "breaking load, lb": np.full(len(lengths), BREAKS), "at r": ratios[table.argmax(axis=1)],
    }  # fmt: skip
    shown = {name: np.asarray(columns[name], dtype=float) for name in list(columns)[:3]}
    longest = max(length for length, tension in zip(lengths, table.max(axis=1)) if tension > BREAKS)
    note = f"Of these lengths the line breaks up to {longest:g} ft: 'on a short length, the nylon line would break'."
    draw = partial(plots.curves, title="Alvin's line", across="length, ft", up="lb", columns=shown, log=(True, True))
    return Answer({}, columns, draw, note=note)


def appendix_2() -> Answer:
    """The listing's own equation, Y'' = -B |Y'| Y' - 39.48 (Y - sin(6.283 r T)), whose constants are rounded 4 pi^2 and 2 pi."""
    drag, r, stiffness, turn = 0.2, 0.9, 39.48, 6.283
    omega = math.sqrt(stiffness)  # in units of 1/T: the cradle has B and K = 39.48 there, the ship 6.283 r
    run = Simulation(dimensionless_system(drag, turn * r, None, stiffness=stiffness), 0.0, (-2.4, 0.0))
    exact = Simulation(dimensionless_system(drag, TURN * r, None, stiffness=TURN * TURN), 0.0, (-2.4, 0.0))
    numbers: dict[str, float] = {}
    off = 0.0
    for time in (0.04, 0.06, 0.08, 0.1):
        y, v = run.advance(time)
        off = max(off, abs(exact.advance(time)[1] / v - 1.0))
        at = f"at T = {short(time)}"
        pull = omega**2 * (y - math.sin(turn * r * time))
        numbers |= {f"Y {at}": y, f"dY/dT {at}": v, f"d2Y/dT2 {at}": -drag * abs(v) * v - pull}
    note = f"With 4 pi^2 and 2 pi unrounded dY/dT is up to {off:.1e} of itself off the printed one."
    return Answer(as_complex(numbers), listed(numbers), note=note)
