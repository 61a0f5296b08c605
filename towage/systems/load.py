"""From a file of another format to the tables of a scene, as `towage.scene.scene.Scene.from_dict` takes them.

What a scene needs and the file does not say is filled in, and said: the stop time and the step by the default experiments of
the FMUs.
"""

from __future__ import annotations

import re
from collections.abc import Collection
from pathlib import Path
from typing import Any

from towage.errors import SceneError
from towage.systems import osp, ssd
from towage.systems.network import Change, Link, Network, Note
from towage.systems.network import Path as Names
from towage.systems.source import Archive, Files
from towage.units.description import Description
from towage.units.loops import loops_of, presumed

STOP, STEPS = 10.0, 1000
"""The stop time, s, and the number of steps, where neither the system nor an FMU says any."""


def system_file(given: str | Path) -> Path | None:
    """The file that a path names, if it is a system of another format: an archive or description of SSP, with #NAME.ssd behind
    it for another variant, one of OSP, or a folder that has either."""
    path = Path(str(given).partition("#")[0])
    if path.is_dir():
        return next((path / name for name in (ssd.MAIN, osp.MAIN) if (path / name).is_file()), None)
    return path if path.suffix.lower() in (".ssp", ".ssd", ".xml") else None


def network_of(given: str | Path) -> Network:
    """The system that `system_file` found. Raises `SceneError`."""
    path = system_file(given)
    assert path is not None
    variant = str(given).partition("#")[2]
    if not path.is_file():
        raise SceneError("there is no such file", file=path)
    file = path.parent.resolve() if path.name in (ssd.MAIN, osp.MAIN) else path  # a folder tells more than such a name
    if path.suffix.lower() == ".xml":
        return osp.read(Files(path.parent, beyond=True), path.name, file)
    if path.suffix.lower() == ".ssd":
        return ssd.read(Files(path.parent), path.name, file)
    files = Archive(path)
    others = [name for name in files.names() if name.lower().endswith(".ssd")]
    network = ssd.read(files, files.name(variant) if variant else ssd.MAIN, file)
    if rest := [name for name in others if name != (variant or ssd.MAIN)]:
        network.say("info", f"the archive has other variants too: {', '.join(f'{path.name}#{name}' for name in rest)}")
    return network


def tables_of(network: Network, reserved: Collection[str]) -> tuple[dict[str, Any], tuple[Note, ...]]:
    """The tables of a scene, and what there is to say of them; ``reserved``: what no unit may be called. Raises `SceneError`."""
    if network.start:
        text = "and the run at 0, with the same length: units that know the time see another"
        network.say("warning", f"the system starts at {network.start:g} s, {text}")
    if not network.components:
        raise network.fault("has no component with an FMU, so that there is nothing to run", network.title)
    links = list(network.connections())
    names = _names(network, reserved)
    components = network.components.values()
    units = {names[c.path]: {"fmu": str(c.files.path(c.fmu).absolute())} for c in components}
    _values(network, names, units, links)
    texts = {link.target: _connection(link, names) for link in links}
    descriptions = [component.description for component in components]
    coupling: dict[str, Any] = {"step": _step(network, descriptions), "scheme": _scheme(network, links, names)}
    if once := [names[c.path] for c in components if c.description.once_per_process]:
        coupling["error_estimate"] = False
        why = "can be instantiated once in a process: there is no second run to estimate the coupling error"
        network.say("warning", f"{', '.join(once)} {why}", "coupling.error_estimate")
    tables = {
        "title": network.title or network.files.root.stem,
        "description": network.text,
        "stop_time": _stop(network, descriptions),
        "units": units,
        "connections": list(texts.values()),
        "transformations": {texts[link.target]: _change(link.change) for link in links if link.change is not None},
        "coupling": coupling,
    }
    return tables, tuple(network.notes)


def _names(network: Network, reserved: Collection[str]) -> dict[Names, str]:
    """What components are called in the scene."""
    names: dict[Names, str] = {}
    taken = set(reserved)
    for path in network.components:
        wanted = re.sub(r"[^A-Za-z0-9_]", "_", "_".join(path))
        wanted = base = wanted if re.match("[A-Za-z_]", wanted) else f"_{wanted}"
        count = 1
        while wanted in taken:
            count += 1
            wanted = f"{base}_{count}"
        taken.add(wanted)
        names[path] = wanted
        if wanted != ".".join(path):
            network.say("info", f"{'.'.join(path)!r} is called {wanted} here")
    return names


def _values(network: Network, names: dict[Names, str], units: dict[str, dict[str, Any]], links: list[Link]) -> None:
    """Parameters and constants of inputs; a value for an input that is connected is left out."""
    fed = {link.target for link in links}
    for node, value in network.values.items():
        variable = network.variable(node)
        if node in fed:
            network.say(
                "info", f"the start value {value!r} of {names[node[0]]}.{node[1]} is left out, because it is connected"
            )
        elif variable:
            table = "inputs" if variable.causality == "input" else "parameters"
            units[names[node[0]]].setdefault(table, {})[node[1]] = value


def _scheme(network: Network, links: list[Link], names: dict[Names, str]) -> str:
    """``auto``, but where there is an algebraic loop, or one that passes through a unit that declares no dependencies."""
    descriptions = {names[path]: component.description for path, component in network.components.items()}
    ends = [(names[link.source[0]], link.source[1], names[link.target[0]], link.target[1]) for link in links]
    loops = loops_of(ends, descriptions)
    guessed = any(presumed(loop, descriptions) for loop in loops)
    solved = all(description.can_get_set_state for description in descriptions.values())
    if not loops or not (guessed or solved):
        return "auto"  # and refused where there is a loop, since no scheme solves it
    scheme = "implicit" if solved else "extrapolate"
    kind = "passes through a unit that declares no dependencies" if guessed else "is algebraic"
    why = (
        "which solves it"
        if solved
        else "as if one of its units had a state, since units that cannot go back have no other"
    )
    network.say("warning", f"the loop {' -> '.join(loops[0])} {kind}: coupled by {scheme}, {why}", "coupling.scheme")
    return scheme


def _connection(link: Link, names: dict[Names, str]) -> str:
    return f"{names[link.source[0]]}.{link.source[1]} -> {names[link.target[0]]}.{link.target[1]}"


def _change(change: Change) -> dict[str, Any]:
    if change.table:
        return {"values": dict(change.table)}
    return {"factor": change.factor, "offset": change.offset, "convert": False}


def _stop(network: Network, descriptions: list[Description]) -> float:
    if network.stop is not None:
        return network.stop - (network.start or 0.0)
    known = [d.default_experiment.stop_time for d in descriptions if d.default_experiment.stop_time]
    stop = max(known, default=STOP)
    why = "the longest default experiment of the FMUs" if known else "no FMU says one either"
    network.say(
        "warning", f"the system says no stop time: {stop:g} s are run ({why}); set stop_time for another", "stop_time"
    )
    return stop


def _step(network: Network, descriptions: list[Description]) -> float:
    stop = _stop(network, descriptions)
    if network.step is not None:
        return network.step
    known = [d.default_experiment.step_size for d in descriptions if d.default_experiment.step_size]
    step = min(min(known, default=stop / STEPS), stop)
    why = (
        "the shortest step of the default experiments of the FMUs" if known else f"{STEPS} in all, for no FMU says one"
    )
    network.say(
        "warning",
        f"the system says no communication step: {step:g} s ({why}); set coupling.step for another",
        "coupling.step",
    )
    return step
