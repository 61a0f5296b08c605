/* One instance of a unit: values, state, stepping and the rules of the call order, without any FMI.
 *
 * The behaviour is that of fmus/python/instance.py, word for word: inputs are cubics over a communication step; after a step,
 * outputs are limits from the left, once anything is set they are limits from the right; a refused call changes nothing.
 * Functions return an Outcome; the message is in `message` of the instance. */
#ifndef TOWAGE_INSTANCE_H
#define TOWAGE_INSTANCE_H

#include <stddef.h>
#include "unit.h"

#define NEVER 1e300

typedef enum { DONE, REFUSED, NO_STEP, NO_MEMORY } Outcome; /* REFUSED: CallError; NO_STEP: StepError of instance.py */
typedef enum { INSTANTIATED, INITIALIZING, STEPPING, TERMINATED, FAILED } Phase;
typedef enum { CO_SIMULATION, MODEL_EXCHANGE } Kind;

typedef struct Instance Instance;
typedef struct Solver Solver;   /* linear.c: what a linear unit computed from its parameters */

struct Instance {
    const Unit *unit;
    Kind kind;
    Phase phase;
    double time, stop_time, offset, first_step;
    bool touched, fresh, frozen, stale; /* stale: a parameter changed, constants are computed before the next use */
    bool continuous; /* model exchange: continuous-time mode, otherwise event mode */
    double *values;  /* all variables but states and their derivatives, which have their place unused */
    double *x, *m;   /* continuous state as stepped (reduced where reduced), modes */
    double *p, *c;   /* parameters in force (with integration_tolerance), constants */
    double *k;       /* cubics of the inputs */
    Solver *solver;
    char message[1024];
    /* work space */
    const double **arguments;
    double **results;
    Integer *iw;
    double *w;
    double *u, *du, *ddu;                          /* inputs and their derivatives at the point that is looked at */
    double *next_x, *next_m;                       /* results of a transition */
    double *kept_x, *kept_m, *kept_p;              /* what a refused step or parameter goes back to */
    double *seed_x, *seed_u, *seed_du;             /* directional derivatives */
    double *sensed_outputs, *sensed_rates, *scratch; /* scratch: of the integrator, of requirements */
};

Instance *instance_new(const Unit *unit, Kind kind); /* NULL: no memory */
void instance_free(Instance *);
void instance_reset(Instance *);
Outcome instance_set_up(Instance *, double start, bool stop_defined, double stop);
Outcome instance_enter_initialization(Instance *);
Outcome instance_exit_initialization(Instance *);
Outcome instance_terminate(Instance *);
Outcome instance_set(Instance *, const unsigned *references, size_t count, const double *values);
Outcome instance_get(Instance *, const unsigned *references, size_t count, double *values);
Outcome instance_step(Instance *, double time, double step);

/* Standard functions of FMI beyond the Python flavour. */
Outcome instance_set_input_derivatives(Instance *, const unsigned *references, size_t count, const int *orders,
                                       const double *values);
Outcome instance_get_output_derivatives(Instance *, const unsigned *references, size_t count, const int *orders,
                                        double *values);
/* Seeds on inputs, input derivatives and states; sensitivities of observed variables and state derivatives. */
Outcome instance_directional_derivative(Instance *, const unsigned *unknowns, size_t unknown_count, const unsigned *knowns,
                                        size_t known_count, const double *seed, double *sensitivity);

/* Full state: one block of instance_state_size bytes, restorable into any instance of the unit. */
size_t instance_state_size(const Instance *);
Outcome instance_save(Instance *, void *block);
Outcome instance_restore(Instance *, const void *block, size_t size);

/* Model exchange. The continuous state is that of the unreduced model. */
Outcome instance_set_time(Instance *, double time);
Outcome instance_set_states(Instance *, const double *x, size_t count);
Outcome instance_get_states(Instance *, double *x, size_t count);
Outcome instance_get_derivatives(Instance *, double *dx, size_t count);
Outcome instance_get_indicators(Instance *, double *g, size_t count);
Outcome instance_discrete_update(Instance *, bool *states_changed, double *next_event_time);
Outcome instance_enter_continuous(Instance *); /* branches are fixed from here on */
Outcome instance_enter_event(Instance *);

/* To the instance's own files: refuse with a message, call a traced function with arguments in a fixed order. */
Outcome refuse(Instance *, Outcome, const char *format, ...);
int traced(Instance *, const Function *, const double **arguments, double **results);

/* linear.c */
/* Makes or remakes the solver: the constants c are known, p too, and get what the study of the unit finds (states used,
 * errors, ...). The own states are in x behind all core states of the unreduced model, however few are in use. */
Outcome solver_make(Instance *);
bool solver_reduced(const Instance *); /* its states belong to its parameters: these must not change any more */
void solver_free(Solver *);
Outcome solver_advance(Instance *, double step);
Outcome solver_observe(Instance *, double t, const double *u, const double *du, double *observed, double *extras);
Outcome solver_derivatives(Instance *, const double *u, const double *du, double *dx);
/* State of the unreduced core and its rates, at u and du, that the reduced ones stand for, whose rates are in dx. */
void solver_expand(Instance *, double *x, double *dx);
Outcome solver_forward(Instance *, double t, const double *u, const double *du, const double *seed_x, const double *seed_u,
                       const double *seed_du, double *observed, double *dx); /* either result may be NULL */

#endif
