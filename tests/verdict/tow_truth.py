"""The true error of a linear tow: against the nonlinear wire of high order, which the verdict on linear tows never asks.

The wire (``models/cable/wire``: elements of degree 4, implicit steps of order 3 by their error) shares the coefficients of the
loading with the linear tow and its judge, and nothing else; it is checked against independent codes (``docs/wire.md``). It is
solved finer and finer until its error changes no more; the last change is told as noise.
"""

from __future__ import annotations

import ctypes
import functools
import tempfile
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tests.verdict.truth import compiled
from towage.fmus.native.trace_chain import chain_headers, point_source
from towage.models.cable.case import CableError, Tow
from towage.models.cable.wire.chain import Chain
from towage.models.cable.wire.grading import graded_mesh
from towage.models.cable.wire.parts import Mass, Section, Wire, uniform_flow
from towage.models.cable.wire.rest import Frame, equilibrium, march

Array = NDArray[np.float64]
SOURCE = Path(__file__).with_name("tow_truth.c")
RUNTIME = Path(__file__).parents[2] / "fmus" / "native" / "runtime" / "chain"
DEGREE = 4
LEVELS = tuple((2e-4 / 5**k, 5e-5 / 5**k, 0.5**k) for k in range(6))
"""Error of a step over the tow speed, of the steady shape over the length, and longest step over the interval of the record. The
error of velocities alone does not see what long steps do to tensions: 5 % with six steps a period."""
CHANGES, LEAST = 0.03, 5e-4
"""The error is known when it changes by less than the first of itself, or than the second."""
FAR = 0.5
"""An error of which no more is asked than that two levels are beyond it: such wires are thrown about, and cost minutes."""


class Sea(NamedTuple):
    """Displacement of the towpoint r(t) Re sum X exp(-i omega t), m: ``omega``, rad/s, (k,), ``amplitudes`` X of (surge, heave),
    (k, 2); r = s^3 (10 - 15 s + 6 s^2), s = t/``ramp``, s, up to 1."""

    omega: Array
    amplitudes: NDArray[np.complex128]
    ramp: float


class Tensions(NamedTuple):
    """Tension at the top and at the body, N, (n,), and motion of the body, forward and up, m, (2, n)."""

    top: Array
    body: Array
    motion: Array


def wire_of(tow: Tow) -> Wire:
    """The tow as a wire with a body, whose drag goes with speed squared."""
    k, b = tow.cable, tow.body
    part = Section(k.length, k.mass, k.weight, k.thickness, k.axial_stiffness, k.drag_coefficient, k.loading, k.added_mass)
    area = 2.0 * b.drag / (tow.density * tow.speed**2)
    return Wire((part,), Mass(b.mass, (b.added_mass_surge, b.added_mass_heave), b.weight, area), tow.density)


@functools.cache
def library() -> ctypes.CDLL:
    """The chain of the native runtime with `tow_truth.c`."""
    folder = Path(tempfile.mkdtemp(prefix="truth"))
    for name, text in {**chain_headers(), "point.c": point_source()}.items():
        (folder / name).write_text(text)
    loaded = compiled([*RUNTIME.glob("chain*.c"), folder / "point.c", SOURCE], RUNTIME, folder)
    number, whole, pointer = ctypes.c_double, ctypes.c_long, ctypes.c_void_p
    loaded.solve.argtypes = [whole, whole, *[pointer] * 5, number, number, whole, pointer, number, whole, number, pointer]
    return loaded


def solve(tow: Tow, sea: Sea, times: Array, tolerance: float, shape: float, longest: float) -> Tensions:
    """The nonlinear tow from its steady state at equally spaced ``times``, s, from 0. Raises `CableError`."""
    wire, frame, stream = wire_of(tow), Frame(np.zeros(2)), np.array([-tow.speed, 0.0])
    flow = uniform_flow(stream)
    rest = march(wire, flow, frame, 2)
    chain = Chain(wire, graded_mesh(wire, rest, DEGREE, 0, shape).mesh, flow, 2)
    elements, step = len(chain.mesh.lengths), float(times[1] - times[0])
    fixture = chain.fixtures[1]
    arrays = [
        0.5 * chain.mesh.lengths, np.hstack([np.broadcast_to(column, (elements, 1)) for column in chain.material]),
        np.concatenate([*fixture.masses, fixture.weight, fixture.drag, fixture.aft]), stream,
        equilibrium(chain, frame, rest.position(chain.mesh.places)),
    ]  # fmt: skip
    sides = [part for x in sea.amplitudes.T for part in (x.real, x.imag)]
    arrays += [np.column_stack([sea.omega, *sides]), np.empty((len(times), 4))]
    *held, waves, found = (np.ascontiguousarray(a, float) for a in arrays)
    failed = library().solve(
        DEGREE, elements, *(a.ctypes.data for a in held), tolerance * tow.speed, longest * step, len(sea.omega),
        waves.ctypes.data, sea.ramp, len(times), step, found.ctypes.data,
    )  # fmt: skip
    if failed:
        raise CableError("the wire's motion was not found")
    return Tensions(found[:, 0], found[:, 1], found[:, 2:].T)


def apart(linear: Tensions, true: Tensions, late: Array) -> float:
    """The largest of the differences over the largest linear change: of both tensions, and of the motion of the body about its
    mean."""
    found = []
    for own, other in zip(linear[:2], true[:2]):
        found.append(np.abs(own - other)[late].max() / np.abs(own - own[0])[late].max())
    own, other = (m[:, late] - m[:, late].mean(axis=1, keepdims=True) for m in (linear.motion, true.motion))
    found.append(np.hypot(*(own - other)).max() / np.hypot(*own).max())
    return float(max(found))


def error(tow: Tow, sea: Sea, times: Array, linear: Tensions, settle: float) -> tuple[float, float]:
    """(error of ``linear`` from ``settle``, s, on; how far it is known). Raises `CableError` where the wire has no motion."""
    late, before = times >= settle, np.inf
    for level in LEVELS:
        found = apart(linear, solve(tow, sea, times, *level), late)
        if min(found, before) > FAR and before < np.inf:
            return min(found, before), 0.0
        change, before = abs(found - before), found
        if change < max(CHANGES * found, LEAST):
            break
    return before, float(change)
