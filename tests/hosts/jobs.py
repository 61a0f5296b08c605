"""Scenes and units as jobs for another host, and the host's answer beside ours.

A host runs in a process of its own, because a crash there would end ours, and in the Python of ``TOWAGE_HOSTS`` (default: the
one that runs this), because hosts ask for packages that towage does not go with. Nothing of towage imports a host.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import msgspec
import numpy as np

from towage.export.export import prepare
from towage.export.osp import write_osp
from towage.export.ssp import PARAMETER_SET, write_ssp
from towage.master.master import Master
from towage.result.result import Result
from towage.scene.flavour import Flavour, resolve
from towage.scene.scene import Checks, Coupling, Record, Scene, UnitEntry
from towage.units.archive import read_description
from towage.units.description import Description

PROGRAMS = Path(__file__).with_name("programs")
LOOSE_STEP = 0.1
"""Step, s, of scenes that leave theirs to the error control."""
TIME_LIMIT = 600
"""Seconds for one job in a host; the longest shipped scene takes less than one."""
Job = dict[str, Any]
Series = dict[str, np.ndarray]


class HostError(Exception):
    """A host that is not there, or that failed; says which and why."""


@dataclass(frozen=True)
class Host:
    """A host: ``takes`` a whole scene as a system or one FMU at a time, by ``program`` of the folder ``programs``.

    ``module`` is the package of it in the Python of the hosts; ``variable`` the environment variable that names its program
    where it is one."""

    name: str
    takes: Literal["system", "unit"]
    program: str
    install: str
    module: str = ""
    variable: str = ""
    first_order: bool = False
    """It has a method of order 1 of its own, so that it is compared with the scene's scheme, from which it differs as such a
    method does; the others have our `jacobi`."""
    own_order: bool = False
    """It reads outputs before inputs are set (fmpy, fmusim) or again after they were passed on (Ecos). Outputs that inputs act
    on without delay are then those of another point, and are left out; what they do to other units is not."""

    def missing(self) -> str:
        """Why it cannot be run here, or nothing."""
        if self.variable:
            place = os.environ.get(self.variable) or shutil.which(self.name.lower())
            return (
                ""
                if place and Path(place).is_file()
                else f"not installed: {self.install}, and name it in {self.variable}"
            )
        look = f"import importlib.util, sys; sys.exit(importlib.util.find_spec({self.module!r}) is None)"
        absent = subprocess.run([python(self.module), "-c", look], cwd=PROGRAMS.parent).returncode
        return f"not installed: {self.install}" if absent else ""

    def run(self, job: Job) -> tuple[str, Series]:
        """(version, values). Raises `HostError`."""
        own = [os.environ.get(self.variable) or shutil.which(self.name.lower()) or ""] if self.variable else []
        command = [python(self.module), str(PROGRAMS / f"{self.program}.py"), *own]
        done = subprocess.run(
            command, input=json.dumps(job), capture_output=True, text=True, cwd=job["folder"], timeout=TIME_LIMIT
        )
        if done.returncode:
            lines = (done.stderr.strip() or done.stdout.strip() or "no message").splitlines()
            raise HostError(f"{self.name} ended with {done.returncode}: {lines[-1]}")
        found = json.loads(done.stdout.splitlines()[-1])
        return found["version"], {name: np.array(values) for name, values in found["values"].items()}


HOSTS = (
    Host("libcosim", "system", "libcosim", "pip install libcosimpy", "libcosimpy"),
    Host("Ecos", "system", "ecos", "pip install ecospy, and libtbb.so.12", "ecospy", own_order=True),
    Host("cofmupy", "system", "cofmupy", "pip install cofmupy", "cofmupy"),
    Host("fmucontainer", "system", "fmucontainer", "pip install fmu-manipulation-toolbox", "fmu_manipulation_toolbox"),
    Host("OMSimulator", "system", "omsimulator", "built from source", variable="OMSIMULATOR", first_order=True),
    Host("fmpy SSP", "system", "fmpy_ssp", "pip install fmpy", "fmpy"),
    Host("fmpy", "unit", "fmpy_one", "pip install fmpy", "fmpy", own_order=True),
    Host("fmusim", "unit", "fmusim", "built from source", variable="FMUSIM", own_order=True),
)


def python(module: str) -> str:
    """The Python that a host is installed in; fmpy comes with towage."""
    return sys.executable if module == "fmpy" else os.environ.get("TOWAGE_HOSTS") or sys.executable


def direct(unit: str, description: Description) -> list[str]:
    """The outputs that inputs act on without delay."""
    return [f"{unit}{name}" for name, inputs in description.dependencies.items() if inputs is None or inputs]


def short(name: str, steps: int, step: float | None = None) -> Scene:
    """The first steps of a shipped scene, with all its outputs recorded and nothing judged."""
    scene = Scene.load(name)
    step = step or scene.coupling.step or LOOSE_STEP
    coupling = Coupling(scene.coupling.scheme, step, error_estimate=False)
    record = Record(interval=step)
    return msgspec.structs.replace(
        scene, coupling=coupling, stop_time=steps * step, record=record, checks=Checks(), cases=()
    )


def ours(scene: Scene, scheme: str, flavour: Flavour, share: float = 1.0) -> Result:
    """In our master, with ``share`` of the step."""
    step = (scene.coupling.step or 0.0) * share
    coupling = msgspec.structs.replace(scene.coupling, scheme=scheme, step=step)
    result = Master(msgspec.structs.replace(scene, coupling=coupling), None, None, flavour).run()
    assert result.status == "done", result.message
    return result


def system_job(
    scene: Scene, flavour: Flavour, directory: Path, kind: str = "osp", at_start: Result | None = None
) -> Job:
    """The scene written to ``directory``, as a system of OSP and as an archive of SSP, with what hosts that read neither
    are given: FMUs, values, connections and, from our run, the connected inputs at time 0."""
    resolved = resolve(scene, flavour=flavour)
    export = prepare(resolved)
    osp, ssp = directory / "osp", directory / "scene.ssp"
    directory.mkdir(exist_ok=True)
    write_osp(export, osp)
    write_ssp(export, ssp)
    initial: dict[str, dict[str, float]] = {}
    for c in resolved.connections if at_start else ():
        value = float(at_start[f"{c.source_unit}.{c.source}"][0])  # type: ignore[index]
        initial.setdefault(c.target_unit, {})[c.target] = c.factor * value + c.offset
    return {
        "kind": kind,
        "folder": str(directory),
        "osp": str(osp),
        "ssp": str(ssp),
        "parameter_set": PARAMETER_SET,
        "step": export.step,
        "steps": round(scene.stop_time / export.step),
        "units": {
            name: {"fmu": str(osp / export.files[name]), "start": dict(unit.parameters)}
            for name, unit in resolved.units.items()
        },
        "connections": [[c.source_unit, c.source, c.target_unit, c.target, c.factor, c.offset] for c in resolved.connections],
        "initial": initial,
        "direct": [each for name, unit in resolved.units.items() for each in direct(f"{name}.", unit.description)],
        "watch": [(unit, name, export.variable(unit, name).value_reference) for unit, name in resolved.record],
    }  # fmt: skip


def one_job(
    fmu: Path, directory: Path, step: float, steps: int, watch: list[str], start: dict[str, float], inputs: str
) -> Job:
    """One FMU; ``inputs``: CSV of what is set at the times of the steps, or nothing."""
    directory.mkdir(exist_ok=True)
    table = directory / "inputs.csv"
    if inputs:
        table.write_text(inputs, encoding="utf-8")
    return {
        "fmu": str(fmu), "folder": str(directory), "step": step, "steps": steps, "watch": watch, "start": start,
        "inputs": str(table) if inputs else None, "direct": direct("", read_description(fmu)),
    }  # fmt: skip


def alone(fmu: Path, step: float, steps: int) -> tuple[list[str], Result]:
    """(outputs, our run) of one FMU with its start values."""
    scene = Scene(
        title=fmu.stem, units={"it": UnitEntry(fmu=str(fmu))}, connections=(), stop_time=steps * step,
        coupling=Coupling("jacobi", step, error_estimate=False), record=Record(interval=step),
    )  # fmt: skip
    result = ours(scene, "jacobi", "auto")
    return [name for unit, name in resolve(scene).record if unit == "it"], result


def difference(theirs: Series, expected: Series) -> tuple[float, str]:
    """(largest difference, relative to the largest value of its variable; that variable)."""
    assert theirs, "the host gave no values"
    worst = (0.0, "")
    for name, values in theirs.items():
        assert len(values) == len(expected[name]), f"{name}: {len(values)} values in place of {len(expected[name])}"
        apart, size = float(np.max(np.abs(values - expected[name]))), float(np.max(np.abs(expected[name])))
        share = apart / size if size else apart
        if not share <= worst[0]:
            worst = share, name
        if share != share:  # nothing is worse than no number
            break
    return worst
