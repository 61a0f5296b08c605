"""A towed body in MoorDyn: 120 m cable, 900 kg body, 6 kn, heave of the towpoint; the case of ``tow_case``.

    fairlead: x = c (t - ramp), z = a r(t) sin(omega t);  body: free point with volume, drag area and added mass

MoorDyn extrapolates the fairlead linearly over a coupling step, so the velocity that it is given is the difference
quotient of the positions; with the velocity itself a step of 0.05 s loses 20 % of the tension's amplitude.

Source of the conventions: MoorDyn 2.7, ``source/Line.cpp`` (drag, added mass) and ``docs``; tangential drag pi Cdt d.
"""

from __future__ import annotations

import contextlib
import math
import os
import tempfile
import time as clock
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from towage.models.cable.case import Body, Cable, Tow
from towage.models.cable.loading import cross_flow

SPEED, DENSITY, GRAVITY, DIAMETER = 3.0867, 1025.0, 9.80665, 0.015
MASS, LENGTH, STIFFNESS, DRAG, FRICTION = 0.83, 120.0, 4e6, 1.2, 0.05
BODY_MASS, BODY_VOLUME, BODY_DRAG_AREA = 900.0, 0.25, 0.30
FREQUENCY = 0.4 * math.pi


def tow_case() -> Tow:
    """The same tow for towage, SI; quadratic drag of the body linearised about the tow speed."""
    drag = 0.5 * DENSITY * BODY_DRAG_AREA * SPEED**2
    weight = (MASS - DENSITY * math.pi * DIAMETER**2 / 4.0) * GRAVITY
    added = DENSITY * BODY_VOLUME
    cable = Cable(LENGTH, MASS, weight, DIAMETER, DRAG, cross_flow(FRICTION), 1.0, False, STIFFNESS)
    net = (BODY_MASS - DENSITY * BODY_VOLUME) * GRAVITY
    return Tow(cable, Body(BODY_MASS, added, added, net, 0.0, drag, 2.0 * drag / SPEED, drag / SPEED), SPEED, DENSITY)


@dataclass(frozen=True)
class MoorDynRun:
    """``time``, s, ``tension`` of the top segment and fairlead ``force`` (forward, up), N, ``body`` relative to the
    fairlead (forward, up), m; ``cost``: processor seconds per simulated second."""

    time: NDArray[np.float64]
    top: NDArray[np.float64]
    bottom: NDArray[np.float64]
    force: NDArray[np.float64]
    body: NDArray[np.float64]
    cost: float


@contextlib.contextmanager
def quiet() -> Iterator[None]:
    """Without the output that the library writes past Python, a line a step."""
    saved = [os.dup(n) for n in (1, 2)]
    with open(os.devnull, "w") as sink:
        try:
            for n in (1, 2):
                os.dup2(sink.fileno(), n)
            yield
        finally:
            for n, copy in zip((1, 2), saved):
                os.dup2(copy, n)
                os.close(copy)


DECK = """--------------------- MoorDyn Input File ------------------------------------
---------------------- LINE TYPES -----------------------------------
TypeName Diam Mass/m EA BA/-zeta EI Cd Ca CdAx CaAx
(name) (m) (kg/m) (N) (N-s/-) (N-m^2) (-) (-) (-) (-)
cable {diameter} {mass} {stiffness} -0.1 0 {drag} 1.0 {tangential_drag} 0
---------------------- POINTS -----------------------------------
ID Attachment X Y Z Mass Volume CdA Ca
(#) (word/ID) (m) (m) (m) (kg) (m^3) (m^2) (-)
1 Free -77.5 0 -487.5 {body_mass} {body_volume} {body_drag_area} 1.0
2 Coupled 0 0 -400 0 0 0 0
---------------------- LINES -----------------------------------
ID LineType AttachA AttachB UnstrLen NumSegs Outputs
(#) (name) (ID) (ID) (m) (-) (-)
1 cable 1 2 {length} {segments} -
---------------------- OPTIONS -----------------------------------
0 writeLog
{inner_step} dtM
rk4 tScheme
{gravity} g
{density} rho
3000 WtrDpth
0 TmaxIC
------------------------- need this line --------------------------------------
"""


def deck(segments: int, inner_step: float) -> str:
    """MoorDyn's input file of the case."""
    return DECK.format(
        diameter=DIAMETER, mass=MASS, stiffness=STIFFNESS, drag=DRAG, tangential_drag=FRICTION * DRAG / math.pi,
        body_mass=BODY_MASS, body_volume=BODY_VOLUME, body_drag_area=BODY_DRAG_AREA, length=LENGTH, segments=segments,
        inner_step=inner_step, gravity=GRAVITY, density=DENSITY,
    )  # fmt: skip


def fairlead(t: float, amplitude: float, start: float) -> list[float]:
    """Place of the towpoint (x forward, y, z up), m: brought to speed over 15 s, heave ramped over 10 s from ``start``."""
    s = min(t / 15.0, 1.0)
    x = SPEED * (t - 7.5 if s >= 1.0 else 15.0 * (s**3 - 0.5 * s**4))
    q = min(max((t - start) / 10.0, 0.0), 1.0)
    ramp = q**3 * (10.0 - 15.0 * q + 6.0 * q * q)
    return [x, 0.0, -400.0 + amplitude * ramp * math.sin(FREQUENCY * t)]


def run(amplitude: float, segments: int, inner_step: float, step: float, settle: float, record: float) -> MoorDynRun:
    """Tow for ``settle`` seconds, heave (``amplitude``, m) from its last 60 on, then record ``record`` seconds."""
    import moordyn

    start = settle - 60.0
    rows = []
    with tempfile.TemporaryDirectory() as folder, quiet():
        path = Path(folder) / "tow.txt"
        path.write_text(deck(segments, inner_step))
        system = moordyn.Create(str(path))
        moordyn.Init(system, fairlead(0.0, amplitude, start), [0.0, 0.0, 0.0])
        line, body = moordyn.GetLine(system, 1), moordyn.GetPoint(system, 1)
        count = round((settle + record) / step)
        begin = clock.process_time()
        for k in range(count):
            t = k * step
            here, there = fairlead(t, amplitude, start), fairlead(t + step, amplitude, start)
            force = moordyn.Step(system, here, [(b - a) / step for a, b in zip(here, there)], t, step)
            if t + step > settle + 1e-9:
                place = moordyn.GetPointPos(body)
                rows.append([
                    t + step, np.linalg.norm(moordyn.GetLineNodeTen(line, segments)),
                    np.linalg.norm(moordyn.GetLineNodeTen(line, 0)), force[0], force[2], place[0] - there[0],
                    place[2] - there[2],
                ])  # fmt: skip
        cost = (clock.process_time() - begin) / (count * step)
        moordyn.Close(system)
    table = np.array(rows)
    return MoorDynRun(table[:, 0], table[:, 1], table[:, 2], table[:, 3:5], table[:, 5:7], cost)


def harmonic(time: NDArray[np.float64], values: NDArray[np.float64], order: int = 1) -> complex:
    """Complex amplitude of a harmonic of `FREQUENCY` over whole periods."""
    return complex(2.0 * np.mean(values * np.exp(1j * order * FREQUENCY * time)))
