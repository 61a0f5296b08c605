"""Explicit embedded Runge-Kutta methods as data. `integrate` runs them; the native flavour writes its stages from them."""

from __future__ import annotations

from dataclasses import dataclass

Vector = tuple[float, ...]


@dataclass(frozen=True)
class Tableau:
    """Butcher coefficients. ``error`` holds one or two weight vectors; with two (E5, E3) the estimate is
    |E5|^2/sqrt(|E5|^2 + 0.01 |E3|^2) as in DOP853. ``order`` is that of the estimate plus one."""

    name: str
    c: Vector
    a: tuple[Vector, ...]
    b: Vector
    error: tuple[Vector, ...]
    order: int


DORMAND_PRINCE_5 = Tableau(
    # J. R. Dormand, P. J. Prince, "A family of embedded Runge-Kutta formulae", J. Comp. Appl. Math. 6 (1980) 19-26.
    name="Dormand-Prince 5(4)",
    c=(0.0, 1 / 5, 3 / 10, 4 / 5, 8 / 9, 1.0),
    a=(
        (),
        (1 / 5,),
        (3 / 40, 9 / 40),
        (44 / 45, -56 / 15, 32 / 9),
        (19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729),
        (9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656),
    ),
    b=(35 / 384, 0.0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84),
    error=((71 / 57600, 0.0, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40),),
    order=5,
)
