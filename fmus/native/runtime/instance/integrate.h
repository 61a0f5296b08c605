/* Dormand-Prince 5(4) with error control and event location: models/numeric/integrate.py in C, the same steps and
 * decisions. */
#ifndef TOWAGE_INTEGRATE_H
#define TOWAGE_INTEGRATE_H

#include <stdbool.h>

typedef struct {
    void *context;
    int states, indicators;
    void (*rates)(void *context, double t, const double *x, double *f);
    void (*indicate)(void *context, double t, const double *x, double *g);
    bool (*on_event)(void *context, double t, double *x); /* whether to stop there */
} System;

/* Doubles of work space that `integrate` needs. */
int integrate_work(int states, int indicators);

/* From t to t_end, or to an event that stops it; *step is the step to begin with (0: the whole) and that to begin the
 * next call with. Returns 0, or a reason: 1 no step is small enough, 2 too many steps; *t and x are then where it
 * stopped. */
int integrate(const System *, double *t, double *x, double t_end, double rtol, double atol, double *step, double *work);

#endif
