"""For all tests: C sources are compiled once."""

from __future__ import annotations

import os
import shlex
import shutil
import sys
from pathlib import Path

import pytest

from tests.caching_compiler import forget


def pytest_configure(config: pytest.Config) -> None:
    """Compile through `caching_compiler`, in this process and all that it starts."""
    compiler = shutil.which("cc")
    if compiler is None or "CC" in os.environ or not hasattr(config, "cache"):
        return
    store = config.cache.mkdir("objects")  # type: ignore[union-attr]
    if not hasattr(config, "workerinput"):
        forget(str(store))
    program = Path(__file__).with_name("caching_compiler.py")
    os.environ["CC"] = shlex.join([sys.executable, "-I", "-S", str(program), str(store), compiler])
