"""C text of ``linear``, which describes a linear unit's matrices in the form of ``Linear`` in ``native/runtime/core/unit.h``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import casadi as ca

from ...models.protocol.state_space import Comparison, Reduction, Resolution
from .c_text import array, entry, initializer
from .traced import TracedLinear

LINEAR_FUNCTIONS = (
    "schedule", "drive", "own_after", "own_rates", "core", "observe", "schedule_forward", "own_rates_forward",
    "core_forward", "observe_forward",
)  # fmt: skip
"""Fields of ``Linear`` that hold a function."""

Functions = Mapping[str, ca.Function]


def linear_text(linear: TracedLinear, functions: Functions, parameters: Sequence[str]) -> str:
    """The definition of ``linear``, those of its comparisons and its resolution before it. ``parameters`` are their names
    in the order of the declaration."""
    study, before = linear.study, []
    fields = {
        "layout": _layout(linear.layouts["setup"]),
        "own": str(linear.own),
        "degree": str(linear.degree),
        "rate_rows": str(linear.rate_rows),
        **{name: entry(functions[f"linear_{name}"]) for name in LINEAR_FUNCTIONS if f"linear_{name}" in functions},
        "growth": _place(linear, study.growth_below),
        **_reduction(linear, study.reduction, parameters),
    }
    if study.comparisons:
        fields["band"] = str(parameters.index("band"))
        texts = (_comparison(linear, functions, number, each) for number, each in enumerate(study.comparisons))
        before.append(array("Comparison", "comparison", texts))
        fields |= {"comparison": "comparison", "comparisons": str(len(study.comparisons))}
    if study.resolution:
        before.append(f"static const Resolution resolution = {_resolution(linear, functions, study.resolution)};")
        fields["resolution"] = "&resolution"
    return "\n\n".join([*before, "static const Linear linear = {\n" + initializer(fields) + "};"])


def _reduction(linear: TracedLinear, reduction: Reduction | None, parameters: Sequence[str]) -> dict[str, str]:
    """The fields that say how the states are reduced; without a reduction, those that say it is none."""
    names = ("reduced", "tolerance", "band")
    if reduction is None:
        absent = (*names, "modal", "measured", "states_used", "error", "direct")
        return {**dict.fromkeys(absent, "-1"), "modal": "false"}
    fields = {
        **{name: str(parameters.index(name) if name in parameters else -1) for name in names},
        "modal": "true" if reduction.modal else "false",
        "measured": _place(linear, reduction.measured),
        "states_used": _place(linear, reduction.states),
        "error": _place(linear, reduction.error),
        "direct": "-1",
    }
    if reduction.direct:
        name, row, col = reduction.direct
        direct = str(min(getattr(linear.places, name)))
        fields |= {"direct": direct, "direct_row": str(row), "direct_column": str(col)}
    return fields


def _comparison(linear: TracedLinear, functions: Functions, number: int, comparison: Comparison) -> str:
    field = f"linear_comparison_{number}"
    fields = {
        "setup": entry(functions[field]), "layout": _layout(linear.layouts[field]), "weight": repr(comparison.weight),
        "truer": "true" if comparison.truer else "false", "target": _place(linear, comparison.target),
    }  # fmt: skip
    if comparison.stand_in:
        fields["stand_in"] = entry(functions[f"{field}_stand_in"])
        fields["stand_in_layout"] = _layout(linear.layouts[f"{field}_stand_in"])
    if comparison.when:
        fields["when"] = entry(functions[f"{field}_when"])
    return "{\n" + initializer(fields) + "}"


def _resolution(linear: TracedLinear, functions: Functions, resolution: Resolution) -> str:
    return "{\n" + initializer({
        "setup": entry(functions["linear_resolution"]), "layout": _layout(linear.layouts["linear_resolution"]),
        "modes": str(resolution.modes), "below": _place(linear, resolution.below),
        "target": _place(linear, resolution.target), "error": repr(resolution.error), "grid": repr(resolution.grid),
        "end": repr(resolution.end),
    }) + "}"  # fmt: skip


def _place(linear: TracedLinear, name: str | None) -> str:
    """Position of a component of the constants in c, -1 for none."""
    return "-1" if name is None else str(getattr(linear.places, name))


def _layout(sizes: Mapping[str, int]) -> str:
    return "{" + ", ".join(f".{name} = {value}" for name, value in sizes.items()) + "}"
