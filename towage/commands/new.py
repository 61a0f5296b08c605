"""``towage new``: a unit to begin with, which runs and passes the tests of artefacts as it stands."""

from __future__ import annotations

import argparse
import keyword
import re
from pathlib import Path

HELP = "write a new unit to begin with"
_NAME = re.compile("[a-z][a-z0-9_]*")

MODEL = '''"""TITLE: a mass on a spring and a damper, pushed by a force.

    m x'' = F - k x - c x'

| symbol | meaning | unit |
|---|---|---|
| x | displacement from rest, positive along the force | m |
| m, k, c | mass, stiffness, damping | kg, N/m, N.s/m |
| F | force | N |

Assumptions: (1) the spring is linear, which holds while abs(x) stays below the travel (`margin_travel`).

Source: Newton's second law; put your equation, symbols, assumptions and source in place of these.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, NamedTuple

from MODELS.numeric.ops import Ops, Value
from MODELS.protocol.model import Model
from MODELS.protocol.variables import Rate, input_variable, margin, output, parameter, tunable


@dataclass(frozen=True)
class Parameters:
    """SI."""

    mass: Annotated[Value, parameter("kg", 1000.0, "Mass", min=1e-9)]
    stiffness: Annotated[Value, parameter("N/m", 4000.0, "Stiffness of the spring", min=0.0)]
    damping: Annotated[Value, tunable("N.s/m", 200.0, "Damping", min=0.0)]
    travel: Annotated[Value, parameter("m", 2.0, "Displacement up to which the spring is linear", min=1e-9)]
    displacement_start: Annotated[Value, parameter("m", 0.0, "Displacement at the start")]


class State(NamedTuple):
    """Outputs both."""

    displacement: Value
    velocity: Value


class Modes(NamedTuple):
    """No branches."""


class Inputs(NamedTuple):
    """What pushes."""

    force: Annotated[Value, input_variable("N", "Force on the mass", unset="nothing pushes")]


class Outputs(NamedTuple):
    """The motion, and the margin of the linear spring."""

    displacement: Annotated[Value, output("m", "Displacement from rest, positive along the force", nominal=1.0)]
    velocity: Annotated[Value, output("m/s", "Velocity", nominal=1.0)]
    margin_travel: Annotated[Value, margin("1 - (x / travel)^2")]
    displacement_rate: Rate


def initial(p: Parameters, ops: Ops) -> tuple[State, Modes]:
    """At the given displacement, without velocity."""
    return State(p.displacement_start, 0.0), Modes()


def derivatives(t: Value, x: State, m: Modes, u: Inputs, p: Parameters, ops: Ops) -> State:
    """x', m/s and m/s2."""
    return State(x.velocity, (u.force - p.stiffness * x.displacement - p.damping * x.velocity) / p.mass)


def outputs(t: Value, x: State, m: Modes, u: Inputs, du: Inputs, p: Parameters, ops: Ops) -> Outputs:
    """All that can be observed."""
    share = x.displacement / p.travel
    return Outputs(x.displacement, x.velocity, 1.0 - share * share, x.velocity)


VALUE = Model(
    "NAME", "TITLE: a mass on a spring and a damper", Parameters, State, Modes, Inputs, Outputs,
    initial=initial, derivatives=derivatives, outputs=outputs,
)  # fmt: skip
'''
"""The text of a model. ``MODELS`` stands for the package of the models as the text must name it."""
UNIT = "UNIT = Unit.of(VALUE, start={\"displacement_start\": 0.1}, inputs={\"force\": (500.0, 1.3)})\n"
"""The declaration: the model, and the run of the reference result in the FMU (amplitude and frequency, rad/s, of inputs)."""
DECLARATION = '''"""Unit `NAME`: the model, with its reference run."""

from ..models.NAME import VALUE
from .declare.unit import Unit

'''
PROJECT = """[build-system]
requires = ["setuptools>=77"]
build-backend = "setuptools.build_meta"

[project]
name = "towage-DASHED"
version = "0.1.0"
description = "TITLE: a unit for towage"
requires-python = ">=3.11"
dependencies = ["towage"]

[project.entry-points."towage.units"]
NAME = "towage_NAME.unit:UNIT"

[tool.setuptools]
packages = ["towage_NAME"]
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options of ``towage new``."""
    parser.add_argument("kind", choices=("unit",), help="what to write")
    parser.add_argument("name", metavar="NAME", help="letters, digits and '_', as spring_line")
    parser.add_argument("--out", metavar="DIR", type=Path, help="a package in this directory (default: see below)")
    parser.epilog = (
        "In a checkout of towage it writes models/NAME.py and fmus/NAME.py, and adds NAME to the units in fmus/__init__.py;\n"
        "elsewhere, and with --out, a package with an entry point, in towage_NAME/. docs/how_to_add.md goes on from there.\n\n"
        "example:\n  towage new unit winch"
    )


def execute(arguments: argparse.Namespace) -> int:
    """0. Raises `TowageError` for a name that cannot be and for what cannot be written."""
    name = arguments.name
    checkout = None if arguments.out else _checkout(Path.cwd())
    files = in_checkout(name, checkout) if checkout else as_package(name, arguments.out or Path())
    write(name, files)
    print("written: " + ", ".join(map(str, files)))
    if checkout:
        print(f"next: python build_fmus.py {name}; pytest tests/fmus -k {name}")
    else:
        print(f"next: pip install -e {next(iter(files)).parent}; towage list")
    return 0


def in_checkout(name: str, root: Path) -> dict[Path, str]:
    """The files of a unit in a checkout, with their text: model, declaration, and the list of units with its name."""
    units = root / "fmus" / "__init__.py"
    listed = re.sub(r"^(UNITS = \(.*?)\)$", rf'\1,\n         "{name}")', units.read_text("utf-8"), count=1, flags=re.M | re.S)
    return {
        root / "models" / f"{name}.py": _filled(MODEL, name, "."),
        root / "fmus" / f"{name}.py": _filled(DECLARATION + UNIT, name),
        units: listed,
    }


def as_package(name: str, directory: Path) -> dict[Path, str]:
    """The files of a package of its own, with their text: its project file, and one module with model and declaration."""
    package = directory / f"towage_{name}"
    head = "from towage.fmus.declare.unit import Unit\n"
    first = "from towage.models.numeric.ops"
    module = _filled(MODEL, name, "towage.models").replace(first, head + first)
    return {
        package / "pyproject.toml": _filled(PROJECT, name),
        package / f"towage_{name}" / "__init__.py": f'"""The unit `{name}`."""\n',
        package / f"towage_{name}" / "unit.py": module + _filled(UNIT, name),
    }


def write(name: str, files: dict[Path, str]) -> None:
    """Writes the files. Raises `TowageError` for a name that is taken or no name, and where one exists already."""
    from towage.errors import TowageError
    from towage.registry import UNITS

    if not _NAME.fullmatch(name) or keyword.iskeyword(name):
        raise TowageError(f"{name!r} cannot name a unit: expected small letters, digits and '_', as spring_line")
    if name in UNITS:
        raise TowageError(f"there is a unit {name!r} already: choose another name")
    for file in files:
        if file.name != "__init__.py" and (file.exists() or file.with_suffix("").is_dir()):
            raise TowageError(f"{file} exists already: choose another name or directory")
    try:
        for file, text in files.items():
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text, "utf-8")
    except OSError as error:
        raise TowageError(f"cannot write {error.filename}: {error.strerror}") from error


def _checkout(here: Path) -> Path | None:
    """The checkout of towage that ``here`` lies in, if it does."""
    folders = (here.resolve(), *here.resolve().parents)
    return next((f for f in folders if (f / "build_fmus.py").is_file() and (f / "fmus" / "__init__.py").is_file()), None)


def _filled(text: str, name: str, models: str = "") -> str:
    title = name.replace("_", " ").capitalize()
    words = {"from MODELS.": f"from {models}." if models != "." else "from .", "TITLE": title, "VALUE": name.upper()}
    for word, value in (words | {"NAME": name, "DASHED": name.replace("_", "-")}).items():
        text = text.replace(word, value)
    return text
