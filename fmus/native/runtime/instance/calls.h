/* The calls of an instance, without any FMI: values, state, stepping and the rules of the call order.
 *
 * The behaviour is that of fmus/python/instance.py, word for word: inputs are cubics over a communication step; after a
 * step, outputs are limits from the left, once anything is set they are limits from the right; a refused call changes
 * nothing. */
#ifndef TOWAGE_CALLS_H
#define TOWAGE_CALLS_H

#include "instance.h"

Instance *instance_new(const Unit *unit, Kind kind); /* NULL: no memory */
bool has_events(const Unit *);                       /* whether event mode makes sense in co-simulation */
void instance_free(Instance *);
void instance_reset(Instance *);
Outcome instance_set_up(Instance *, double start, bool stop_defined, double stop);
Outcome instance_enter_initialization(Instance *);
Outcome instance_exit_initialization(Instance *);
Outcome instance_terminate(Instance *);
Outcome instance_set(Instance *, const unsigned *references, size_t count, const double *values);
Outcome instance_get(Instance *, const unsigned *references, size_t count, double *values);
/* Where `early` is set the step ends at the first event; `time` of the instance tells where, `event_due` that one
 * waits. */
Outcome instance_step(Instance *, double time, double step);

/* Standard functions of FMI beyond the Python flavour. */
Outcome instance_set_input_derivatives(Instance *, const unsigned *references, size_t count, const int *orders,
                                       const double *values);
Outcome instance_get_output_derivatives(Instance *, const unsigned *references, size_t count, const int *orders,
                                        double *values);
/* Seeds on inputs, input derivatives and states; sensitivities of observed variables and state derivatives. */
Outcome instance_directional_derivative(Instance *, const unsigned *unknowns, size_t unknown_count,
                                        const unsigned *knowns, size_t known_count, const double *seed,
                                        double *sensitivity);

/* Full state: one block of instance_state_size bytes, restorable into any instance of the unit. */
size_t instance_state_size(const Instance *); /* now: some units have as many states as their parameters make */
Outcome instance_save(Instance *, void *block);
Outcome instance_restore(Instance *, const void *block, size_t size);
/* The same as it may be stored: a block and its checksum, so that no number that was changed comes back. */
size_t instance_serialized_size(size_t block_size);
void instance_serialize(const void *block, size_t block_size, void *bytes);
Outcome instance_deserialize(Instance *, const void *bytes, size_t size, void *block);

/* What a host holds: a block with its size in front, in memory that `free` gives back. */
typedef union {
    size_t size;
    double align;
} StateHead;
void *state_room(void *kept, size_t size); /* `kept` in a new size, or a new one; NULL: no memory, `kept` stays */
void *state_block(void *state);

/* Model exchange, the last three with event mode in co-simulation too. The continuous state is that of the unreduced
 * model. */
Outcome instance_set_time(Instance *, double time);
Outcome instance_set_states(Instance *, const double *x, size_t count);
Outcome instance_get_states(Instance *, double *x, size_t count);
Outcome instance_get_derivatives(Instance *, double *dx, size_t count);
Outcome instance_get_indicators(Instance *, double *g, size_t count);
Outcome instance_discrete_update(Instance *, bool *states_changed, double *next_event_time);
Outcome instance_enter_continuous(Instance *); /* branches are fixed from here on */
Outcome instance_enter_event(Instance *);

#endif
