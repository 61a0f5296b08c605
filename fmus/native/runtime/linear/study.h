/* What is found out about a linear unit at its start. */
#ifndef TOWAGE_STUDY_H
#define TOWAGE_STUDY_H

#include "instance.h"

/* Errors of the comparisons, added to their constants. */
Outcome compare(Instance *);
/* The constant of the unit's `resolution`. */
Outcome resolve(Instance *);

#endif
