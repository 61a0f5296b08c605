#include "chain_rest.h"
#include <math.h>
#include <string.h>

#include "chain_limits.h"

/* Sum of squares of the forces that free nodes lack, N2; the forces themselves in stepper->change. */
static double unbalance(ChainStepper *stepper, const double *r)
{
    const Chain *chain = &stepper->chain;
    const int n = (chain->nodes - 1) * chain->dimensions;
    double sum = 0.0;
    Drive drive;
    memset(&drive, 0, sizeof drive);
    const Motion at = {r, stepper->state.velocity, stepper->state.acceleration};
    chain_needed(chain, &at, &drive, stepper->change);
    for (int i = 0; i < n; i++) sum += stepper->change[i] * stepper->change[i];
    return sum;
}

/* Newton's method on the forces of the nodes: with w large, M + w C + w^2 K is w^2 K. Where it goes astray, w is a
 * short time of motion that dies out at once, and grows again. */
static bool settle(ChainStepper *stepper, double length)
{
    const Chain *chain = &stepper->chain;
    const int n = chain->nodes * chain->dimensions;
    const double longest = 1e6, nothing_paid[3] = {0.0};
    ChainState *state = &stepper->state;
    double w = longest, *trial = stepper->guess;
    for (int k = 0; k < CHAIN_MAX_NEWTON; k++) {
        double moved = 0.0;
        const double before = unbalance(stepper, state->position);
        const Motion at = {state->position, state->velocity, state->acceleration};
        chain_band(chain, &at, nothing_paid, w, stepper->band, stepper->inertia);
        const bool factored = chain_factor(chain, stepper->band);
        chain_solve(chain, stepper->band, stepper->change);
        for (int i = 0; i < n; i++) {
            const double move = w * w * stepper->change[i];
            trial[i] = state->position[i] - move;
            moved = fmax(moved, fabs(move));
        }
        const double growth = unbalance(stepper, trial) / before;
        if (!(factored && moved < CHAIN_FAR * length
              && (growth < (w < longest ? 4.0 : 1.0) || moved < CHAIN_ARRIVED * length))) {
            w = w < longest ? CHAIN_SHORTER * w : CHAIN_FIRST_TIME;
            if (w < CHAIN_SHORTEST) return false;
            continue;
        }
        memcpy(state->position, trial, (size_t)n * sizeof *trial);
        if (w == longest && moved < CHAIN_TOLERANCE * length) return true;
        w *= fmin(10.0, fmax(1.5, 1.0 / sqrt(growth)));
        if (!(w < 1e4)) w = longest;
    }
    return false;
}

bool chain_rest(ChainStepper *stepper, const double *velocity, const ChainShape *shape)
{
    const Chain *chain = &stepper->chain;
    const int d = chain->dimensions, n = chain->nodes * d;
    ChainState *state = &stepper->state;
    double low = 0.0;
    for (int e = 0; e < chain->elements; e++) {
        for (int q = 0; q <= chain->degree; q++) {
            double y[MARCH_SIZE];
            chain_shape_at(shape, -1, low + chain->half[e] * (chain->rule->points[q] + 1.0), y);
            memcpy(state->position + (e * chain->degree + q) * d, y, (size_t)d * sizeof *y);
        }
        low += 2.0 * chain->half[e];
    }
    memset(state->position + n - d, 0, (size_t)d * sizeof(double));
    memset(state->acceleration, 0, (size_t)n * sizeof(double));
    for (int i = 0; i < n; i++) state->velocity[i] = velocity[i % d];
    stepper->factored = false;
    state->made_weight = state->before_step = state->step = 0.0;
    return settle(stepper, low);
}
