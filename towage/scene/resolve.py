"""From a scene to a `ResolvedScene`: checked against the descriptions of its units, so that everything named exists and fits.

Every value becomes a number in the unit that its variable declares, SI for the shipped units; connections get the factor
between two units of the same dimension. Nothing of the FMUs is run. `described` takes FMUs as they are found;
`towage.scene.flavour.resolve` chooses their flavours too.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import msgspec
from msgspec.structs import replace

from towage.errors import SceneError
from towage.registry import SCHEMES
from towage.scene.files import descriptions_of
from towage.scene.inputs import check_aliases, check_constants, check_needed, unset_inputs
from towage.scene.physical import check_physical
from towage.scene.scene import Scene
from towage.scene.transform import carried
from towage.scene.values import Names, Values, with_article
from towage.units.conventions import has
from towage.units.description import Description, Value, Variable
from towage.units.loops import loops_of, presumed
from towage.units.store import Locate


class ResolvedConnection(NamedTuple):
    """Target value = factor * source value + offset, or what ``values`` has for a discrete one; a text is passed on as it is.
    ``changed``: the scene transforms the value, so that both ends are not the same quantity."""

    source_unit: str
    source: str
    target_unit: str
    target: str
    factor: float
    offset: float = 0.0
    values: tuple[tuple[float, float], ...] = ()
    changed: bool = False

    def __str__(self) -> str:
        return f"{self.source_unit}.{self.source} -> {self.target_unit}.{self.target}"


class ResolvedUnit(msgspec.Struct, frozen=True):
    """A unit that exists: its FMU, and the values set on it before the run, in the units its variables declare.
    ``flavour``: python, native, or for a foreign FMU the tool that made it."""

    name: str
    path: Path
    description: Description
    parameters: dict[str, Value]
    flavour: str = ""


class ResolvedVariant(msgspec.Struct, frozen=True):
    """Another run that a check asks for (`towage.scene.parts.Variant`); ``scene`` None: the same one."""

    name: str
    scene: ResolvedScene | None
    coarse: bool
    nudged: str = ""


class ResolvedScene(msgspec.Struct, frozen=True):
    """A scene in which everything named exists and fits. ``record`` is (unit, variable); ``loops`` the algebraic ones,
    as "a.y -> b.u -> b.y -> a.u -> a.y": solved by the implicit scheme, or only presumed, for want of declarations;
    ``variants`` the other runs that its checks ask for; ``forgotten`` the inputs, as "unit.input", that are neither connected
    nor set and whose start value has no meaning of its own, ``remedies`` what to do about each; ``reads`` (unit, variable) that
    checks compare, recorded or not; ``warnings`` what was taken although something is wrong with it."""

    scene: Scene
    units: dict[str, ResolvedUnit]
    connections: tuple[ResolvedConnection, ...]
    record: tuple[tuple[str, str], ...]
    loops: tuple[str, ...]
    variants: tuple[ResolvedVariant, ...] = ()
    forgotten: tuple[str, ...] = ()
    remedies: tuple[str, ...] = ()
    reads: tuple[tuple[str, str], ...] = ()
    warnings: tuple[str, ...] = ()


def described(scene: Scene, locate: Locate, open_ends: bool = False) -> ResolvedScene:
    """A scene of one case against the descriptions of its units' FMUs. ``open_ends``: inputs that are needed may be left
    open, for what does not run the scene: they become inputs of what it is composed into, or are varied.

    Raises ``SceneError``, and ``FmuError`` for an FMU that is refused; a ``LookupError`` or ``OSError`` of ``locate``
    becomes a ``SceneError``."""
    return _resolved(scene, descriptions_of(scene, locate), open_ends)


def check_all(scene: Scene, locate: Locate) -> tuple[str, ...]:
    """Refuses a scene that does not fit its units itself or in one of its cases; gives the inputs, as "unit.input", that may
    have been forgotten. Raises what `described` raises."""
    descriptions = descriptions_of(scene, locate)
    forgotten = dict.fromkeys(_resolved(scene, descriptions).forgotten)
    for case in scene.cases:
        try:
            forgotten |= dict.fromkeys(_resolved(scene.case(case.name), descriptions).forgotten)
        except SceneError as error:
            raise scene.error(f"{error.key}: {error.args[0]}", f"cases.{case.name}.set") from None
    return tuple(forgotten)


def warned(scene: Scene, locate: Locate) -> tuple[str, ...]:
    """What is taken in a scene that `check_all` passed, although something is wrong with it."""
    return _resolved(scene, descriptions_of(scene, locate)).warnings


def _resolved(scene: Scene, descriptions: Mapping[str, Description], open_ends: bool = False) -> ResolvedScene:
    """The scene against these descriptions, and the variants that its checks ask for, which leave connections out on
    purpose."""
    names = Names(scene, descriptions)
    resolved = _bare(scene, names)
    sources = {(c.target_unit, c.target): f"{c.source_unit}.{c.source}" for c in resolved.connections}
    check_constants(names, sources)
    check_needed(names)
    check_aliases(names, sources)
    forgotten = unset_inputs(names, sources, open_ends)
    check_physical(names, {name: unit.parameters for name, unit in resolved.units.items()})
    _check_margins(names)
    variants, reads = [], []
    for check in scene.active_checks():
        check.fit(names, scene.checks.get(check.name))
        reads += [(unit, name) for unit, _, name in (text.partition(".") for text in check.reads(resolved))]
    for check in scene.active_checks():
        for variant in check.variants(scene):
            other = _bare(variant.scene, Names(variant.scene, descriptions)) if variant.scene else None
            other = other and replace(other, reads=tuple(reads))
            variants.append(ResolvedVariant(variant.name, other, variant.coarse, variant.nudged))
    _check_loops(resolved.loops, names)
    told = tuple(forgotten), tuple(forgotten.values())
    return replace(resolved, variants=tuple(variants), forgotten=told[0], remedies=told[1], reads=tuple(reads))


def _bare(scene: Scene, names: Names) -> ResolvedScene:
    """The scene with its values, connections and record."""
    connections = tuple(_connection(text, f"connections[{k}]", names) for k, text in enumerate(scene.connections))
    _check_single_sources(connections, names)
    values = Values(names)
    units = {name: ResolvedUnit(name, d.path, d, values.of(name)) for name, d in names.descriptions.items()}
    loops = tuple(" -> ".join(loop) for loop in loops_of([c[:4] for c in connections], names.descriptions))
    said = [f"{name}: {text}" for name, d in names.descriptions.items() for text in d.warnings]
    warnings = tuple(dict.fromkeys((*said, *names.warnings)))
    return ResolvedScene(scene, units, connections, names.record(), loops, warnings=warnings)


def _connection(text: str, key: str, names: Names) -> ResolvedConnection:
    (source_unit, source), (target_unit, target) = _ends(text, key, names)
    for unit, variable, wanted in ((source_unit, source, "output"), (target_unit, target, "input")):
        if variable.causality != wanted:
            kind = with_article(variable.causality)
            raise names.fault(f"{unit}.{variable.name} is {kind}: expected {with_article(wanted)}", key)
    done = carried(names, text, (source_unit, source), (target_unit, target), key)
    changed = text in names.scene.transformations
    return ResolvedConnection(source_unit, source.name, target_unit, target.name, *done, changed)


def _ends(text: str, key: str, names: Names) -> tuple[tuple[str, Variable], tuple[str, Variable]]:
    """Both ends of a connection; where names hold an arrow themselves, the way to read it that names existing variables."""
    parts = text.split("->")
    ways = [("->".join(parts[:k]), "->".join(parts[k:])) for k in range(1, len(parts))]
    sound = [way for way in ways if all(map(names.exists, way))] or ways[:1]
    if len(sound) > 1:
        every = " or ".join(f"from {one.strip()!r} to {other.strip()!r}" for one, other in sound)
        raise names.fault(f"{text!r} may be read in several ways, {every}: rename a unit of the scene", key)
    first, second = sound[0]
    return names.find(first, key), names.find(second, key)


def _check_single_sources(connections: tuple[ResolvedConnection, ...], names: Names) -> None:
    fed: dict[tuple[str, str], ResolvedConnection] = {}
    for index, connection in enumerate(connections):
        first = fed.setdefault((connection.target_unit, connection.target), connection)
        if first is not connection:
            target = f"{connection.target_unit}.{connection.target}"
            message = f"{target} has two sources: {first.source_unit}.{first.source} and "
            raise names.fault(f"{message}{connection.source_unit}.{connection.source}", f"connections[{index}]")


def _check_margins(names: Names) -> None:
    added = {margin for check in names.scene.active_checks() for margin in check.margins}
    for index, name in enumerate(names.scene.checks.report_only):
        key = f"checks.report_only[{index}]"
        unit, _, own = name.partition(".")
        if own in added and unit in names.variables:
            continue
        unit, variable = names.find(name, key)
        if not (variable.name.startswith("margin_") and has(names.descriptions[unit], variable.name)):
            raise names.fault(f"{name!r} is no margin: expected 'unit.margin_...'", key)


def check_instances(resolved: ResolvedScene) -> None:
    """Refuses, where all units are in one process, a unit that a process may hold once: twice in the scene, or in a second run
    beside the first. Raises `SceneError`."""
    seen: set[Path] = set()
    for name, unit in resolved.units.items():
        if unit.description.once_per_process and (unit.path in seen or resolved.variants):
            raise resolved.scene.error(
                f"{unit.path.name} can be instantiated only once in a process, and the scene, with the runs it is compared with, "
                "has more: take towage.run or `towage run`, which give it processes of its own",
                f"units.{name}.fmu",
            )
        seen.add(unit.path)


def _check_loops(loops: tuple[str, ...], names: Names) -> None:
    """Refuses algebraic loops that the scheme cannot solve. FMI counts an output whose unit declares no dependencies as
    direct, and units that cannot restore their state have no implicit scheme: to name a scheme that never goes back says
    that such a loop is only presumed."""
    if not loops:
        return
    guessed = any(presumed(loop.split(" -> "), names.descriptions) for loop in loops)
    scheme = names.scene.coupling.scheme
    if scheme != "auto":
        chosen = SCHEMES.get(scheme)
        if chosen.solves_loops or (guessed and not chosen.goes_back):
            return
    note = " (outputs without declared dependencies count as direct)" if guessed else ""
    hint = "; if one of them has a state all the same, say so by scheme 'extrapolate'" if guessed else ""
    raise names.fault(
        f"algebraic loop {'; '.join(loops)}{note}, which scheme {scheme!r} cannot solve: "
        f"use scheme 'implicit', or break the loop with a unit that has a state{hint}",
        "connections",
    )
