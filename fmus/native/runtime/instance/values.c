/* Setting and getting values: what may be set when, and what must be computed before it can be read. */
#include "calls.h"

#include <string.h>

#include "linear.h"
#include "message.h"
#include "observe.h"

static bool settable(const Instance *it, const Variable *v)
{
    if (v->causality != INPUT && v->causality != PARAMETER) return false;
    return it->phase == INSTANTIATED || it->phase == INITIALIZING || (it->phase == STEPPING && v->variability != FIXED);
}

/* In continuous-time and step mode only the inputs and their derivatives, which come after all other parameters. */
static bool held(const Instance *it, unsigned reference)
{
    return it->continuous && reference < (unsigned)it->unit->first.inputs;
}

/* The states of a reduced model have no meaning for other parameters. */
static bool tied(const Instance *it, unsigned reference)
{
    return it->phase == STEPPING && reference < (unsigned)it->unit->first.calculated && solver_reduced(it);
}

static Outcome refuse_set(Instance *it, unsigned reference, double value)
{
    static const char *const causalities[] = CAUSALITY_NAMES;
    static const char *const variabilities[] = VARIABILITY_NAMES;
    const Variable *v = &it->unit->variable[reference];
    Number text;
    if (!settable(it, v))
        return refuse(it, REFUSED, "%s may not be set in phase %s: it is a %s %s", v->name, phase_name(it->phase),
                      variabilities[v->variability], causalities[v->causality]);
    if (held(it, reference))
        return refuse(it, REFUSED, "%s may not be set in %s mode: it is a tunable parameter", v->name,
                      it->kind == CO_SIMULATION ? "step" : "continuous-time");
    if (tied(it, reference))
        return refuse(it, REFUSED,
                      "%s may not be set: the states of another reduced model mean something else, this needs "
                      "reduced = 0",
                      v->name);
    return refuse(it, REFUSED, "%s = %s: expected a finite number", v->name, shortest(value, text));
}

Outcome instance_set(Instance *it, const unsigned *references, size_t count, const double *values)
{
    for (size_t i = 0; i < count; i++) {
        const Outcome outcome = known_reference(it, references[i]);
        if (outcome != DONE) return outcome;
        if (!settable(it, &it->unit->variable[references[i]]) || held(it, references[i]) || tied(it, references[i])
            || !is_finite(values[i]))
            return refuse_set(it, references[i], values[i]);
    }
    for (size_t i = 0; i < count; i++) {
        it->values[references[i]] = values[i];
        it->stale = it->stale || references[i] < (unsigned)it->unit->first.calculated;
    }
    it->touched = true;
    it->fresh = false;
    return DONE;
}

/* Whether all references are parameters, inputs and their derivatives, whose values are always up to date. */
static bool given(const Unit *unit, const unsigned *references, size_t count)
{
    for (size_t i = 0; i < count; i++)
        if (references[i] >= (unsigned)unit->first.observed
            || (references[i] >= (unsigned)unit->first.calculated && references[i] < (unsigned)unit->first.inputs))
            return false;
    return true;
}

/* States and their derivatives, which are not among the values, in kept_x and sensed_rates. */
static Outcome show_states(Instance *it, bool rates)
{
    const bool reduced = it->unit->linear && solver_reduced(it);
    memcpy(it->kept_x, it->x, (size_t)it->unit->states * sizeof *it->x);
    memset(it->sensed_rates, 0, (size_t)it->unit->states * sizeof *it->sensed_rates);
    if (it->phase == INSTANTIATED || !(rates || reduced)) return DONE;
    const Outcome outcome = state_rates(it, it->sensed_rates);
    if (outcome == DONE && reduced) solver_expand(it, it->kept_x, it->sensed_rates);
    return outcome;
}

Outcome instance_get(Instance *it, const unsigned *references, size_t count, double *values)
{
    const Unit *unit = it->unit;
    const unsigned state = (unsigned)unit->first.states, rate = (unsigned)unit->first.state_derivatives,
                   extra = (unsigned)unit->first.extras;
    bool states = false, rates = false;
    Outcome outcome = DONE;
    for (size_t i = 0; i < count; i++) {
        if ((outcome = known_reference(it, references[i])) != DONE) return outcome;
        states = states || (references[i] >= state && references[i] < extra);
        rates = rates || (references[i] >= rate && references[i] < extra);
    }
    /* parameters can be read while they do not fit together yet */
    if (!it->fresh && (it->phase != INITIALIZING || !given(unit, references, count))) outcome = refresh(it);
    if (outcome == DONE && states) outcome = show_states(it, rates);
    for (size_t i = 0; outcome == DONE && i < count; i++) {
        if (references[i] < state || references[i] >= extra)
            values[i] = it->values[references[i]];
        else
            values[i] =
                references[i] < rate ? it->kept_x[references[i] - state] : it->sensed_rates[references[i] - rate];
        if (!is_finite(values[i])) /* a calculated parameter: outputs were checked */
            outcome = refuse(it, REFUSED, "%s is not finite", unit->variable[references[i]].name);
    }
    return outcome;
}
