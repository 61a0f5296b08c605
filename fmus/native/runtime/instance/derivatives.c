/* Derivatives that the standard asks for: of inputs, of outputs, and in the direction of a seed. */
#include "calls.h"

#include <string.h>

#include "call.h"
#include "linear.h"
#include "message.h"
#include "observe.h"

Outcome instance_set_input_derivatives(Instance *it, const unsigned *references, size_t count, const int *orders,
                                       const double *values)
{
    const unsigned first = (unsigned)it->unit->first.inputs, end = (unsigned)it->unit->first.input_derivatives;
    Number text;
    if (it->phase > STEPPING)
        return refuse(it, REFUSED, "set input derivatives in phase %s, expected phase stepping or earlier",
                      phase_name(it->phase));
    for (size_t i = 0; i < count; i++) {
        if (references[i] < first || references[i] >= end)
            return refuse(it, REFUSED, "derivative of value reference %u: expected an input, they are %u to %u",
                          references[i], first, end - 1);
        const char *name = it->unit->variable[references[i]].name;
        if (orders[i] < 1 || orders[i] > INPUT_ORDERS)
            return refuse(it, REFUSED, "derivative of order %d of %s: expected 1 to %d", orders[i], name, INPUT_ORDERS);
        if (!is_finite(values[i]))
            return refuse(it, REFUSED, "%s_d%d = %s: expected a finite number", name, orders[i],
                          shortest(values[i], text));
    }
    for (size_t i = 0; i < count; i++)
        it->values[end + INPUT_ORDERS * (references[i] - first) + (unsigned)orders[i] - 1] = values[i];
    it->touched = true;
    it->fresh = false;
    return DONE;
}

/* Outputs, with inputs and their derivatives at the same point: they are needed where an output is not fresh alone. */
static Outcome linearization_point(Instance *it, const char *what)
{
    if (it->phase == INSTANTIATED)
        return refuse(it, REFUSED, "%s in phase instantiated, expected phase initializing or later", what);
    const Outcome outcome = refresh(it);
    return outcome == DONE ? prepare(it) : outcome;
}

/* Sensitivities of all outputs to the passing of time, inputs going on as their derivatives say. */
static Outcome outputs_in_time(Instance *it)
{
    const size_t inputs = (size_t)it->unit->inputs * sizeof *it->u;
    const Outcome outcome = state_rates(it, it->seed_x);
    if (outcome != DONE) return outcome;
    memcpy(it->seed_u, it->du, inputs);
    memcpy(it->seed_du, it->ddu, inputs);
    return outputs_forward(it, 1.0, it->sensed_outputs);
}

Outcome instance_get_output_derivatives(Instance *it, const unsigned *references, size_t count, const int *orders,
                                        double *values)
{
    const Unit *unit = it->unit;
    const unsigned first = (unsigned)unit->first.observed;
    bool sensed = false;
    Outcome outcome = linearization_point(it, "get output derivatives");
    for (size_t i = 0; outcome == DONE && i < count; i++) {
        outcome = known_reference(it, references[i]);
        if (outcome == DONE && unit->variable[references[i]].causality != OUTPUT)
            outcome = refuse(it, REFUSED, "derivative of %s: expected an output", unit->variable[references[i]].name);
        else if (outcome == DONE && orders[i] != 1)
            outcome = refuse(it, REFUSED, "derivative of order %d of %s: expected 1", orders[i],
                             unit->variable[references[i]].name);
    }
    for (size_t i = 0; outcome == DONE && i < count; i++) {
        const unsigned output = references[i] - first;
        const int rate = unit->rate[output];
        if (rate < 0 && !sensed) {
            outcome = outputs_in_time(it);
            sensed = true;
        }
        values[i] = rate >= 0 ? it->values[first + (unsigned)rate] : it->sensed_outputs[output];
        if (outcome == DONE && !is_finite(values[i]))
            outcome = refuse(it, REFUSED, "the derivative of %s is not finite", unit->variable[references[i]].name);
    }
    return outcome;
}

/* The seed of a known, NULL where there is none: d2 and d3 of an input act later, not at this point. */
static Outcome seed_of(Instance *it, unsigned reference, double **seed)
{
    const Unit *unit = it->unit;
    const unsigned input = (unsigned)unit->first.inputs, derivative = (unsigned)unit->first.input_derivatives;
    const unsigned observed = (unsigned)unit->first.observed, state = (unsigned)unit->first.states;
    *seed = NULL;
    if (reference >= input && reference < derivative)
        *seed = it->seed_u + (reference - input);
    else if (reference >= derivative && reference < observed)
        *seed =
            (reference - derivative) % INPUT_ORDERS == 0 ? it->seed_du + (reference - derivative) / INPUT_ORDERS : NULL;
    else if (reference >= state && reference < (unsigned)unit->first.state_derivatives)
        *seed = it->seed_x + (reference - state);
    else
        return refuse(it, REFUSED, "derivative with respect to %s: expected an input, its derivative or a state",
                      unit->variable[reference].name);
    return DONE;
}

static Outcome gather_seeds(Instance *it, const unsigned *knowns, size_t count, const double *seed)
{
    const size_t inputs = (size_t)it->unit->inputs * sizeof *it->seed_u;
    double *place;
    memset(it->seed_x, 0, (size_t)it->unit->states * sizeof *it->seed_x);
    memset(it->seed_u, 0, inputs);
    memset(it->seed_du, 0, inputs);
    for (size_t i = 0; i < count; i++) {
        Outcome outcome = known_reference(it, knowns[i]);
        if (outcome == DONE) outcome = seed_of(it, knowns[i], &place);
        if (outcome != DONE) return outcome;
        if (place) *place += seed[i];
    }
    return DONE;
}

static Outcome rates_forward(Instance *it, double *sensed)
{
    const Unit *unit = it->unit;
    if (unit->linear)
        return solver_forward(it, it->time, it->u, it->du, it->seed_x, it->seed_u, it->seed_du, NULL, sensed);
    const double *arguments[] = {
        &it->time, it->x, it->m, it->u, it->p, it->c, NULL, NULL, it->seed_x, NULL, it->seed_u, NULL, NULL,
    };
    memcpy(it->arguments, arguments, sizeof arguments);
    it->results[0] = sensed;
    traced(it, &unit->derivatives_forward, it->arguments, it->results);
    return DONE;
}

Outcome instance_directional_derivative(Instance *it, const unsigned *unknowns, size_t unknown_count,
                                        const unsigned *knowns, size_t known_count, const double *seed,
                                        double *sensitivity)
{
    const Unit *unit = it->unit;
    const unsigned observed = (unsigned)unit->first.observed, state = (unsigned)unit->first.states;
    const unsigned rate = (unsigned)unit->first.state_derivatives, extra = (unsigned)unit->first.extras;
    bool outputs = false, rates = false;
    Outcome outcome = linearization_point(it, "directional derivative");
    if (outcome == DONE) outcome = gather_seeds(it, knowns, known_count, seed);
    for (size_t i = 0; outcome == DONE && i < unknown_count; i++) {
        const bool is_output = unknowns[i] >= observed && unknowns[i] < state;
        const bool is_rate = unknowns[i] >= rate && unknowns[i] < extra;
        outcome = known_reference(it, unknowns[i]);
        if (outcome == DONE && !is_output && !is_rate)
            outcome = refuse(it, REFUSED,
                             "directional derivative of %s: expected an output, a local variable or the "
                             "derivative of a state",
                             unit->variable[unknowns[i]].name);
        outputs = outputs || is_output;
        rates = rates || is_rate;
    }
    if (outcome == DONE && outputs) outcome = outputs_forward(it, 0.0, it->sensed_outputs);
    if (outcome == DONE && rates) outcome = rates_forward(it, it->sensed_rates);
    for (size_t i = 0; outcome == DONE && i < unknown_count; i++) {
        sensitivity[i] =
            unknowns[i] < state ? it->sensed_outputs[unknowns[i] - observed] : it->sensed_rates[unknowns[i] - rate];
        if (!is_finite(sensitivity[i]))
            outcome = refuse(it, REFUSED, "the sensitivity of %s is not finite", unit->variable[unknowns[i]].name);
    }
    return outcome;
}
