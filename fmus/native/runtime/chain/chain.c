#include "chain.h"
#include <math.h>
#include <string.h>

#include "chain_limits.h"

enum { MOST_POINTS = MOST_DEGREE + 1, BLOCK = MOST_DIMENSIONS * MOST_DIMENSIONS };

int chain_work(const Chain *chain) { return 64 + 8 * chain->dimensions * chain->dimensions; }

int chain_width(const Chain *chain) { return (chain->degree + 1) * chain->dimensions - 1; }

void chain_flow(const Chain *chain, double z, double *velocity, double *slope)
{
    const int d = chain->dimensions;
    int k = 0;
    while (k < chain->levels - 2 && z >= chain->level[k + 1]) k++;
    const double *low = chain->flow + k * d;
    const bool inside = chain->levels > 1 && z >= chain->level[0] && z <= chain->level[chain->levels - 1];
    const double size = chain->levels > 1 ? chain->level[k + 1] - chain->level[k] : 1.0;
    const double share = inside ? (z - chain->level[k]) / size : chain->levels > 1 && z > chain->level[k] ? 1.0 : 0.0;
    for (int c = 0; c < d; c++) {
        const double difference = chain->levels > 1 ? low[d + c] - low[c] : 0.0;
        velocity[c] = low[c] + share * difference;
        if (slope) slope[c] = inside ? difference / size : 0.0;
    }
}

/* What the functions of a point take, at point q of an element whose nodes' values begin at r, u, b. */
typedef struct {
    double g[MOST_DIMENSIONS], rate[MOST_DIMENSIONS], v[MOST_DIMENSIONS], slope[MOST_DIMENSIONS];
    const double *arguments[5];
} Point;

static void point_at(const Chain *chain, int element, int q, const double *r, const double *u, const double *b,
                     Point *at)
{
    const int d = chain->dimensions, points = chain->degree + 1;
    const double *slopes = chain->slopes + q * points, inverse = 1.0 / chain->half[element];
    for (int c = 0; c < d; c++) {
        double g = 0.0, rate = 0.0;
        for (int j = 0; j < points; j++) g += slopes[j] * r[j * d + c];
        if (chain->damped) {
            for (int j = 0; j < points; j++) rate += slopes[j] * u[j * d + c];
        }
        at->g[c] = g * inverse;
        at->rate[c] = rate * inverse;
    }
    chain_flow(chain, r[q * d + d - 1], at->v, at->slope);
    for (int c = 0; c < d; c++) at->v[c] = u[q * d + c] - at->v[c];
    at->arguments[0] = at->g;
    at->arguments[1] = at->rate;
    at->arguments[2] = at->v;
    at->arguments[3] = b + q * d;
    at->arguments[4] = chain->material + element * POINT_MATERIAL;
}

/* Speed of a fixture through the water, with what keeps its derivative finite (point.py); the velocity, and the slope
 * of the water's over z where asked for. */
static double fixture_speed(const Chain *chain, const double *r, const double *u, double *v, double *slope)
{
    const int d = chain->dimensions;
    double square = CHAIN_SMALL_SPEED2;
    chain_flow(chain, r[d - 1], v, slope);
    for (int c = 0; c < d; c++) {
        v[c] = u[c] - v[c];
        square += v[c] * v[c];
    }
    return sqrt(square);
}

void chain_fixture(const Chain *chain, int fixture, const double *r, const double *u, const double *b, double *load)
{
    const int d = chain->dimensions;
    const double *numbers = chain->fixture + fixture * (d + 2);
    double v[MOST_DIMENSIONS];
    const double factor = numbers[d + 1] * fixture_speed(chain, r, u, v, NULL);
    for (int c = 0; c < d; c++) load[c] += numbers[c] * b[c] + factor * v[c];
    load[d - 1] += numbers[d];
}

void chain_needed(const Chain *chain, const double *r, const double *u, const double *b, const Drive *drive,
                  double *needed)
{
    const int d = chain->dimensions, p = chain->degree, points = p + 1;
    memset(needed, 0, (size_t)(chain->nodes * d) * sizeof *needed);
    for (int e = 0; e < chain->elements; e++) {
        const int first = e * p * d;
        double *sum = needed + first;
        for (int q = 0; q < points; q++) {
            double n[MOST_DIMENSIONS], load[MOST_DIMENSIONS], *results[] = {n, load};
            const double *slopes = chain->slopes + q * points, weight = chain->weights[q];
            Point at;
            point_at(chain, e, q, r + first, u + first, b + first, &at);
            chain->loads(at.arguments, results, NULL, chain->work, 0);
            for (int c = 0; c < d; c++) {
                n[c] *= weight;
                sum[q * d + c] += weight * chain->half[e] * load[c];
            }
            for (int i = 0; i < points; i++) {
                for (int c = 0; c < d; c++) sum[i * d + c] += slopes[i] * n[c];
            }
        }
    }
    for (int k = 0; k < chain->fixtures; k++) {
        const int at = chain->fixture_node[k] * d;
        chain_fixture(chain, k, r + at, u + at, b + at, needed + at);
    }
    if (!chain->held) {
        for (int c = 0; c < d; c++) needed[c] -= drive->force[c];
    }
}

/* Block (i, j) of an element's matrix: w^2 K and w C of the pull, D' (w/half) D. */
static void add_pull(const Chain *chain, const double *pull, double scale, int q, int row, double *band)
{
    const int d = chain->dimensions, points = chain->degree + 1, width = chain_width(chain);
    const double *slopes = chain->slopes + q * points;
    for (int i = 0; i < points; i++) {
        for (int a = 0; a < d; a++) {
            double *line = band + (row + i * d + a) * (2 * width + 1) + width - i * d - a;
            const double left = scale * slopes[i];
            for (int j = 0; j < points; j++) {
                for (int c = 0; c < d; c++) line[j * d + c] += left * slopes[j] * pull[c * d + a];
            }
        }
    }
}

/* The load at point q: on its own node, by all nodes through g and by its own velocity and acceleration. */
static void add_load(const Chain *chain, const double *by_g, const double *own, double weight, int q, int row,
                     double *band)
{
    const int d = chain->dimensions, points = chain->degree + 1, width = chain_width(chain);
    const double *slopes = chain->slopes + q * points;
    for (int a = 0; a < d; a++) {
        double *line = band + (row + q * d + a) * (2 * width + 1) + width - q * d - a;
        for (int j = 0; j < points; j++) {
            for (int c = 0; c < d; c++) line[j * d + c] += weight * slopes[j] * by_g[c * d + a];
        }
        for (int c = 0; c < d; c++) line[q * d + c] += own[c * d + a];
    }
}

static void add_fixtures(const Chain *chain, const double *r, const double *u, double w, double *band, double *inertia)
{
    const int d = chain->dimensions, width = chain_width(chain);
    for (int k = 0; k < chain->fixtures; k++) {
        const int at = chain->fixture_node[k] * d;
        const double *fixture = chain->fixture + k * (d + 2);
        double v[MOST_DIMENSIONS], slope[MOST_DIMENSIONS];
        const double speed = fixture_speed(chain, r + at, u + at, v, slope);
        for (int a = 0; a < d; a++) {
            double *line = band + (at + a) * (2 * width + 1) + width - a;
            for (int c = 0; c < d; c++) {
                const double damping = fixture[d + 1] * (v[a] * v[c] / speed + (a == c ? speed : 0.0));
                line[c] += w * damping;
                line[d - 1] -= w * w * damping * slope[c];
            }
            line[a] += fixture[a];
            inertia[(chain->fixture_node[k] * d + a) * d + a] += fixture[a];
        }
    }
}

void chain_band(const Chain *chain, const double *r, const double *u, const double *b, double w, double *band,
                double *inertia)
{
    const int d = chain->dimensions, p = chain->degree, points = p + 1, width = chain_width(chain), block = d * d;
    memset(band, 0, (size_t)(chain->nodes * d * (2 * width + 1)) * sizeof *band);
    memset(inertia, 0, (size_t)(chain->nodes * block) * sizeof *inertia);
    for (int e = 0; e < chain->elements; e++) {
        const int first = e * p * d;
        const double half = chain->half[e];
        for (int q = 0; q < points; q++) {
            double pull[BLOCK], pull_rate[BLOCK], by_g[BLOCK], by_v[BLOCK], by_a[BLOCK];
            double *results[] = {pull, pull_rate, by_g, by_v, by_a};
            const double weight = chain->weights[q], local = weight * half;
            Point at;
            point_at(chain, e, q, r + first, u + first, b + first, &at);
            chain->derivatives(at.arguments, results, NULL, chain->work, 0);
            for (int k = 0; k < block; k++) {
                inertia[(e * p + q) * block + k] += local * by_a[k];
                pull[k] = w * (w * pull[k] + pull_rate[k]);
                by_a[k] = local * (by_a[k] + w * by_v[k]);
            }
            /* sheared water: velocity by height */
            for (int a = 0; a < d; a++) {
                double difference = 0.0;
                for (int c = 0; c < d; c++) difference += by_v[c * d + a] * at.slope[c];
                by_a[(d - 1) * d + a] -= local * w * w * difference;
            }
            add_pull(chain, pull, weight / half, q, first, band);
            add_load(chain, by_g, by_a, weight * w * w, q, first, band);
        }
    }
    add_fixtures(chain, r, u, w, band, inertia);
}
