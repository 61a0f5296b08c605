/* What follows from the parameters: ranges, requirements, constants, calculated parameters, the initial state. */
#include "parameters.h"

#include <string.h>

#include "call.h"
#include "linear.h"
#include "message.h"

static Outcome check_ranges(Instance *it)
{
    for (int i = 0; i < it->unit->first.calculated; i++) {
        const Variable *v = &it->unit->variable[i];
        const double x = it->values[i];
        if (!(x < v->min || x > v->max)) continue;
        if (v->min == v->max)
            return refuse(it, REFUSED, "%s = %g %s: expected %g, the value that this unit was built for", v->name, x,
                          v->unit, v->min);
        if (!is_finite(v->min))
            return refuse(it, REFUSED, "%s = %g %s: expected at most %g", v->name, x, v->unit, v->max);
        if (!is_finite(v->max))
            return refuse(it, REFUSED, "%s = %g %s: expected at least %g", v->name, x, v->unit, v->min);
        return refuse(it, REFUSED, "%s = %g %s: expected %g to %g", v->name, x, v->unit, v->min, v->max);
    }
    return DONE;
}

/* A function of (p), (p, c) and nothing else. */
static void from_parameters(Instance *it, const Function *function, double *first, double *second)
{
    if (!function->call) return;
    it->arguments[0] = it->p;
    it->arguments[1] = it->c;
    it->results[0] = first;
    it->results[1] = second;
    traced(it, function, it->arguments, it->results);
}

/* Puts the parameters among the values in force. Refused, those in force may be of no use any more. */
Outcome compute_constants(Instance *it)
{
    const Unit *unit = it->unit;
    it->stale = true; /* until the end: what comes between may refuse */
    Outcome outcome = check_ranges(it);
    if (outcome != DONE) return outcome;
    memcpy(it->p, it->values, (size_t)unit->first.calculated * sizeof *it->p);
    from_parameters(it, &unit->setup, it->c, NULL);
    from_parameters(it, &unit->required, it->scratch, NULL);
    for (int i = 0; unit->required.call && i < unit->requirements; i++)
        if (!(it->scratch[i] > 0.0)) return refuse(it, REFUSED, "%s", unit->requirement[i]);
    if (unit->linear && (outcome = solver_make(it)) != DONE) return outcome;
    if (unit->steps && (outcome = unit->steps->make(it)) != DONE) return outcome;
    from_parameters(it, &unit->calculate, it->values + unit->first.calculated, NULL);
    it->frozen = unit->frozen >= 0 && it->p[unit->frozen] > 0.5;
    it->stale = false;
    return DONE;
}

Outcome retune(Instance *it)
{
    const size_t size = (size_t)it->unit->first.calculated * sizeof *it->p;
    Outcome outcome;
    if (it->unit->linear && solver_reduced(it)) {
        memcpy(it->values, it->p, size);
        it->stale = false;
        return refuse(it, REFUSED,
                      "parameters may not be set: the states of another reduced model mean something else, "
                      "this needs reduced = 0");
    }
    memcpy(it->kept_p, it->p, size);
    outcome = compute_constants(it);
    if (outcome == REFUSED) {
        memcpy(it->values, it->kept_p, size);
        if (compute_constants(it) == NO_MEMORY) /* they were in force before, nothing else can refuse them */
            outcome = NO_MEMORY;
    }
    return outcome;
}

Outcome initialize(Instance *it)
{
    const Unit *unit = it->unit;
    if (it->stale) {
        const Outcome outcome = compute_constants(it);
        if (outcome != DONE) return outcome;
    }
    memset(it->x, 0, (size_t)it->states * sizeof *it->x);
    memset(it->m, 0, (size_t)unit->modes * sizeof *it->m);
    from_parameters(it, &unit->initial, it->x, it->m);
    if (unit->steps) unit->steps->begin(it);
    it->offset = it->first_step = 0.0;
    it->touched = true;
    it->fresh = false;
    return DONE;
}
