"""What a data file holds: variables with their dimensions and attributes, missing values as nan.

netCDF of every kind is read with netCDF4, which applies ``_FillValue``, ``missing_value``, ``valid_range``, ``scale_factor``
and ``add_offset``. GRIB needs the extra ``grib`` (cfgrib, eccodes).
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from towage import reading
from towage.errors import SceneError

Array = NDArray[np.float64]
MOST_VALUES = 64_000_000
"""Of a variable, unpacked."""


@dataclass(frozen=True)
class Variable:
    """``load()`` gives its values as floats, nan where there are none, of shape ``shape`` over the dimensions ``dims``."""

    file: Path
    name: str
    dims: tuple[str, ...]
    shape: tuple[int, ...]
    attributes: dict[str, Any]
    load: Callable[[], Array]

    def text(self, attribute: str) -> str:
        """An attribute as text without spaces around it; empty if there is none."""
        return str(self.attributes.get(attribute, "")).strip()

    def fault(self, attribute: str, message: str) -> SceneError:
        """The fault of an attribute of this variable, or of its values."""
        place = f"{self.name}: {attribute}" if attribute else self.name
        return SceneError(f"{place}: {message}", file=self.file)


Contents = dict[str, Variable]


@contextmanager
def opened(path: Path, notes: list[str]) -> Iterator[list[Contents]]:
    """Variables of a file, numeric ones alone: one group for netCDF, one for every kind of message for GRIB. What the
    reader warns of goes into ``notes``. Raises `SceneError` for a file that cannot be read."""
    try:
        with open(path, "rb") as stream:
            start = stream.read(8)
    except OSError as error:
        raise SceneError(f"cannot be read: {error.strerror}", file=path) from error
    if start.startswith(b"GRIB"):
        yield _grib(path)
        return
    if not start.startswith((b"CDF", b"\x89HDF")):
        raise SceneError("is neither a netCDF nor a GRIB file: expected it to begin with 'CDF', '\\x89HDF' or 'GRIB', "
                         f"found {start[:4]!r}", file=path)  # fmt: skip
    from netCDF4 import Dataset

    try:
        with reading.foreign(path, "netCDF file"):
            data = Dataset(path)
            reading.limited(max((each.size for each in data.variables.values()), default=0), MOST_VALUES, "values")
    except reading.Refused as refused:
        raise SceneError(str(refused), file=path) from refused
    with data, warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        group = {name: _netcdf(path, name, each) for name, each in data.variables.items() if _numeric(each.dtype)}
        if not group:
            inner = f"; its groups ({', '.join(data.groups)}) are not looked into" if data.groups else ""
            raise SceneError(f"has no numeric variables{inner}", file=path)
        yield [group]
    notes += dict.fromkeys(f"{path.name}: {warning.message}" for warning in said)


def _numeric(dtype: Any) -> bool:
    return isinstance(dtype, np.dtype) and np.issubdtype(dtype, np.number)


def _netcdf(path: Path, name: str, variable: Any) -> Variable:
    def load() -> Array:
        try:
            with reading.foreign(path, "netCDF file"):
                return _plain(variable[...])
        except reading.Refused as refused:
            raise SceneError(f"{name}: {refused}", file=path) from refused

    attributes = {key: variable.getncattr(key) for key in variable.ncattrs()}
    return Variable(path, name, tuple(variable.dimensions), tuple(variable.shape), attributes, load)


def _plain(values: Any) -> Array:
    """Floats with nan in place of what is masked."""
    return np.asarray(np.ma.filled(np.ma.asarray(values, dtype=float), np.nan))


def _values(column: Any) -> Array:
    return _plain(column.values)


def _grib(path: Path) -> list[Contents]:
    """All messages of a GRIB file. Nothing is written beside it."""
    try:
        import cfgrib  # type: ignore[import-untyped,unused-ignore]
    except (ImportError, RuntimeError) as error:
        raise SceneError(f"is a GRIB file; to read it: pip install 'towage[grib]' ({error})", file=path) from error
    try:
        with reading.foreign(path, "GRIB file"), warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of xarray's future defaults, which cfgrib relies on
            sets = cfgrib.open_datasets(str(path), backend_kwargs={"indexpath": ""}, decode_times=False)
    except reading.Refused as refused:
        raise SceneError(str(refused), file=path) from refused
    groups = []
    for data in sets:
        numeric = {str(name): column for name, column in data.variables.items() if np.issubdtype(column.dtype, np.number)}
        groups.append({
            name: Variable(path, name, tuple(map(str, column.dims)), column.shape, dict(column.attrs), partial(_values, column))
            for name, column in numeric.items()
        })  # fmt: skip
    if not groups:
        raise SceneError("has no messages", file=path)
    return groups
