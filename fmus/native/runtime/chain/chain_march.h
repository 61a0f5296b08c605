/* The steady shape of a wire, marched up from its body: models/cable/wire/rest.py's `march` in C. */
#ifndef TOWAGE_CHAIN_MARCH_H
#define TOWAGE_CHAIN_MARCH_H

#include "chain.h"

enum { MARCH_SIZE = 2 * MOST_DIMENSIONS };

/* Place and pull (r, n) with their slopes over s, at places s that ascend; those of piece k begin at first[k]. */
typedef struct {
    double s, y[MARCH_SIZE], slope[MARCH_SIZE];
} MarchPlace;

typedef struct {
    MarchPlace *place;
    int count, room, pieces, dimensions;
    int *first;
    double reached; /* m from the lower end, where the march ended */
} ChainShape;

/* The shape of a wire whose elements are its pieces, in water that moves past it with `velocity`, the top at zero;
 * false: no memory, or it was not found beyond shape->reached. */
bool chain_march(const Chain *wire, const double *velocity, ChainShape *shape);
void chain_shape_end(ChainShape *shape);

/* (r, n) at s, m, of a piece; of all of them for -1. */
void chain_shape_at(const ChainShape *shape, int piece, double s, double *y);

#endif
