"""Stages of work become one share that only grows."""

from __future__ import annotations

import pytest

from towage.master.stages import Stages


def test_stages_share_by_weight() -> None:
    heard: list[tuple[float, str]] = []
    stages = Stages(lambda share, text: heard.append((share, text)), {"run": 1.0, "again": 0.5, "other": 0.5})
    for stage in ("run", "again", "other"):
        hear = stages.progress(stage, 8.0)
        hear(0.0)
        hear(4.0)
    stages.done()
    assert heard == [
        (0.0, "run"), (0.25, "run"), (0.5, "again"), (0.625, "again"), (0.75, "other"), (0.875, "other"), (1.0, "done"),
    ]  # fmt: skip


def test_nobody_needs_to_listen() -> None:
    stages = Stages(None, {"run": 1.0})
    stages.progress("run", 1.0)(0.5)
    stages.done()
    with pytest.raises(KeyError):
        stages.progress("walk", 1.0)
