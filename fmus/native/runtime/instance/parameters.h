/* What follows from the parameters. */
#ifndef TOWAGE_PARAMETERS_H
#define TOWAGE_PARAMETERS_H

#include "instance.h"

Outcome compute_constants(Instance *); /* all that follows from the parameters; refuses those that make no sense */
Outcome retune(Instance *);            /* tuned parameters; refused, the previous ones are in force again */
Outcome initialize(Instance *);        /* constants if they are stale, initial state and modes */

#endif
