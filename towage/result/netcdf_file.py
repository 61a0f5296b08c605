"""netCDF 4: for xarray, ncview, CDO and whatever else reads it."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from towage.files import atomic_write


def write_netcdf(
    path: str | os.PathLike[str], series: Mapping[str, NDArray[Any]], units: Mapping[str, str], about: Mapping[str, Any]
) -> None:
    """Variables of dimension and coordinate ``time`` (s) with the attribute ``units``; "1" where there is none. A slash, which no
    name may hold, becomes a bar; ``long_name`` has the name itself. ``about``:
    attributes of the file, anything that is no text as JSON. Raises `TowageError` and keeps the earlier file if it cannot be
    written."""
    from netCDF4 import Dataset

    data = Dataset("result.nc", "w", format="NETCDF4", memory=4096)
    data.createDimension("time", len(series["time"]))
    for name, values in series.items():
        if values.dtype.kind == "U":
            variable = data.createVariable(name.replace("/", "|"), str, ("time",))
            variable.long_name = name
            variable[:] = values.astype(object)
            continue
        column = np.asarray(values, dtype=float)
        variable = data.createVariable(name.replace("/", "|"), "f8", ("time",), compression="zlib", fill_value=False)
        variable.units, variable.long_name = units.get(name) or "1", name
        variable[:] = column
    for name, value in about.items():
        data.setncattr_string(name, value if isinstance(value, str) else json.dumps(value, sort_keys=True))
    content = data.close()
    with atomic_write(path) as stream:
        stream.write(bytes(content))
