"""Wave fields on a regular grid of the plane and a regular series of times.

    F(x) = sum_i P_i(s) F_i,   P the cubic convolution kernel with a = -1/2 (Catmull-Rom),   s in [0, 1]

The tensor product in x, y and t has continuous first derivatives everywhere. Height, cos K and sin K are interpolated
one by one and the direction vector normalised after; where it vanishes (a vortex centre) there is no direction. One
more value at each end comes from the quadratic through the last three, 3 F(1) - 3 F(2) + F(3).

| symbol | meaning | unit |
|---|---|---|
| F | height, m; cos K, sin K (K: angle from +x toward which the waves come FROM); peak period, s | |

Assumptions: (1) after the last time the field stays as it was then (continuous, its time derivative is not; no equation
of a route contains that); (2) nothing is extrapolated in space: `inside` tells where there are data, and a route that
leaves them is refused; (3) interpolating a Gaussian storm of sigma 120 nm on a mesh of 60 nm costs 0.013 h, and
directions rounded to tens of degrees and heights to feet 0.03 h: the data are the error, not the solver.

Source: Minimal-time ship routing (1964), equations (27)-(29): P(x)/16 is this kernel; R. G. Keys, IEEE Trans. ASSP 29
(1981) 1153-1160.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from ..numeric.arrays import AnyArray
from .fields import Sea, directed_sea

# values at the four neighbours from 1, s, s^2, s^3
KERNEL = 0.5 * np.array([[0.0, 2.0, 0.0, 0.0], [-1.0, 0.0, 1.0, 0.0], [2.0, -5.0, 4.0, -1.0], [-1.0, 3.0, -3.0, 1.0]])
SLOPE = KERNEL[1:] * np.array([[1.0], [2.0], [3.0]])


def _weights(s: AnyArray) -> tuple[AnyArray, AnyArray]:
    """Kernel at the four neighbours and its derivative, (..., 4)."""
    powers = np.empty((*s.shape, 4))
    powers[..., 0] = 1.0
    powers[..., 1] = s
    np.multiply(s, s, out=powers[..., 2])
    np.multiply(powers[..., 2], s, out=powers[..., 3])
    return powers @ KERNEL, powers[..., :3] @ SLOPE


def _with_ghosts(values: AnyArray, axis: int) -> AnyArray:
    """One more value at either end of an axis."""
    v = np.moveaxis(values, axis, 0)
    n = len(v)
    if n == 1:
        first, last = v[0], v[0]
    elif n == 2:
        first, last = 2.0 * v[0] - v[1], 2.0 * v[1] - v[0]
    else:
        first, last = 3.0 * v[0] - 3.0 * v[1] + v[2], 3.0 * v[-1] - 3.0 * v[-2] + v[-3]
    return np.moveaxis(np.concatenate([first[None], v, last[None]]), 0, axis)


@dataclass(frozen=True)
class Axis:
    """start, start + step, ... of ``count`` values."""

    start: float
    step: float
    count: int

    @property
    def end(self) -> float:
        """The last value."""
        return self.start + self.step * (self.count - 1)

    def place(self, value: AnyArray) -> tuple[AnyArray, AnyArray]:
        """(index of the cell, position in it 0 ... 1); beyond the ends the end itself."""
        if self.count == 1:
            return np.zeros(np.shape(value), dtype=int), np.zeros(np.shape(value))
        position = np.clip((value - self.start) / self.step, 0.0, self.count - 1.0)
        cell = np.minimum(position.astype(int), self.count - 2)
        return cell, position - cell


@dataclass(frozen=True)
class GridField:
    """Data (nt, ny, nx). ``peak_period`` may be None: it then follows from the height. Raises ``ValueError``."""

    x: Axis
    y: Axis
    t: Axis
    height: AnyArray
    cos_angle: AnyArray
    sin_angle: AnyArray
    peak_period: AnyArray | None = None
    _data: AnyArray = field(init=False, repr=False)

    def __post_init__(self) -> None:
        shape = (self.t.count, self.y.count, self.x.count)
        given = [self.height, self.cos_angle, self.sin_angle]
        given.append(np.zeros(shape) if self.peak_period is None else self.peak_period)
        names = ("height", "cos_angle", "sin_angle", "peak_period")
        for name, values in zip(names, given):
            if values.shape != shape:
                raise ValueError(f"{name} has shape {values.shape}, expected (nt, ny, nx) = {shape}")
            if not np.all(np.isfinite(values)):
                raise ValueError(f"{name} has {int(np.sum(~np.isfinite(values)))} values that are not finite")
        if self.x.count < 2 or self.y.count < 2 or min(self.x.step, self.y.step, self.t.step) <= 0.0:
            raise ValueError("a grid needs at least 2 x 2 places and positive steps")
        data = np.stack(given, axis=-1)
        for axis in range(3):
            data = _with_ghosts(data, axis)
        object.__setattr__(self, "_data", data)

    @property
    def horizon(self) -> float:
        """Time of the last field, s; infinite where there is only one."""
        return self.t.end if self.t.count > 1 else math.inf

    def inside(self, x: AnyArray, y: AnyArray) -> AnyArray:
        """Whether places lie on the grid (with a tolerance of 1e-9 of a mesh)."""
        ex, ey = 1e-9 * self.x.step, 1e-9 * self.y.step
        across = (x >= self.x.start - ex) & (x <= self.x.end + ex)
        return np.asarray(across & (y >= self.y.start - ey) & (y <= self.y.end + ey))

    def values(self, x: AnyArray, y: AnyArray, t: AnyArray) -> AnyArray:
        """(3, 4, k): value, x and y derivative of the four data."""
        x, y, t = np.broadcast_arrays(x, y, t)
        shape = x.shape
        (i, u), (j, v), (h, w) = self.x.place(x.ravel()), self.y.place(y.ravel()), self.t.place(t.ravel())
        (wx, wy, wt), (dx, dy, _) = _weights(np.stack([u, v, w]))
        near = np.arange(4)
        rows, columns = (j[:, None] + near)[:, :, None], (i[:, None] + near)[:, None, :]
        k = len(i)
        if self.t.count == 1:
            block = self._data[1][rows, columns]
        else:
            cells = self._data[(h[:, None] + near)[:, :, None, None], rows[:, None], columns[:, None]]
            block = (wt[:, None] @ cells.reshape(k, 4, 64)).reshape(k, 4, 4, 4)
        # first along y, with value and slope together, then along x
        both = (np.stack([wy, dy / self.y.step], axis=1) @ block.reshape(k, 4, 16)).reshape(k, 2, 4, 4)
        value = np.stack([wx, dx / self.x.step], axis=1) @ both[:, 0]
        slope = wx[:, None] @ both[:, 1]
        both = np.concatenate([value, slope], axis=1)  # (k, 3, 4)
        return np.asarray(np.moveaxis(both, 0, -1).reshape(3, 4, *shape))

    def at(self, x: AnyArray, y: AnyArray, t: AnyArray) -> Sea:
        """The sea; beyond the edge that of the edge, without a gradient meaning."""
        f = self.values(x, y, t)
        return directed_sea((f[0, 0], f[1, 0], f[2, 0]), (f[0, 1], f[1, 1], f[2, 1]), (f[0, 2], f[1, 2], f[2, 2]))

    def period(self, x: AnyArray, y: AnyArray, t: AnyArray) -> AnyArray:
        """Peak period, s; 0 where it follows from the height."""
        return np.asarray(np.maximum(0.0, self.values(x, y, t)[0, 3]))
