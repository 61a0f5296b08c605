/* The matrices of a linear unit at work: made from its parameters, stepped exactly, observed. */
#ifndef TOWAGE_LINEAR_H
#define TOWAGE_LINEAR_H

#include "instance.h"

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
Outcome solver_forward(Instance *, double t, const double *u, const double *du, const double *seed_x,
                       const double *seed_u, const double *seed_du, double *observed,
                       double *dx); /* either result may be NULL */

#endif
