/* Dormand and Prince's method of order 5(4), as models/numeric/tableaus.py has it, with cubics between its steps: the
 * accuracy asked of a step makes them exact to far below what a mesh is chosen by. */
#include "chain_march.h"
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "chain_limits.h"
#include "chain_marching.h"

/* Of a step, relative; cubics between steps then err by 1e-8 or less. */
#define TOLERANCE 1e-10
enum { MOST_STEPS = 200000 }; /* of a section */

/* A wire on its way up: what it is made of here, and its velocity. */
typedef struct {
    const Chain *chain;
    const double *velocity;
    int piece;
} March;

/* d/ds of place and pull: dr/ds = g(n), dn/ds = q. */
static void slopes_at(const March *march, const double *y, double *slope)
{
    const Chain *chain = march->chain;
    const int d = chain->dimensions;
    const double *material = chain->material + march->piece * POINT_MATERIAL, *n = y + d;
    double v[MOST_DIMENSIONS], g[MOST_DIMENSIONS], unused[MOST_DIMENSIONS], tension = 0.0;
    const double zero[MOST_DIMENSIONS] = {0.0};
    const double *arguments[] = {g, zero, v, zero, material};
    double *results[] = {unused, slope + d};
    for (int c = 0; c < d; c++) tension += n[c] * n[c];
    const double factor = 1.0 / (sqrt(tension) + CHAIN_NO_TENSION) + 1.0 / material[0];
    chain_flow(chain, y[d - 1], v, NULL);
    for (int c = 0; c < d; c++) {
        v[c] = march->velocity[c] - v[c];
        slope[c] = g[c] = factor * n[c];
    }
    chain->loads(arguments, results, NULL, chain->work, 0);
}

static bool record(ChainShape *shape, double s, const double *y, const double *slope)
{
    if (shape->count == shape->room) {
        const int room = 2 * shape->room + 64;
        MarchPlace *place = realloc(shape->place, (size_t)room * sizeof *place);
        if (!place) return false;
        shape->place = place;
        shape->room = room;
    }
    MarchPlace *next = shape->place + shape->count++;
    next->s = s;
    memcpy(next->y, y, sizeof next->y);
    memcpy(next->slope, slope, sizeof next->slope);
    return true;
}

/* A step of length h from y with its slope; the end and its slope, the error over the tolerance. */
static double try_step(const March *march, double h, const double *size, const double *y, const double *slope,
                       double *end, double *end_slope)
{
    const int n = 2 * march->chain->dimensions;
    double k[MARCH_STAGES][MARCH_SIZE], error = 0.0;
    memcpy(k[0], slope, sizeof k[0]);
    for (int stage = 1; stage < MARCH_STAGES; stage++) {
        for (int i = 0; i < n; i++) {
            double sum = 0.0;
            for (int j = 0; j < stage; j++) sum += MARCH_ROWS[stage - 1][j] * k[j][i];
            end[i] = y[i] + h * sum;
        }
        slopes_at(march, end, k[stage]);
    }
    memcpy(end_slope, k[MARCH_STAGES - 1], sizeof k[0]);
    for (int i = 0; i < n; i++) {
        double sum = 0.0;
        for (int j = 0; j < MARCH_STAGES; j++) sum += MARCH_ERROR[j] * k[j][i];
        const double one = fabs(h * sum) / (size[i] + TOLERANCE * fmax(fabs(y[i]), fabs(end[i])));
        if (!(one <= error)) error = one;
    }
    return error;
}

/* Through one piece, from y at s to its end. */
static bool through(const March *march, double length, double *s, double *y, ChainShape *shape)
{
    const Chain *chain = march->chain;
    const int d = chain->dimensions;
    const double begin = *s, own = 2.0 * chain->half[march->piece];
    const double weight = chain->material[march->piece * POINT_MATERIAL + CHAIN_WEIGHT];
    double slope[MARCH_SIZE] = {0.0}, end[MARCH_SIZE] = {0.0}, end_slope[MARCH_SIZE] = {0.0}, size[MARCH_SIZE];
    double pull = fabs(weight) * own + 1.0, h = own / 1024.0, done = 0.0;
    for (int c = 0; c < d; c++) pull += fabs(y[d + c]);
    for (int c = 0; c < d; c++) {
        size[c] = TOLERANCE / 1024.0 * length;
        size[d + c] = TOLERANCE / 1024.0 * pull;
    }
    slopes_at(march, y, slope);
    if (!record(shape, begin, y, slope)) return false;
    for (int step = 0; step < MOST_STEPS; step++) {
        const bool last = h >= (own - done) * (1.0 - CHAIN_END);
        const double taken = last ? own - done : h;
        const double error = try_step(march, taken, size, y, slope, end, end_slope);
        const double grow = error < 1e30 ? CHAIN_SAFETY * pow(fmax(error, CHAIN_NO_ERROR), -0.2) : CHAIN_LEAST;
        shape->reached = begin + done;
        if (error <= 1.0) {
            done += taken;
            memcpy(y, end, sizeof end);
            memcpy(slope, end_slope, sizeof slope);
            *s = last ? begin + own : begin + done;
            if (!record(shape, *s, y, slope)) return false;
            if (last) return true;
        }
        h = taken * fmin(CHAIN_MOST, fmax(CHAIN_LEAST, grow));
        if (!(h > DBL_EPSILON * own)) return false;
    }
    return false;
}

/* From `start` up; y at the top. */
static bool march_up(March *march, const double *start, double length, double *y, ChainShape *shape)
{
    const Chain *chain = march->chain;
    const int d = chain->dimensions;
    const double zero[MOST_DIMENSIONS] = {0.0};
    double s = 0.0;
    int next = 0;
    memset(y, 0, MARCH_SIZE * sizeof *y);
    memcpy(y, start, (size_t)d * sizeof *y);
    shape->count = 0;
    for (int k = 0; k < chain->elements; k++) {
        while (next < chain->fixtures && chain->fixture_node[next] == k * chain->degree)
            chain_fixture(chain, next++, y, march->velocity, zero, y + d);
        march->piece = k;
        shape->first[k] = shape->count;
        if (!through(march, length, &s, y, shape)) return false;
    }
    shape->first[chain->elements] = shape->count;
    return true;
}

bool chain_march(const Chain *wire, const double *velocity, ChainShape *shape)
{
    const int d = wire->dimensions;
    March march = {wire, velocity, 0};
    double start[MOST_DIMENSIONS] = {0.0}, length = 0.0;
    memset(shape, 0, sizeof *shape);
    shape->dimensions = d;
    shape->pieces = wire->elements;
    shape->first = calloc((size_t)wire->elements + 1, sizeof *shape->first);
    if (!shape->first || wire->held) return false;
    for (int k = 0; k < wire->elements; k++) length += 2.0 * wire->half[k];
    for (int pass = 0; pass < CHAIN_MAX_MARCHES; pass++) {
        double y[MARCH_SIZE], missed = 0.0;
        if (!march_up(&march, start, length, y, shape)) return false;
        for (int c = 0; c < d; c++) missed = fmax(missed, fabs(y[c]));
        if (wire->levels < 2 || missed < CHAIN_MARCHED * length || pass + 1 == CHAIN_MAX_MARCHES) {
            for (int i = 0; i < shape->count; i++)
                for (int c = 0; c < d; c++) shape->place[i].y[c] -= y[c];
            break;
        }
        for (int c = 0; c < d; c++) start[c] -= y[c];
    }
    return true;
}

void chain_shape_end(ChainShape *shape)
{
    free(shape->place);
    free(shape->first);
}

void chain_shape_at(const ChainShape *shape, int piece, double s, double *y)
{
    int low = piece < 0 ? 0 : shape->first[piece], high = (piece < 0 ? shape->count : shape->first[piece + 1]) - 1;
    while (high - low > 1) {
        const int middle = (low + high) / 2;
        if (shape->place[middle].s <= s)
            low = middle;
        else
            high = middle;
    }
    const MarchPlace *a = shape->place + low, *b = shape->place + high;
    const double h = b->s - a->s, x = h > 0.0 ? fmin(1.0, fmax(0.0, (s - a->s) / h)) : 0.0, e = 1.0 - x;
    for (int i = 0; i < 2 * shape->dimensions; i++)
        y[i] = e * e * (1.0 + 2.0 * x) * a->y[i] + x * x * (3.0 - 2.0 * x) * b->y[i]
               + h * x * e * (e * a->slope[i] - x * b->slope[i]);
}
