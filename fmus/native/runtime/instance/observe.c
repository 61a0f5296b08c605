/* Inputs, branches and outputs at the point where the instance is. */
#include "observe.h"

#include "call.h"
#include "linear.h"
#include "message.h"
#include "parameters.h"
#include "transition.h"

Outcome prepare(Instance *it)
{
    if (it->stale) {
        const Outcome outcome = retune(it);
        if (outcome != DONE) return outcome;
    }
    const bool begin = it->touched;
    if (begin) {
        it->touched = false;
        it->offset = 0.0;
        cubics(it);
    }
    const double s = it->offset, *k = it->k;
    for (int i = 0; i < it->unit->inputs; i++, k += CUBIC) {
        it->u[i] = k[0] + s * (k[1] + s * (k[2] + s * k[3]));
        it->du[i] = k[1] + s * (2.0 * k[2] + s * 3.0 * k[3]);
        it->ddu[i] = 2.0 * k[2] + 6.0 * s * k[3];
    }
    /* where there is an event mode, branches change in it alone */
    if (begin && ((it->kind == CO_SIMULATION && !it->events) || it->phase == INITIALIZING)) change_due(it, it->time);
    return DONE;
}

/* All `count` values from reference `first` are finite, or a message says which is not. */
static Outcome check_finite(Instance *it, int first, int count)
{
    Number text;
    for (int i = first; i < first + count; i++)
        if (!is_finite(it->values[i]))
            return refuse(it, NO_STEP, "%s became %s", it->unit->variable[i].name, shortest(it->values[i], text));
    return DONE;
}

Outcome observe(Instance *it)
{
    const Unit *unit = it->unit;
    double *observed = it->values + unit->first.observed;
    Outcome outcome = prepare(it);
    if (outcome != DONE) return outcome;
    if (unit->linear) {
        outcome = solver_observe(it, it->time, it->u, it->du, observed, it->values + unit->first.extras);
        if (outcome != DONE) return outcome;
    } else if (unit->steps) {
        outcome = unit->steps->observe(it, observed);
        if (outcome != DONE) return outcome;
    } else {
        const double **a = arguments_at(it, &it->time);
        a[4] = it->du;
        a[5] = it->p;
        a[6] = it->c;
        it->results[0] = observed;
        traced(it, &unit->outputs, a, it->results);
    }
    outcome = check_finite(it, unit->first.observed, unit->observed);
    if (outcome == DONE) outcome = check_finite(it, unit->first.extras, unit->extras);
    it->fresh = outcome == DONE;
    return outcome;
}

Outcome first_outputs(Instance *it)
{
    Number time;
    Outcome outcome = initialize(it);
    if (outcome != DONE) return outcome;
    outcome = observe(it);
    if (outcome == NO_STEP) return explain(it, REFUSED, "initial values at t = %s: ", shortest(it->time, time));
    return outcome;
}

Outcome refresh(Instance *it)
{
    Number time;
    if (it->phase == FAILED) return refuse(it, REFUSED, "the instance failed before: reset it, or free it");
    if (it->fresh || it->phase == INSTANTIATED) return DONE;
    if (it->phase == INITIALIZING) return first_outputs(it);
    const Outcome outcome = observe(it);
    if (outcome == NO_STEP) return explain(it, REFUSED, "outputs at t = %s: ", shortest(it->time, time));
    return outcome;
}

Outcome rates_now(Instance *it, double *dx)
{
    const Unit *unit = it->unit;
    if (unit->linear) return solver_derivatives(it, it->u, it->du, dx);
    if (unit->derivatives.call) {
        const double **a = arguments_at(it, &it->time);
        a[4] = it->p;
        a[5] = it->c;
        it->results[0] = dx;
        traced(it, &unit->derivatives, a, it->results);
    }
    return DONE;
}

Outcome state_rates(Instance *it, double *dx)
{
    Number text;
    Outcome outcome = it->phase == INITIALIZING ? refresh(it) : DONE;
    if (outcome == DONE) outcome = prepare(it);
    if (outcome == DONE) outcome = rates_now(it, dx);
    for (int i = 0; outcome == DONE && i < it->unit->states; i++)
        if (!is_finite(dx[i]))
            outcome = refuse(it, REFUSED, "%s became %s",
                             it->unit->variable[it->unit->first.state_derivatives + i].name, shortest(dx[i], text));
    return outcome;
}

void indicators_now(Instance *it, double *g)
{
    const double **a = arguments_at(it, &it->time);
    a[4] = it->p;
    a[5] = it->c;
    it->results[0] = g;
    traced(it, &it->unit->indicate, a, it->results);
}

Outcome outputs_forward(Instance *it, double seed_t, double *sensed)
{
    const Unit *unit = it->unit;
    if (unit->linear)
        return solver_forward(it, it->time, it->u, it->du, it->seed_x, it->seed_u, it->seed_du, sensed, NULL);
    if (unit->steps) return unit->steps->forward(it, seed_t, sensed);
    const double *arguments[] = {
        &it->time, it->x,      it->m, it->u,      it->du,      it->p, it->c, it->values + unit->first.observed,
        &seed_t,   it->seed_x, NULL,  it->seed_u, it->seed_du, NULL,  NULL, /* modes, parameters and constants stay */
    };
    for (size_t i = 0; i < sizeof arguments / sizeof *arguments; i++) it->arguments[i] = arguments[i];
    it->results[0] = sensed;
    traced(it, &unit->outputs_forward, it->arguments, it->results);
    return DONE;
}
