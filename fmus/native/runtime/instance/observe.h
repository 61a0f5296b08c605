/* Outputs, rates and indicators at the point where the instance is. */
#ifndef TOWAGE_OBSERVE_H
#define TOWAGE_OBSERVE_H

#include "instance.h"

Outcome prepare(Instance *);                 /* constants, branches, inputs u and du at the present point */
Outcome observe(Instance *);                 /* NO_STEP where a number is not finite */
Outcome first_outputs(Instance *);           /* initial state and outputs, in the initialization phase */
Outcome refresh(Instance *);                 /* `observe` as the phase demands, REFUSED instead of NO_STEP */
Outcome rates_now(Instance *, double *dx);   /* derivatives of the state, after `prepare` */
Outcome state_rates(Instance *, double *dx); /* the same with `prepare`, refused where they are not finite */
void indicators_now(Instance *, double *g);
/* Sensitivities of the outputs; seed_t 1: their rate of change in time. */
Outcome outputs_forward(Instance *, double seed_t, double *sensed);

#endif
