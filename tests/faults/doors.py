"""The doors of towage, and sound inputs for each of them (`tests.faults.fuzz`)."""

from __future__ import annotations

import ctypes
import io
import json
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from tests.faults import boxes, forecasts, systems
from tests.zoo.zoo import description3
from towage.commands.common import setting
from towage.errors import FmuError
from towage.files import sealed, unsealed
from towage.master.checkpoint import Keeper
from towage.master.outcome import recovered
from towage.report.page import text_summary
from towage.result.journal import FORMAT, Journal, read_at
from towage.result.records import Event, Finding, Margin, Verdict
from towage.result.result import Result
from towage.routing import file as routes
from towage.scene.resolve import check_all
from towage.scene.scene import SHIPPED, Scene
from towage.sweeps.journal import Journal as SweepJournal
from towage.sweeps.row import Row
from towage.units.archive import extract, read_description
from towage.units.fmu import Unit
from towage.units.store import locator
from towage.units.wiring import Wanted
from towage.verify.verify import cases

SCENES = ("slack", "docking", "sea_cliff", "deep_lift", "tow_600ft")
def doors(folder: Path, door: Callable[..., Any]) -> list[Any]:
    """All of them; seeds are made in ``folder``."""
    scenes = [(SHIPPED / f"{name}.toml").read_bytes() for name in SCENES]
    shipped = [path.read_bytes() for path in sorted((SHIPPED.parent / "routes").glob("*.toml"))]
    result, journal, sweep = folder / "seed.npz", folder / "seed.journal", folder / "seed.jsonl"
    _result().save_npz(result)
    _journal(journal)
    with SweepJournal(sweep, {"scene": {"title": "a"}}, False) as rows:
        for k in range(5):
            rows.append(Row(k, "done", "valid", "", {"x": k / 3}))
    box = boxes.build(folder / "seed.fmu", resources__noise=bytes(range(256)))
    metadata = json.dumps(json.loads(np.load(result)["metadata"].tobytes()) | {"checksum": None}).encode()
    reference = json.dumps(
        {"cases": json.loads((SHIPPED.parent / "reference" / "cradle.json").read_text())["cases"][:2]}
    )
    return [
        door("scene", ".toml", scenes, lambda path: check_all(Scene.load(path), locator())),
        door("route", ".toml", shipped, routes.load),
        door("setting", ".txt", [b"ship.heave_period='8 s'", b"coupling.step=[1, 2.5e-3]", b"a.b=true"], _setting),
        door("archive", ".fmu", [box.read_bytes()], _archive),
        door("description", ".xml", [boxes.xml().encode()], _description),
        door("result", ".npz", [result.read_bytes()], lambda path: text_summary(Result.load_npz(path))),
        door("metadata", ".json", [metadata], _metadata),
        door("journal", ".journal", [journal.read_bytes()], lambda path: text_summary(recovered(read_at(path), ""))),
        door("about", ".json", [json.dumps(_result().metadata()).encode()], _about),
        door("sweep", ".jsonl", [sweep.read_bytes()], _sweep),
        door("reference", ".json", [reference.encode()], cases),
        door("description3", ".xml", [description3().encode()], _description),
        door("checkpoint", ".checkpoint", [sealed({"journal": 1, "run": {"steps": [0.1]}})], _checkpoint),
        door("kept", ".json", [sealed({"yaw": [1.0], "flutter": [[1.0, 2.0, True]], "stable": [[0.0, 1.0]]})], _kept),
        door("frame", ".json", [*_FRAMES], _frame),
        *forecasts.doors(folder, door),
        door("state", ".state", _states(), _state),
        door("system", ".ssp", [systems.archive(folder / "seed.ssp")], _system),
        door("structure", ".ssd", [systems.SSD.encode()], _system),
        door("osp", ".xml", [systems.OSP.encode()], _system),
    ]


def _result() -> Result:
    time = np.arange(20.0)
    return Result(
        "A run", "8 s wave", "hermite", "done", "", time, {"a.x": np.sin(time), "a.y": time}, {"a.x": "m", "a.y": "N"},
        one_way={"a.x": np.cos(time)}, events=[Event(1.5, "a", "slack", -1)], step_sizes=np.ones(19),
        checks=[Finding("step", "ok", 0.1, 0.2, "is short enough", "none")], margins=[Margin("a.margin_taut", 0.4, 3.0, True)],
        verdict=Verdict("valid", "all of it", 0.1, 0.5), statistics={"steps": 19.0, "wall_s": 0.1, "real_time_factor": 190.0},
        scene_source='title = "A run"\n', flavours={"a": "native"}, coupling_error={"a.x": 1e-3},
    )  # fmt: skip


def _journal(path: Path) -> None:
    journal = Journal(path, ["a.x", "a.y"], _result().metadata())
    for k in range(20):
        journal.row(np.array([k, np.sin(k), k], dtype=float).tobytes(), k % 3 > 0)
    journal.event(Event(1.5, "a", "slack", -1))
    journal.close()


def _setting(path: Path) -> None:
    import argparse

    try:
        setting(path.read_text("utf-8", "replace"))
    except argparse.ArgumentTypeError as error:
        raise FmuError(str(error)) from error  # which argparse makes exit code 2


def _system(path: Path) -> None:
    """A system of another format, its FMU beside it; what it unpacks is removed."""
    import os
    import tempfile
    from unittest import mock

    boxes.build(path.parent / "box.fmu")
    with tempfile.TemporaryDirectory() as place, mock.patch.dict(os.environ, TOWAGE_CACHE=place):
        check_all(Scene.load(path), locator())


def _archive(path: Path) -> None:
    read_description(path)
    extract(path, path.parent / "unpacked", replace=True)


def _description(path: Path) -> None:
    read_description(boxes.build(path.with_suffix(".fmu"), path.read_bytes()))


def _metadata(path: Path) -> None:
    """What a result says, with sound arrays and without a checksum."""
    stored = {"time": np.arange(20.0), "step_sizes": np.ones(19), "a.x": np.ones(20), "a.y": np.ones(20)}
    stream = io.BytesIO()
    np.savez(stream, metadata=np.frombuffer(path.read_bytes(), np.uint8), **stored, **{"one_way:a.x": np.ones(20)})
    text_summary(Result.load_npz(io.BytesIO(stream.getvalue())))


def _about(path: Path) -> None:
    """The head of a journal whose checksum fits."""
    try:
        about = json.loads(path.read_bytes())
    except (ValueError, RecursionError):
        about = path.read_bytes().decode("latin-1")
    path.write_bytes(sealed({"journal": FORMAT, "names": ["a.x", "a.y"], "interval": 0.1, "held": [], "about": about}))
    text_summary(recovered(read_at(path), ""))


_FRAMES = (
    b'E{"time": 1.5, "unit": "a", "name": "slack", "direction": -1}',
    b'M[0.5, "a", "Warning", "logStatusWarning", "said"]',
    b'T[0.5, "a.words", "said"]',
)
"""Tag and JSON of frames of a journal."""


def _frame(path: Path) -> None:
    """A frame whose checksum fits, after sound rows."""
    frame = path.read_bytes()
    tag, text = frame[:1], frame[1:]
    _journal(path)
    with open(path, "ab") as file:
        file.write(b"".join((tag, len(text).to_bytes(4, "little"), text, zlib.crc32(text).to_bytes(4, "little"))))
    kept = read_at(path)
    text_summary(recovered(kept, ""))
    if kept.lost:
        raise FmuError("has a frame that is none")


def _sweep(path: Path) -> None:
    with SweepJournal(path, {"scene": {"title": "a"}}, True, 5):
        pass


def _checkpoint(path: Path) -> None:
    """What is damaged is not used."""
    if Keeper(path.with_suffix("")).found() is None:
        raise FmuError("is no checkpoint")


def _kept(path: Path) -> None:
    """What programs keep in the cache is made again where it is damaged."""
    try:
        unsealed(path.read_bytes())
    except ValueError as error:
        raise FmuError(str(error)) from error


_UNITS: dict[bytes, Unit] = {}
"""Units whose states are offered, by the seed."""


def _unit(place: Path) -> Unit:
    from towage.units.archive import unpacked
    from towage.units.store import cache

    description = read_description(place)
    unit = Unit("it", description, unpacked(place, cache() / "unpacked"), Wanted([], [], [], cubic=False))
    _begun(unit)
    return unit


def _begun(unit: Unit) -> None:
    unit.enter({}, (0.0, 10.0), None)
    unit.begin(0.0)


def _states() -> list[bytes]:
    """Of a unit in both flavours."""
    from towage.fmus.native.build import build
    from towage.units.store import native_place

    place = native_place("ship", {})
    for path in (locator()("ship"), place if place.is_file() else build("ship", place.parent)[0]):
        unit = _unit(path)
        _UNITS[unit.frozen(0.0)] = unit
    return list(_UNITS)


def _state(path: Path) -> None:
    """A state that was changed is refused by the units of both flavours."""
    data, taken = path.read_bytes(), False
    for seed, unit in _UNITS.items():
        state = ctypes.c_void_p()
        instance = unit.instance
        status = instance.deserialize(instance.component, data, len(data), ctypes.byref(state))
        status = status or instance.set_state(instance.component, state)
        taken = taken or not status
        if not status and data != seed:
            raise AssertionError("a changed state was taken")
        if status >= 3:  # an instance that says so takes nothing any more
            instance._slave.reset()
            _begun(unit)
    if not taken:
        raise FmuError("this is no state of either")
