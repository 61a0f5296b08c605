"""Which FMU every unit of a scene gets: its Python flavour, a native one, or the file that the scene names.

`resolve` is the way from a scene to what runs: the scene is checked against the descriptions of its units, which both
flavours share; then the FMUs are chosen. Sizes of a
native FMU are fixed when it is built (``Size`` of its model), so that a scene, and each of its cases, decides not only
whether there is one but which. ``segments = 0``, as many as the tolerance needs, is decided by the Python model here.
"""

from __future__ import annotations

import functools
import hashlib
import importlib.util
from collections.abc import Callable
from pathlib import Path
from typing import Literal, get_args

from msgspec.structs import replace

from towage.data.given import Given
from towage.errors import FmuError
from towage.registry import UNITS
from towage.scene.files import carried
from towage.scene.resolve import ResolvedScene, ResolvedUnit, described
from towage.scene.scene import Scene
from towage.units.archive import read_description
from towage.units.description import Description, is_own
from towage.units.store import Structure, locator, native_place

Flavour = Literal["auto", "python", "native"]
FLAVOURS: tuple[Flavour, ...] = get_args(Flavour)
REMEDY = "pip install 'towage[native]', or take the flavour python"
Say = Callable[[str], None]


def resolve(
    scene: Scene, fmus: Path | None = None, flavour: Flavour = "auto", say: Say = lambda text: None
) -> ResolvedScene:
    """The scene of one case with its FMUs and those of the other runs that its checks ask for, shipped units from ``fmus``
    or the cache.

    ``auto``: native where an FMU of the wanted structure is present; ``native``: built where it is not, which takes
    seconds and is told to ``say`` before. Raises what `described` raises, and `FmuError` where a wanted FMU cannot be
    had."""
    choose = functools.partial(_with_flavours, fmus=fmus, flavour=flavour, say=say)
    resolved = choose(described(scene, locator(fmus)))
    variants = tuple(replace(v, scene=v.scene and choose(v.scene)) for v in resolved.variants)
    return replace(resolved, variants=variants)


def _with_flavours(resolved: ResolvedScene, fmus: Path | None, flavour: Flavour, say: Say) -> ResolvedScene:
    units = {}
    for name, unit in resolved.units.items():
        shipped = resolved.scene.units[name].fmu
        if not shipped.endswith(".fmu"):
            data = carried(resolved.scene, name)
            unit = _with_data(unit, data, flavour, say) if data else _chosen(unit, shipped, fmus, flavour, say)
        units[name] = replace(unit, flavour=flavour_of(unit.description))
    return replace(resolved, units=units)


def flavour_of(description: Description) -> str:
    """``python`` or ``native`` for our own FMUs, else the tool that made it."""
    if not is_own(description):
        return description.generation_tool or "unknown tool"
    compiled = description.can_interpolate_inputs or description.fmi_version != "2.0"  # PythonFMU's bridge offers neither
    return "native" if compiled else "python"


def _chosen(unit: ResolvedUnit, shipped: str, fmus: Path | None, flavour: Flavour, say: Say) -> ResolvedUnit:
    """The unit with the FMU that ``flavour`` asks for; structural parameters have the values of the build."""
    from towage.fmus.declare.unit import load

    given = flavour_of(unit.description)
    if flavour == "python" and given != "python":
        raise FmuError(f"is {given}, and the flavour python is asked for", file=unit.path)
    if flavour == "python" or given != "python" or shipped not in UNITS.own or load(shipped).not_native:
        return unit
    beside = fmus / "native" / f"{shipped}.fmu" if fmus else None
    if flavour == "auto" and not (beside and beside.is_file()) and not _cached(shipped):
        return unit  # before the structure is computed, which may take a second
    structure = _structure(unit, shipped)
    if structure is None:
        return unit
    place = native_place(shipped, structure)
    for path in (beside, place):
        if path and path.is_file():
            description = read_description(path)
            if {v.name: v.start for v in description.variables if v.name in structure} == structure:
                return _with(unit, description, structure)
    if flavour == "auto":
        return unit
    shape = ", ".join(f"{parameter} = {value:g}" for parameter, value in structure.items())
    say(f"building native {shipped}" + (f" with {shape}" if shape else ""))
    return _with(unit, read_description(_build(shipped, place.parent, structure)), structure)


def _with_data(unit: ResolvedUnit, data: Given, flavour: Flavour, say: Say) -> ResolvedUnit:
    """As `_chosen`, of a unit that carries data."""
    if flavour == "python" or (flavour == "auto" and not data.native_folder().is_dir()):
        return unit
    structure = _structure(unit, data.name)
    assert structure is not None
    place = _place(data.native_folder(), data.name, structure)
    if not place.is_file():
        if flavour == "auto":
            return unit
        say(f"building native {data.name} with its files")
        _build_given(data, place, structure)
    return _with(unit, read_description(place), structure)


def _place(folder: Path, name: str, structure: Structure) -> Path:
    shape = ",".join(f"{parameter}={value:g}" for parameter, value in sorted(structure.items()))
    return folder / hashlib.sha256(shape.encode()).hexdigest()[:16] / f"{name}.fmu"


def _build_given(data: Given, place: Path, structure: Structure) -> None:
    if not importlib.util.find_spec("casadi"):
        raise FmuError(f"native {data.name} is not built yet, and building takes CasADi: {REMEDY}")
    from towage.fmus.native.build import build_unit
    from towage.fmus.native.compiler import CompileError

    try:
        build_unit(data.unit, place.parent, structure=structure)
    except CompileError as error:
        raise FmuError(f"native {data.name} cannot be built: {error}; {REMEDY}") from error


def _build(shipped: str, directory: Path, structure: Structure) -> Path:
    """The native FMU, built now. Raises `FmuError` that says what is missing."""
    if not importlib.util.find_spec("casadi"):
        raise FmuError(f"native {shipped} is not built yet, and building takes CasADi: {REMEDY}")
    from towage.fmus.native.build import build
    from towage.fmus.native.compiler import CompileError

    try:
        return build(shipped, directory, structure=structure)[0]
    except CompileError as error:
        raise FmuError(f"native {shipped} cannot be built: {error}; {REMEDY}") from error


def _with(unit: ResolvedUnit, description: Description, structure: Structure) -> ResolvedUnit:
    return ResolvedUnit(unit.name, description.path, description, {**unit.parameters, **structure})


def _structure(unit: ResolvedUnit, shipped: str) -> Structure | None:
    """Values of the structural parameters that the scene's values ask for. None where the model refuses these values: the
    Python flavour is then taken, which tells why when it starts."""
    from towage.fmus.declare.unit import load

    declared = load(shipped)
    if not declared.model.linear and not declared.model.structure:
        return {}
    variables = unit.description.by_name()
    names = [v.name for v in declared.parameters if v.name in variables]
    values = {name: float(unit.parameters.get(name, variables[name].start or 0.0)) for name in names}
    if not declared.model.linear:
        return {name: values[name] for name in declared.model.structure}
    try:
        return _size(shipped, tuple(values.items()))
    except ValueError:
        return None


@functools.cache
def _size(shipped: str, values: tuple[tuple[str, float], ...]) -> Structure:
    """The structure of the unit's model with these parameters. Raises ``ValueError`` where there is none."""
    from towage.fmus.declare.unit import load

    linear = load(shipped).model.linear
    assert linear is not None
    size = linear.size_of(linear.Parameters(**dict(values)))
    return dict(zip(size._fields, map(float, size)))


def _cached(shipped: str) -> bool:
    """Whether the cache has a native FMU of the unit, of any structure."""
    return any(native_place(shipped, {}).parents[1].glob(f"*/{shipped}.fmu"))
