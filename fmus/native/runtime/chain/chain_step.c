#include "chain_step.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "chain_limits.h"

static size_t size_of(const Chain *chain) { return (size_t)(chain->nodes * chain->dimensions); }

void chain_state_in(ChainState *state, double *vectors, int size)
{
    double **const parts[] = {&state->position, &state->velocity, &state->acceleration, state->made,
                              state->made + 1,  state->made + 2,  &state->before};
    for (size_t i = 0; i < sizeof parts / sizeof *parts; i++) *parts[i] = vectors + i * (size_t)size;
}

bool chain_stepper_begin(ChainStepper *stepper)
{
    const Chain *chain = &stepper->chain;
    const size_t n = size_of(chain), width = (size_t)chain_width(chain);
    double **const vectors[] = {stepper->kept,     stepper->kept + 1, stepper->kept + 2, &stepper->stage_r,
                                &stepper->stage_u, &stepper->stage_k, &stepper->base_r,  &stepper->base_u,
                                &stepper->guess,   &stepper->change};
    const size_t count = sizeof vectors / sizeof *vectors;
    double *block = calloc(n * (count + 2 * MOST_STAGES + 2 * width + 1 + (size_t)chain->dimensions), sizeof *block);
    if (!block) return false;
    for (size_t i = 0; i < count; i++, block += n) *vectors[i] = block;
    stepper->us = block;
    stepper->ks = stepper->us + n * MOST_STAGES;
    stepper->band = stepper->ks + n * MOST_STAGES;
    stepper->inertia = stepper->band + n * (2 * width + 1);
    return true;
}

void chain_stepper_end(ChainStepper *stepper) { free(stepper->kept[0]); /* the first part of the block */ }

/* Factors of the place `kept`. */
static bool factorise(ChainStepper *stepper)
{
    const Motion at = {stepper->kept[0], stepper->kept[1], stepper->kept[2]};
    chain_band(&stepper->chain, &at, stepper->kept_paid, stepper->kept_weight, stepper->band, stepper->inertia);
    stepper->factorisations++;
    stepper->factored = chain_factor(&stepper->chain, stepper->band);
    return stepper->factored;
}

static bool factorise_here(ChainStepper *stepper, double weight, const Drive *drive)
{
    const size_t bytes = size_of(&stepper->chain) * sizeof(double);
    memcpy(stepper->kept[0], stepper->stage_r, bytes);
    memcpy(stepper->kept[1], stepper->stage_u, bytes);
    memcpy(stepper->kept[2], stepper->stage_k, bytes);
    memcpy(stepper->kept_paid, drive->paid, sizeof drive->paid);
    stepper->kept_weight = weight;
    return factorise(stepper);
}

/* Whether the factors at hand are those that the state names. */
static bool same_place(const ChainStepper *stepper)
{
    const ChainState *state = &stepper->state;
    const size_t bytes = size_of(&stepper->chain) * sizeof(double);
    bool same = stepper->kept_weight == state->made_weight
                && memcmp(stepper->kept_paid, state->made_paid, sizeof state->made_paid) == 0;
    for (int i = 0; i < 3; i++) same = same && memcmp(stepper->kept[i], state->made[i], bytes) == 0;
    return same;
}

/* Brings the factors that the state names, where they serve a step with `weight`. */
static void recall(ChainStepper *stepper, double weight)
{
    const ChainState *state = &stepper->state;
    const size_t bytes = size_of(&stepper->chain) * sizeof(double);
    if (state->made_weight != weight) {
        stepper->factored = false;
    } else if (!stepper->factored || !same_place(stepper)) {
        for (int i = 0; i < 3; i++) memcpy(stepper->kept[i], state->made[i], bytes);
        memcpy(stepper->kept_paid, state->made_paid, sizeof state->made_paid);
        stepper->kept_weight = weight;
        factorise(stepper);
    }
}

/* Motion of a stage with accelerations stage_k; the ends where the drive has them. */
static void place(ChainStepper *stepper, double weight, const Drive *drive)
{
    const Chain *chain = &stepper->chain;
    const int d = chain->dimensions, n = chain->nodes * d;
    double *r = stepper->stage_r, *u = stepper->stage_u, *k = stepper->stage_k;
    for (int i = 0; i < n; i++) {
        u[i] = stepper->base_u[i] + weight * k[i];
        r[i] = stepper->base_r[i] + weight * u[i];
    }
    for (int c = 0; c < d; c++) {
        r[n - d + c] = drive->top[0][c];
        u[n - d + c] = drive->top[1][c];
        k[n - d + c] = drive->top[2][c];
        if (chain->held) {
            r[c] = drive->lower[0][c];
            u[c] = drive->lower[1][c];
            k[c] = drive->lower[2][c];
        }
    }
}

static double largest(const double *x, int n)
{
    double size = 0.0;
    for (int i = 0; i < n; i++) {
        const double one = fabs(x[i]);
        if (!(one <= size)) size = one;
    }
    return size;
}

/* Newton's method from `guess`; false: it does not converge. */
static bool solve_stage(ChainStepper *stepper, double weight, const Drive *drive)
{
    const Chain *chain = &stepper->chain;
    const int n = chain->nodes * chain->dimensions;
    const double target = CHAIN_NEWTON * stepper->tolerance;
    const Motion at = {stepper->stage_r, stepper->stage_u, stepper->stage_k};
    double last = INFINITY;
    bool again = false;
    memcpy(stepper->stage_k, stepper->guess, (size_t)n * sizeof(double));
    for (int iteration = 0; iteration < CHAIN_MAX_ITERATIONS; iteration++) {
        place(stepper, weight, drive);
        if (!stepper->factored && !factorise_here(stepper, weight, drive)) return false;
        chain_needed(chain, &at, drive, stepper->change);
        stepper->evaluations++;
        chain_solve(chain, stepper->band, stepper->change);
        const double size = weight * largest(stepper->change, n), rate = size / last;
        if (!(size < CHAIN_RUNAWAY) || rate > CHAIN_DIVERGING) {
            if (again) return false;
            memcpy(stepper->stage_k, stepper->guess, (size_t)n * sizeof(double));
            last = INFINITY;
            stepper->factored = false;
            again = true;
            continue;
        }
        for (int i = 0; i < n; i++) stepper->stage_k[i] -= stepper->change[i];
        const double left = last == INFINITY ? 0.1 : rate < 0.5 ? rate / (1.0 - rate) : 1.0;
        if (size * left < target) {
            place(stepper, weight, drive);
            return true;
        }
        const bool slow = rate > CHAIN_SLOW && last < INFINITY;
        stepper->factored = !slow;
        last = slow ? INFINITY : size;
    }
    return false;
}

/* First guess of a stage: the polynomial through the last accelerations that are known, at `where` of the step. */
static void extrapolate(ChainStepper *stepper, int stage, double step, double where)
{
    const int n = stepper->chain.nodes * stepper->chain.dimensions;
    const ChainState *state = &stepper->state;
    double places[3];
    const double *values[3];
    int count = 0;
    for (int s = stage; s >= -1 && count < 3; s--) {
        if (s < 0 && !(state->before_step > 0.0)) break;
        places[count] = s < 0 ? -state->before_step / step : s == 0 ? 0.0 : stepper->tableau->places[s - 1];
        values[count++] = s < 0 ? state->before : stepper->ks + s * n;
    }
    memset(stepper->guess, 0, (size_t)n * sizeof(double));
    for (int j = 0; j < count; j++) {
        double share = 1.0;
        for (int i = 0; i < count; i++) {
            if (i != j) share *= (where - places[i]) / (places[j] - places[i]);
        }
        for (int i = 0; i < n; i++) stepper->guess[i] += share * values[j][i];
    }
}

/* Error of the velocities over the tolerance, through inertia and factors. */
static double error_of(ChainStepper *stepper, double step)
{
    const Chain *chain = &stepper->chain;
    const int d = chain->dimensions, n = chain->nodes * d;
    double *raw = stepper->guess, *x = stepper->change;
    memset(raw, 0, (size_t)n * sizeof(double));
    for (int s = 0; s <= stepper->tableau->stages; s++) {
        const double weight = step * stepper->tableau->error[s];
        for (int i = 0; i < n; i++) raw[i] += weight * stepper->ks[s * n + i];
    }
    for (int node = 0; node < chain->nodes; node++) {
        const double *block = stepper->inertia + node * d * d;
        for (int a = 0; a < d; a++) {
            double sum = 0.0;
            for (int c = 0; c < d; c++) sum += block[c * d + a] * raw[node * d + c];
            x[node * d + a] = sum;
        }
    }
    chain_solve(chain, stepper->band, x);
    return largest(x, n) / stepper->tolerance;
}

/* Tries a step; stages in us and ks; the error over the tolerance, negative: a stage failed. */
static double attempt(ChainStepper *stepper, double t, double step)
{
    const ChainTableau *table = stepper->tableau;
    const int n = stepper->chain.nodes * stepper->chain.dimensions;
    const size_t bytes = (size_t)n * sizeof(double);
    const ChainState *state = &stepper->state;
    const double weight = table->diagonal * step;
    recall(stepper, weight);
    memcpy(stepper->us, state->velocity, bytes);
    memcpy(stepper->ks, state->acceleration, bytes);
    for (int s = 1; s <= table->stages; s++) {
        const double *row = table->rows + (s - 1) * MOST_STAGES;
        Drive drive;
        memcpy(stepper->base_r, state->position, bytes);
        memcpy(stepper->base_u, state->velocity, bytes);
        for (int j = 0; j < s; j++) {
            const double share = step * row[j];
            for (int i = 0; i < n; i++) {
                stepper->base_r[i] += share * stepper->us[j * n + i];
                stepper->base_u[i] += share * stepper->ks[j * n + i];
            }
        }
        extrapolate(stepper, s - 1, step, table->places[s - 1]);
        memset(&drive, 0, sizeof drive);
        stepper->motion(stepper->data, t + table->places[s - 1] * step, &drive);
        /* a held top has no wire to give */
        stepper->hauled = stepper->chain.last + drive.paid[0] <= CHAIN_HAULED * stepper->chain.last;
        if (stepper->hauled || !solve_stage(stepper, weight, &drive)) return -1.0;
        memcpy(stepper->us + s * n, stepper->stage_u, bytes);
        memcpy(stepper->ks + s * n, stepper->stage_k, bytes);
    }
    return error_of(stepper, step);
}

double chain_step(ChainStepper *stepper, double t, double step)
{
    const size_t bytes = size_of(&stepper->chain) * sizeof(double);
    const long factorised = stepper->factorisations;
    ChainState *state = &stepper->state;
    double most = CHAIN_MOST;
    stepper->hauled = false;
    for (int k = 0; k < CHAIN_MAX_HALVINGS && !stepper->hauled; k++) {
        const double error = attempt(stepper, t, step);
        if (!(error >= 0.0)) {
            stepper->failures++;
            most = 1.0;
            step *= 0.5;
            continue;
        }
        double grow = CHAIN_SAFETY * pow(fmax(error, CHAIN_NO_ERROR), -1.0 / stepper->tableau->order);
        if (error > 1.0) {
            stepper->rejections++;
            step *= fmin(CHAIN_LESS, fmax(CHAIN_LEAST, grow));
            continue;
        }
        stepper->steps++;
        if (stepper->factorisations > factorised + stepper->tableau->stages) most = 1.0;
        memcpy(state->before, state->acceleration, bytes);
        memcpy(state->position, stepper->stage_r, bytes);
        memcpy(state->velocity, stepper->stage_u, bytes);
        memcpy(state->acceleration, stepper->stage_k, bytes);
        for (int i = 0; i < 3; i++) memcpy(state->made[i], stepper->kept[i], bytes);
        memcpy(state->made_paid, stepper->kept_paid, sizeof state->made_paid);
        state->made_weight = stepper->kept_weight;
        state->before_step = step;
        state->step = step * fmin(most, grow);
        return step;
    }
    stepper->failed_at = t;
    stepper->failed_step = step;
    return 0.0;
}

bool chain_advance(ChainStepper *stepper, double t, double span)
{
    ChainState *state = &stepper->state;
    double done = 0.0, reached = 0.0;
    long counted = 0;
    while (done < span * (1.0 - CHAIN_END)) {
        const double left = span - done, before = state->step;
        const double asked = fmin(before > 0.0 ? before : 0.1 * left, stepper->largest);
        /* equal steps to the end, so that factors are kept */
        const double first = left / ceil(left / asked - CHAIN_ROUNDING), step = chain_step(stepper, t + done, first);
        if (!(step > 0.0)) return false;
        done += step;
        if (++counted % CHAIN_PATIENCE == 0) { /* steps that lead nowhere */
            if (done - reached < CHAIN_PROGRESS * span) {
                stepper->failed_at = t + done;
                stepper->failed_step = step;
                return false;
            }
            reached = done;
        }
        double wanted = fmin(state->step, stepper->largest);
        if (wanted >= step) wanted = step < asked ? fmax(before, wanted) : wanted > CHAIN_WORTH * step ? wanted : step;
        state->step = wanted;
    }
    return true;
}
