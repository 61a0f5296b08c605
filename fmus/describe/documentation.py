"""What an FMU tells about itself: a page from its declaration and its model's docstring."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

from ..declare.unit import Unit, Variable
from .block import block

REFERENCE_STEP = 0.1
NO_REFERENCE = (
    "There is no reference run: with what this build fixed, the other parameters need values that only a user can give, "
    "and the unit says which when it is initialised."
)
MARGINS = "Each is 1 at rest, 0 at the limit of what the model assumes, negative beyond."
_STYLE = (
    "body{font:16px/1.5 system-ui,sans-serif;max-width:62rem;margin:2rem auto;padding:0 1rem;color:#111;background:#fff}"
    "div{overflow-x:auto}table{border-collapse:collapse;margin:1rem 0}"
    "td,th{border:1px solid #bbb;padding:.2rem .5rem;text-align:left;vertical-align:top}"
    "pre{background:#f4f4f4;padding:.7rem 1rem;overflow-x:auto}code{font-size:.92em}.icon{float:right;width:6rem}"
)


def documentation_page(unit: Unit, variables: Sequence[Variable], reference: bool, icon: str) -> str:
    """Self-contained HTML. ``variables``: those of the flavour, which may have more than the unit's; ``reference``: whether
    the FMU carries a reference run; ``icon``: SVG."""
    title, _, text = unit.model.documentation.partition("\n")
    tables = "".join(_table(title, variables) for title, variables in variable_groups(unit, variables))
    return (
        "<!DOCTYPE html>\n<html lang='en'><head><meta charset='utf-8'>"
        "<meta name='viewport' content='width=device-width, initial-scale=1'>"
        f"<title>{escape(unit.name)}</title><style>{_STYLE}</style></head><body>"
        f"<div class='icon'>{icon}</div><h1>{escape(unit.name)}</h1>\n<p>{escape(title or unit.description + '.')}</p>\n"
        f"<div>{block(unit)}</div>\n<div>{_rendered(text)}</div>\n{tables}"
        f"<h2>Reference run</h2>\n{_reference(unit) if reference else f'<p>{NO_REFERENCE}</p>'}\n"
        "<p>Terms: <a href='licenses/license.txt'>licenses/license.txt</a>.</p></body></html>\n"
    )


def _rendered(text: str) -> str:
    """HTML of a docstring: paragraphs, indented equations, tables. Loaded here alone: what runs an FMU needs no Markdown."""
    from markdown_it import MarkdownIt

    html: str = MarkdownIt("commonmark", {"html": False}).enable("table").render(text)
    return html


def variable_groups(
    unit: Unit, variables: Sequence[Variable] | None = None
) -> list[tuple[str, list[Variable]]]:
    """Variables under the headings of the documentation; input derivatives are left to the text."""
    shown = [v for v in variables or unit.variables if v not in unit.input_derivatives]
    margins = [v for v in shown if v.causality == "output" and v.name.rpartition(".")[2].startswith("margin_")]
    titles = {
        "Parameters": "parameter", "Inputs": "input", "Outputs": "output", "Margins": "",
        "Calculated parameters": "calculatedParameter", "Local variables": "local",
    }  # fmt: skip
    return [
        (title, margins if title == "Margins" else [v for v in shown if v.causality == causality and v not in margins])
        for title, causality in titles.items()
    ]


def meaning(v: Variable) -> str:
    """What the variable is and, of an input, what it means to leave it open."""
    if v.needed:
        return f"{v.description}. Needed: connect it or set a constant"
    return f"{v.description}. Neither connected nor set: {v.unset}" if v.unset else v.description


def _table(title: str, variables: list[Variable]) -> str:
    if not variables:
        return ""
    rows = "".join(
        f"<tr><td><code>{escape(v.name)}</code></td><td>{escape(v.unit)}</td>"
        f"<td>{'' if v.start is None else f'{v.start:g}'}</td><td>{escape(meaning(v))}</td></tr>\n"
        for v in variables
    )
    note = f"<p>{MARGINS}</p>\n" if title == "Margins" else ""
    head = "<tr><th>name</th><th>unit</th><th>start</th><th>meaning</th></tr>"
    return f"<h2>{title}</h2>\n{note}<div><table>{head}\n{rows}</table></div>\n"


def _reference(unit: Unit) -> str:
    """How the reference run was made, and the files that let a program repeat it."""
    inputs = "".join(
        f"<li><code>{escape(name)}</code>(t) = {amplitude:g} sin({omega:g} t)</li>"
        for name, (amplitude, omega) in unit.reference_inputs.items()
    )
    files = f"<code>{escape(unit.name)}"
    return (
        f"<p>Start with the values of {files}_start.ssv</code>. Before each step of {REFERENCE_STEP:g} s set what the row of "
        f"{files}_in.csv</code> gives, which are the inputs and their three derivatives, and the outputs are those of "
        f"{files}_ref.csv</code>; the last step begins at the time of the last row but one. The inputs are</p>"
        f"<ul>{inputs or '<li>none</li>'}</ul>"
    )
