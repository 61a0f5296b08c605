"""Linear units in C against numpy: matrix functions, exact steps, observation, derivatives, reduction."""

from __future__ import annotations

import ctypes
import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.linalg import expm, matrix_balance, solve_continuous_lyapunov

from towage.fmus.trace import Traced
from towage.fmus.trace_linear import trace
from towage.fmus.unit import load
from towage.models.cable_fidelity import tow_elastic, tow_rigid
from towage.models.cable_parameters import tow_of
from towage.models.cable_reduction import reduce
from towage.models.matrix_ops import numbers
from towage.models.ops import FLOATS

from . import linear_example as example
from .native_instance import (
    DONE,
    MODEL_EXCHANGE,
    NATIVE,
    NO_STEP,
    REFUSED,
    NativeInstance,
    compile_library,
    doubles,
    unit_library,
)

Library = tuple[ctypes.CDLL, Traced]
RANDOM = np.random.default_rng(1)


# ---- matrices --------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def dense(tmp_path_factory: pytest.TempPathFactory) -> ctypes.CDLL:
    found = compile_library([NATIVE / "dense.c", NATIVE / "eigen.c"], tmp_path_factory.mktemp("dense") / "dense.so")
    for function in (found.exponential, found.eigenvalues, found.schur, found.lu_factor):
        function.restype = ctypes.c_bool
    return found


def column_major(a: Any) -> Any:
    return doubles(np.asarray(a).ravel(order="F").tolist())


def square(values: Any, n: int, columns: int | None = None) -> Any:
    return np.array(values).reshape(n, columns or n, order="F")


def companion(n: int) -> Any:
    """Of (s + 1)^n: one eigenvalue, one vector."""
    a = np.diag(np.ones(n - 1), 1)
    a[-1] = -np.poly1d([-1.0] * n, True).coeffs[:0:-1]
    return a


def chain(n: int) -> Any:
    """Masses on stiff springs, little damped, with displacements in micrometres: a norm far above the eigenvalues."""
    half = n // 2
    stiffness = 1e4 * (2.0 * np.eye(half) - np.eye(half, k=1) - np.eye(half, k=-1))
    a = np.block([[np.zeros((half, half)), np.eye(half)], [-stiffness, -0.01 * np.eye(half)]])
    scale = np.r_[np.full(half, 1e6), np.ones(half)]
    return a * scale[:, None] / scale


MATRICES: dict[str, Callable[[], Any]] = {
    "one": lambda: np.array([[-3.0]]),
    "zero": lambda: np.zeros((5, 5)),
    "random": lambda: RANDOM.normal(size=(30, 30)),
    "random160": lambda: RANDOM.normal(size=(160, 160)) / 8.0,
    "defective": lambda: companion(5),
    "nilpotent": lambda: np.diag(np.full(9, 100.0), 1),
    "triangular": lambda: np.triu(RANDOM.normal(size=(20, 20))) * 3.0,
    "stiff": lambda: np.diag([-1e5, -1.0, -1e-5]) + np.diag([1e3, 1.0], 1),
    "unscaled": lambda: chain(80),
}


@pytest.mark.parametrize("name", MATRICES)
def test_exponential(name: str, dense: ctypes.CDLL) -> None:
    a, _ = matrix_balance(MATRICES[name](), permute=False)
    n = len(a)
    found = column_major(a)
    assert dense.exponential(n, found, doubles(6 * n * n), (ctypes.c_int * n)())
    exact = expm(a)
    # both lose digits with every squaring of a matrix that is not normal: 1e-16 times the norm, 3e4 for the chain
    assert np.abs(square(found, n) - exact).max() <= 1e-15 * max(10.0, np.abs(a).sum(axis=0).max()) * np.abs(exact).max()


def test_exponential_refuses_what_is_not_finite(dense: ctypes.CDLL) -> None:
    for a in (np.array([[math.nan, 0.0], [0.0, 1.0]]), np.array([[1e4]])):
        n = len(a)
        assert not dense.exponential(n, column_major(a), doubles(6 * n * n), (ctypes.c_int * n)())


def eigenvalues(dense: ctypes.CDLL, a: Any) -> Any:
    n = len(a)
    values = doubles(2 * n)
    assert dense.eigenvalues(n, column_major(a), values, doubles(2 * n * n), doubles(2 * n))
    return np.array(values)[::2] + 1j * np.array(values)[1::2]


@pytest.mark.parametrize("name", MATRICES)
def test_eigenvalues(name: str, dense: ctypes.CDLL) -> None:
    a = MATRICES[name]()
    left = list(np.linalg.eigvals(a))
    # of a five-fold eigenvalue rounding leaves eps^(1/5) = 7e-4, of the ten-fold zero exactly nothing
    near = {"defective": 3e-3}.get(name, 1e-11 * np.abs(left).max())
    for value in eigenvalues(dense, a):
        place = int(np.argmin(np.abs(np.array(left) - value)))
        assert abs(left.pop(place) - value) <= near


def test_lyapunov_and_vectors(dense: ctypes.CDLL) -> None:
    """In the coordinates of a Schur form; both equations have the solutions that scipy finds."""
    n = 24
    a = RANDOM.normal(size=(n, n)) - 8.0 * np.eye(n)
    h, q = column_major(a), doubles(n * n)
    dense.hessenberg(n, h, q, doubles(n))
    real, turn = square(h, n), square(q, n)
    # products of orthogonal matrices: n eps of the norm
    assert np.abs(turn @ real @ turn.T - a).max() < 1e-13 * n
    assert np.abs(np.tril(real, -2)).max() == 0.0
    t, u = (doubles(np.c_[m.ravel(order="F"), np.zeros(n * n)].ravel().tolist()) for m in (real, turn))
    assert dense.schur(n, t, u)

    def complex_square(values: Any, columns: int = n) -> Any:
        return (np.array(values)[::2] + 1j * np.array(values)[1::2]).reshape(n, columns, order="F")

    triangle, unitary = complex_square(t), complex_square(u)
    assert np.abs(unitary @ triangle @ unitary.conj().T - a).max() < 1e-13 * n
    b = RANDOM.normal(size=(n, 3))
    for adjoint in (False, True):
        f = unitary.conj().T @ b @ b.T @ unitary
        given = doubles(np.c_[f.ravel(order="F").real, f.ravel(order="F").imag].ravel().tolist())
        dense.lyapunov(n, t, adjoint, given)
        found = (unitary @ complex_square(given) @ unitary.conj().T).real
        exact = solve_continuous_lyapunov(a.T if adjoint else a, -b @ b.T)
        # the distance of the spectrum from the axis is of order 1: only rounding
        assert np.abs(found - exact).max() < 1e-12 * np.abs(exact).max()
    for j in (0, n // 2, n - 1):
        right, left = doubles(2 * n), doubles(2 * n)
        dense.right_vector(n, t, j, right)
        dense.left_vector(n, t, j, left)
        x, y = complex_square(right, 1)[:, 0], complex_square(left, 1)[:, 0]
        # vectors grow where eigenvalues are close: 1e-3 here
        assert np.abs(triangle @ x - triangle[j, j] * x).max() < 1e-11 * np.abs(x).max()
        assert np.abs(y.conj() @ triangle - triangle[j, j] * y.conj()).max() < 1e-11 * np.abs(y).max()


def test_factors(dense: ctypes.CDLL) -> None:
    """Singular values, and the factor of a matrix of low rank with a wide range of scales."""
    a = RANDOM.normal(size=(12, 9)) * 10.0 ** -np.arange(9)
    u, v, s = column_major(a), doubles(81), doubles(9)
    dense.singular_values(12, 9, u, v, s)
    exact = np.linalg.svd(a, compute_uv=False)
    # one-sided rotations are accurate relative to each singular value of scaled columns, LAPACK to the largest: 1e-16
    assert np.abs(np.array(s) - exact).max() < 1e-14 * exact[0]
    assert np.abs(square(u, 12, 9) @ square(v, 9).T - a).max() < 1e-14 * exact[0]
    b = RANDOM.normal(size=(10, 4)) * 10.0 ** np.linspace(-6.0, 6.0, 10)[:, None]
    p, root = column_major(b @ b.T), doubles(100)
    rank = dense.root_factor(10, p, root, doubles(10))
    assert 4 <= rank <= 6  # one or two columns at the level of rounding
    found, size = square(root, 10)[:, :rank], np.abs(b).max(axis=1)
    assert np.abs((found @ found.T - b @ b.T) / np.outer(size, size)).max() < 1e-13


def test_solve(dense: ctypes.CDLL) -> None:
    a, b = RANDOM.normal(size=(40, 40)), RANDOM.normal(size=(40, 3))
    lu, x, pivot = column_major(a), column_major(b), (ctypes.c_int * 40)()
    assert dense.lu_factor(40, lu, pivot)
    dense.lu_solve(40, 3, lu, pivot, x)
    exact = np.linalg.solve(a, b)
    assert np.abs(square(x, 40, 3) - exact).max() < 1e-15 * np.linalg.cond(a) * np.abs(exact).max()
    assert not dense.lu_factor(2, doubles(4), pivot)


# ---- steps and observation -------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def masses(tmp_path_factory: pytest.TempPathFactory) -> Library:
    traced = trace(example.unit(example), {})
    return unit_library(traced, tmp_path_factory.mktemp("masses")), traced


PARAMETERS = example.Parameters(4.0, 0.3, 1.5, 0.1, 2.0, 3.0)
FORCE, PACE = (0.4, -0.8, 0.6, 0.9), (0.7, 0.5, -0.4, 0.3)
"""Value and three derivatives."""


def given(force: tuple[float, ...], pace: tuple[float, ...]) -> dict[str, float]:
    names = [f"{name}{end}" for name in ("force", "pace") for end in ("", "_d1", "_d2", "_d3")]
    return dict(zip(names, force + pace))


def matrices(s: float, p: example.Parameters = PARAMETERS) -> tuple[Any, ...]:
    found = example.setup(p, example.Size(), numbers())
    a, b = (m[0] + s * m[1] + s * s * m[2] for m in (found.a, found.b))
    return a, b, found.c, found.d, found.e


def stepped(z: Any, impulse: float, force: Any, s: float, h: float, p: example.Parameters = PARAMETERS) -> Any:
    """One exponential of everything: z, impulse, and the derivatives of the force."""
    a, b, *_ = matrices(s, p)
    block = np.zeros((9, 9))
    block[:4, :4], block[:4, 4], block[:4, 5] = a, b[:, 1], b[:, 0]
    block[4, 5] = block[5, 6] = block[6, 7] = block[7, 8] = 1.0
    return (expm(block * h) @ np.array([*z, impulse, *force]))[:5]


def taylor(u: tuple[float, ...], h: float) -> tuple[float, float]:
    """Value and rate after ``h``."""
    return (
        u[0] + h * (u[1] + h * (u[2] / 2.0 + h * u[3] / 6.0)),
        u[1] + h * (u[2] + h * u[3] / 2.0),
    )


@pytest.mark.parametrize("h", [1e-3, 0.3, 7.0])
def test_steps_and_observation(h: float, masses: Library) -> None:
    it = NativeInstance(*masses)
    x = np.array([0.1, 0.0, 0.0, 0.0, 0.0])
    for k in range(3):
        assert it.set(**given(FORCE, PACE)) == DONE
        assert it.step(k * h, h) == DONE
        x = stepped(x[:4], x[4], FORCE, taylor(PACE, 0.5 * h)[0] ** 2, h)
    scale = np.abs(x).max()
    # rounding, times the growth of an inverted spring where the pace is large
    found = it.get(*(f"state.z[{i}]" for i in range(1, 5)), "state.impulse")
    assert np.abs(found - x).max() <= 1e-11 * scale
    (f, df), (pace, _) = taylor(FORCE, h), taylor(PACE, h)
    a, b, c, d, e = matrices(pace**2)
    v, dv, ddv = np.array([f, x[4]]), np.array([df, f]), np.array([0.0, df])
    rate = a @ x[:4] + b @ v
    y, dy = c @ x[:4] + d @ v + e @ dv, c @ rate + d @ dv + e @ ddv
    roots = np.linalg.eigvals(a)
    growth = max(roots.real[np.abs(roots) < 20.0])
    wanted = [y[0], y[1], growth, x[4] * y[3] * math.sin(f), dy[0], dy[1], *y]
    names = [*example.Outputs._fields, *(f"row[{i}]" for i in range(1, 5))]
    size = max(np.abs(wanted))
    assert np.abs(np.array(it.get(*names)) - wanted).max() <= 1e-11 * size


def test_study_finds_what_numpy_finds(masses: Library) -> None:
    it = NativeInstance(*masses)
    own, longer = (example.setup(PARAMETERS, example.Size(n), numbers()) for n in (2.0, 3.0))
    worst = 0.0
    for omega in np.geomspace(0.02, 3.0, 40):
        s = -1j * omega
        gains = [m.c @ np.linalg.solve(s * np.eye(len(m.a[0])) - m.a[0], m.b[0]) + m.d + s * m.e for m in (own, longer)]
        for rows in (slice(0, 2), slice(2, 4)):
            difference = np.abs(gains[0][rows] - gains[1][rows]).max(axis=0)
            worst = max(worst, (difference / np.abs(gains[1][rows]).max(axis=0)).max())
    resolved = 0
    for k in range(1, 9):
        s = 0.25 * k
        found, finer = (np.linalg.eigvals(m.a[0] + s * m.a[1] + s * s * m.a[2]) for m in (own, longer))
        slowest = min(finer[finer.imag >= 0.0], key=abs)
        if np.abs(found - slowest).min() > 0.5 * abs(slowest):
            break
        resolved = k
    error, limit = it.get("error", "resolved")
    assert error == pytest.approx(0.5 * worst, rel=1e-12)  # the same arithmetic but for its order
    assert limit == max(resolved, 0.5) * 0.25
    # without damping `when` is not met
    assert NativeInstance(*masses, damping=0.04).get("error") == [0.0]


def test_prepared_steps_come_and_go_without_a_trace(masses: Library) -> None:
    """Six pairs of step and pace in turn are more than are kept: a run is bit-equal to one that makes each anew."""
    mixed = NativeInstance(*masses)
    time, results = 0.0, []
    plan = [(h, pace) for _ in range(3) for h in (0.1, 0.25, 0.7) for pace in (0.3, 1.1)]
    for h, pace in plan:
        before = mixed.get(*(f"state.z[{i}]" for i in range(1, 5)), "state.impulse")
        results.append((before, h, pace))
        mixed.set(**given(FORCE, (pace, 0.0, 0.0, 0.0)))
        assert mixed.step(time, h) == DONE
        time += h
    again = NativeInstance(*masses)
    time = 0.0
    for before, h, pace in results:
        assert again.get(*(f"state.z[{i}]" for i in range(1, 5)), "state.impulse") == before
        again.set(**given(FORCE, (2.0, 0.0, 0.0, 0.0)))
        again.set(**given(FORCE, (pace, 0.0, 0.0, 0.0)))
        again.get("growth")  # observes in between
        assert again.step(time, h) == DONE
        time += h


def test_inputs_below_their_minimum_make_no_step(masses: Library) -> None:
    it = NativeInstance(*masses)
    for pace in ((-0.1, 0.0, 0.0, 0.0), (0.1, -1.0, 0.0, 0.0)):
        it.set(**given(FORCE, pace))
        assert it.step(0.0, 0.5) == NO_STEP
        assert "pace = -0." in it.message and "expected at least 0" in it.message
    it.set(**given(FORCE, (0.1, -0.2, 0.0, 0.0)))
    assert it.step(0.0, 0.5) == DONE


def test_a_tunable_parameter_acts_from_the_next_step_on(masses: Library) -> None:
    it = NativeInstance(*masses)
    x = np.array([0.1, 0.0, 0.0, 0.0, 0.0])
    for k, stiffness in enumerate((4.0, 9.0, 4.0)):
        it.set(stiffness=stiffness, **given(FORCE, PACE))
        assert it.step(0.2 * k, 0.2) == DONE
        p = replace(PARAMETERS, stiffness=stiffness)
        x = stepped(x[:4], x[4], FORCE, taylor(PACE, 0.1)[0] ** 2, 0.2, p)
    found = it.get(*(f"state.z[{i}]" for i in range(1, 5)), "state.impulse")
    assert np.abs(found - x).max() < 1e-13  # rounding
    assert it.set(stiffness=-1.0) == DONE and it.step(0.6, 0.2) == REFUSED
    assert it.message.endswith("stiffness must be positive")


def test_directional_derivatives(masses: Library) -> None:
    it = NativeInstance(*masses, kind=MODEL_EXCHANGE)
    assert masses[0].instance_enter_continuous(it.handle) == DONE
    states = [*(f"z[{i}]" for i in range(1, 5)), "impulse"]
    knowns = [*(f"state.{s}" for s in states), "force", "pace"]
    unknowns = [*example.Outputs._fields, *(f"der(state.{s})" for s in states)]
    at = np.array([0.3, -0.2, 0.5, 0.1, 0.7, 0.4, 0.8])

    def seen(x: Any) -> Any:
        it.set_states(x[:5].tolist())
        it.set(force=x[5], pace=x[6], force_d1=0.3, pace_d1=0.2)
        return np.array([*it.get(*example.Outputs._fields), *it.derivatives()])

    for j, name in enumerate(knowns):
        step = 1e-4 * np.eye(7)[j]
        # Richardson of central differences: h^4 = 1e-16, rounding 1e-15/h
        slope = (8.0 * (seen(at + step) - seen(at - step)) - (seen(at + 2.0 * step) - seen(at - 2.0 * step))) / 12e-4
        seen(at)
        found = it.directional(unknowns, [name], [1.0])
        assert np.abs(found - slope).max() < 1e-8, name


def test_derivatives_are_those_of_the_step(masses: Library) -> None:
    """Model exchange and co-simulation are of one model: (x(h) - x(-h))/2h of exact steps."""
    it = NativeInstance(*masses, kind=MODEL_EXCHANGE)
    assert masses[0].instance_enter_continuous(it.handle) == DONE
    x, force, pace = np.array([0.3, -0.2, 0.5, 0.1, 0.7]), (0.4, 0.0, 0.0, 0.0), 0.8
    it.set_states(x.tolist())
    it.set(force=force[0], pace=pace)
    h = 1e-4
    exact = (stepped(x[:4], x[4], force, pace**2, h) - stepped(x[:4], x[4], force, pace**2, -h)) / (2.0 * h)
    assert np.abs(np.array(it.derivatives()) - exact).max() < 1e-6  # h^2 times the third derivative


# ---- reduction -------------------------------------------------------------------------------------------------------

SEGMENTS = 8.0


@pytest.fixture(scope="module", params=[0.0, 1.0], ids=["rigid", "elastic"])
def tow(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[Library, bool]:
    unit = load("tow_system")
    unit = replace(
        unit, parameters=tuple(
            replace(v, variability="tunable") if v.name == "body_mass" else v for v in unit.parameters
        )
    )  # fmt: skip
    traced = trace(unit, {"segments": SEGMENTS, "extensible": request.param})
    library = unit_library(traced, tmp_path_factory.mktemp(f"tow{request.param:.0f}"))
    return (library, traced), request.param > 0.5


CASE = {"axial_stiffness": 4e6}


def python_model(elastic: bool) -> Any:
    unit = load("tow_system")
    values = {v.name: v.start for v in unit.parameters} | {"extensible": float(elastic), "segments": SEGMENTS}
    # 0: a cable that keeps its length has no stretched equilibrium either
    values["axial_stiffness"] = CASE["axial_stiffness"] if elastic else 0.0
    model = (tow_elastic if elastic else tow_rigid)(tow_of(unit.model.Parameters(**values)), int(SEGMENTS))
    # momenta beside angles cost the gramians of the rigid model three digits of the error, in any other coordinates none
    a, (scale, _) = matrix_balance(model.a, permute=False, separate=True)
    return replace(model, a=a, b=model.b / scale[:, None], c=model.c * scale)


@pytest.mark.parametrize("tolerance", [0.3, 0.1, 0.03])
def test_reduction_is_that_of_the_python_flavour(tolerance: float, tow: tuple[Library, bool]) -> None:
    library, elastic = tow
    full = NativeInstance(*library, reduced=0.0, tolerance=tolerance, **CASE)
    small = NativeInstance(*library, reduced=1.0, tolerance=tolerance, **CASE)
    (spent,), (states, error) = full.get("model_error"), small.get("states", "model_error")
    allowed = max(0.25 * tolerance, tolerance - spent)
    wanted = reduce(python_model(elastic), allowed, 2.0, elastic, 2)
    assert error - spent <= allowed
    assert abs(states - len(wanted.model.a)) <= 1
    if states == len(wanted.model.a):
        # the error of the same candidate; coordinates differ by what rounding leaves of the weak ones
        assert error - spent == pytest.approx(wanted.error, rel=1e-6, abs=1e-9)
    assert full.get("states") == [4.0 * SEGMENTS if elastic else 2.0 * SEGMENTS]


def test_a_reduced_model_behaves_as_the_full_one(tow: tuple[Library, bool]) -> None:
    library, _ = tow
    tolerance, h = 0.2, 0.1
    both = [NativeInstance(*library, reduced=r, tolerance=tolerance, **CASE) for r in (0.0, 1.0)]
    spent = both[0].get("model_error")[0]
    found: list[list[list[float]]] = [[], []]
    for k in range(2500):
        t = k * h
        for it, each in zip(both, found):
            it.set(velocity_heave=0.4 * math.sin(1.1 * t), velocity_heave_d1=0.44 * math.cos(1.1 * t),
                   velocity_heave_d2=-0.484 * math.sin(1.1 * t))  # fmt: skip
            assert it.step(t, h) == DONE
            if k >= 2000:  # the slowest mode, -0.045/s, has decayed to 1e-4
                each.append(it.get("reaction_surge", "reaction_heave"))
    full, small = np.array(found)
    # the measure is of amplitudes, largest component over largest component
    assert np.abs(full - small).max() <= (tolerance - spent) * np.abs(full).max()


def test_only_an_unreduced_model_can_be_tuned(tow: tuple[Library, bool]) -> None:
    library, _ = tow
    for reduced, outcome in ((0.0, DONE), (1.0, REFUSED)):
        it = NativeInstance(*library, reduced=reduced, **CASE)
        assert it.step(0.0, 0.1) == DONE
        assert it.set(body_mass=950.0) == outcome
    assert it.message == (
        "body_mass may not be set: the states of another reduced model mean something else, this needs reduced = 0"
    )
    assert it.step(0.1, 0.1) == DONE


def test_no_equilibrium_is_refused(tow: tuple[Library, bool]) -> None:
    library, _ = tow
    it = NativeInstance(*library, **CASE | {"body_weight_in_water": -1e5})
    assert it.initialized == REFUSED and it.message


def test_error_of_the_segments_is_that_of_the_frequency_response(tow: tuple[Library, bool]) -> None:
    library, elastic = tow
    unit = load("tow_system")
    values = {v.name: v.start for v in unit.parameters} | CASE
    values |= {"extensible": float(elastic), "segments": SEGMENTS, "reduced": 0.0}
    measured = unit.model.calculated(unit.model.Parameters(**values), FLOATS)
    it = NativeInstance(*library, reduced=0.0, **CASE)
    estimated, lost = it.get("model_error", "inextensible_error")
    # extrapolation from two meshes; another grid of frequencies
    assert 0.5 < estimated / measured.model_error < 1.5
    # the same quantity between lumped models; 0 where the cable is elastic
    assert lost == pytest.approx(measured.inextensible_error, rel=0.1, abs=1e-3)
