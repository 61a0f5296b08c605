/* LANES members on their way: where each stands, and what it is to find and to keep. */
#ifndef BLOCK_H
#define BLOCK_H

#include "model.h"

enum { DONE, NO_STEP, TOO_MANY, NOT_FINITE }; /* status: what ended a member */

typedef struct {
    long count, chosen; /* times; series */
    const double *times;
    const long *columns; /* of the series */
    double rtol, longest;
} Task;

typedef struct {
    double *series, *low, *high; /* of the block's first member */
    long *status;
    double *when;
    int used; /* lanes that hold a member of their own */
} Sink;

typedef struct {
    V c[NC + 1], t, h, x[NX], m[NM + 1], f[NX], g[NG + 1];
    V target, due, cut, least, tries, since, low[NY], high[NY];
    I active;
    long place[LANES];
    const Task *task;
    Sink sink;
} Block;

/* The lanes ``which`` end here. */
static void stop(Block *b, I which, long status)
{
    EACH (l)
        if (which[l] && b->active[l]) {
            b->active[l] = 0;
            if (l < b->sink.used) {
                b->sink.status[l] = status;
                b->sink.when[l] = b->t[l];
            }
        }
}

#endif
