/* Gains of a linear unit over a band of frequencies, the errors that they show, and how far its modes are resolved.
 *
 * The measure of errors is that of models/cable/lumped/reduction.py: for every frequency and input, the largest difference in a
 * pair of rows of y (force on the towpoint; velocity of the body, or force on it) over the largest gain of the pair. */
#ifndef TOWAGE_GAINS_H
#define TOWAGE_GAINS_H

#include "eigen.h"
#include "instance.h"

enum { FREQUENCIES = 40, COMPARED = 4 }; /* evenly spaced in their logarithm; rows of y, two pairs */

/* Arguments and results of a traced function, the missing ones NULL. */
typedef struct {
    const double *at[20]; /* observe_forward */
} Arguments;
typedef struct {
    double *at[3]; /* core */
} Results;
void evaluate(Instance *, const Function *, Arguments, Results);

/* z' = A z + B v, y = C z + D v + E v' with n states, k inputs and r rows; column by column. */
typedef struct {
    int n, k, r;
    const double *a, *b, *c, *d, *e;
} StateSpace;

/* The matrices at schedule 0 among constants. */
StateSpace state_space(const Layout *, const double *constants);
/* sum = A0 + s A1 + s^2 A2 for matrices of `size` elements that follow each other. */
void combine(int size, int powers, const double *a, double s, double *sum);
/* D^-1 A D, D^-1 B, C D for the first inputs and rows, D = diag(scale) such that A is balanced. */
void balanced_copy(const StateSpace *, int inputs, int rows, double *a, double *b, double *c, double *scale);

int counted_inputs(const Instance *); /* the first of v that count in errors */
void band_frequencies(double band, double *omega);
/* Gains of the compared rows by the first inputs: found[(frequency * inputs + input) * COMPARED + row]. False: no memory. */
bool gains(const StateSpace *, const double *omega, int inputs, Complex *found);
double relative_error(const Complex *found, const Complex *reference, int inputs);

/* Errors of the comparisons, added to their constants. */
Outcome compare(Instance *);
/* The constant of the unit's `resolution`. */
Outcome resolve(Instance *);

#endif
