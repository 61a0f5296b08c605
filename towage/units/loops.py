"""Algebraic loops: outputs that reach themselves through connections and units without delay."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from towage.units.description import Description


def presumed(loop: Iterable[str], descriptions: Mapping[str, Description]) -> bool:
    """Whether a loop passes through a unit that declares no dependencies, so that all of its inputs count as direct."""
    ends = (node.partition(".") for node in loop)
    return any(descriptions[unit].dependencies.get(name, ()) is None for unit, _, name in ends)


def loops_of(
    connections: Sequence[tuple[str, str, str, str]], descriptions: Mapping[str, Description]
) -> list[tuple[str, ...]]:
    """A shortest cycle through each output that can reach itself by connections and direct dependencies, each once, as
    "unit.variable". ``connections``: (unit, output, unit, input)."""
    after: dict[str, list[str]] = {}
    for one, output, other, target in connections:
        after.setdefault(f"{one}.{output}", []).append(f"{other}.{target}")
        for name, inputs in descriptions[other].dependencies.items():
            if inputs is None or target in inputs:
                after.setdefault(f"{other}.{target}", []).append(f"{other}.{name}")
    loops: list[tuple[str, ...]] = []
    for start in dict.fromkeys(f"{c[0]}.{c[1]}" for c in connections):
        if not any(start in loop for loop in loops) and (loop := _cycle(start, after)):
            loops.append(loop)
    return loops


def _cycle(start: str, after: Mapping[str, list[str]]) -> tuple[str, ...]:
    """A shortest way from ``start`` back to it; empty if there is none."""
    before: dict[str, str] = {}
    queue = [start]
    while queue and start not in before:
        node = queue.pop(0)
        for following in after.get(node, ()):
            if following not in before:
                before[following] = node
                queue.append(following)
    if start not in before:
        return ()
    loop = [start, before[start]]
    while loop[-1] != start:
        loop.append(before[loop[-1]])
    return tuple(reversed(loop))
