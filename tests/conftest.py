"""For all tests: how many examples property tests see. HYPOTHESIS_PROFILE=long gives each 20 000, at random."""

from __future__ import annotations

import os

from hypothesis import HealthCheck, settings

# the same examples every time: a property that fails at random tells nothing of the change that it fails in
settings.register_profile("default", derandomize=True, deadline=None)
settings.register_profile("long", max_examples=20_000, deadline=None, suppress_health_check=list(HealthCheck))
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "default"))
