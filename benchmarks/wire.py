"""Error against time of the nonlinear wire, bare and native, beside MoorDyn, on one case in the plane and one in space.

    OPENBLAS_NUM_THREADS=1 python benchmarks/wire.py [--no-moordyn]

Heave: the case of ``moordyn_tow.py``, 0.2 m; error of the force on the towpoint at the driving frequency against this
wire on a fine mesh with small steps. Turn: a fish on 150 m of wire at 3 m/s, a half circle of 60 m; error of body and pull
over 12 instants of 150 s against the same on a fine mesh, which is within 1e-5 of independent reference values. Time:
milliseconds of processor time a simulated second, one thread, the least of three, steady state in C over a minute included;
the mesh is chosen in Python, MoorDyn's run until its steady state is not in its time. All in one run: only ratios mean
something.
"""

from __future__ import annotations

import argparse
import math
import subprocess
import tempfile
import time
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import moordyn_tow
import numpy as np
from moordyn_tow import FREQUENCY, SPEED, harmonic, tow_case

from towage.fmus.native.trace_chain import chain_headers, point_source
from towage.models.cable.wire.chain import Chain
from towage.models.cable.wire.grading import graded_mesh
from towage.models.cable.wire.parts import Mass, Section, Wire, cross_flow_section, uniform_flow
from towage.models.cable.wire.rest import Frame, march
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
    """What a run of ``wire_host.c`` printed: rows (t, body relative to the top, pull on the top); ms a simulated second; the
    steady state in C, ms; steps, evaluations, factorisations, failures, rejections."""

    rows: Array
    motion: float
    setup: float
    counts: tuple[int, ...]

    @property
    def cost(self) -> float:
        """ms a simulated second of a run of a minute, set-up included."""
        return self.motion + self.setup / 60.0


def build(folder: Path) -> Path:
    """The host, compiled."""
    for name, text in {**chain_headers(), "point.c": point_source()}.items():
        (folder / name).write_text(text)
    sources = [*RUNTIME.glob("chain*.c"), folder / "point.c", Path(__file__).with_name("wire_host.c")]
    program = folder / "wire_host"
    subprocess.run(
        ["cc", "-std=c99", "-O2", "-I", str(RUNTIME), "-I", str(folder), *map(str, sources), "-lm", "-o", str(program)],
        check=True,
    )  # fmt: skip
    return program


def numbers(chain: Chain, setting: list[float], times: list[float]) -> str:
    """The case as text for the host."""
    nodes, fixture = chain.fixtures
    out: list[float] = [chain.dimensions, chain.mesh.degree, len(chain.mesh.lengths), 0.0, 0.0]
    material = np.hstack([np.broadcast_to(column, (len(chain.mesh.lengths), 1)) for column in chain.material])
    out += [*(0.5 * chain.mesh.lengths), *material.ravel()]
    out += [len(nodes)]
    for k, node in enumerate(nodes):
        out += [node, *(m[k] for m in fixture.masses), fixture.weight[k], fixture.drag[k], fixture.aft[k]]
    out += [1.0, 0.0, *np.zeros(chain.dimensions), *setting, len(times), *times]
    return " ".join(f"{float(x):.17g}" for x in out)


def bare(program: Path, wire: Wire, mesh: tuple[int, int], stepping: tuple[float, float, int], path: list[float],
         times: list[float]) -> Bare:
    """Run: ``mesh`` = (elements, degree), graded in Python by the steady shape at the speed ``path[1]``; ``stepping`` =
    (tolerance, largest step, order)."""
    d = 3 if path[0] == 1.0 else 2
    frame, flow = Frame(np.array([path[1], *np.zeros(d - 1)])), uniform_flow(np.zeros(d))
    shape = march(wire, flow, frame, d)
    chain = Chain(wire, graded_mesh(wire, shape, mesh[1], mesh[0]).mesh, flow, d)
    text = numbers(chain, [*stepping, *path], times)
    runs = []
    for _ in range(3):
        done = subprocess.run([str(program)], input=text, capture_output=True, text=True)
        if done.returncode:
            raise SystemExit(f"wire_host: {done.returncode} {done.stderr}")
        *lines, last = done.stdout.splitlines()
        runs.append([float(x) for x in last.split()])
    return Bare(
        np.array([[float(x) for x in line.split()] for line in lines]), 1e3 * min(run[0] for run in runs) / times[-1],
        1e3 * min(run[1] for run in runs), tuple(int(x) for x in runs[0][2:]),
    )  # fmt: skip


def heave_force(rows: Array) -> Array:
    """Complex amplitude a metre of heave of the pull on the towpoint, forward and up, N/m."""
    keep = rows[:, 0] > HEAVE_START + 1e-9
    return np.array([harmonic(rows[keep, 0], rows[keep, c]) for c in (3, 4)]) / 0.2


def turn_values(rows: Array) -> Array:
    """(Body relative to the top, pull on it) at `TURN_TIMES`, (12, 6)."""
    return rows[[bool(np.abs(np.array(TURN_TIMES) - t).min() < 1e-6) for t in rows[:, 0]], 1:]


def turn_error(values: Array, fine: Array) -> tuple[float, float]:
    """(Error of the body's place, of the pull) over the largest component of each."""
    error = np.abs(values - fine)
    return float(error[:, :3].max() / np.abs(fine[:, :3]).max()), float(error[:, 3:].max() / np.abs(fine[:, 3:]).max())


TURN_DECK = """--------------------- MoorDyn Input File ------------------------------------
---------------------- LINE TYPES -----------------------------------
TypeName Diam Mass/m EA BA/-zeta EI Cd Ca CdAx CaAx
(name) (m) (kg/m) (N) (N-s/-) (N-m^2) (-) (-) (-) (-)
wire 0.012 0.6 8e6 0 0 1.5 1.0 0.01 0
---------------------- POINTS -----------------------------------
ID Attachment X Y Z Mass Volume CdA Ca
(#) (word/ID) (m) (m) (m) (kg) (m^3) (m^2) (-)
1 Free {x} 0 {z} 800 {volume} 0.3 {added}
2 Coupled 0 0 -400 0 0 0 0
---------------------- LINES -----------------------------------
ID LineType AttachA AttachB UnstrLen NumSegs Outputs
(#) (name) (ID) (ID) (m) (-) (-)
1 wire 1 2 150 {segments} -
---------------------- OPTIONS -----------------------------------
0 writeLog
{inner} dtM
rk4 tScheme
9.80665 g
1025 rho
3000 WtrDpth
0 TmaxIC
------------------------- need this line --------------------------------------
"""


def turn_place(t: float) -> list[float]:
    """Of MoorDyn's towpoint: straight before t = 0, then the turn."""
    angle = min(max(TURN_SPEED * t / TURN_RADIUS, 0.0), math.pi)
    rest = TURN_SPEED * (min(t, 0.0) + max(0.0, t - math.pi * TURN_RADIUS / TURN_SPEED))
    return [
        TURN_RADIUS * math.sin(angle) + rest * math.cos(angle),
        TURN_RADIUS * (1.0 - math.cos(angle)) + rest * math.sin(angle), -400.0,
    ]  # fmt: skip


def moordyn_turn(segments: int, inner: float, step: float, settle: float = 150.0) -> tuple[Array, float]:
    """(Values as `turn_values`, ms a simulated second); towed straight for ``settle`` seconds first, not timed."""
    import moordyn

    volume = (800.0 - 5000.0 / moordyn_tow.GRAVITY) / 1025.0
    text = TURN_DECK.format(
        x=turn_place(-settle)[0] - 111.076, z=-494.382, volume=volume, added=300.0 / (1025.0 * volume), segments=segments,
        inner=inner,
    )  # fmt: skip
    rows = []
    with tempfile.TemporaryDirectory() as folder, moordyn_tow.quiet():
        (Path(folder) / "turn.txt").write_text(text)
        system = moordyn.Create(str(Path(folder) / "turn.txt"))
        moordyn.Init(system, turn_place(-settle), [TURN_SPEED, 0.0, 0.0])
        body, count, first = moordyn.GetPoint(system, 1), round((TURN_TIMES[-1] + settle) / step), round(settle / step)
        begin = time.process_time()
        for k in range(count):
            if k == first:
                begin = time.process_time()
            t = k * step - settle
            here, there = turn_place(t), turn_place(t + step)
            force = moordyn.Step(system, here, [(b - a) / step for a, b in zip(here, there)], k * step, step)
            if np.abs(np.array(TURN_TIMES) - t - step).min() < 0.5 * step:
                place = moordyn.GetPointPos(body)
                rows.append([*(np.array(place) - there), *force])
        cost = 1e3 * (time.process_time() - begin) / TURN_TIMES[-1]
        moordyn.Close(system)
    return np.array(rows), cost


Row = tuple[str, float, float | None, float]
"""(What, error of the pull, of the body's place, ms a simulated second)."""


def heave_rows(program: Path, quick: bool) -> list[Row]:
    """The case in the plane."""
    times = [HEAVE_START + (HEAVE_STOP - HEAVE_START) * k / HEAVE_SAMPLES for k in range(HEAVE_SAMPLES + 1)]
    path = [0.0, SPEED, 0.2, FREQUENCY, HEAVE_RAMP]
    fine = heave_force(bare(program, heave_wire(), (12, 6), (1e-7, 0.05, 4), path, times).rows)
    rows: list[Row] = []

    def error(force: Array) -> float:
        return min(float(np.abs(s * force - fine).max() / np.abs(fine).max()) for s in (1.0, -1.0))

    for n, inner in [] if quick else [(20, 2e-3), (10, 4e-3)]:
        run = moordyn_tow.run(0.2, n, inner, 0.01, 120.0, 5.0)
        force = np.array([harmonic(run.time, run.force[:, c]) for c in (0, 1)]) / 0.2
        rows.append((f"MoorDyn, N = {n}, dt {inner:g}", error(force), None, 1e3 * run.cost))
    for mesh, stepping in (
        ((1, 6), (3e-3, 0.5, 3)), ((2, 4), (3e-3, 0.5, 3)), ((2, 5), (1e-3, 0.5, 3)), ((2, 6), (3e-4, 0.5, 4)),
    ):  # fmt: skip
        # the record of a period would hold the steps: timed without it
        timed = bare(program, heave_wire(), mesh, stepping, path, [HEAVE_STOP])
        found = bare(program, heave_wire(), mesh, stepping, path, times)
        rows.append((_label(mesh, stepping), error(heave_force(found.rows)), None, timed.cost))
    return rows


def _label(mesh: tuple[int, int], stepping: tuple[float, float, int]) -> str:
    return f"{mesh[0]} of degree {mesh[1]}, tolerance {stepping[0]:g} m/s, order {stepping[2]}"


def turn_rows(program: Path, quick: bool) -> list[Row]:
    """The case in space."""
    times = sorted([*TURN_TIMES, math.pi * TURN_RADIUS / TURN_SPEED])
    path = [1.0, TURN_SPEED, TURN_RADIUS, math.pi, 0.0]
    fine = turn_values(bare(program, turn_wire(), (6, 6), (1e-7, 0.5, 4), path, times).rows)
    rows: list[Row] = []
    for n, inner in [] if quick else [(20, 2e-3), (10, 4e-3)]:
        values, cost = moordyn_turn(n, inner, 0.02)
        place, pull = turn_error(values, fine)
        rows.append((f"MoorDyn, N = {n}, dt {inner:g}", pull, place, cost))
    for mesh, stepping in (
        ((1, 4), (1e-2, 3.0, 3)), ((1, 6), (1e-2, 3.0, 3)), ((2, 4), (1e-3, 2.0, 3)), ((1, 6), (1e-5, 2.0, 3)),
        ((2, 6), (1e-5, 2.0, 4)),
    ):  # fmt: skip
        found = bare(program, turn_wire(), mesh, stepping, path, times)
        place, pull = turn_error(turn_values(found.rows), fine)
        rows.append((_label(mesh, stepping), pull, place, found.cost))
    return rows


def printed(heading: str, rows: Iterable[Row]) -> None:
    """A table as Markdown; its first row is MoorDyn's, if there is one."""
    rows = list(rows)
    peer = rows[0][3] if rows[0][0].startswith("MoorDyn") else None
    print(f"### {heading}\n\n| model | error of the pull | error of the body | ms a simulated s | MoorDyn N = 20 over it |")
    print("|---|---|---|---|---|")
    for label, pull, place, cost in rows:
        body, ratio = "" if place is None else f"{place:.2g}", f"{peer / cost:.3g}" if peer else ""
        print(f"| {label} | {pull:.2g} | {body} | {cost:.3g} | {ratio} |")
    print()


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--no-moordyn", action="store_true")
    quick = parser.parse_args().no_moordyn
    with tempfile.TemporaryDirectory() as folder:
        program = build(Path(folder))
        printed("Heave of 0.2 m, in the plane", heave_rows(program, quick))
        printed("A turn of 60 m, in space", turn_rows(program, quick))


if __name__ == "__main__":
    main()
