"""Error that a tow makes by being linear: in tensions and in the motion of the body, for any drive.

    error = largest |nonlinear - linear| over the largest |linear|, after the start

The nonlinear motion is that of ``picard.py``, so that the whole run of a unit, from rest to the end of its drive, costs a
fraction of a second. The body's oscillation is judged about its mean; its mean shift (a body that is towed in waves runs
higher or deeper) is told apart, in m.

    bound = 1.15 error + remainder,   remainder = last correction * q/(1 - q),   q: how the corrections shrink

The remainder is proved for a contraction by q, which is taken from the last two corrections. The 15 % are for the segments,
which are few and the same for both motions, and the times: calibrated on random tows (``tests/verdict/tows.py``).

Assumptions: those of ``picard.py``.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from ...numeric.arrays import Array, ComplexArray
from ..case import CableError, Tow
from .lumped import hanging
from .picard import DIVERGED, KEPT, Corrections, Motion, Picard, apart

SEGMENTS, SEGMENTS_SHARE = 16, 0.15
"""At least so many, the same for both motions; the share of the error that they and the times may change."""
PERIOD_POINTS = 64
"""Times of a period of a regular drive: harmonics up to the 21st."""
HARMONICS = 4.0
"""Highest frequency of the corrections over that of the drive; the fourth is below 1 % where anything can be judged."""
NEGLIGIBLE = 1e-6
"""Share of the square of the drive's rate that its highest frequencies may hold."""
FEWEST_TIMES, MOST_TIMES, MOST_NUMBERS = 64, 8192, 4e6
"""Times of a record, and numbers in the matrices of its frequencies: 64 MB."""
TAPER, REST = 0.1, 0.25
"""After its end a drive dies out over the first share of its length, and nothing moves for the second one."""
PARTS = 4
"""Peaks are looked for at so many times as many times as the corrections have."""
DECAY = 8.0
"""What is left of the end at the start is e^-8 of it: no trace of a motion that is still ringing. With e^-5 a slightly damped
tow at its resonance was 2 % off; e^-12 changes 0.05 %."""
ENOUGH, SHRINKS = 1e-3, 0.7
"""Corrections smaller than the first, or that shrink by the second, are followed to their end."""


@dataclass(frozen=True)
class Linearity:
    """Relative errors of the linear model: ``tension_top``, ``tension_body``, ``motion`` of the body about its mean; ``bound``
    of the largest; ``rise``, ``ahead``: mean shift of the body, up and forward, m; ``heave``: linear amplitude of its heave,
    m; ``time``, s, of the largest error of the tension at the top. ``followed``: the corrections converge, else the errors
    are those of the last that made sense, and may be larger. ``model``: the largest difference of a model's own motion to the
    linear one, likewise relative, where it was given."""

    tension_top: float
    tension_body: float
    motion: float
    bound: float
    rise: float
    ahead: float
    heave: float
    time: float
    followed: bool
    model: float = 0.0

    @property
    def error(self) -> float:
        """The largest of the errors."""
        return max(self.tension_top, self.tension_body, self.motion)


RIGHT = Linearity(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, True)
"""Of a tow that is not moved."""
STILL = 1e-7
"""Drives below this share of the tow speed and of the tension at the body make no error that could be told from rounding."""


def _still(tow: Tow, drive: Array) -> bool:
    return bool(np.abs(drive[:2]).max() < STILL * tow.speed and np.abs(drive[2:]).max() < STILL * tow.end_tension)


def regular(tow: Tow, quadratic_drag: bool, amplitudes: ComplexArray, omega: float) -> Linearity:
    """Of a regular drive at ``omega``, rad/s, with complex ``amplitudes`` (4,) of Re(q exp(-i omega t)): velocity of the
    towpoint, m/s, forward and up, and force on the body, N. Raises `CableError`."""
    step = 2.0 * math.pi / omega / PERIOD_POINTS
    turning = np.exp(-1j * omega * step * np.arange(PERIOD_POINTS))
    drive = (np.asarray(amplitudes)[:, None] * turning).real
    top: Array = (1j / omega * np.asarray(amplitudes)[:2, None] * turning).real
    chain = hanging(tow, SEGMENTS)
    if _still(tow, drive):
        return RIGHT
    made = Picard(chain, quadratic_drag, step, PERIOD_POINTS).run(drive)
    return _judged(made, top, np.linspace(0.0, step * (PERIOD_POINTS - 1), PERIOD_POINTS), 0.0)


def recorded(
    tow: Tow, quadratic_drag: bool, time: Array, drive: Array, settle: float, own: Array | None = None, segments: int = SEGMENTS,
) -> Linearity:  # fmt: skip
    """Of a ``drive`` (4, n), as `regular` has it, at equally spaced times (n,), s, from the steady tow at the first one; judged
    from ``settle`` on. Only the largest part of a drive that is too long for `MOST_NUMBERS` is followed. ``own`` (4, n): what
    a linear model of ``segments`` made of the drive, changes of the tensions at top and body, N, and motion of the body, m;
    so many are taken, where the drive is short enough for them. Raises `CableError`."""
    from scipy.interpolate import CubicSpline  # takes long to load, and a unit may never ask

    times = time
    if _still(tow, drive):
        return RIGHT
    if len(time) < FEWEST_TIMES:
        raise CableError(f"the drive is known at {len(time)} times: expected at least {FEWEST_TIMES}, by a shorter step")
    highest = highest_frequency(time, drive)
    wanted = KEPT * math.pi / (HARMONICS * highest) if highest else math.inf
    stride = int(min(max(1.0, wanted / (time[1] - time[0])), max(1, len(time) // FEWEST_TIMES)))
    time, drive = time[::stride], drive[:, ::stride]
    step = float(time[1] - time[0])
    fine_enough = int(0.5 * math.sqrt(MOST_NUMBERS / (KEPT * (1.0 + REST + TAPER) * len(time))))
    chain = hanging(tow, max(SEGMENTS, min(segments, fine_enough)))
    most = int(min(MOST_TIMES, MOST_NUMBERS / (2 * chain.count) ** 2 / KEPT) / (1.0 + REST + TAPER))
    kept = _largest(time, drive, settle, most)
    time, drive = time[kept], drive[:, kept]
    dying = int(TAPER * len(time)) + 1
    if kept.start:
        # from rest, as a tow begins
        drive = drive * np.minimum(1.0, np.arange(len(time)) / dying)
        settle = max(settle, float(time[dying]))
    whole = _ended(drive, dying, int(REST * len(time)))
    engine = Picard(chain, quadratic_drag, step, whole.shape[1], DECAY / (step * whole.shape[1]))
    made = engine.run(whole)
    fine = np.linspace(time[0], time[-1], PARTS * (len(time) - 1) + 1)
    top = CubicSpline(time, drive[:2], axis=1).antiderivative()(fine)
    linear, *corrected = (_finer(engine, motion) for motion in (made.linear, *made.corrected))
    found = _judged(replace(made, linear=linear, corrected=tuple(corrected)), top, fine, settle)
    if own is None or kept.start:
        return found
    # what was before a part that is followed alone is in the model's motion, and not in this one
    values = CubicSpline(times, own, axis=1)(fine)
    model = Motion(values[0], values[1], values[2:] - top)
    late = slice(int(np.searchsorted(fine, settle)), len(fine))
    one, two = (_of(motion, top, len(fine), late) for motion in (model, linear))
    return replace(found, model=max(apart(one, two, two)))


def _finer(engine: Picard, motion: Motion) -> Motion:
    return Motion(*(engine.between(values, PARTS) for values in (motion.tension_top, motion.tension_body, motion.body)))


def highest_frequency(time: Array, drive: Array) -> float:
    """Angular frequency, rad/s, above which nothing of the drive's rate is left but `NEGLIGIBLE`; 0 without a drive."""
    omega = 2.0 * math.pi * np.fft.rfftfreq(len(time), time[1] - time[0])
    # each of the four against its own largest
    power = np.abs(np.fft.rfft(drive * np.hanning(len(time)))) ** 2 * omega**2
    above = np.cumsum(power[:, ::-1], axis=1)[:, ::-1]
    counts = (above > NEGLIGIBLE * above[:, :1]) & (above[:, :1] > 0.0)
    return float(omega[np.flatnonzero(counts.any(axis=0))].max(initial=0.0))


def _largest(time: Array, drive: Array, settle: float, most: int) -> slice:
    """The ``most`` times in whose middle the drive is largest after ``settle``."""
    if len(time) <= most:
        return slice(0, len(time))
    size = np.abs(drive) / np.maximum(np.abs(drive).max(axis=1, keepdims=True), 1e-300)
    middle = int(np.argmax(size.max(axis=0) * (time >= settle)))
    first = min(max(0, middle - most // 2), len(time) - most)
    return slice(first, first + most)


def _ended(drive: Array, dying: int, quiet: int) -> Array:
    """The drive, continued with its slope and dying out over ``dying`` times, then ``quiet`` ones without any."""
    share = np.arange(1, dying + 1) / (dying + 1.0)
    weight = 0.5 + 0.5 * np.cos(math.pi * share)
    tail = (2.0 * drive[:, -1:] - drive[:, -2 : -2 - dying : -1]) * weight
    return np.hstack([drive, tail, np.zeros((4, quiet))])


def _judged(made: Corrections, top: Array, time: Array, settle: float) -> Linearity:
    """The errors from ``settle``, s, on; ``top``: displacement of the towpoint, m, (2, n)."""
    n, part = len(time), slice(int(np.searchsorted(time, settle)), len(time))
    steps = [_of(motion, top, n, part) for motion in (made.linear, *made.corrected)]
    linear = steps[0]
    followed = (made.last < DIVERGED and made.shrinks < SHRINKS) or made.last < ENOUGH
    best = steps[-1] if followed else steps[1]
    errors = apart(best, linear, linear)
    ratio = min(made.shrinks, SHRINKS)
    bound = (1.0 + SEGMENTS_SHARE) * max(errors) + (made.last * ratio / (1.0 - ratio) if followed else max(errors))
    shift = made.corrected[-1 if followed else 0].body[:, :n][:, part] - made.linear.body[:, :n][:, part]
    worst = int(np.argmax(np.abs(best.tension_top - linear.tension_top)))
    return Linearity(
        *errors, bound, float(shift[1].mean()), float(shift[0].mean()), float(np.abs(linear.body[1]).max()),
        float(time[part][worst]), followed,
    )  # fmt: skip


def _of(motion: Motion, top: Array, n: int, part: slice) -> Motion:
    """A motion over ``part`` of the first ``n`` times, the body's about its mean and with the towpoint's."""
    body = (motion.body[:, :n] + top)[:, part]
    return Motion(motion.tension_top[:n][part], motion.tension_body[:n][part], body - body.mean(axis=1, keepdims=True))
