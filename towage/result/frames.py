"""A result as a pandas table or an xarray Dataset; both are imported only here, and only when asked for."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from typing import TYPE_CHECKING, Any

from numpy.typing import NDArray

from towage.errors import TowageError

if TYPE_CHECKING:
    import pandas
    import xarray

Series = Mapping[str, NDArray[Any]]


def dataframe(series: Series, units: Mapping[str, str], about: Mapping[str, str]) -> pandas.DataFrame:
    """The series, shape (n,), over ``time`` (s) as a table; ``attrs`` are ``about`` and ``units``. Raises `TowageError`
    without pandas."""
    columns = {name: values for name, values in series.items() if name != "time"}
    pd = _module("pandas")
    table: pandas.DataFrame = pd.DataFrame(columns, index=pd.Index(series["time"], name="time"))
    table.attrs = {**about, "units": {name: units.get(name, "") for name in ("time", *columns)}}
    return table


def dataset(series: Series, units: Mapping[str, str], about: Mapping[str, str]) -> xarray.Dataset:
    """The series, shape (n,), over ``time`` (s) as a Dataset whose variables have the attribute ``units``. Raises
    `TowageError` without xarray."""
    variables = {name: ("time", values, {"units": units.get(name, "")}) for name, values in series.items()}
    coordinate = {"time": variables.pop("time")}
    made: xarray.Dataset = _module("xarray").Dataset(variables, coords=coordinate, attrs=dict(about))
    return made


def _module(name: str) -> Any:
    try:
        return import_module(name)
    except ImportError as error:
        raise TowageError(f"this needs {name} ({error}): pip install 'towage[frames]'") from error
