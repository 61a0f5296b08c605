/* What an instance of a unit holds, and what its functions return: an Outcome, with the message in `message`. */
#ifndef TOWAGE_INSTANCE_H
#define TOWAGE_INSTANCE_H

#include <stdbool.h>
#include <stddef.h>

#include "unit.h"

typedef enum { DONE, REFUSED, NO_STEP, NO_MEMORY } Outcome; /* REFUSED: CallError; NO_STEP: StepError of instance.py */
typedef enum { CO_SIMULATION, MODEL_EXCHANGE } Kind;

typedef struct Instance Instance;
typedef struct Solver Solver; /* linear/solver.h: what a linear unit computed from its parameters */
typedef struct Wire Wire;     /* chain/wire.h: the same of a wire */

/* What a unit that steps by itself does in place of traced functions; how many states it has follows from its
 * parameters. Seeds are those of the instance. */
typedef struct Steps {
    Outcome (*make)(Instance *); /* from p and c: room for the states, calculated parameters */
    void (*end)(Instance *);     /* gives back what `make` took */
    void (*begin)(Instance *);   /* states at the start of a run, all zero before */
    Outcome (*advance)(Instance *, double step);
    Outcome (*observe)(Instance *, double *observed);
    Outcome (*forward)(Instance *, double seed_t, double *sensed);
} Steps;

struct Instance {
    const Unit *unit;
    Kind kind;
    Phase phase;
    double time, stop_time, offset, first_step;
    bool touched, fresh, frozen, stale; /* stale: a parameter changed, constants are computed before the next use */
    bool events, early; /* co-simulation with event mode; steps may end at an event, which waits for it */
    bool event_due;     /* at the end of the last step */
    bool continuous;    /* with event mode: continuous-time or step mode, otherwise event mode */
    double *values;     /* all variables but states and their derivatives, which have their place unused */
    int states;         /* those of the unit, or as many as its parameters made */
    double *x, *m;      /* continuous state as stepped (reduced where reduced), modes */
    double *p, *c;      /* parameters in force (with integration_tolerance), constants */
    double *k, *later;  /* cubics of the inputs over the step, and counted from an event inside it */
    Solver *solver;
    void *memory; /* of kernels */
    Wire *wire;
    char message[1024];
    /* work space */
    const double **arguments;
    double **results;
    Integer *iw;
    double *w;
    double *u, *du, *ddu;                            /* inputs and their derivatives at the point that is looked at */
    double *next_x, *next_m;                         /* results of a transition */
    double *kept_x, *kept_m, *kept_p;                /* what a refused step or parameter goes back to */
    double *seed_x, *seed_u, *seed_du;               /* directional derivatives */
    double *sensed_outputs, *sensed_rates, *scratch; /* scratch: of the integrator, of requirements */
};

static inline bool is_finite(double value) { return value - value == 0.0; }

#endif
