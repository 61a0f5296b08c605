"""For all tests: C sources are compiled once, and how many examples property tests see. HYPOTHESIS_PROFILE=long gives each
20 000, at random."""

from __future__ import annotations

import os
import shlex
import shutil
import sys
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

from tests.caching_compiler import forget

# the same examples every time: a property that fails at random tells nothing of the change that it fails in
settings.register_profile("default", derandomize=True, deadline=None)
settings.register_profile("long", max_examples=20_000, deadline=None, suppress_health_check=list(HealthCheck))
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "default"))


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
