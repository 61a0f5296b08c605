#include "chain_look.h"
#include <math.h>
#include <string.h>

enum { MOST_POINTS = MOST_DEGREE + 1 };

void chain_loads(const Chain *chain, const Motion *at, const double *paid, double *n, double *q)
{
    const int d = chain->dimensions, points = chain->degree + 1;
    for (int k = 0; k < chain->elements * points; k++) {
        double *results[] = {n + k * d, q + k * d};
        Point point;
        chain_point(chain, k / points, k % points, at, paid, &point);
        chain->loads(point.arguments, results, NULL, chain->work, 0);
        for (int c = 0; c < d; c++) q[k * d + c] *= point.half;
    }
}

/* Derivative over the element's own coordinate, twice where `again` is given, of values at its nodes. */
static void differentiate(const Chain *chain, const double *x, int q, double *slope, double *again)
{
    const int d = chain->dimensions, points = chain->degree + 1;
    const double *slopes = chain->rule->slopes;
    for (int c = 0; c < d; c++) {
        slope[c] = 0.0;
        if (again) again[c] = 0.0;
        for (int j = 0; j < points; j++) {
            slope[c] += slopes[q * points + j] * x[j * d + c];
            for (int k = 0; again && k < points; k++)
                again[c] += slopes[q * points + j] * slopes[j * points + k] * x[k * d + c];
        }
    }
}

/* What the traced function of a moment takes: slopes of r and u, the second one of r, u, b, water. */
typedef struct {
    double by[6][MOST_DIMENSIONS];
} Gathered;

static void gather_point(const Chain *chain, int element, int q, const Motion *at, Gathered *got)
{
    const int d = chain->dimensions, first = element * chain->degree * d;
    differentiate(chain, at->r + first, q, got->by[0], got->by[2]);
    differentiate(chain, at->u + first, q, got->by[1], NULL);
    memcpy(got->by[3], at->u + first + q * d, (size_t)d * sizeof(double));
    memcpy(got->by[4], at->b + first + q * d, (size_t)d * sizeof(double));
}

/* A point with its water and, where there is a `delta`, its change. `place`: four numbers. */
static void gather_all(const Chain *chain, int k, const Motion *at, const Motion *delta, Gathered *value,
                       Gathered *seed, double *place)
{
    const int d = chain->dimensions, points = chain->degree + 1, element = k / points;
    const int height = (element * chain->degree + k % points) * d + d - 1;
    double slope[MOST_DIMENSIONS];
    gather_point(chain, element, k % points, at, value);
    chain_flow(chain, at->r[height], value->by[5], slope);
    place[0] = chain->half[element];
    place[1] = chain->share[k];
    place[2] = element < chain->growing ? 0.0 : 1.0;
    place[3] = chain->last;
    if (!delta) return;
    gather_point(chain, element, k % points, delta, seed);
    for (int c = 0; c < d; c++) seed->by[5][c] = slope[c] * delta->r[height];
}

void chain_loads_change(const Chain *chain, const Motion *at, const double *paid, const Motion *delta,
                        const double *paid_change, double *n, double *q)
{
    const int d = chain->dimensions, points = chain->degree + 1;
    for (int k = 0; k < chain->elements * points; k++) {
        const int element = k / points;
        double place[4];
        Gathered value, seed;
        gather_all(chain, k, at, delta, &value, &seed, place);
        const double *arguments[2 * 9 + 2] = {
            value.by[0], value.by[1], value.by[2],
            value.by[3], value.by[4], value.by[5],
            paid,        place,       chain->material + element * POINT_MATERIAL,
            NULL,        NULL,        seed.by[0],
            seed.by[1],  seed.by[2],  seed.by[3],
            seed.by[4],  seed.by[5],  paid_change,
            NULL,        NULL,
        };
        double *results[] = {n + k * d, q + k * d};
        chain->change(arguments, results, NULL, chain->work, 0);
    }
}

void chain_bent(const Chain *chain, int point, const Motion *at, const double *paid, double bent[2])
{
    double place[4];
    Gathered value;
    gather_all(chain, point, at, NULL, &value, NULL, place);
    const double *arguments[] = {value.by[0], value.by[2], value.by[3], value.by[5], paid, place};
    double *results[] = {bent};
    chain->bent(arguments, results, NULL, chain->work, 0);
}

void chain_bent_change(const Chain *chain, int point, const Motion *at, const double *paid, const Motion *delta,
                       const double *paid_change, double bent[2])
{
    double place[4];
    Gathered value, seed;
    gather_all(chain, point, at, delta, &value, &seed, place);
    const double *arguments[] = {value.by[0], value.by[2], value.by[3], value.by[5], paid,        place, NULL,
                                 seed.by[0],  seed.by[2],  seed.by[3],  seed.by[5],  paid_change, NULL};
    double *results[] = {bent};
    chain->bent_change(arguments, results, NULL, chain->work, 0);
}

void chain_fixture_loads(const Chain *chain, const Motion *at, const double *force, double *loads)
{
    const int d = chain->dimensions;
    memset(loads, 0, (size_t)(chain->fixtures * d) * sizeof *loads);
    for (int k = 0; k < chain->fixtures; k++) {
        const int node = chain->fixture_node[k] * d;
        chain_fixture(chain, k, at->r + node, at->u + node, at->b + node, loads + k * d);
    }
    for (int c = 0; c < d && !chain->held; c++) loads[c] -= force[c];
}

void chain_fixture_loads_change(const Chain *chain, const Motion *at, const Motion *delta, const double *force_change,
                                double *loads)
{
    const int d = chain->dimensions;
    for (int k = 0; k < chain->fixtures; k++) {
        const int node = chain->fixture_node[k] * d;
        const double *numbers = chain->fixture + k * (d + FIXTURE_OTHERS);
        double v[MOST_DIMENSIONS], slope[MOST_DIMENSIONS], dv[MOST_DIMENSIONS], along = 0.0;
        const double speed = chain_fixture_speed(chain, at->r + node, at->u + node, v, slope);
        for (int c = 0; c < d; c++) {
            dv[c] = delta->u[node + c] - slope[c] * delta->r[node + d - 1];
            along += v[c] * dv[c] / speed;
        }
        for (int c = 0; c < d; c++)
            loads[k * d + c] = numbers[c] * delta->b[node + c] + numbers[d + 1] * (along * v[c] + speed * dv[c]);
    }
    for (int c = 0; c < d && !chain->held; c++) loads[c] -= force_change[c];
}

void chain_gather(const Chain *chain, const double *n, const double *q, const double *fixtures, double *needed)
{
    const int d = chain->dimensions, p = chain->degree, points = p + 1;
    memset(needed, 0, (size_t)(chain->nodes * d) * sizeof *needed);
    for (int k = 0; k < chain->elements * points; k++) {
        double *sum = needed + k / points * p * d;
        const double *slopes = chain->rule->slopes + k % points * points, weight = chain->rule->weights[k % points];
        for (int c = 0; c < d; c++) {
            sum[k % points * d + c] += weight * q[k * d + c];
            for (int i = 0; i < points; i++) sum[i * d + c] += slopes[i] * weight * n[k * d + c];
        }
    }
    for (int k = 0; k < chain->fixtures; k++)
        for (int c = 0; c < d; c++) needed[chain->fixture_node[k] * d + c] += fixtures[k * d + c];
}

void chain_pulls(const Chain *chain, const double *q, const double *fixtures, const double *needed, double *pulls)
{
    const int d = chain->dimensions, points = chain->degree + 1;
    double start[MOST_DIMENSIONS] = {0.0};
    int next = 0;
    for (int c = 0; c < d && chain->held; c++) start[c] = -needed[c];
    for (int e = 0; e < chain->elements; e++) {
        const double *own = q + e * points * d;
        for (; next < chain->fixtures && chain->fixture_node[next] / chain->degree <= e; next++)
            for (int c = 0; c < d; c++) start[c] += fixtures[next * d + c];
        for (int i = 0; i < points; i++)
            for (int c = 0; c < d; c++) {
                double sum = start[c];
                for (int j = 0; j < points; j++) sum += chain->rule->integrals[i * points + j] * own[j * d + c];
                pulls[(e * points + i) * d + c] = sum;
            }
        memcpy(start, pulls + (e * points + points - 1) * d, (size_t)d * sizeof *start);
    }
}

/* Size of a Legendre coefficient of the slope, and its change. */
static double coefficient(const Chain *chain, const double *row, const double *r, const double *dr, double half,
                          double dhalf, double *delta)
{
    const int d = chain->dimensions, points = chain->degree + 1;
    double square = 0.0, along = 0.0;
    for (int c = 0; c < d; c++) {
        double value = 0.0, moved = 0.0;
        for (int q = 0; q < points; q++)
            for (int j = 0; j < points; j++) {
                const double factor = row[q] * chain->rule->slopes[q * points + j] / half;
                value += factor * r[j * d + c];
                moved += factor * (dr ? dr[j * d + c] : 0.0);
            }
        moved -= value * dhalf / half;
        square += value * value;
        along += value * moved;
    }
    const double size = sqrt(square);
    *delta = size > 0.0 ? along / size : 0.0;
    return size;
}

double chain_shape_error(const Chain *chain, const double *r, double paid, const double *dr, double dpaid,
                         double *delta)
{
    const int d = chain->dimensions, p = chain->degree;
    const double out[3] = {paid};
    double worst = 0.0, worst_change = 0.0, length = paid;
    for (int e = 0; e < chain->elements; e++) {
        const double half = chain_half(chain, e, out);
        const double dhalf = e < chain->growing ? 0.0 : chain->half[e] * dpaid / chain->last;
        const double *own = r + e * p * d, *moved = dr ? dr + e * p * d : NULL;
        double dlast, dbefore;
        const double last = coefficient(chain, chain->rule->last, own, moved, half, dhalf, &dlast);
        double before = coefficient(chain, chain->rule->before, own, moved, half, dhalf, &dbefore);
        if (p <= 2 || before < last) {
            before = last;
            dbefore = dlast;
        }
        length += 2.0 * chain->half[e];
        if (!(before > 0.0)) continue;
        const double error = half * last * last / before;
        if (error < worst) continue;
        worst = error;
        worst_change = (dhalf * last * last + 2.0 * half * last * dlast - error * dbefore) / before;
    }
    if (delta) *delta = (worst_change - worst * dpaid / length) / length;
    return worst / length;
}
