"""A family of scenes that try to fool the verdict: how a scene is drawn, what it is, and what is true of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from towage.result.result import Result
from towage.scene.flavour import Flavour
from towage.scene.scene import Scene


@dataclass(frozen=True)
class Truth:
    """``error``: the largest error of what the word is about, relative; ``motion``: that of which the program's bound is, None
    where there is no bound; ``chaotic``: two runs that begin 1e-9 apart part; ``noise``: half the width of the confidence
    interval of ``error`` where it is statistical, or how far its solver knows it."""

    error: float
    motion: float | None = None
    chaotic: bool = False
    noise: float = 0.0


@dataclass(frozen=True)
class Family:
    """``draw(seed, index)`` gives a scene by its numbers, ``scene`` makes the `Scene` of them, ``truth`` the `Truth` of what its
    run says, by other means than that run, and ``kind`` a word for what is counted apart. ``tolerance`` is that of the
    scenes, ``flavour`` that in which they cost least."""

    name: str
    tolerance: float
    draw: Callable[[int, int], Any]
    scene: Callable[[Any], Scene]
    truth: Callable[[Any, Result], Truth]
    kind: Callable[[Any], str]
    flavour: Flavour = "native"
