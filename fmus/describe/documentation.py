"""What an FMU tells about itself: a page from its declaration and its model's docstring."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

from ..declare.unit import Unit, Variable

REFERENCE_STEP = 0.1
NO_REFERENCE = (
    "There is no reference result: with what this build fixed, the other parameters need values that only a user can give, "
    "and the unit says which when it is initialised."
)


def documentation_page(unit: Unit, variables: Sequence[Variable] | None = None, reference: bool = True) -> str:
    """Self-contained HTML. ``variables``: those of the flavour, if it has more than the unit's; ``reference``: whether the FMU
    carries a reference result."""
    return (
        "<!DOCTYPE html>\n<html lang='en'><head><meta charset='utf-8'>"
        f"<title>{escape(unit.name)}</title><style>body{{font:16px/1.5 system-ui;max-width:62rem;margin:2rem auto;"
        "padding:0 1rem}table{border-collapse:collapse}td,th{border:1px solid #bbb;padding:.2rem .5rem;text-align:left}"
        "pre{background:#f4f4f4;padding:1rem;overflow-x:auto;color:#111}</style></head><body>"
        f"<h1>{escape(unit.name)}</h1><p>{escape(unit.description)}.</p>"
        f"<pre>{escape(unit.model.documentation)}</pre>\n"
        + "".join(_table(title, variables) for title, variables in variable_groups(unit, variables))
        + f"<p>{_reference(unit) if reference else NO_REFERENCE}</p>"
        "</body></html>\n"
    )


def variable_groups(
    unit: Unit, variables: Sequence[Variable] | None = None
) -> list[tuple[str, list[Variable]]]:
    """Variables under the headings of the documentation; input derivatives are left to the text."""
    titles = {
        "parameter": "Parameters", "input": "Inputs", "output": "Outputs",
        "calculatedParameter": "Calculated parameters", "local": "Local variables",
    }  # fmt: skip
    shown = [v for v in variables or unit.variables if v not in unit.input_derivatives]
    return [(title, [v for v in shown if v.causality == causality]) for causality, title in titles.items()]


def _table(title: str, variables: list[Variable]) -> str:
    if not variables:
        return ""
    rows = "".join(
        f"<tr><td><code>{escape(v.name)}</code></td><td>{escape(v.unit)}</td>"
        f"<td>{'' if v.start is None else f'{v.start:g}'}</td><td>{escape(v.description)}</td></tr>\n"
        for v in variables
    )
    return f"<h2>{title}</h2><table><tr><th>name</th><th>unit</th><th>start</th><th>meaning</th></tr>\n{rows}</table>\n"


def _reference(unit: Unit) -> str:
    return f"<code>{escape(unit.name)}_ref.csv</code> holds a reference result: {escape(reference_text(unit))}"


def reference_text(unit: Unit) -> str:
    """How the reference result was made."""
    start = ", ".join(f"{k} = {v:g}" for k, v in unit.start.items())
    inputs = ", ".join(f"{k}(t) = {a:g} sin({w:g} t)" for k, (a, w) in unit.reference_inputs.items())
    return (
        f"{start}; {inputs}, set with its three derivatives every {REFERENCE_STEP:g} s. "
        "The first columns are the inputs, the others the outputs."
    )
