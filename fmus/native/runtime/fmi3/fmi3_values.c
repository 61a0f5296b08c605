/* FMI 3.0: values of variables, partial derivatives, full state. */
#include "fmi3.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "message.h"

static unsigned time_reference(void) { return (unsigned)towage_unit.variables; }

/* Number of values that a reference delivers; 0: there is no such reference. */
static size_t elements(unsigned reference)
{
    if (reference < time_reference()) return towage_unit.length ? (size_t)towage_unit.length[reference] : 1;
    return reference == time_reference() ? 1 : reference == time_reference() + 1 ? (size_t)towage_unit.indicators : 0;
}

/* Whether there are as many values as the references deliver, and places to put them. */
static bool fits(Component *c, const unsigned *references, size_t count, const void *values, size_t value_count)
{
    size_t expected = 0;
    if ((count && !references) || (value_count && !values))
        return fmi3_decline(c, fmi3Error, "references or values at a null pointer"), false;
    for (size_t i = 0; i < count; i++) {
        size_t n = elements(references[i]);
        if (n == 0) return fmi3_decline(c, fmi3Error, "no variable has value reference %u", references[i]), false;
        expected += n;
    }
    if (expected != value_count)
        fmi3_decline(c, fmi3Error, "%lu values, expected %lu", (unsigned long)value_count, (unsigned long)expected);
    return expected == value_count;
}

static bool scalar(unsigned reference) { return reference < time_reference() && elements(reference) == 1; }

static Outcome get_other(Component *c, unsigned reference, double *values)
{
    size_t n = elements(reference);
    if (reference == time_reference()) {
        *values = c->it->time;
        return DONE;
    }
    if (reference > time_reference()) return instance_get_indicators(c->it, values, n);
    for (size_t k = 0; k < n; k++) c->unknowns[k] = reference + (unsigned)k;
    return instance_get(c->it, c->unknowns, n, values);
}

fmi3Status fmi3GetFloat64(fmi3Instance instance, const fmi3ValueReference references[], size_t count,
                          fmi3Float64 values[], size_t value_count)
{
    Component *c = instance;
    Outcome outcome = DONE;
    if (!c || !fits(c, references, count, values, value_count)) return fmi3Error;
    for (size_t i = 0; i < count && outcome == DONE;) {
        size_t run = 0;
        while (i + run < count && scalar(references[i + run])) run++;
        outcome = run ? instance_get(c->it, references + i, run, values) : get_other(c, references[i], values);
        values += run ? run : elements(references[i]);
        i += run ? run : 1;
    }
    return fmi3_report(c, outcome);
}

fmi3Status fmi3SetFloat64(fmi3Instance instance, const fmi3ValueReference references[], size_t count,
                          const fmi3Float64 values[], size_t value_count)
{
    Component *c = instance;
    if (!c || !fits(c, references, count, values, value_count)) return fmi3Error;
    for (size_t i = 0; i < count; i++)
        if (!scalar(references[i]))
            return fmi3_decline(c, fmi3Error, "the variable of reference %u may not be set", references[i]);
    return fmi3_report(c, instance_set(c->it, references, count, values));
}

fmi3Status fmi3GetOutputDerivatives(fmi3Instance instance, const fmi3ValueReference references[], size_t count,
                                    const fmi3Int32 orders[], fmi3Float64 values[], size_t value_count)
{
    Component *c = instance;
    ONLY_IN(STEP_MODE);
    NEEDS(!count || orders);
    if (!fits(c, references, count, values, value_count)) return fmi3Error;
    for (size_t i = 0; i < count; i++)
        if (!scalar(references[i]))
            return fmi3_decline(c, fmi3Error, "the variable of reference %u is no output", references[i]);
    return fmi3_report(c, instance_get_output_derivatives(c->it, references, count, orders, values));
}

/* The references of all elements, in `list`. */
static bool expand(Component *c, const unsigned *references, size_t count, unsigned *list)
{
    size_t n = 0;
    for (size_t i = 0; i < count; i++)
        for (size_t k = 0; k < elements(references[i]); k++) {
            if (references[i] >= time_reference() || n == (size_t)towage_unit.variables)
                return fmi3_decline(c, fmi3Error, "no partial derivatives with reference %u, or it is listed again",
                                    references[i]),
                       false;
            list[n++] = references[i] + (unsigned)k;
        }
    return true;
}

fmi3Status fmi3GetDirectionalDerivative(fmi3Instance instance, const fmi3ValueReference unknowns[],
                                        size_t unknown_count, const fmi3ValueReference knowns[], size_t known_count,
                                        const fmi3Float64 seed[], size_t seeds, fmi3Float64 sensitivity[],
                                        size_t sensitivities)
{
    Component *c = instance;
    ONLY_IN(COMPUTED);
    if (!fits(c, unknowns, unknown_count, sensitivity, sensitivities) || !fits(c, knowns, known_count, seed, seeds)
        || !expand(c, unknowns, unknown_count, c->unknowns) || !expand(c, knowns, known_count, c->knowns))
        return fmi3Error;
    return fmi3_report(
        c, instance_directional_derivative(c->it, c->unknowns, sensitivities, c->knowns, seeds, seed, sensitivity));
}

/* One directional derivative for each known: the units have few inputs, but may have many outputs. */
fmi3Status fmi3GetAdjointDerivative(fmi3Instance instance, const fmi3ValueReference unknowns[], size_t unknown_count,
                                    const fmi3ValueReference knowns[], size_t known_count, const fmi3Float64 seed[],
                                    size_t seeds, fmi3Float64 sensitivity[], size_t sensitivities)
{
    Component *c = instance;
    const double one = 1.0;
    ONLY_IN(COMPUTED);
    if (!fits(c, unknowns, unknown_count, seed, seeds) || !fits(c, knowns, known_count, sensitivity, sensitivities)
        || !expand(c, unknowns, unknown_count, c->unknowns) || !expand(c, knowns, known_count, c->knowns))
        return fmi3Error;
    for (size_t k = 0; k < sensitivities; k++) {
        Outcome outcome = instance_directional_derivative(c->it, c->unknowns, seeds, c->knowns + k, 1, &one, c->column);
        if (outcome != DONE) return fmi3_report(c, outcome);
        sensitivity[k] = 0.0;
        for (size_t i = 0; i < seeds; i++) sensitivity[k] += seed[i] * c->column[i];
        if (!isfinite(sensitivity[k])) return fmi3_decline(c, fmi3Error, "a sensitivity became %g", sensitivity[k]);
    }
    return fmi3OK;
}

/* A state of `size` bytes at *state; one that the host gives back is used again. */
static bool room(Component *c, fmi3FMUState *state, size_t size)
{
    void *made = state_room(*state, size);
    if (!made) return fmi3_report(c, refuse(c->it, NO_MEMORY, "no memory for a state")), false;
    *state = made;
    return true;
}

fmi3Status fmi3GetFMUState(fmi3Instance instance, fmi3FMUState *state)
{
    Component *c = instance;
    if (!c) return fmi3Error;
    NEEDS(state);
    const bool made = !*state;
    if (!room(c, state, instance_state_size(c->it))) return fmi3Fatal;
    Outcome outcome = instance_save(c->it, state_block(*state));
    if (outcome != DONE && made) fmi3FreeFMUState(instance, state);
    return fmi3_report(c, outcome);
}

fmi3Status fmi3SetFMUState(fmi3Instance instance, fmi3FMUState state)
{
    Component *c = instance;
    if (!c) return fmi3Error;
    NEEDS(state);
    return fmi3_report(c, instance_restore(c->it, state_block(state), ((StateHead *)state)->size));
}

fmi3Status fmi3FreeFMUState(fmi3Instance instance, fmi3FMUState *state)
{
    if (!instance) return fmi3Error;
    NEEDS(state);
    free(*state);
    *state = NULL;
    return fmi3OK;
}

fmi3Status fmi3SerializedFMUStateSize(fmi3Instance instance, fmi3FMUState state, size_t *size)
{
    if (!instance) return fmi3Error;
    NEEDS(state && size);
    *size = instance_serialized_size(((StateHead *)state)->size);
    return fmi3OK;
}

fmi3Status fmi3SerializeFMUState(fmi3Instance instance, fmi3FMUState state, fmi3Byte bytes[], size_t size)
{
    if (!instance) return fmi3Error;
    NEEDS(state && bytes);
    const size_t held = ((StateHead *)state)->size, needed = instance_serialized_size(held);
    if (size != needed)
        return fmi3_decline(instance, fmi3Error, "%lu bytes for a state, expected %lu", (unsigned long)size,
                            (unsigned long)needed);
    instance_serialize(state_block(state), held, bytes);
    return fmi3OK;
}

/* Whose state it is, is seen when it is set. */
fmi3Status fmi3DeserializeFMUState(fmi3Instance instance, const fmi3Byte bytes[], size_t size, fmi3FMUState *state)
{
    if (!instance) return fmi3Error;
    NEEDS(bytes && state);
    Component *c = instance;
    const size_t least = instance_serialized_size(0);
    if (size < least) return fmi3_decline(instance, fmi3Error, "%lu bytes are no state", (unsigned long)size);
    const bool made = !*state;
    if (!room(instance, state, size - least)) return fmi3Fatal;
    const Outcome outcome = instance_deserialize(c->it, bytes, size, state_block(*state));
    if (outcome != DONE && made) fmi3FreeFMUState(instance, state);
    return fmi3_report(c, outcome);
}
