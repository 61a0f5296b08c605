"""The wire against the theory of the linear tow in frequency: both forms of the added mass, both quadrants, steady forces."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from towage.models.cable.case import Body, Cable, Tow
from towage.models.cable.loading import eames
from towage.models.cable.steady.perturbation import Excitation
from towage.models.cable.steady.response import respond
from towage.models.cable.wire.chain import Chain, Drive
from towage.models.cable.wire.grading import graded_mesh
from towage.models.cable.wire.parts import Mass, Section, Wire, uniform_flow
from towage.models.cable.wire.rest import Frame, equilibrium, march

DEEP = Tow(
    Cable(180.0, 0.83, 6.3, 0.015, 1.5, eames(0.03), 1.0, True, 4e6), Body(900.0, 290.0, 870.0, 5300.0, -400.0, 900.0, 0.0, 0.0),
    4.0, 1025.0, 1,
)  # fmt: skip
FLOAT = Tow(
    Cable(90.0, 0.83, 6.3, 0.015, 1.5, eames(0.03), 1.0, True, 4e6), Body(300.0, 70.0, 200.0, 2800.0, 6200.0, 900.0, 0.0, 0.0),
    3.0867, 1025.0, 2,
)  # fmt: skip


def wire_of(tow: Tow) -> Wire:
    """The wire of a tow whose body has a constant drag."""
    k, b = tow.cable, tow.body
    part = Section(
        k.length, k.mass, k.weight, k.thickness, k.axial_stiffness, k.drag_coefficient, k.loading, k.added_mass,
        momentum_form=k.momentum_form,
    )  # fmt: skip
    return Wire((part,), Mass(b.mass, (b.added_mass_surge, b.added_mass_heave), b.weight - b.lift, 0.0, b.drag), tow.density)


Array = np.ndarray


def response_of(chain: Chain, nodes: Array, top: Array, force: Array, omega: float) -> tuple[Array, Array]:
    """(Motion of the body, m, change of the pull on the ship, N) for amplitudes of the top, m, and of a force on the body, N:
    central differences of the forces that a motion needs."""
    zero, size = np.zeros(2), nodes.size
    drive, flat = Drive(zero, zero, zero), np.zeros(3 * size)
    flat[:size] = nodes.ravel()

    def needed(x: np.ndarray) -> np.ndarray:
        return chain.needed(*x.reshape(3, -1, 2), drive).ravel()

    columns, change = np.zeros((size, 3 * size)), 1e-5
    for k in range(3 * size):
        step = np.zeros(3 * size)
        step[k] = change
        columns[:, k] = (needed(flat + step) - needed(flat - step)) / (2.0 * change)
    stiff, damp, mass = np.split(columns, 3, axis=1)
    whole = stiff - 1j * omega * damp - omega**2 * mass
    side = -whole[:-2, -2:] @ top
    side[:2] += force
    moved = np.concatenate([np.linalg.solve(whole[:-2, :-2], side), top])
    return moved[:2], (whole @ moved)[-2:]


@pytest.mark.parametrize(
    ("tow", "excitation"), [(DEEP, Excitation(surge=0.5, heave=1.0)), (FLOAT, Excitation(drag=100.0, lift=80.0j))]
)
def test_small_motions_are_those_of_the_linear_tow(tow: Tow, excitation: Excitation) -> None:
    """Loads are per stretched length there, per unstretched here: the stretch of 1e-3 is between them. What the momentum form
    changes is smaller than that, so that it is compared by itself."""
    omega = 2.0 * math.pi * 0.15
    top, force = np.array([excitation.surge, excitation.heave]), np.array([-excitation.drag, excitation.lift])
    changes = []
    for momentum in (True, False):
        tow = replace(tow, cable=replace(tow.cable, momentum_form=momentum))
        wire, flow, frame = wire_of(tow), uniform_flow(np.array([-tow.speed, 0.0])), Frame(np.zeros(2))
        shape = march(wire, flow, frame, 2)
        chain = Chain(wire, graded_mesh(wire, shape, 6, 4, 1e-4).mesh, flow, 2)
        found = response_of(chain, equilibrium(chain, frame, shape.position(chain.mesh.places)), top, force, omega)
        theirs = respond(tow, omega, excitation)
        expected = np.array([x[0, 0] for x in theirs.displacement]), np.array(theirs.towpoint_force)
        for one, other in zip(found, expected):
            assert np.abs(one - other).max() < 1e-3 * np.abs(other).max()
        changes.append((found[1], expected[1]))
    ours, their = (with_form - without for with_form, without in zip(*changes))
    assert np.abs(ours - their).max() < 0.01 * np.abs(their).max()
