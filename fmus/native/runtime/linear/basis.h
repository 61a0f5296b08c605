/* The two ways to a smaller model, as in models/cable/lumped/reduction.py, which gives their sources. */
#ifndef TOWAGE_BASIS_H
#define TOWAGE_BASIS_H

#include "gains.h"

typedef struct {
    const StateSpace *full;
    int inputs; /* the first of v that count */
    double omega[FREQUENCIES];
    Complex *exact, *reduced; /* gains, of the full and of a reduced model */
} Measure;

/* A model in other coordinates, of which a reduced one is cut. Balanced: a, b, c. Modal: values, left, right, in the
 * order of their importance, with 1 or 2 states each. */
typedef struct {
    int count;
    double *a, *b, *c, *work;
    Complex *values, *left, *right;
    int *width, *order, *pivot;
} Basis;

/* Balanced realisation, the weak states replaced by their static response (singular perturbation); false where there is
 * no such model, or none that is stable. */
bool balanced_basis(const Measure *, Basis *, double *room);
bool balanced_model(const Measure *, const Basis *, int states, double *room, StateSpace *);

/* The modes that matter in the band, static and acceleration correction for the others; false where a pair would be
 * split. */
bool modal_basis(const Measure *, Basis *, double *room);
bool modal_model(const Measure *, const Basis *, int states, double *room, StateSpace *);

#endif
