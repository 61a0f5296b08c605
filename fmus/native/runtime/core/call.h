/* Calls of traced functions with arguments in a fixed order. */
#ifndef TOWAGE_CALL_H
#define TOWAGE_CALL_H

#include "instance.h"

/* Arguments and results of a traced function, the missing ones NULL. */
typedef struct {
    const double *at[20]; /* observe_forward */
} Arguments;

typedef struct {
    double *at[3]; /* core */
} Results;

/* With lists of the caller's, which are as long as the function needs. */
int traced(Instance *, const Function *, const double **arguments, double **results);
/* With copies in the lists of the instance. */
void evaluate(Instance *, const Function *, Arguments, Results);
/* The list of the instance with the arguments t, x, m, u, with which most functions begin. */
const double **arguments_at(Instance *, const double *t);

#endif
