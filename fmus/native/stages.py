"""C text of the stages of a Runge-Kutta method, written out from its tableau.

A loop over the tableau costs more than a right-hand side of two components. Terms with a weight of zero are left out; sums
run in the order of the stages, as in `models.numeric.integrate.unrolled`, so that equal arithmetic gives equal bits.
"""

from __future__ import annotations

from collections.abc import Sequence

from ...models.numeric.tableaus import DORMAND_PRINCE_5, Tableau


def combination(weights: Sequence[float], rate: str) -> str:
    """The weighted sum of the stages' rates; ``rate`` is one of them in C, ``{}`` the number of its stage."""
    return " + ".join(f"{w!r} * {rate.format(j)}" for j, w in enumerate(weights) if w != 0.0)


def stage_lines(
    method: Tableau, rate: str, evaluate: str, loop: str, end: str = "t + h", point: str = "y"
) -> list[str]:
    """The statements from x and the rates of stage 0 at time t to the step's end y, with the rates of all further stages.

    ``rate`` as in `combination`; ``evaluate`` is the call for the rates of a stage, with the places time, point and stage;
    ``loop`` the head of the loop over the components i; ``end`` the time at the end of the step; ``point`` where a stage's
    state may be kept. The step itself is one more stage, whose rates begin the next step.
    """
    lines = []
    for stage, weights in enumerate((*method.a[1:], method.b), 1):
        last = stage == len(method.c)
        time = end if last else f"t + {method.c[stage]!r} * h"
        state = "y" if last else point
        lines += [
            loop,
            f"    {state}[i] = x[i] + h * ({combination(weights, rate)});",
            evaluate.format(time=time, point=state, stage=stage),
        ]
    return lines


def runtime_stages(method: Tableau = DORMAND_PRINCE_5) -> str:
    """Text of ``stages.h``, which ``runtime/instance/integrate.c`` includes."""
    if len(method.error) != 1:
        raise ValueError(f"{method.name}: the native integrator takes one error estimate, not {len(method.error)}")
    used = sorted({j for weights in (*method.a, method.b) for j, w in enumerate(weights) if w != 0.0})
    names = ", ".join(f"*k{j} = k[{j}]" for j in used)
    steps = stage_lines(
        method, rate="k{}[i]", evaluate="system->rates(system->context, {time}, {point}, k[{stage}]);",
        loop="for (int i = 0; i < n; i++)", point="point",
    )  # fmt: skip
    body = "\n".join(f"    {line}" for line in steps)
    return f"""/* {method.name}: made from its tableau in models/numeric/tableaus.py. */
#ifndef TOWAGE_STAGES_H
#define TOWAGE_STAGES_H

#include "integrate.h"

enum {{ STAGES = {len(method.c) + 1}, ORDER = {method.order} }}; /* of rates, the last at the end of the step */

/* The step of length h from (t, x) with the rates k[0]: its end y, the rates of the other stages. */
static void stages(const System *system, double t, const double *x, double h, double *const *k, double *point, double *y)
{{
    const int n = system->states;
    const double {names};
{body}
}}

/* Error of component i. */
static inline double stage_error(int i, double h, double *const *k)
{{
    return h * ({combination(method.error[0], "k[{}][i]")});
}}

#endif
"""
