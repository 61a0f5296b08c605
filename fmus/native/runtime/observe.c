/* Inputs, branches and outputs at the point where the instance is. */

#include "core.h"

void cubics(Instance *it)
{
    const int n = it->unit->inputs;
    const double *u = it->values + first_input(it->unit), *d = it->values + first_derivative(it->unit);
    double *k = it->k;
    for (int i = 0; i < n; i++, d += 3, k += 4) {
        k[0] = u[i];
        k[1] = d[0];
        k[2] = 0.5 * d[1];
        k[3] = d[2] / 6.0;
    }
}

void inputs_at(Instance *it, double s)
{
    const double *k = it->k;
    for (int i = 0; i < it->unit->inputs; i++, k += 4)
        it->u[i] = k[0] + s * (k[1] + s * (k[2] + s * k[3]));
}

/* The arguments t, x, m, u that most functions begin with. */
static const double **at(Instance *it, const double *t)
{
    const double **a = it->arguments;
    a[0] = t;
    a[1] = it->x;
    a[2] = it->m;
    a[3] = it->u;
    return a;
}

void change(Instance *it, double t)
{
    const Unit *unit = it->unit;
    const double **a = at(it, &t);
    a[4] = it->p;
    a[5] = it->c;
    it->results[0] = it->next_x;
    it->results[1] = it->next_m;
    traced(it, &unit->change, a, it->results);
    for (int i = 0; i < unit->states; i++)
        it->x[i] = it->next_x[i];
    for (int i = 0; i < unit->modes; i++)
        it->m[i] = it->next_m[i];
}

double next_event(Instance *it, double t)
{
    double due = NEVER;
    if (!it->unit->next_event.call)
        return NEVER;
    it->arguments[0] = &t;
    it->arguments[1] = it->m;
    it->arguments[2] = it->p;
    it->arguments[3] = it->c;
    it->results[0] = &due;
    traced(it, &it->unit->next_event, it->arguments, it->results);
    return due;
}

void change_due(Instance *it, double t)
{
    const double tolerance = 1e-12; /* relative to 1 s + |t|: k * h is not exactly the time of an event */
    if (!it->unit->change.call)
        return;
    const double due = next_event(it, t), left = due - t;
    change(it, 0.0 < left && left <= tolerance * (1.0 + (t < 0.0 ? -t : t)) ? due : t);
}

Outcome prepare(Instance *it)
{
    if (it->stale) {
        const Outcome outcome = retune(it);
        if (outcome != DONE)
            return outcome;
    }
    const bool begin = it->touched;
    if (begin) {
        it->touched = false;
        it->offset = 0.0;
        cubics(it);
    }
    const double s = it->offset, *k = it->k;
    for (int i = 0; i < it->unit->inputs; i++, k += 4) {
        it->u[i] = k[0] + s * (k[1] + s * (k[2] + s * k[3]));
        it->du[i] = k[1] + s * (2.0 * k[2] + s * 3.0 * k[3]);
        it->ddu[i] = 2.0 * k[2] + 6.0 * s * k[3];
    }
    /* in model exchange, branches change in event mode only */
    if (begin && (it->kind == CO_SIMULATION || it->phase == INITIALIZING))
        change_due(it, it->time);
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
    double *observed = it->values + first_observed(unit);
    Outcome outcome = prepare(it);
    if (outcome != DONE)
        return outcome;
    if (unit->linear) {
        outcome = solver_observe(it, it->time, it->u, it->du, observed, it->values + first_extra(unit));
        if (outcome != DONE)
            return outcome;
    } else {
        const double **a = at(it, &it->time);
        a[4] = it->du;
        a[5] = it->p;
        a[6] = it->c;
        it->results[0] = observed;
        traced(it, &unit->outputs, a, it->results);
    }
    outcome = check_finite(it, first_observed(unit), unit->observed);
    if (outcome == DONE)
        outcome = check_finite(it, first_extra(unit), unit->extras);
    it->fresh = outcome == DONE;
    return outcome;
}

Outcome refresh(Instance *it)
{
    Number time;
    if (it->phase == FAILED)
        return refuse(it, REFUSED, "the instance failed before: reset it, or free it");
    if (it->fresh || it->phase == INSTANTIATED)
        return DONE;
    if (it->phase == INITIALIZING)
        return first_outputs(it);
    const Outcome outcome = observe(it);
    if (outcome == NO_STEP)
        return explain(it, REFUSED, "outputs at t = %s: ", shortest(it->time, time));
    return outcome;
}

Outcome rates_now(Instance *it, double *dx)
{
    const Unit *unit = it->unit;
    if (unit->linear)
        return solver_derivatives(it, it->u, it->du, dx);
    if (unit->derivatives.call) {
        const double **a = at(it, &it->time);
        a[4] = it->p;
        a[5] = it->c;
        it->results[0] = dx;
        traced(it, &unit->derivatives, a, it->results);
    }
    return DONE;
}

void indicators_now(Instance *it, double *g)
{
    const double **a = at(it, &it->time);
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
    const double *arguments[] = {
        &it->time, it->x, it->m, it->u, it->du, it->p, it->c, it->values + first_observed(unit), &seed_t, it->seed_x,
        NULL, it->seed_u, it->seed_du, NULL, NULL, /* modes, parameters and constants stay */
    };
    for (size_t i = 0; i < sizeof arguments / sizeof *arguments; i++)
        it->arguments[i] = arguments[i];
    it->results[0] = sensed;
    traced(it, &unit->outputs_forward, it->arguments, it->results);
    return DONE;
}
