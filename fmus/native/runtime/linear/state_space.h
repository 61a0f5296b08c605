/* Linear models as matrices. */
#ifndef TOWAGE_STATE_SPACE_H
#define TOWAGE_STATE_SPACE_H

#include "unit.h"

/* z' = A z + B v, y = C z + D v + E v' with n states, k inputs and r rows; column by column. */
typedef struct {
    int n, k, r;
    const double *a, *b, *c, *d, *e;
} StateSpace;

/* The matrices at schedule 0 among constants. */
StateSpace state_space(const Layout *, const double *constants);
/* sum = A0 + s A1 + s^2 A2 for matrices of `size` elements that follow each other. */
void combine(int size, int powers, const double *a, double s, double *sum);
/* The matrices of a model of so many states in `room`; D and E those of the full one. */
StateSpace cut(const StateSpace *full, int states, double *room);
/* D^-1 A D, D^-1 B, C D for the first inputs and rows, D = diag(scale) such that A is balanced. */
void balanced_copy(const StateSpace *, int inputs, int rows, double *a, double *b, double *c, double *scale);

#endif
