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

from .route_fields import Sea, directed_sea
from .route_polar import Array


def _weights(s: Array) -> tuple[Array, Array]:
    """Kernel at the four neighbours and its derivative, (k, 4)."""
    s2, s3 = s * s, s * s * s
    return (
        np.stack([0.5 * (-s3 + 2.0 * s2 - s), 0.5 * (3.0 * s3 - 5.0 * s2 + 2.0), 0.5 * (-3.0 * s3 + 4.0 * s2 + s),
                  0.5 * (s3 - s2)], axis=-1),
        np.stack([0.5 * (-3.0 * s2 + 4.0 * s - 1.0), 0.5 * (9.0 * s2 - 10.0 * s), 0.5 * (-9.0 * s2 + 8.0 * s + 1.0),
                  0.5 * (3.0 * s2 - 2.0 * s)], axis=-1),
    )  # fmt: skip


def _with_ghosts(values: Array, axis: int) -> Array:
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

    def place(self, value: Array) -> tuple[Array, Array]:
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
    height: Array
    cos_angle: Array
    sin_angle: Array
    peak_period: Array | None = None
    _data: Array = field(init=False, repr=False)

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

    def inside(self, x: Array, y: Array) -> Array:
        """Whether places lie on the grid (with a tolerance of 1e-9 of a mesh)."""
        ex, ey = 1e-9 * self.x.step, 1e-9 * self.y.step
        across = (x >= self.x.start - ex) & (x <= self.x.end + ex)
        return np.asarray(across & (y >= self.y.start - ey) & (y <= self.y.end + ey))

    def values(self, x: Array, y: Array, t: Array) -> Array:
        """(3, 4, k): value, x and y derivative of the four data."""
        x, y, t = np.broadcast_arrays(x, y, t)
        shape = x.shape
        x, y, t = x.ravel(), y.ravel(), t.ravel()
        (i, u), (j, v) = self.x.place(x), self.y.place(y)
        near = np.arange(4)
        wx, dx = _weights(u)
        wy, dy = _weights(v)
        if self.t.count == 1:
            block = self._data[1][(j[:, None] + near)[:, :, None], (i[:, None] + near)[:, None, :]]
        else:
            h, w = self.t.place(t)
            wt = _weights(w)[0]
            cells = self._data[
                (h[:, None] + near)[:, :, None, None], (j[:, None] + near)[:, None, :, None],
                (i[:, None] + near)[:, None, None, :],
            ]  # fmt: skip
            block = np.einsum("kt,ktyxc->kyxc", wt, cells)
        rows = np.einsum("ky,kyxc->kxc", wy, block)
        slope = np.einsum("ky,kyxc->kxc", dy / self.y.step, block)
        found = np.stack([
            np.einsum("kx,kxc->ck", wx, rows), np.einsum("kx,kxc->ck", dx / self.x.step, rows),
            np.einsum("kx,kxc->ck", wx, slope),
        ])  # fmt: skip
        return np.asarray(found.reshape(3, 4, *shape))

    def at(self, x: Array, y: Array, t: Array) -> Sea:
        """The sea; beyond the edge that of the edge, without a gradient meaning."""
        f = self.values(x, y, t)
        return directed_sea((f[0, 0], f[1, 0], f[2, 0]), (f[0, 1], f[1, 1], f[2, 1]), (f[0, 2], f[1, 2], f[2, 2]))

    def period(self, x: Array, y: Array, t: Array) -> Array:
        """Peak period, s; 0 where it follows from the height."""
        return np.asarray(np.maximum(0.0, self.values(x, y, t)[0, 3]))
