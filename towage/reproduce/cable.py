"""The report on towed cables: its sample tables and its computer experiment, of ``cable.toml``.

Quantities of the samples are in units of a segment, the tow speed and the tension at the body.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from towage.models.cable.steady.perturbation import Excitation
from towage.models.cable.steady.response import respond
from towage.models.cable.steady.shooting import respond_by_shooting
from towage.reproduce import plots
from towage.reproduce.cable_scheme import frozen_angles, omflo, omway
from towage.reproduce.items import Answer, Column

LENGTHS, KNOTS = (200.0, 400.0, 600.0, 800.0, 1000.0, 1200.0), (6.0, 10.0, 14.0)
FREQUENCIES = np.arange(0.01, 0.801, 0.01)
SEGMENT, SPEED, SAMPLE_KNOTS = 10.0, 23.6, 14.0
"""Of the sample: ft, ft/s, kn. The report does not print them; they are read from its groups."""


def sample_omway() -> Answer:
    """Increments of the configuration by frozen coefficients and superposition of modes."""
    tow, omega, printed = omway()
    turn, phi = frozen_angles(tow, omega, Excitation(heave=1.0))
    numbers: dict[str, complex] = {}
    for row in range(len(printed)):
        cx, cy = -turn[row] * math.sin(phi[row]), turn[row] * math.cos(phi[row])
        for name, value in (("CX", cx), ("CY", cy)):
            numbers[f"{name}M, J = {row + 2}"] = complex(abs(value))
            numbers[f"D{name}, J = {row + 2}"] = complex(cmath.phase(value))
    return Answer(numbers, _listed(numbers), note="The scheme is wrong in two ways: `towage/reproduce/cable_scheme.py`.")


def sample_omway_true() -> Answer:
    """The perturbation solved by collocation; the scheme's angle at the towpoint beside it."""
    tow, omega, _ = omway()
    found = respond(tow, omega, Excitation(heave=1.0))
    x, y = (abs(v[-1, -1]) for v in found.configuration)
    turn, _ = frozen_angles(tow, omega, Excitation(heave=1.0))
    exact = found.angle[-1, -1]
    numbers = {"CXM at the towpoint": complex(x), "CYM at the towpoint": complex(y)}
    note = f"The scheme's angle at the towpoint is {100.0 * abs(turn[-1] - exact) / abs(exact):.1f} % off."
    shot, _ = respond_by_shooting(tow, omega, Excitation(heave=1.0))
    difference = float(np.max(np.abs(found.angle - shot.angle)) / np.max(np.abs(found.angle)))
    return Answer(numbers, _listed(numbers), None, difference, "collocation and shooting with exact coefficients", note)


def sample_omflo() -> Answer:
    """The same in Quadrant II."""
    printed, found = omflo()
    numbers = {f"CYM, row {row}": complex(abs(value)) for row, value in enumerate(found, 1)}
    known = [abs(cmath.phase(a / b)) for a, b in zip(found, printed) if b.imag]
    note = f"Phases differ by at most {max(known):.1e} rad where they are printed; amplitudes of 1e-4 are printed to 1e-6."
    return Answer(numbers, _listed(numbers), note=note)


def experiment_with_the_sample() -> Answer:
    """First frequency at which the tangential velocity or the tension at the towpoint exceeds its steady value, heave 10 ft, the
    force on the body as in the sample; 0 where none does up to 0.8 Hz."""
    rows: list[tuple[float, float, float, float]] = []
    for length in LENGTHS:
        for knots in KNOTS:
            failed = _failures(length, knots)
            rows.append((length, knots, *failed))
    names = ("length, ft", "speed, kn", "VM from, Hz", "TM from, Hz")
    columns: dict[str, Column] = {name: np.array(values) for name, values in zip(names, zip(*rows))}
    shown: dict[str, tuple[Sequence[float], Sequence[float]]] = {}
    for knots in KNOTS:
        here = [row for row in rows if row[1] == knots and row[2]]
        shown[f"VM, {knots:g} kn"] = [r[0] for r in here], [r[2] for r in here]
    draw = partial(plots.points, title="VM exceeds V0", across="length, ft", up="from, Hz", series=shown)
    note = (
        "A higher speed helps, as the report says, and VM mostly fails before TM. A longer cable fails later here, earlier in "
        "the report: its inputs must have changed with the length."
    )
    return Answer({}, columns, draw, note=note)


def _failures(length: float, knots: float) -> tuple[float, float]:
    tow, _, _ = omway()
    tow = replace(tow, cable=replace(tow.cable, length=length / SEGMENT), speed=knots / SAMPLE_KNOTS)
    found = [0.0, 0.0]
    for hertz in FREQUENCIES:
        response = respond(tow, 2.0 * math.pi * float(hertz) * SEGMENT / SPEED, Excitation(heave=1.0))
        angle, tension, _, _ = response.steady.at(tow.cable.length)
        ratios = abs(response.velocity[1][-1, -1]) / (tow.speed * math.cos(angle)), abs(response.tension[-1, -1]) / tension
        found = [first or (float(hertz) if ratio > 1.0 else 0.0) for first, ratio in zip(found, ratios)]
        if all(found):
            break
    return found[0], found[1]


def _listed(numbers: dict[str, complex]) -> dict[str, Column]:
    return {"what": list(numbers), "computed": [value.real for value in numbers.values()]}
