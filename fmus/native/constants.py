"""C text of ``constants.h``: what the native runtime shares with the Python flavour, from the definitions there."""

from __future__ import annotations

from collections.abc import Iterable

from ...models.cable.lumped import fidelity, reduction
from ...models.numeric import integrate, ops, root, tableaus
from ...models.slender import damping
from ..declare.unit import INPUT_ORDERS
from ..describe.fmi2 import LOG_CATEGORIES
from ..python import stepping, values
from .c_text import text

CAUSALITIES = {"PARAMETER": "parameter", "CALCULATED": "calculatedParameter", "INPUT": "input", "OUTPUT": "output",
               "LOCAL": "local"}  # fmt: skip
"""Causality of FMI by its name in C."""
VARIABILITIES = {"FIXED": "fixed", "TUNABLE": "tunable", "DISCRETE": "discrete", "CONTINUOUS": "continuous"}
"""Variability of FMI by its name in C."""

NUMBERS = {
    "NEVER": (ops.NEVER, "s: no time of a run is as late"),
    "TIME_TOLERANCE": (stepping.TIME_TOLERANCE, "of a step's time, relative to 1 s + |t|"),
    "EVENT_TOLERANCE": (values.EVENT_TOLERANCE, "of an event's time, likewise"),
    "SAFETY": (integrate.SAFETY, "factor on the step that the error asks for"),
    "MOST_GROWTH": (integrate.MOST_GROWTH, "of a step from one to the next"),
    "LEAST_GROWTH": (integrate.LEAST_GROWTH, "likewise, after a step that was refused"),
    "EASY": (
        0.95 * (integrate.SAFETY / integrate.MOST_GROWTH) ** tableaus.DORMAND_PRINCE_5.order,
        "ratio of error to tolerance below which a step grows by MOST_GROWTH, whatever the power is",
    ),
    "RESCUE": (integrate.RESCUE, "factor on a step whose error is no number"),
    "NO_NUMBER": (integrate.NO_NUMBER, "an error over its tolerance beyond which it says nothing"),
    "LANDING": (integrate.LANDING, "a step longer than this share of what is left goes to the end"),
    "EVENT_WIDTH": (integrate.EVENT_WIDTH, "of the bracket of an event, relative to the step"),
    "TIME_WIDTH": (integrate.TIME_WIDTH, "likewise, relative to the time"),
    "BEYOND": (root.BEYOND, "how far beyond the zero it is sought, in widths"),
    "TINY": (integrate.TINY, "keeps a share of zero by zero a number"),
    "SMALLEST": (integrate.SMALLEST, "added to a tolerance, which may have underflowed"),
    "NEAR": (integrate.NEAR, "share of its values at the ends below which an indicator's vertex is looked at"),
    "ROUNDING": (integrate.ROUNDING, "share of its value beyond the next zero below which an indicator is rounding"),
    "BLIND": (integrate.BLIND, "share of a step, begun on a zero, in which the sign is not trusted"),
    "MOST_BLIND": (integrate.MOST_BLIND, "to which that grows where events follow each other in steps cut to SHORT"),
    "SHORT": (integrate.SHORT, "share of a step"),
    "BAND_START": (reduction.BAND_START, "rad/s, low end of the band"),
    "BAND_SHARE": (reduction.BAND_SHARE, "of the high end, at most"),
    "NEGLIGIBLE": (reduction.NEGLIGIBLE, "Hankel singular values below this share of the largest are rounding"),
    "LEAST_SHARE": (fidelity.LEAST_SHARE, "of the tolerance that the reduction may use, whatever the segments took"),
    "PADE_NORM": (damping.PADE_NORM, "1-norm up to which the approximant of exp is exact to rounding"),
}
COUNTS = {
    "INPUT_ORDERS": (len(INPUT_ORDERS), "derivatives of an input"),
    "CUBIC": (len(INPUT_ORDERS) + 1, "coefficients of an input over a communication step"),
    "MAX_STEPS": (integrate.MAX_STEPS, "of the integrator in one communication step"),
    "MAX_TRIALS": (integrate.MAX_TRIALS, "to locate an event"),
    "FREQUENCIES": (reduction.FREQUENCIES, "of the band at which errors are measured"),
}
LISTS = {
    "PHASE_NAMES": values.PHASES,
    "CAUSALITY_NAMES": tuple(CAUSALITIES.values()),
    "VARIABILITY_NAMES": tuple(VARIABILITIES.values()),
    "LOG_CATEGORIES": tuple(LOG_CATEGORIES),
}
"""Initializers of arrays of strings."""


def definitions(*names: str) -> list[str]:
    """Definitions of some of ``NUMBERS``, to the last bit."""
    return [f"#define {name} {NUMBERS[name][0]!r} /* {NUMBERS[name][1]} */" for name in names]


def constants_header() -> str:
    """The text of ``constants.h``."""
    counts = [f"    {name} = {value}, /* {meaning} */" for name, (value, meaning) in COUNTS.items()]
    lists = [f"#define {name} {_initializer(map(text, words))}" for name, words in LISTS.items()]
    enums = (
        _enum("Phase", [name.upper() for name in values.PHASES]),
        _enum("Causality", CAUSALITIES),
        _enum("Variability", VARIABILITIES),
    )
    return "\n".join([
        "/* What C and Python share: made from the definitions in Python by fmus/native/constants.py. */",
        "#ifndef TOWAGE_CONSTANTS_H", "#define TOWAGE_CONSTANTS_H", "",
        *definitions(*NUMBERS), "", "enum {", *counts, f"    LOG_KINDS = {len(LOG_CATEGORIES)}, /* of messages */", "};", "",
        *enums, "", *lists, "",
        "/* Coefficients of the approximant of exp of order 13: Higham, Functions of Matrices, table 10.4. */",
        f"#define PADE {_initializer(map(repr, damping.PADE))}", "", "#endif", "",
    ])  # fmt: skip


def _enum(name: str, members: Iterable[str]) -> str:
    return f"typedef enum {{ {', '.join(members)} }} {name};"


def _initializer(values: Iterable[str]) -> str:
    return "{" + ", ".join(values) + "}"
