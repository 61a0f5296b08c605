/* A linear unit at work: the model in force, prepared steps, prepared observation. */
#ifndef TOWAGE_SOLVER_H
#define TOWAGE_SOLVER_H

#include "instance.h"
#include "state_space.h"

enum { OPERATORS = 4 }; /* prepared steps that are kept; the one that was not used for the longest time goes */

typedef struct {
    double step, schedule;
    unsigned long used; /* when, counted in uses; 0: never made */
    double *matrix;     /* [Ad | G], n rows; G by inputs and, for each, by powers of time */
} Operator;

struct Solver {
    StateSpace model; /* in force; matrices of the schedule's powers follow each other */
    bool reduced;
    double *room; /* matrices of the reduced model */
    unsigned long uses;
    Operator operators[OPERATORS];
    double *observer; /* to (y, y') from (z, v, v', v''); y' for the rows whose rates are used */
    double *rates;    /* [A | B] */
    double schedule;  /* of observer, rates and growth, if `current` */
    bool current, grown;
    double growth;
    double *a, *b, *scale, *block, *work; /* of an exponential (6 N^2, N its rows), or of eigenvalues and vectors */
    int *pivot;
    double *vector, *seed_vector, *y, *seed_y, *next, *seed_next; /* next: z, own or derivatives */
    double *data;                                                 /* all of these */
};

/* Own states are behind the unreduced core, whatever part of that is in use. */
static inline const double *own_states(const Instance *it) { return it->x + it->unit->linear->layout.states; }

double schedule_of(Instance *, const double *u);

#endif
