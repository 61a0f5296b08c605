/* Gains of a linear unit over a band of frequencies, and the errors that they show.
 *
 * The measure of errors is that of models/cable/lumped/reduction.py: for every frequency and input, the largest
 * difference in a pair of rows of y (force on the towpoint; velocity of the body, or force on it) over the largest gain
 * of the pair. */
#ifndef TOWAGE_GAINS_H
#define TOWAGE_GAINS_H

#include "eigen.h"
#include "instance.h"
#include "state_space.h"

enum { COMPARED = 4 }; /* rows of y, two pairs */

int counted_inputs(const Instance *);              /* the first of v that count in errors */
void band_frequencies(double band, double *omega); /* FREQUENCIES of them, evenly spaced in their logarithm */
/* Gains of the compared rows by the first inputs: values[(frequency * inputs + input) * COMPARED + row]. False: no
 * memory. */
bool gains(const StateSpace *, const double *omega, int inputs, Complex *values);
double relative_error(const Complex *values, const Complex *reference, int inputs);

#endif
