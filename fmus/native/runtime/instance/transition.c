/* Inputs over a communication step, and the changes of state and modes at its points. */
#include "transition.h"

#include "call.h"

void cubics(Instance *it)
{
    const int n = it->unit->inputs;
    const double *u = it->values + it->unit->first.inputs, *d = it->values + it->unit->first.input_derivatives;
    double *k = it->k;
    for (int i = 0; i < n; i++, d += INPUT_ORDERS, k += CUBIC) {
        k[0] = u[i];
        k[1] = d[0];
        k[2] = 0.5 * d[1];
        k[3] = d[2] / 6.0;
    }
}

void cubics_from(Instance *it, double s)
{
    const double *k = it->k;
    double *l = it->later;
    for (int i = 0; i < it->unit->inputs; i++, k += CUBIC, l += CUBIC) {
        l[0] = k[0] + s * (k[1] + s * (k[2] + s * k[3]));
        l[1] = k[1] + s * (2.0 * k[2] + s * 3.0 * k[3]);
        l[2] = k[2] + 3.0 * k[3] * s;
        l[3] = k[3];
    }
}

void inputs_at(Instance *it, double s)
{
    const double *k = it->k;
    for (int i = 0; i < it->unit->inputs; i++, k += CUBIC) it->u[i] = k[0] + s * (k[1] + s * (k[2] + s * k[3]));
}

/* What the transition makes of state and modes, to next_x and next_m. */
static void changed(Instance *it, double t)
{
    const double **a = arguments_at(it, &t);
    a[4] = it->p;
    a[5] = it->c;
    it->results[0] = it->next_x;
    it->results[1] = it->next_m;
    traced(it, &it->unit->change, a, it->results);
}

void change(Instance *it, double t)
{
    const Unit *unit = it->unit;
    changed(it, t);
    for (int i = 0; i < unit->states; i++) it->x[i] = it->next_x[i];
    for (int i = 0; i < unit->modes; i++) it->m[i] = it->next_m[i];
}

double next_event(Instance *it, double t)
{
    double due = NEVER;
    if (!it->unit->next_event.call) return NEVER;
    it->arguments[0] = &t;
    it->arguments[1] = it->m;
    it->arguments[2] = it->p;
    it->arguments[3] = it->c;
    it->results[0] = &due;
    traced(it, &it->unit->next_event, it->arguments, it->results);
    return due;
}

/* t, or the next event if it is a rounding error away. */
static double event_at(Instance *it, double t)
{
    const double due = next_event(it, t), left = due - t;
    return 0.0 < left && left <= EVENT_TOLERANCE * (1.0 + (t < 0.0 ? -t : t)) ? due : t;
}

void change_due(Instance *it, double t)
{
    if (it->unit->change.call) change(it, event_at(it, t));
}

bool change_waits(Instance *it, double t)
{
    const Unit *unit = it->unit;
    if (!unit->change.call) return false;
    changed(it, event_at(it, t));
    for (int i = 0; i < unit->states; i++)
        if (it->next_x[i] != it->x[i]) return true;
    for (int i = 0; i < unit->modes; i++)
        if (it->next_m[i] != it->m[i]) return true;
    return false;
}
