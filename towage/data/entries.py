"""Entries of a table of responses while a file is read."""

from __future__ import annotations

import math

from towage.models.sea.response_table import DOFS, TURN
from towage.reading import Refused

Key = tuple[float, float, float]
"""Speed, m/s, heading, rad within 0 ... 2 pi, frequency, rad/s; rounded, so that equal ones are equal."""
Values = dict[Key, dict[int, complex]]
"""H by degree of freedom of every entry."""


def key_of(speed: float, heading: float, omega: float, where: str) -> Key:
    """The key of an entry. Raises `Refused` for a frequency that is none."""
    if not 0.0 < omega < 1e3:
        raise Refused(f"{where}: a wave frequency of {omega:g} rad/s: expected a number above 0")
    turned = round(heading % TURN, 9)
    return round(speed, 9), 0.0 if turned >= round(TURN, 9) else turned, round(omega, 9)


def put(values: Values, key: Key, dof: int, value: complex, where: str) -> None:
    """An entry, which must not stand there with another value. Raises `Refused`."""
    row = values.setdefault(key, {})
    if dof in row and abs(row[dof] - value) > 1e-6 * max(abs(value), 1e-9):
        speed, heading, omega = key
        raise Refused(
            f"{where}: {DOFS[dof]} at {omega:g} rad/s, {math.degrees(heading):g} deg, {speed:g} m/s stands there twice, and "
            "differs"
        )
    row[dof] = value
