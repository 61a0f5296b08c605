"""Writers of result files, as values; `towage.registry.WRITERS` finds them, and those of other packages, by name."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from towage.files import atomic_write
from towage.result.result import Result


@dataclass(frozen=True)
class Writer:
    """A kind of result file. ``write(result, path)`` writes one; it raises `TowageError` and keeps an earlier file if that
    fails. ``suffix`` is without a dot, ``description`` one line for ``towage run --help``."""

    name: str
    suffix: str
    write: Callable[[Result, Path], None]
    description: str


CSV = Writer("csv", "csv", Result.save_csv, "a column a variable, for spreadsheets")
NPZ = Writer("npz", "npz", Result.save_npz, "everything, bit-exact, for towage report and numpy")
NETCDF = Writer("nc", "nc", Result.save_netcdf, "netCDF 4 with units of measure and provenance, for xarray")
MAT = Writer("mat", "mat", Result.save_mat, "MAT 5, for MATLAB and Octave")


def write_files(result: Result, path: Path, writers: Sequence[Writer]) -> list[Path]:
    """One file a writer, and a log of what the units said, if they did; ``path`` has no suffix yet. Raises `TowageError`."""
    files = []
    if result.messages:
        files.append(path.with_name(f"{path.name}.log"))
        with atomic_write(files[-1]) as stream:
            stream.write("".join(f"{message.line()}\n" for message in result.messages).encode(errors="backslashreplace"))
    for writer in writers:
        files.append(path.with_name(f"{path.name}.{writer.suffix}"))
        writer.write(result, files[-1])
    return files
