/* The steady state of a chain with a body, in a frame that moves straight on: models/cable/wire/rest.py in C. */
#ifndef TOWAGE_CHAIN_REST_H
#define TOWAGE_CHAIN_REST_H

#include "chain_march.h"
#include "chain_step.h"

/* Puts the stepper's state into the equilibrium of a tow with `velocity`, m/s, the top at zero, from the shape that was
 * marched; false: it was not found. */
bool chain_rest(ChainStepper *stepper, const double *velocity, const ChainShape *shape);

#endif
