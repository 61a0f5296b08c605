"""Wave fields and currents on a regular grid of the plane, at times at any distances.

    F(x) = sum_i P_i(s) F_i,   P the cubic convolution kernel with a = -1/2 (Catmull-Rom),   s in [0, 1]

The tensor product in x, y and t has continuous first derivatives everywhere. Height, cos K and sin K are interpolated
one by one and the direction vector normalised after; where it vanishes (a vortex centre) there is no direction. One
more value at each end comes from the quadratic through the last three, 3 F(1) - 3 F(2) + F(3). Times at unequal distances
have slopes from parabolas (`Knots`), the same where the distances are equal.

| symbol | meaning | unit |
|---|---|---|
| F | height, m; cos K, sin K (K: angle from +x toward which the waves come FROM); peak period, s; currents, m/s | |

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
from .fields import Flow, Sea, directed_sea

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


def _with_ghosts(values: AnyArray, axis: int, places: AnyArray | None = None) -> AnyArray:
    """One more value at either end of an axis, at the distance of the last step: from the quadratic through the last
    three. ``places`` (n,): where the values stand, at equal distances if None."""
    v = np.moveaxis(values, axis, 0)
    n = len(v)
    if n == 1:
        first, last = v[0], v[0]
    elif n == 2:
        first, last = 2.0 * v[0] - v[1], 2.0 * v[1] - v[0]
    else:
        a, b, c = _ghost_weights(1.0 if places is None else float((places[2] - places[1]) / (places[1] - places[0])))
        first = a * v[0] + b * v[1] + c * v[2]
        a, b, c = _ghost_weights(1.0 if places is None else float((places[-2] - places[-3]) / (places[-1] - places[-2])))
        last = a * v[-1] + b * v[-2] + c * v[-3]
    return np.moveaxis(np.concatenate([first[None], v, last[None]]), 0, axis)


def _ghost_weights(r: float) -> tuple[float, float, float]:
    """Lagrange's weights at -1 of values at 0, 1 and 1 + ``r``; 3, -3, 1 for r = 1."""
    return (2.0 + r) * 2.0 / (1.0 + r), -(2.0 + r) / r, 2.0 / (r * (1.0 + r))


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

    @property
    def places(self) -> AnyArray:
        """All values."""
        return np.asarray(self.start + self.step * np.arange(self.count))

    def place(self, value: AnyArray) -> tuple[AnyArray, AnyArray]:
        """(index of the cell, position in it 0 ... 1); beyond the ends the end itself."""
        if self.count == 1:
            return np.zeros(np.shape(value), dtype=int), np.zeros(np.shape(value))
        position = np.clip((value - self.start) / self.step, 0.0, self.count - 1.0)
        cell = np.minimum(position.astype(int), self.count - 2)
        return cell, position - cell

    def weights(self, cell: AnyArray, s: AnyArray) -> AnyArray:
        """Of the four values around each cell, (..., 4)."""
        return _weights(s)[0]


@dataclass(frozen=True)
class Knots:
    """Ascending ``places`` (n,), n >= 2, at any distances: times of a forecast that is hourly first and three-hourly
    later. The slope at a knot is that of the parabola through it and its neighbours, which at equal distances is Keys'
    kernel."""

    places: AnyArray
    _kernels: AnyArray = field(init=False, repr=False)

    def __post_init__(self) -> None:
        step = np.diff(self.places)
        if len(self.places) < 2 or not np.all(step > 0.0):
            raise ValueError("knots must be two or more, and ascend")
        before, after = np.concatenate([step[:1], step[:-1]]), np.concatenate([step[1:], step[-1:]])
        differences = np.diff(np.eye(4), axis=0)  # of neighbouring values
        d0, d1, d2 = (differences[k] / h[:, None] for k, h in enumerate((before, step, after)))
        h0, h1, h2 = (h[:, None] for h in (before, step, after))
        first, second = h1 * (h1 * d0 + h0 * d1) / (h0 + h1), h1 * (h2 * d1 + h1 * d2) / (h1 + h2)
        rise = np.broadcast_to(differences[1], first.shape)
        start = np.broadcast_to(np.eye(4)[1], first.shape)
        kernels = np.stack([start, first, 3.0 * rise - 2.0 * first - second, first + second - 2.0 * rise], axis=1)
        object.__setattr__(self, "_kernels", kernels)

    @property
    def count(self) -> int:
        """Of the knots."""
        return len(self.places)

    @property
    def start(self) -> float:
        """The first knot."""
        return float(self.places[0])

    @property
    def end(self) -> float:
        """The last knot."""
        return float(self.places[-1])

    @property
    def step(self) -> float:
        """The least distance."""
        return float(np.min(np.diff(self.places)))

    def place(self, value: AnyArray) -> tuple[AnyArray, AnyArray]:
        """(index of the cell, position in it 0 ... 1); beyond the ends the end itself."""
        v = np.clip(value, self.start, self.end)
        cell = np.clip(np.searchsorted(self.places, v, side="right") - 1, 0, self.count - 2)
        return cell, (v - self.places[cell]) / (self.places[cell + 1] - self.places[cell])

    def weights(self, cell: AnyArray, s: AnyArray) -> AnyArray:
        """Of the four values around each cell, (..., 4)."""
        powers = np.stack([np.ones_like(s), s, s * s, s * s * s], axis=-1)
        return np.asarray(np.einsum("...i,...ij->...j", powers, self._kernels[cell]))


class Layers:
    """``data`` (nt, ny, nx, n): n quantities over a grid and times, and their interpolation. Raises ``ValueError``."""

    def __init__(self, x: Axis, y: Axis, t: Axis | Knots, data: AnyArray) -> None:
        if x.count < 2 or y.count < 2 or min(x.step, y.step, t.step) <= 0.0:
            raise ValueError("a grid needs at least 2 x 2 places and positive steps")
        self.x, self.y, self.t = x, y, t
        places = t.places if isinstance(t, Knots) else None
        self._data = _with_ghosts(_with_ghosts(_with_ghosts(data, 0, places), 1), 2)

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
        """(3, n, k): value, x and y derivative of the n quantities."""
        x, y, t = np.broadcast_arrays(x, y, t)
        shape = x.shape
        (i, u), (j, v), (h, w) = self.x.place(x.ravel()), self.y.place(y.ravel()), self.t.place(t.ravel())
        (wx, wy), (dx, dy) = _weights(np.stack([u, v]))
        near = np.arange(4)
        rows, columns = (j[:, None] + near)[:, :, None], (i[:, None] + near)[:, None, :]
        k, n = len(i), self._data.shape[-1]
        if self.t.count == 1:
            block = self._data[1][rows, columns]
        else:
            cells = self._data[(h[:, None] + near)[:, :, None, None], rows[:, None], columns[:, None]]
            block = (self.t.weights(h, w)[:, None] @ cells.reshape(k, 4, 16 * n)).reshape(k, 4, 4, n)
        # first along y, with value and slope together, then along x
        both = (np.stack([wy, dy / self.y.step], axis=1) @ block.reshape(k, 4, 4 * n)).reshape(k, 2, 4, n)
        value = np.stack([wx, dx / self.x.step], axis=1) @ both[:, 0]
        slope = wx[:, None] @ both[:, 1]
        both = np.concatenate([value, slope], axis=1)  # (k, 3, n)
        return np.asarray(np.moveaxis(both, 0, -1).reshape(3, n, *shape))


@dataclass(frozen=True)
class GridField:
    """Data (nt, ny, nx). ``peak_period`` may be None: it then follows from the height. Raises ``ValueError``."""

    x: Axis
    y: Axis
    t: Axis | Knots
    height: AnyArray
    cos_angle: AnyArray
    sin_angle: AnyArray
    peak_period: AnyArray | None = None
    layers: Layers = field(init=False, repr=False)

    def __post_init__(self) -> None:
        given = {"height": self.height, "cos_angle": self.cos_angle, "sin_angle": self.sin_angle}
        given["peak_period"] = np.zeros(self.height.shape) if self.peak_period is None else self.peak_period
        object.__setattr__(self, "layers", _checked(self.x, self.y, self.t, given))

    @property
    def horizon(self) -> float:
        """Time of the last field, s; infinite where there is only one."""
        return self.layers.horizon

    def inside(self, x: AnyArray, y: AnyArray) -> AnyArray:
        """Whether places lie on the grid (with a tolerance of 1e-9 of a mesh)."""
        return self.layers.inside(x, y)

    @property
    def detail(self) -> float:
        """Length within which the field changes: two meshes, m."""
        return 2.0 * min(self.x.step, self.y.step)

    def at(self, x: AnyArray, y: AnyArray, t: AnyArray) -> Sea:
        """The sea; beyond the edge that of the edge, without a gradient meaning."""
        f = self.layers.values(x, y, t)
        return directed_sea((f[0, 0], f[1, 0], f[2, 0]), (f[0, 1], f[1, 1], f[2, 1]), (f[0, 2], f[1, 2], f[2, 2]))

    def centres(self, t: float) -> tuple[tuple[float, float, float], ...]:
        """Not known."""
        return ()

    def period(self, x: AnyArray, y: AnyArray, t: AnyArray) -> AnyArray:
        """Peak period, s; 0 where it follows from the height."""
        return np.asarray(np.maximum(0.0, self.layers.values(x, y, t)[0, 3]))


@dataclass(frozen=True)
class GridCurrent:
    """Components along the axes of the plane, true speeds, m/s, (nt, ny, nx). Raises ``ValueError``."""

    x: Axis
    y: Axis
    t: Axis | Knots
    u: AnyArray
    w: AnyArray
    layers: Layers = field(init=False, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "layers", _checked(self.x, self.y, self.t, {"u": self.u, "w": self.w}))

    @property
    def horizon(self) -> float:
        """Time of the last field, s; infinite where there is only one."""
        return self.layers.horizon

    @property
    def detail(self) -> float:
        """Length within which the current changes: two meshes, m."""
        return 2.0 * min(self.x.step, self.y.step)

    def inside(self, x: AnyArray, y: AnyArray) -> AnyArray:
        """Whether places lie on the grid (with a tolerance of 1e-9 of a mesh)."""
        return self.layers.inside(x, y)

    def at(self, x: AnyArray, y: AnyArray, t: AnyArray) -> Flow:
        """The current; beyond the edge that of the edge."""
        f = self.layers.values(x, y, t)
        return Flow(f[0, 0], f[0, 1], f[1, 0], f[2, 0], f[1, 1], f[2, 1])


def _checked(x: Axis, y: Axis, t: Axis | Knots, given: dict[str, AnyArray]) -> Layers:
    """The layers, if they have the shape of the grid and are finite."""
    shape = (t.count, y.count, x.count)
    for name, values in given.items():
        if values.shape != shape:
            raise ValueError(f"{name} has shape {values.shape}, expected (nt, ny, nx) = {shape}")
        if not np.all(np.isfinite(values)):
            raise ValueError(f"{name} has {int(np.sum(~np.isfinite(values)))} values that are not finite")
    return Layers(x, y, t, np.stack(list(given.values()), axis=-1))
