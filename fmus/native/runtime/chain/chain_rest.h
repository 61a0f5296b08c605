/* The steady state of a chain with a body: models/cable/wire/rest.py in C, for a tow that moves straight on or hangs.
 */
#ifndef TOWAGE_CHAIN_REST_H
#define TOWAGE_CHAIN_REST_H

#include "chain_step.h"

/* Puts the stepper's state into the equilibrium of a tow with `velocity`, m/s, the top at zero; false: it was not
 * found. */
bool chain_rest(ChainStepper *stepper, const double *velocity);

#endif
