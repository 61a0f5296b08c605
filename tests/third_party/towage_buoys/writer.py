"""Writer `count`: the number of rows of a result."""

from pathlib import Path

from towage.result.result import Result
from towage.result.writers import Writer


def _write(result: Result, path: Path) -> None:
    path.write_text(f"{len(result.time)}\n", encoding="ascii")


COUNT = Writer("count", "count", _write, "the number of rows")
