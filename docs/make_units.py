"""Writes ``docs/units.md`` from the units' declarations: ``python docs/make_units.py``."""

from pathlib import Path

from towage.fmus import UNITS
from towage.fmus.declare.unit import Unit, load
from towage.fmus.describe.documentation import meaning, variable_groups


def page(units: list[Unit]) -> str:
    """Markdown tables of all variables."""
    lines = [
        "# Units",
        "",
        "Made from the declarations in `fmus/` by `make docs`. Every input has three derivatives at the communication",
        "point as tunable parameters (`<input>_d1`, `_d2`, `_d3`); all zero means held. The equations are in the",
        "documentation inside each FMU and in `models/`.",
    ]
    for unit in units:
        lines += ["", f"## {unit.name}", "", f"{unit.description}."]
        for title, variables in variable_groups(unit):
            if variables:
                lines += ["", f"### {title}", "", "| name | unit | start | meaning |", "|---|---|---|---|"]
            for v in variables:
                start = "" if v.start is None else f"{v.start:g}"
                text = meaning(v).replace("|", "\\|")
                lines.append(f"| `{v.name}` | {v.unit} | {start} | {text} |")
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    Path(__file__).with_name("units.md").write_text(page([load(name) for name in UNITS]), encoding="utf-8")
