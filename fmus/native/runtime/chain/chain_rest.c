#include "chain_rest.h"
#include <math.h>
#include <string.h>

#include "chain_limits.h"

enum { SUBSTEPS = 16, SIZE = 2 * MOST_DIMENSIONS };

/* A wire on its way up: what it is made of here, and its velocity. */
typedef struct {
    const Chain *chain;
    const double *velocity;
    int element;
} March;

/* d/ds of place and pull: dr/ds = g(n), dn/ds = q. */
static void slopes_at(const March *march, const double *y, double *slope)
{
    const Chain *chain = march->chain;
    const int d = chain->dimensions;
    const double *material = chain->material + march->element * POINT_MATERIAL, *n = y + d;
    double v[MOST_DIMENSIONS], unused[MOST_DIMENSIONS], tension = 0.0;
    const double zero[MOST_DIMENSIONS] = {0.0};
    const double *arguments[] = {slope, zero, v, zero, material};
    double *results[] = {unused, slope + d};
    for (int c = 0; c < d; c++) tension += n[c] * n[c];
    const double factor = 1.0 / sqrt(tension) + 1.0 / material[0];
    chain_flow(chain, y[d - 1], v, NULL);
    for (int c = 0; c < d; c++) {
        v[c] = march->velocity[c] - v[c];
        slope[c] = factor * n[c];
    }
    chain->loads(arguments, results, NULL, chain->work, 0);
}

/* One step of the classical method of Runge and Kutta. */
static void march_step(const March *march, double h, double *y)
{
    static const double shares[] = {0.0, 0.5, 0.5, 1.0}, weights[] = {1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0};
    const int size = 2 * march->chain->dimensions;
    double slope[SIZE] = {0.0}, total[SIZE] = {0.0}, there[SIZE];
    for (int stage = 0; stage < 4; stage++) {
        for (int i = 0; i < size; i++) there[i] = y[i] + shares[stage] * h * slope[i];
        slopes_at(march, there, slope);
        for (int i = 0; i < size; i++) total[i] += weights[stage] * slope[i];
    }
    for (int i = 0; i < size; i++) y[i] += h * total[i];
}

/* Nodes from `start` up; y ends at the top. */
static void march_up(March *march, const double *points, double *nodes, double *y)
{
    const Chain *chain = march->chain;
    const int d = chain->dimensions, p = chain->degree;
    const double zero[MOST_DIMENSIONS] = {0.0};
    int next = 0;
    for (int node = 0; node < chain->nodes; node++) {
        memcpy(nodes + node * d, y, (size_t)d * sizeof *y);
        while (next < chain->fixtures && chain->fixture_node[next] == node) {
            chain_fixture(chain, next++, y, march->velocity, zero, y + d);
        }
        if (node == chain->nodes - 1) return;
        march->element = node / p;
        const double h = chain->half[march->element] * (points[node % p + 1] - points[node % p]) / SUBSTEPS;
        for (int k = 0; k < SUBSTEPS; k++) march_step(march, h, y);
    }
}

/* Sum of squares of the forces that free nodes lack, N2; the forces themselves in stepper->change. */
static double unbalance(ChainStepper *stepper, const double *r)
{
    const Chain *chain = &stepper->chain;
    const int n = (chain->nodes - 1) * chain->dimensions;
    double sum = 0.0;
    Drive drive;
    memset(&drive, 0, sizeof drive);
    chain_needed(chain, r, stepper->state.velocity, stepper->state.acceleration, &drive, stepper->change);
    for (int i = 0; i < n; i++) sum += stepper->change[i] * stepper->change[i];
    return sum;
}

/* Newton's method on the forces of the nodes: with w large, M + w C + w^2 K is w^2 K. Where it goes astray, w is a
 * short time of motion that dies out at once, and grows again. */
static bool settle(ChainStepper *stepper, double length)
{
    const Chain *chain = &stepper->chain;
    const int n = chain->nodes * chain->dimensions;
    const double longest = 1e6;
    ChainState *state = &stepper->state;
    double w = longest, *trial = stepper->guess;
    for (int k = 0; k < CHAIN_MAX_NEWTON; k++) {
        double moved = 0.0;
        const double before = unbalance(stepper, state->position);
        chain_band(chain, state->position, state->velocity, state->acceleration, w, stepper->band, stepper->inertia);
        if (!chain_factor(chain, stepper->band)) return false;
        chain_solve(chain, stepper->band, stepper->change);
        for (int i = 0; i < n; i++) {
            const double move = w * w * stepper->change[i];
            trial[i] = state->position[i] - move;
            moved = fmax(moved, fabs(move));
        }
        const double growth = unbalance(stepper, trial) / before;
        if (!(moved < CHAIN_FAR * length && (growth < (w < longest ? 4.0 : 1.0) || moved < CHAIN_ARRIVED * length))) {
            w = w < longest ? CHAIN_SHORTER * w : CHAIN_FIRST_TIME;
            continue;
        }
        memcpy(state->position, trial, (size_t)n * sizeof *trial);
        if (w == longest && moved < CHAIN_TOLERANCE * length) return true;
        w = w > 1e4 ? longest : 10.0 * w;
    }
    return false;
}

bool chain_rest(ChainStepper *stepper, const double *velocity)
{
    const Chain *chain = &stepper->chain;
    const int d = chain->dimensions, n = chain->nodes * d;
    ChainState *state = &stepper->state;
    March march = {chain, velocity, 0};
    double start[MOST_DIMENSIONS] = {0.0}, length = 0.0, missed = INFINITY;
    if (chain->held) return false;
    for (int e = 0; e < chain->elements; e++) length += 2.0 * chain->half[e];
    for (int pass = 0; pass < CHAIN_MAX_MARCHES && missed > CHAIN_MARCHED * length; pass++) {
        double y[SIZE] = {0.0};
        memcpy(y, start, (size_t)d * sizeof *y);
        march_up(&march, chain->points, state->position, y);
        for (int i = 0; i < n; i++) state->position[i] -= y[i % d];
        missed = 0.0;
        for (int c = 0; c < d; c++) {
            missed = fmax(missed, fabs(y[c]));
            start[c] -= y[c];
        }
        if (chain->levels < 2) break;
    }
    memset(state->acceleration, 0, (size_t)n * sizeof(double));
    for (int i = 0; i < n; i++) state->velocity[i] = velocity[i % d];
    stepper->factored = false;
    state->made_weight = 0.0;
    return settle(stepper, length);
}
