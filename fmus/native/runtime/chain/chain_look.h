/* What is read off a chain in motion, and how that changes: loads at points and on what is fixed to the wire, needed
 * forces, pulls, the error of the shape. Arrays at points: p + 1 an element, `dimensions` components each. */
#ifndef TOWAGE_CHAIN_LOOK_H
#define TOWAGE_CHAIN_LOOK_H

#include "chain.h"

/* Pull and load of an element's half length, N, at points. */
void chain_loads(const Chain *chain, const Motion *at, const double *paid, double *n, double *q);

/* Their changes for a small change of the motion and of the wire paid out. */
void chain_loads_change(const Chain *chain, const Motion *at, const double *paid, const Motion *delta,
                        const double *paid_change, double *n, double *q);

/* Resisting loads on what is fixed to the wire, N, one vector each; the force on the body belongs to the first. */
void chain_fixture_loads(const Chain *chain, const Motion *at, const double *force, double *loads);
void chain_fixture_loads_change(const Chain *chain, const Motion *at, const Motion *delta, const double *force_change,
                                double *loads);

/* Forces that the nodes need, N, from loads at points and on what is fixed; linear, and so its own change. */
void chain_gather(const Chain *chain, const double *n, const double *q, const double *fixtures, double *needed);

/* Pulls at points, N, by the balance dn/ds = q from the body on, or from what a held lower end needs; likewise linear.
 */
void chain_pulls(const Chain *chain, const double *q, const double *fixtures, const double *needed, double *pulls);

/* Curvature squared, 1/m2, and speed of the water across the wire, m/s, at a point, and their change. */
void chain_bent(const Chain *chain, int point, const Motion *at, const double *paid, double bent[2]);
void chain_bent_change(const Chain *chain, int point, const Motion *at, const double *paid, const Motion *delta,
                       const double *paid_change, double bent[2]);

/* Error of positions by the elements over the length, and its change for changes dr, dpaid where `delta` is given. */
double chain_shape_error(const Chain *chain, const double *r, double paid, const double *dr, double dpaid,
                         double *delta);

#endif
