"""What a scene may name: units, schemes, checks and writers, the project's own and those of other packages.

A `Registry` maps names to values. The project's own names stand here, each with the place of its value, which is
imported when it is first asked for. Another package brings values by entry points of the registry's group:

    [project.entry-points."towage.schemes"]
    leapfrog = "my_package.leapfrog:LEAPFROG"

Entry points are read only for a name that is not one of the project's own, or for a list of all names, because reading
the metadata of every installed package takes longer than checking a scene.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from importlib import import_module
from typing import TYPE_CHECKING, Any

from towage.errors import TowageError, suggest
from towage.fmus import UNITS as SHIPPED_UNITS

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint


class Registry:
    """Values of one kind by name.

    ``group`` is the group of entry points and ``what`` the kind in words, for messages. ``kind`` is the type that every
    value must have, and the values of ``own`` are places, both as "module:attribute".
    """

    def __init__(self, group: str, what: str, kind: str, own: Mapping[str, str]) -> None:
        self.group = group
        self.what = what
        self.own = dict(own)
        self._kind = kind
        self._loaded: dict[str, Any] = {}

    def get(self, name: str) -> Any:
        """The value called ``name``. Raises `TowageError` if there is none, or if the package that brings it is faulty."""
        if name not in self._loaded:
            if name in self.own:
                self._loaded[name] = _attribute(self.own[name])
            elif name in self._foreign:
                self._loaded[name] = self._load(self._foreign[name])
            else:
                known = self.names()
                raise TowageError(
                    f"unknown {self.what} {name!r}{suggest(name, known)}; expected one of: {', '.join(known)}"
                )
        return self._loaded[name]

    def place(self, name: str) -> str:
        """Where the value called ``name`` is, as "module:attribute". Raises ``KeyError`` if there is none."""
        return self.own[name] if name in self.own else self._foreign[name].value

    def names(self) -> tuple[str, ...]:
        """All names, the project's own first. Nothing is imported. Raises `TowageError` if two packages bring one name."""
        return (*self.own, *sorted(self._foreign))

    def __contains__(self, name: object) -> bool:
        """Whether ``name`` can be asked for."""
        return name in self.own or name in self._foreign

    @cached_property
    def _foreign(self) -> dict[str, EntryPoint]:
        """The entry points of other packages by name. Raises `TowageError` where one takes a name that is taken."""
        from importlib.metadata import entry_points

        points: dict[str, EntryPoint] = {}
        for point in entry_points(group=self.group):
            if point.name in self.own:
                raise TowageError(
                    f"{_origin(point)} brings the {self.what} {point.name!r}, a name that towage uses itself: its author "
                    "must choose another name; until then uninstall the package"
                )
            other = points.setdefault(point.name, point)
            if other.value != point.value:
                raise TowageError(
                    f"{_origin(point)} and {_origin(other)} both bring the {self.what} {point.name!r}: uninstall one"
                )
        return points

    def _load(self, point: EntryPoint) -> Any:
        """The value of an entry point. Whatever its package raises becomes a `TowageError` that names it."""
        try:
            value = point.load()
        except Exception as error:
            raise TowageError(
                f"{_origin(point)} brings the {self.what} {point.name!r}, which cannot be loaded "
                f"({type(error).__name__}: {error}): update the package or uninstall it"
            ) from error
        kind = _attribute(self._kind)
        if not isinstance(value, kind):
            raise TowageError(
                f"{_origin(point)} brings the {self.what} {point.name!r}, which is a {type(value).__name__}: expected a "
                f"{kind.__name__} (see docs/how_to_add.md)"
            )
        return value


def _attribute(place: str) -> Any:
    """What "module:attribute" names."""
    module, _, name = place.partition(":")
    return getattr(import_module(module), name)


def _origin(point: EntryPoint) -> str:
    """Where an entry point comes from, for messages."""
    package = f"package {point.dist.name!r}" if point.dist else "a package of unknown name"
    return f"{package} (entry point {point.name} = {point.value} of {point.group})"


SCHEMES = Registry(
    "towage.schemes",
    "scheme",
    "towage.master.schemes:Scheme",
    {
        "hermite": "towage.master.schemes:HERMITE",
        "extrapolate": "towage.master.schemes:EXTRAPOLATE",
        "implicit": "towage.master.schemes:IMPLICIT",
        "jacobi": "towage.master.schemes:JACOBI",
        "gauss-seidel": "towage.master.schemes:GAUSS_SEIDEL",
    },
)
"""Coupling schemes, `towage.master.schemes.Scheme`."""

UNITS = Registry(
    "towage.units",
    "unit",
    "towage.fmus.declare.unit:Unit",
    {name: f"towage.fmus.{name}:UNIT" for name in SHIPPED_UNITS},
)
"""Declarations of units, `towage.fmus.declare.unit.Unit`."""

CHECKS = Registry(
    "towage.checks",
    "check",
    "towage.checks.check:Check",
    {
        "units": "towage.checks.units:CHECK",
        "inputs": "towage.checks.inputs:CHECK",
        "step": "towage.checks.step:CHECK",
        "error": "towage.checks.error:CHECK",
        "sdof": "towage.checks.sdof:CHECK",
        "statistics": "towage.checks.statistics:CHECK",
        "simpler": "towage.checks.simpler:CHECK",
        "towing": "towage.checks.tows:CHECK",
        "wire": "towage.checks.wire:CHECK",
        "margins": "towage.checks.margins:CHECK",
    },
)
"""Checks of a run, `towage.checks.check.Check`, in the order in which their findings are told."""

AXES = Registry(
    "towage.axes",
    "axis",
    "towage.ladder.axis:Axis",
    {
        "sea": "towage.ladder.drive:SEA",
        "ways": "towage.ladder.drive:WAYS",
        "line": "towage.ladder.lift:LINE",
        "drag": "towage.ladder.lift:DRAG",
        "cable": "towage.ladder.tow:CABLE",
        "body": "towage.ladder.body:BODY",
    },
)
"""Axes of the ladder of models, `towage.ladder.axis.Axis`, in the order in which a scene is made simpler along them."""

WRITERS = Registry(
    "towage.writers",
    "writer",
    "towage.result.writers:Writer",
    {
        "csv": "towage.result.writers:CSV",
        "npz": "towage.result.writers:NPZ",
        "mat": "towage.result.writers:MAT",
        "nc": "towage.result.writers:NETCDF",
    },
)
"""Writers of result files, `towage.result.writers.Writer`."""
