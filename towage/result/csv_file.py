"""CSV: one column a series, for spreadsheets and other programs."""

from __future__ import annotations

import codecs
import csv
import os
from collections.abc import Mapping
from typing import Any

from numpy.typing import NDArray

from towage.files import atomic_write


def write_csv(path: str | os.PathLike[str], series: Mapping[str, NDArray[Any]], units: Mapping[str, str]) -> None:
    """Header ``name [unit]``, one row a sample, shortest digits that read back exactly; UTF-8. The series have one length.
    Raises `TowageError` and keeps the earlier file if it cannot be written."""
    with atomic_write(path) as stream:
        writer = csv.writer(codecs.getwriter("utf-8")(stream, "backslashreplace"), lineterminator="\n")
        writer.writerow([f"{name} [{units.get(name) or '-'}]" for name in series])
        writer.writerows(zip(*(values.tolist() for values in series.values()), strict=True))
