"""Ship, line and cradle as one system of ordinary differential equations: the reference of every coupled scene.

    x = free motion (+ z),   m1 z'' + c1 z' + K1 z = F sin(Omega t) - (T - W),   M y'' = T - W_c - b |y'| y'

| symbol | meaning | unit |
|---|---|---|
| x, y | heave of the upper end and of the cradle, positive up | m |
| z | response of the ship, with ``two_way`` only; the state is then (z, z', y, y'), else (y, y') | m |
| T, W | tension of the line and its static value | N |
| W_c | weight in water of the cradle | N |
| F, Omega | ``force_amplitude`` and ``force_frequency`` of a wave force on the ship, ``two_way`` only | N, rad/s |

Every equation is that of `ship`, `spring_line` and `cradle`; this module joins them without an interface, so that no
coupling error is left. Taut and slack, the reversal of drag and the extremes of tension are located as events; all
extremes therefore lie on ends of steps and have the accuracy of the integrator, 1e-12 over tens of periods.

Assumptions: those of the three models; ``never_slack`` replaces the line by a spring that can push (the linear
sections of the source); an interval of slack less deep than 1e-11 of the stretch is grazing and does not count.

Method: the eighth-order tableau of Prince and Dormand with the error estimate of Hairer, DOP853 (E. Hairer, S. P.
Norsett, G. Wanner, Solving Ordinary Differential Equations I, 2nd ed., section II.10). Source: MIT thesis 1969,
section II, examples 1 to 3; register rows 19 to 21.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from scipy.integrate import DOP853

from ..numeric.integrate import Rates, Vector, integrate
from ..numeric.ops import FLOATS, Ops, Value
from ..numeric.tableaus import Tableau
from . import cradle, ship, spring_line

DORMAND_PRINCE_8 = Tableau(
    # P. J. Prince, J. R. Dormand, J. Comp. Appl. Math. 7 (1981) 67-75; error vectors of Hairer's DOP853
    name="Dormand-Prince 8(5,3)",
    c=tuple(map(float, DOP853.C[:12])),
    a=tuple(tuple(map(float, row[:i])) for i, row in enumerate(DOP853.A[:12])),
    b=tuple(map(float, DOP853.B[:12])),
    error=(tuple(map(float, DOP853.E5)), tuple(map(float, DOP853.E3))),
    order=8,
)

REST = 1e-290
"""Length, m, below which nothing moves: tolerances of such a motion would underflow."""

GRAZING = 1e-11
"""Depth of slack, as a share of the lengths it is the difference of, below which it is beyond the integrator."""


@dataclass(frozen=True)
class System:
    """Parameters of the parts and how they are joined; SI."""

    ship: ship.Parameters
    line: spring_line.Parameters
    cradle: cradle.Parameters
    two_way: bool = False
    force_amplitude: float = 0.0
    force_frequency: float = 0.0
    submersible_velocity: float = 0.0

    @property
    def never_slack(self) -> bool:
        """Whether the line is a spring that can push."""
        return bool(self.line.never_slack > 0.5)

    @property
    def stiffness(self) -> float:
        """K, N/m."""
        return float(spring_line.stiffness(self.line, FLOATS))

    @property
    def period(self) -> float:
        """That of the wave force where there is one, else of the free motion, s."""
        if self.two_way and self.force_amplitude != 0.0 and self.force_frequency != 0.0:
            return 2.0 * math.pi / self.force_frequency
        return float(self.ship.heave_period)

    def start(self) -> Vector:
        """The state of the start parameters."""
        z, y = ship.initial(self.ship, FLOATS)[0], cradle.initial(self.cradle, FLOATS)[0]
        return (*z, *y) if self.two_way else tuple(y)

    def top(self, t: float, x: Sequence[Value], ops: Ops) -> tuple[Value, Value]:
        """Heave of the upper end, m, and its rate, m/s."""
        heave, rate, _ = ship.free_motion(t, self.ship, ops)
        return (heave + x[0], rate + x[1]) if self.two_way else (heave, rate)

    def rates(self, modes: list[float], ops: Ops) -> Callable[[float, Sequence[Value]], tuple[Value, ...]]:
        """x' on the branches in force, ``modes`` = [taut, docked], which the caller may change between steps."""
        k, static, at = self.stiffness, self.line.static_tension, 2 if self.two_way else 0

        def one_way(t: float, x: Sequence[Value]) -> tuple[Value, ...]:
            y, v = x[at], x[at + 1]
            stretch = spring_line.stretch(self.top(t, x, ops)[0], y, static, k)
            tension = spring_line.pull(stretch, modes[0], k, 1.0, ops)
            return v, cradle.acceleration(v, modes[1], tension, self.cradle, ops)

        def both_ways(t: float, x: Sequence[Value]) -> tuple[Value, ...]:
            y, v = x[at], x[at + 1]
            stretch = spring_line.stretch(self.top(t, x, ops)[0], y, static, k)
            tension = spring_line.pull(stretch, modes[0], k, 1.0, ops)
            load = tension - static - self.force_amplitude * ops.sin(self.force_frequency * t)
            z = ship.derivatives(t, ship.State(x[0], x[1]), ship.Modes(), ship.Inputs(load), self.ship, ops)
            return z[0], z[1], v, cradle.acceleration(v, modes[1], tension, self.cradle, ops)

        return both_ways if self.two_way else one_way

    def scales(self, x: Vector) -> Vector:
        """A length and a speed of the motion for each component of the state, from which tolerances follow: not less
        than what rounding moves, and those of a motion of 1 m where nothing moves at all."""
        k, mass = self.stiffness, cradle.virtual_mass(0.0, self.cradle)
        force = abs(self.force_amplitude) / self.ship.stiffness if self.two_way else 0.0
        omega = math.sqrt(k / mass)
        lengths = (*map(abs, x[0::2]), *(abs(v) / omega for v in x[1::2]))
        length = max(abs(self.ship.heave_amplitude), force, *lengths, self.rounding)
        if length < REST:
            length = 1.0
        return (length, length * omega) * (len(x) // 2)

    @property
    def rounding(self) -> float:
        """What the stretch W/K + x - y cannot tell from zero, m."""
        return 2.0**-52 * float(self.line.static_tension) / self.stiffness


class Simulation:
    """A run of ``system`` from ``x`` at time ``t``, s; ``advance`` moves it on and keeps the record.

    ``heave_max``, ``heave_min``, m, and ``tension_max``, N, are those of the cradle and the line since the start or
    `restart`; ``slack_time``, s; ``slack_events``, times that the line went slack; ``taut_switches``, both directions;
    ``turning_points``, (t, y) at the zeros of y'. ``before_docking``: the state just before the submersible came
    aboard, None until then. ``tail_rates(t, x, modes)`` adds components to the state, beginning at ``tail``.
    """

    def __init__(
        self,
        system: System,
        t: float = 0.0,
        x: Vector | None = None,
        *,
        rtol: float = 1e-13,
        tail: Vector = (),
        tail_atol: float = 1e-8,
        tail_rates: Callable[[float, Vector, list[float]], tuple[float, ...]] | None = None,
    ) -> None:
        start = system.start() if x is None else x
        self.system, self.t, self.rtol = system, t, rtol
        self.x: Vector = (*start, *tail)
        self.n, self._at = len(start), 2 if system.two_way else 0
        length, speed = system.scales(start)[:2]
        share = max(0.1 * rtol, system.rounding / length)  # a small motion of a stretched line: no finer than rounding
        self.atol = (*(share * length, share * speed) * (len(start) // 2), *(tail_atol for _ in tail))
        self.modes = [1.0, 0.0]
        self._k, self._static = system.stiffness, system.line.static_tension
        self.before_docking: Vector | None = None
        self._step = 0.02 * min(system.period, 2.0 * math.pi / self._fastest())
        rates = system.rates(self.modes, FLOATS)
        self._rates: Rates
        if tail_rates is None:
            self._rates = rates
        else:
            extra = tail_rates
            self._rates = lambda t, x: (*rates(t, x), *extra(t, x, self.modes))
        self.modes[0] = self._branch(t, self.x)
        self.restart()

    def _fastest(self) -> float:
        p = self.system
        omega = math.sqrt(self._k / cradle.virtual_mass(0.0, p.cradle))
        return max(omega, math.sqrt((p.ship.stiffness + self._k) / p.ship.mass)) if p.two_way else omega

    @property
    def taut(self) -> bool:
        """Whether the line is taut."""
        return self.modes[0] > 0.5

    @property
    def state(self) -> Vector:
        """The state without its tail."""
        return self.x[: self.n]

    @property
    def slack_time(self) -> float:
        """Time with a slack line since the start or `restart`, s."""
        return self._slack_time + (self.t - self._slack_since if not self.taut and self._deep else 0.0)

    def stretch(self, t: float, x: Vector) -> tuple[float, float]:
        """e, m, and its rate, m/s."""
        heave, rate = self.system.top(t, x, FLOATS)
        y, v = x[self._at], x[self._at + 1]
        return spring_line.stretch(heave, y, self._static, self._k), rate - v

    def restart(self) -> None:
        """Forget the record and begin it at the present state."""
        self.heave_max = self.heave_min = self.x[self._at]
        self.tension_max = 0.0
        self.turning_points: list[tuple[float, float]] = []
        self.slack_events = self.taut_switches = 0
        self._slack_time, self._slack_since, self._deep = 0.0, self.t, not self.taut
        self._note(self.t, self.x)

    def advance(self, t_end: float) -> Vector:
        """Go on to ``t_end``, s, docking on the way when due; returns the state there."""
        p = self.system.cradle
        while True:
            due = cradle.next_event_time(self.t, cradle.Modes(self.modes[1]), p, FLOATS)
            if due <= self.t:
                self._dock()
                continue
            if self.t >= t_end:
                return self.state
            target = min(t_end, due)
            self.x, self._step = integrate(
                self._rates,
                self.t,
                self.x,
                target,
                rtol=self.rtol,
                atol=self.atol,
                indicators=self._indicators,
                on_event=self._switch,
                first_step=self._step,
                method=DORMAND_PRINCE_8,
                max_steps=2_000_000,
                on_step=self._accepted,
            )
            self.t = target

    def _dock(self) -> None:
        self.before_docking = self.state
        velocity, docked = cradle.capture(
            self.t, self.x[self._at + 1], self.modes[1], self.system.submersible_velocity, self.system.cradle, FLOATS
        )
        self.x = (*self.x[: self._at + 1], velocity, *self.x[self._at + 2 :])
        self.modes[1] = docked

    def _indicators(self, t: float, x: Vector) -> tuple[float, ...]:
        """Drag reversal, extremes of tension (a grazing line goes slack next to one), taut and slack."""
        e, e_rate = self.stretch(t, x)
        return x[self._at + 1], e_rate, (1.0 if self.system.never_slack else e)

    def _branch(self, t: float, x: Vector) -> float:
        return 1.0 if self.system.never_slack or self.stretch(t, x)[0] > 0.0 else 0.0

    def _switch(self, t: float, x: Vector) -> Vector:
        """The branch beyond an event."""
        taut = self._branch(t, x)
        if taut != self.modes[0]:
            self.modes[0] = taut
            if taut < 0.5:
                self._slack_since, self._deep = t, False
            elif self._deep:
                self._slack_time += t - self._slack_since
                self.taut_switches += 1
        return x

    def _accepted(self, t0: float, x0: Vector, f0: Sequence[float], t: float, x: Vector, f: Sequence[float]) -> None:
        if (x0[self._at + 1] > 0.0) != (x[self._at + 1] > 0.0):
            self.turning_points.append((t, x[self._at]))
        self._note(t, x)

    def _note(self, t: float, x: Vector) -> None:
        y = x[self._at]
        self.heave_max, self.heave_min = max(self.heave_max, y), min(self.heave_min, y)
        e, _ = self.stretch(t, x)
        tension = spring_line.pull(e, 1.0, self._k, float(self.system.never_slack), FLOATS)
        self.tension_max = max(self.tension_max, tension)
        if not self.taut and not self._deep:
            free = self._static / self._k
            self._deep = e < -GRAZING * (abs(y) + abs(e + y - free) + free)
            self.slack_events += self._deep
            self.taut_switches += self._deep
