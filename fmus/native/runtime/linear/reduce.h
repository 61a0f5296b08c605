/* The smallest model that is good enough: models/cable/lumped/reduction.py in C, the same methods and decisions. */
#ifndef TOWAGE_REDUCE_H
#define TOWAGE_REDUCE_H

#include "gains.h"

/* `model` becomes the smallest stable model whose error up to the unit's `band` is at most what the comparisons left of
 * its `tolerance`, its matrices in `room` (`reduced_size` doubles); it stays as it is where there is none. The error is
 * added to the unit's constant. Its rows are followed by n more, which give the state that it stands for: z = C z_r + D
 * v + E v'. */
size_t reduced_size(const StateSpace *full);
Outcome reduce(Instance *, StateSpace *model, double *room);

#endif
