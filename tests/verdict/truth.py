"""The true error of the one-way model of a body on a line below a ship, without coupling, FMUs or the project's models.

`truth.c` integrates both degrees of freedom as one system with located events. The errors are those that the word is about:
amplitude (half the swing), peak tension above its mean, rms of the difference of motion and of tension over the standard
deviation of the one-way signal, on the same time as the run that is judged. A subharmonic motion shifted by whole periods is
the same motion. Where the motion is chaotic (a start 1e-9 apart leaves it) two runs differ at every instant, and the truth is
that of the statistics, from a run of many thousand periods.
"""

from __future__ import annotations

import ctypes
import functools
import math
import subprocess
import tempfile
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tests.verdict.family import Truth
from towage.fmus.native.compiler import compiler, host

Array = NDArray[np.float64]
SOURCE = Path(__file__).with_name("truth.c")
NUDGE = 1e-9
"""Difference of the starts of twins, over the amplitude."""
LEFT = 1e-4
"""Difference of twins, over the standard deviation, of a chaotic motion: a resonance of damping ratio 5e-3 makes 1e-7 of it."""
SAMPLES = 160
"""Samples a period of wave or body, the shorter."""
RADIANS = 0.05
"""Of the fastest frequency a step."""
LONG = 3000
"""Periods from which the statistics of chaos are taken."""
BLOCKS = 20
MOST_PERIODS = 8
SAME = 1e-3
"""rms, over the standard deviation, below which a motion has repeated."""


@dataclass(frozen=True)
class Pair:
    """Ship, line, body and sea; SI. The free heave is r(t) sum ``amplitude`` cos(``frequency`` t + ``phase``), r a smooth rise
    over ``ramp``; ``period`` of a regular sea, else 0."""

    ship_mass: float
    ship_damping: float
    ship_stiffness: float
    mass: float
    drag: float
    stiffness: float
    weight: float
    ramp: float
    amplitude: tuple[float, ...]
    frequency: tuple[float, ...]
    phase: tuple[float, ...]
    period: float

    @property
    def size(self) -> float:
        """Amplitude of a regular sea of the same variance, m."""
        return math.sqrt(sum(a * a for a in self.amplitude))


def compiled(sources: Iterable[Path], *folders: Path) -> ctypes.CDLL:
    """C ``sources`` as a library for this process, with headers from ``folders``."""
    place = Path(tempfile.mkdtemp(prefix="truth")) / "truth.so"
    flags = ("-std=c99", "-O2", "-fno-math-errno", "-fPIC", "-shared", "-Wall", "-Werror")
    included = [word for folder in folders for word in ("-I", str(folder))]
    subprocess.run([*compiler(host()), *flags, *included, *map(str, sources), "-o", str(place), "-lm"], check=True)
    return ctypes.CDLL(str(place))


@functools.cache
def library() -> ctypes.CDLL:
    """`truth.c`."""
    loaded = compiled([SOURCE])
    number, whole, pointer = ctypes.c_double, ctypes.c_long, ctypes.c_void_p
    loaded.solve.argtypes = [pointer, whole, whole, pointer, pointer, pointer, number, number, number, whole, pointer, pointer]
    loaded.solve.restype = None
    return loaded


def solve(pair: Pair, two_way: bool, dt: float, samples: int, start: float = 0.0) -> tuple[Array, Array]:
    """Heave of the body, m, and tension, N, at multiples of ``dt``, s, shapes (samples,)."""
    p = pair
    own = math.sqrt(p.stiffness / p.mass)
    fastest = max(own, *p.frequency)
    if two_way:
        ship = math.sqrt((p.ship_stiffness + p.stiffness) / p.ship_mass)
        fastest = max(fastest, ship, own * math.sqrt(1.0 + p.mass / p.ship_mass))
    values = np.array([p.ship_mass, p.ship_damping, p.ship_stiffness, p.mass, p.drag, p.stiffness, p.weight, p.ramp])
    waves = [np.array(row) for row in (p.amplitude, p.frequency, p.phase)]
    heave, tension = np.empty(samples), np.empty(samples)
    library().solve(
        values.ctypes.data, int(two_way), len(p.amplitude), *(row.ctypes.data for row in waves), start, dt, RADIANS / fastest,
        samples, heave.ctypes.data, tension.ctypes.data,
    )  # fmt: skip
    return heave, tension


def truth(pair: Pair, settle: float, stop: float) -> Truth:
    """The errors of the one-way model from ``settle`` to ``stop``, s."""
    own = 2.0 * math.pi * math.sqrt(pair.mass / pair.stiffness)
    dt = min(own, 2.0 * math.pi / max(pair.frequency)) / SAMPLES
    if pair.period:
        dt = pair.period / math.ceil(pair.period / dt)
    samples, first = int(stop / dt) + 1, math.ceil(settle / dt)
    one, two = solve(pair, False, dt, samples), solve(pair, True, dt, samples)
    for way, motion in ((False, one[0]), (True, two[0])):
        twin = solve(pair, way, dt, samples, NUDGE * pair.size)[0]
        late = slice(first + 2 * (samples - first) // 3, None)
        if rms(twin[late] - motion[late]) > LEFT * float(motion[late].std()):
            return statistical(pair, settle, dt)
    x, y = (run[0][first:] for run in (one, two))
    amplitude = abs(relative(np.ptp(x), np.ptp(y)))
    above = [float(run[1][first:].max() - run[1][first:].mean()) for run in (one, two)]
    motion, tension = least(pair, dt, [run[0][first:] for run in (one, two)], [run[1][first:] for run in (one, two)])
    return Truth(max(amplitude, abs(relative(*above)), motion, tension), max(amplitude, motion), False)


def least(pair: Pair, dt: float, heave: list[Array], tension: list[Array]) -> tuple[float, float]:
    """rms of the difference of motions and of tensions over the standard deviation, at the shift by whole periods at which
    the motions differ least, where the one-way motion repeats."""
    lag = round(pair.period / dt)
    shifts = [0]
    for n in range(1, MOST_PERIODS + 1) if lag else ():
        x = heave[0]
        if n * lag < len(x) - 8 and rms(x[n * lag :] - x[: -n * lag]) <= SAME * float(x.std()):
            shifts = [k * lag for k in range(n)]
            break

    def apart(one: Array, two: Array, shift: int) -> float:
        late = one[shift:]
        return rms(two[: len(late)] - late) / float(late.std())

    return min((apart(*heave, shift), apart(*tension, shift)) for shift in shifts)


def statistical(pair: Pair, settle: float, dt: float) -> Truth:
    """Errors of standard deviation and of the largest tenth of the crests, of motion and tension, over `LONG` periods."""
    period = pair.period or 2.0 * math.pi / pair.frequency[int(np.argmax(np.abs(pair.amplitude)))]
    dt *= 4.0
    first = math.ceil(settle / dt)
    samples = first + int(LONG * period / dt)
    runs = [solve(pair, way, dt, samples) for way in (False, True)]
    worst = []
    for k in (0, 1):
        blocks = [np.array_split(run[k][first:], BLOCKS) for run in runs]
        for measure in (np.std, largest_tenth):
            means = [np.array([measure(block) for block in side]) for side in blocks]
            error = abs(relative(float(means[0].mean()), float(means[1].mean())))
            spread = math.hypot(*(float(side.std(ddof=1) / side.mean()) for side in means))
            worst.append((error, 2.1 * spread / math.sqrt(BLOCKS), k))
    error, noise, _ = max(worst)
    return Truth(error, max(w[0] for w in worst if w[2] == 0), True, noise)


def largest_tenth(values: Array) -> float:
    """Mean of the largest tenth of the crests above the mean."""
    v = values - values.mean()
    crests = np.sort(v[1:-1][(v[1:-1] >= v[:-2]) & (v[1:-1] > v[2:]) & (v[1:-1] > 0.0)])
    return float(crests[-max(1, len(crests) // 10) :].mean()) if len(crests) else 0.0


def rms(values: Array) -> float:
    """Root of the mean square."""
    return math.sqrt(float(np.mean(values**2)))


def relative(one: float, two: float) -> float:
    """one / two - 1."""
    return one / two - 1.0 if two else math.inf if one else 0.0
