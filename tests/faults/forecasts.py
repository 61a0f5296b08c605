"""The doors of forecasts: netCDF of every kind, and GRIB where its extra is there.

What reads them is forked (`tests.faults.forked`); the last door starts its process as a run does.
"""

from __future__ import annotations

import importlib
import importlib.util
import io
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from tests.faults.forked import Forked
from towage.routing import file as routes
from towage.routing.forecast import contents

KINDS = {
    "forecast": ("NETCDF3_CLASSIC", "NETCDF3_64BIT_OFFSET", "NETCDF3_64BIT_DATA"),
    "forecast_hdf": ("NETCDF4", "NETCDF4_CLASSIC"),
}
ROUTE = """title = "Forecast"
[map]
kind = "sphere"
[route]
start = ["45 deg", "-50 deg"]
end = ["48 deg", "-10 deg"]
[ship]
speed = "19.3 kn"
[sea]
kind = "file"
file = "input.nc"
"""


def doors(folder: Path, door: Callable[..., Any]) -> list[Any]:
    """All of them; seeds are made in ``folder``."""
    made = [
        door(name, ".nc", [_netcdf(folder / "seed.nc", kind) for kind in kinds], partial(_route, library="netCDF4"), 0.3)
        for name, kinds in KINDS.items()
    ]
    if importlib.util.find_spec("cfgrib"):
        made.append(door("forecast_grib", ".nc", [_grib()], partial(_route, library="cfgrib"), 0.05))
    return [*made, door("forecast_started", ".nc", [_netcdf(folder / "seed.nc", "NETCDF4")], partial(_route, library=""), 0.02)]


def _netcdf(path: Path, kind: Any) -> bytes:
    from netCDF4 import Dataset

    axes = {
        "time": (np.arange(0.0, 25.0, 12.0), "hours since 2020-01-05 00:00:00"),
        "latitude": (np.arange(60.0, 29.0, -5.0), "degrees"), "longitude": (np.arange(-60.0, 1.0, 5.0), "degrees"),
    }  # fmt: skip
    with Dataset(path, "w", format=kind) as out:
        for name, (values, unit) in axes.items():
            out.createDimension(name, len(values))
            variable = out.createVariable(name, "f8", (name,))
            variable[:] = values
            variable.units = unit
        for name, value in (("swh", 3.0), ("mwd", 270.0), ("pp1d", 9.0)):
            packed = name == "swh"
            variable = out.createVariable(name, "i2" if packed else "f8", tuple(axes), zlib=kind.startswith("NETCDF4"))
            if packed:
                variable.scale_factor, variable.add_offset = 0.001, 1.0
            variable[:] = np.full((3, 7, 13), value)
    return path.read_bytes()


def _grib() -> bytes:
    import eccodes

    out = io.BytesIO()
    for parameter, value in ((140229, 3.0), (140230, 270.0)):
        message = eccodes.codes_grib_new_from_samples("regular_ll_sfc_grib2")
        keys = {
            "dataDate": 20200105, "dataTime": 0, "Ni": 13, "Nj": 7, "latitudeOfFirstGridPointInDegrees": 60.0,
            "latitudeOfLastGridPointInDegrees": 30.0, "longitudeOfFirstGridPointInDegrees": 300.0,
            "longitudeOfLastGridPointInDegrees": 360.0, "iDirectionIncrementInDegrees": 5.0,
            "jDirectionIncrementInDegrees": 5.0, "paramId": parameter, "bitsPerValue": 16,
        }  # fmt: skip
        for key, number in keys.items():
            eccodes.codes_set(message, key, number)
        eccodes.codes_set_values(message, np.linspace(0.9, 1.1, 91) * value)
        out.write(eccodes.codes_get_message(message))
        eccodes.codes_release(message)
    return out.getvalue()


def _route(path: Path, library: str) -> None:
    """Read a route over the forecast, in a fork that finds the library loaded."""
    usual = contents.Child
    if library:
        importlib.import_module(library)
        contents.Child = Forked  # type: ignore[misc, assignment]
    try:
        route = path.with_name("route.toml")
        route.write_text(ROUTE, "utf-8")
        routes.load(route)
    finally:
        contents.Child = usual  # type: ignore[misc]
        if library:
            contents._end()
