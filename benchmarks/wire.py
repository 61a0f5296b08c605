"""Error against time of the nonlinear wire, bare and native, beside MoorDyn, on one case in the plane and one in space.

    OPENBLAS_NUM_THREADS=1 python benchmarks/wire.py [--reference FILE]

Heave: the case of ``moordyn_tow.py``, 0.2 m; error of the force on the towpoint at the driving frequency against this
wire on a fine mesh with small steps (the linear response differs from it by what is not linear, and is given beside). Turn:
`TURN`, in space; error of body and pull over 12 instants of 150 s against the same on a fine mesh. Time: milliseconds of
processor time a simulated second, one thread, the least of three. All in one run: only ratios mean something.
"""

from __future__ import annotations

import argparse
import math
import subprocess
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import moordyn_tow
import numpy as np
from moordyn_tow import FREQUENCY, SPEED, harmonic, tow_case

from towage.fmus.native.trace_chain import constants_source, point_source
from towage.models.cable.wire.chain import Chain, Mesh
from towage.models.cable.wire.grading import graded_mesh
from towage.models.cable.wire.parts import Mass, Section, Wire, cross_flow_section, uniform_flow
from towage.models.cable.wire.rest import Frame, equilibrium, march
from towage.models.numeric.arrays import Array

RUNTIME = Path(__file__).resolve().parents[1] / "fmus" / "native" / "runtime" / "chain"
TURN_SPEED, TURN_RADIUS = 3.0, 60.0
TURN_TIMES = [12.5 * k for k in range(1, 13)]
HEAVE_RAMP, HEAVE_START, HEAVE_STOP, HEAVE_SAMPLES = 10.0, 40.0, 45.0, 50


def heave_wire() -> Wire:
    """The tow of ``moordyn_tow.py``."""
    tow = tow_case()
    k, b = tow.cable, tow.body
    part = Section(k.length, k.mass, k.weight, k.thickness, k.axial_stiffness, k.drag_coefficient, k.loading)
    return Wire((part,), Mass(b.mass, b.added_mass_surge, b.weight, moordyn_tow.BODY_DRAG_AREA), tow.density)


def turn_wire() -> Wire:
    """A fish of 800 kg on 150 m of wire of 12 mm."""
    part = Section(150.0, 0.6, 4.747156, 0.012, 8e6, *cross_flow_section(1.5, 0.01))
    return Wire((part,), Mass(800.0, 300.0, 5000.0, 0.3), 1025.0)


@dataclass(frozen=True)
class Bare:
    """What a run of ``wire_host.c`` printed: rows (t, body relative to the top, pull on the top); ms a simulated second, with
    the set-up of mesh and equilibrium in Python beside it, ms; steps, evaluations, factorisations, failures, rejections."""

    rows: Array
    cost: float
    setup: float
    counts: tuple[int, ...]


def build(folder: Path, dimensions: int) -> Path:
    """The host for two or three dimensions, compiled."""
    place = folder / f"{dimensions}d"
    place.mkdir()
    (place / "point.c").write_text(point_source(dimensions))
    (place / "chain_constants.h").write_text(constants_source())
    sources = [*RUNTIME.glob("*.c"), place / "point.c", Path(__file__).with_name("wire_host.c")]
    program = place / "wire_host"
    subprocess.run(
        ["cc", "-std=c99", "-O2", "-I", str(RUNTIME), "-I", str(place), *map(str, sources), "-lm", "-o", str(program)],
        check=True,
    )  # fmt: skip
    return program


def numbers(chain: Chain, state: Array, speed: float, setting: list[float], times: list[float]) -> str:
    """The case as text for the host."""
    nodes, fixture = chain.fixtures
    out: list[float] = [chain.dimensions, chain.mesh.degree, len(chain.mesh.lengths), 0.0, 0.0]
    out += [*(0.5 * chain.mesh.lengths), *np.hstack([np.broadcast_to(c, (len(chain.mesh.lengths), 1)) for c in chain.material]).ravel()]
    out += [*chain.rule.weights, *chain.rule.slopes.ravel(), len(nodes)]
    for k, node in enumerate(nodes):
        out += [node, *(m[k] for m in fixture.masses), fixture.weight[k], fixture.drag[k]]
    out += [1.0, 0.0, *np.zeros(chain.dimensions), *setting]
    velocity = np.zeros_like(state)
    velocity[:, 0] = speed
    out += [*state.ravel(), *velocity.ravel(), len(times), *times]
    return " ".join(f"{float(x):.17g}" for x in out)


def bare(program: Path, wire: Wire, speed: float, mesh: tuple[int, int], stepping: tuple[float, float, int],
         path: list[float], times: list[float]) -> Bare:
    """Run: ``mesh`` = (elements, degree), ``stepping`` = (tolerance, largest step, order)."""
    d = 3 if path[0] == 1.0 else 2
    begin = time.process_time()
    frame, flow = Frame(np.array([speed, *np.zeros(d - 1)])), uniform_flow(np.zeros(d))
    shape = march(wire, flow, frame, d)
    chain = Chain(wire, graded_mesh(wire, shape, mesh[1], mesh[0]).mesh, flow, d)
    nodes = equilibrium(chain, frame, shape.position(chain.mesh.places))
    setup = 1e3 * (time.process_time() - begin)
    text = numbers(chain, nodes, speed, [*stepping, *path], times)
    costs = []
    for _ in range(3):
        done = subprocess.run([str(program)], input=text, capture_output=True, text=True)
        if done.returncode:
            raise SystemExit(f"wire_host: {done.returncode} {done.stderr}")
        *lines, last = done.stdout.splitlines()
        costs.append(float(last.split()[0]))
    return Bare(
        np.array([[float(x) for x in line.split()] for line in lines]), 1e3 * min(costs) / times[-1], setup,
        tuple(int(x) for x in last.split()[1:]),
    )  # fmt: skip
