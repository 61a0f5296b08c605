"""Checkpoints of a run: the state of its units, of the signals between them and of the master, from which it goes on to the
same bits.

Units that cannot serialise their state (FMI's ``canSerializeFMUstate``), do not restore it, have FMI 3's event mode, of which the
host keeps a part, or send texts leave no checkpoint: their run begins anew.
"""

from __future__ import annotations

import base64
import os
import time as clock
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from towage.errors import RunError
from towage.files import sealed, unsealed
from towage.result.journal import Journal, Kept
from towage.result.records import Event

if TYPE_CHECKING:
    from towage.master.simulation import Simulation
    from towage.master.system import System

EVERY = 1.0
"""Least time between two checkpoints, s of the clock on the wall."""
SUFFIX = ".checkpoint"
_SIGNAL = ("value", "rate", "end_value", "end_rate", "old_value", "scale", "unknown")
_SIMULATION = ("time", "done", "control", "before")
_RUN = ("rejected", "located", "time")


class Keeper:
    """Keeps checkpoints of a run beside its journal, now and then, each in the place of the one before. A disk that is full
    costs the checkpoint, not the run."""

    def __init__(self, journal: Path) -> None:
        self.path = journal.with_suffix(SUFFIX)
        self._due = clock.monotonic() + EVERY

    def look(self, simulation: Simulation) -> None:
        """Keep a checkpoint, if one is due and all units can serialise their state."""
        if clock.monotonic() < self._due or not simulation.recorder.journal:
            return
        if not can_freeze(simulation.system):
            return
        data = {"journal": simulation.recorder.journal.size(), **frozen(simulation)}
        with suppress(OSError):
            temporary = self.path.with_suffix(".next")
            temporary.write_bytes(sealed(data))
            os.replace(temporary, self.path)
        self._due = clock.monotonic() + EVERY

    def found(self) -> dict[str, Any] | None:
        """The checkpoint that an earlier run left, if it is whole."""
        try:
            return unsealed(self.path.read_bytes())
        except (OSError, ValueError, RecursionError):
            return None


def can_freeze(system: System) -> bool:
    """Whether a checkpoint holds everything that the next step of these units depends on."""
    return not system.distrusted and all(
        unit.description.can_serialize_state and unit.instance.freezes and not unit.wiring.others.words for unit in system.units
    )


def frozen(simulation: Simulation) -> dict[str, Any]:
    """Everything that the next step depends on, in terms of JSON."""
    system, run = simulation.system, simulation.run
    return {
        "units": [
            {
                "state": base64.b64encode(unit.frozen(simulation.time)).decode(),
                "values": list(unit.values),
                "inputs": list(unit.input_buffer),
            }
            for unit in system.units
        ],
        "signals": [
            {name: getattr(s, name) for name in _SIGNAL} | {"polynomial": list(s.polynomial)} for s in system.signals
        ],
        "system": {
            "old_step": system.old_step,
            "learned": [[np.asarray(a).tolist(), np.asarray(b).tolist()] for a, b in system.learned_now],
            "learned_step": system.learned_step,
            "noise": system.noise,
            "scales": list(system.scales.items()),
            "late_units": sorted(system.late_units),
        },
        "simulation": {name: getattr(simulation, name) for name in _SIMULATION},
        "run": {name: getattr(run, name) for name in _RUN},
        "steps": run.steps.tolist(),
        "bonds": [[bond.residual, bond.throughput] for bond in run.bonds],
    }


def thaw(simulation: Simulation, data: dict[str, Any], kept: Kept) -> None:
    """Go on from where the checkpoint was taken; ``kept``: what the journal holds up to there. Raises `RunError` where it is
    not one of this system."""
    system, run = simulation.system, simulation.run
    simulation.recorder.go_on(kept.rows)  # first: it is kept even if the rest does not fit
    try:
        for unit, said in zip(system.units, data["units"], strict=True):
            unit.thaw(base64.b64decode(said["state"]), data["simulation"]["time"])
            unit.values = list(said["values"])
            unit.input_buffer[:] = said["inputs"]
        for signal, said in zip(system.signals, data["signals"], strict=True):
            for name in _SIGNAL:
                setattr(signal, name, said[name])
            signal.polynomial = tuple(said["polynomial"])
        _thaw_system(system, data["system"])
        for name in _SIMULATION:
            setattr(simulation, name, data["simulation"][name])
        for name in _RUN:
            setattr(run, name, data["run"][name])
        run.steps.extend(data["steps"])
        for bond, (residual, throughput) in zip(run.bonds, data["bonds"], strict=True):
            bond.residual, bond.throughput = residual, throughput
    except (KeyError, ValueError, TypeError) as error:
        raise RunError(f"the checkpoint is of another system: {error}") from error
    run.events += [Event(**vars(event)) for event in kept.events]


def _thaw_system(system: System, said: dict[str, Any]) -> None:
    system.old_step, system.learned_step = said["old_step"], said["learned_step"]
    system.noise, system.late_units = dict(said["noise"]), set(said["late_units"])
    system.scales = {i: list(scales) for i, scales in said["scales"]}
    system.unknown = [s for s in system.signals if s.unknown]
    system.learned_now[:] = [(np.array(a), np.array(b)) for a, b in said["learned"]]


def reopened(journal: Path, names: list[str], data: dict[str, Any]) -> tuple[Journal, Kept]:
    """The journal, cut to where the checkpoint was taken, and what it holds. Raises `RunError` where it does not fit."""
    from towage.result.journal import read

    with open(journal, "r+b") as file:
        if file.seek(0, 2) < data["journal"]:
            raise RunError("the journal ends before its checkpoint")
        file.truncate(data["journal"])
        kept = read(file)
    if kept is None or kept.names != names or kept.lost:
        raise RunError("the journal does not fit its checkpoint")
    return Journal(journal, names), kept
