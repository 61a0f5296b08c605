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

double chain_half(const Chain *chain, int element, const double *paid)
{
    return element < chain->growing ? chain->half[element] : chain->half[element] * (1.0 + paid[0] / chain->last);
}

/* Values at point q of the derivative over s of what has values x at the nodes. */
static void differentiate(const Chain *chain, const double *x, int q, double inverse, double *slope)
{
    const int d = chain->dimensions, points = chain->degree + 1;
    const double *slopes = chain->rule->slopes + q * points;
    for (int c = 0; c < d; c++) {
        double sum = 0.0;
        for (int j = 0; j < points; j++) sum += slopes[j] * x[j * d + c];
        slope[c] = sum * inverse;
    }
}

/* The material moves through the point with sigma = x L': its rates instead of the node's. */
static void slide(const Chain *chain, int element, int q, const double *r, const double *paid, Point *point)
{
    const int d = chain->dimensions, points = chain->degree + 1;
    const double share = chain->share[element * points + q], sigma = paid[1] * share, faster = paid[2] * share;
    const double stretch = element < chain->growing ? 0.0 : paid[1] / (chain->last + paid[0]);
    double slopes[(MOST_DEGREE + 1) * MOST_DIMENSIONS], bend[MOST_DIMENSIONS];
    for (int j = 0; j < points; j++) differentiate(chain, r, j, 1.0 / point->half, slopes + j * d);
    differentiate(chain, slopes, q, 1.0 / point->half, bend);
    for (int c = 0; c < d; c++) {
        const double stretched = point->rate[c] - stretch * point->g[c];
        point->a[c] += sigma * sigma * bend[c] - 2.0 * sigma * stretched - faster * point->g[c];
        point->v[c] -= sigma * point->g[c];
        point->rate[c] = stretched;
    }
    point->slide = sigma;
}

void chain_point(const Chain *chain, int element, int q, const Motion *at, const double *paid, Point *point)
{
    const int d = chain->dimensions, first = element * chain->degree * d;
    const double *r = at->r + first, *u = at->u + first, *b = at->b + first;
    const bool moving = paid[1] != 0.0 || paid[2] != 0.0;
    point->half = chain_half(chain, element, paid);
    point->slide = 0.0;
    differentiate(chain, r, q, 1.0 / point->half, point->g);
    memset(point->rate, 0, sizeof point->rate);
    if (chain->damped || moving) differentiate(chain, u, q, 1.0 / point->half, point->rate);
    double flow[MOST_DIMENSIONS];
    chain_flow(chain, r[q * d + d - 1], flow, point->slope);
    for (int c = 0; c < d; c++) {
        point->v[c] = u[q * d + c];
        point->a[c] = b[q * d + c];
    }
    if (moving) slide(chain, element, q, r, paid, point);
    for (int c = 0; c < d; c++) point->v[c] -= flow[c];
    const double *arguments[] = {point->g, point->rate, point->v, point->a, chain->material + element * POINT_MATERIAL};
    memcpy(point->arguments, arguments, sizeof arguments);
}

double chain_fixture_speed(const Chain *chain, const double *r, const double *u, double *v, double *slope)
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
    const double *numbers = chain->fixture + fixture * (d + FIXTURE_OTHERS);
    double v[MOST_DIMENSIONS];
    const double factor = numbers[d + 1] * chain_fixture_speed(chain, r, u, v, NULL);
    for (int c = 0; c < d; c++) load[c] += numbers[c] * b[c] + factor * v[c];
    load[0] += numbers[d + 2];
    load[d - 1] += numbers[d];
}

void chain_needed(const Chain *chain, const Motion *at, const Drive *drive, double *needed)
{
    const int d = chain->dimensions, p = chain->degree, points = p + 1;
    memset(needed, 0, (size_t)(chain->nodes * d) * sizeof *needed);
    for (int e = 0; e < chain->elements; e++) {
        double *sum = needed + e * p * d;
        for (int q = 0; q < points; q++) {
            double n[MOST_DIMENSIONS], load[MOST_DIMENSIONS], *results[] = {n, load};
            const double *slopes = chain->rule->slopes + q * points, weight = chain->rule->weights[q];
            Point point;
            chain_point(chain, e, q, at, drive->paid, &point);
            chain->loads(point.arguments, results, NULL, chain->work, 0);
            for (int c = 0; c < d; c++) {
                n[c] *= weight;
                sum[q * d + c] += weight * point.half * load[c];
            }
            for (int i = 0; i < points; i++) {
                for (int c = 0; c < d; c++) sum[i * d + c] += slopes[i] * n[c];
            }
        }
    }
    for (int k = 0; k < chain->fixtures; k++) {
        const int node = chain->fixture_node[k] * d;
        chain_fixture(chain, k, at->r + node, at->u + node, at->b + node, needed + node);
    }
    if (!chain->held) {
        for (int c = 0; c < d; c++) needed[c] -= drive->force[c];
    }
}

/* Block (i, j) of an element's matrix: w^2 K and w C of the pull, D' (w/half) D. */
static void add_pull(const Chain *chain, const double *pull, double scale, int q, int row, double *band)
{
    const int d = chain->dimensions, points = chain->degree + 1, width = chain_width(chain);
    const double *slopes = chain->rule->slopes + q * points;
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
    const double *slopes = chain->rule->slopes + q * points;
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
        const double *fixture = chain->fixture + k * (d + FIXTURE_OTHERS);
        double v[MOST_DIMENSIONS], slope[MOST_DIMENSIONS];
        const double speed = chain_fixture_speed(chain, r + at, u + at, v, slope);
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

void chain_band(const Chain *chain, const Motion *at, const double *paid, double w, double *band, double *inertia)
{
    const int d = chain->dimensions, p = chain->degree, points = p + 1, width = chain_width(chain), block = d * d;
    memset(band, 0, (size_t)(chain->nodes * d * (2 * width + 1)) * sizeof *band);
    memset(inertia, 0, (size_t)(chain->nodes * block) * sizeof *inertia);
    for (int e = 0; e < chain->elements; e++) {
        for (int q = 0; q < points; q++) {
            double pull[BLOCK], pull_rate[BLOCK], by_g[BLOCK], by_v[BLOCK], by_a[BLOCK];
            double *results[] = {pull, pull_rate, by_g, by_v, by_a};
            Point point;
            chain_point(chain, e, q, at, paid, &point);
            const double weight = chain->rule->weights[q], local = weight * point.half;
            chain->derivatives(point.arguments, results, NULL, chain->work, 0);
            for (int k = 0; k < block; k++) {
                inertia[(e * p + q) * block + k] += local * by_a[k];
                pull[k] = w * (w * pull[k] + pull_rate[k]);
                by_a[k] = local * (by_a[k] + w * by_v[k]);
                by_g[k] -= point.slide * by_v[k];
            }
            /* sheared water: velocity by height */
            for (int a = 0; a < d; a++) {
                double difference = 0.0;
                for (int c = 0; c < d; c++) difference += by_v[c * d + a] * point.slope[c];
                by_a[(d - 1) * d + a] -= local * w * w * difference;
            }
            add_pull(chain, pull, weight / point.half, q, e * p * d, band);
            add_load(chain, by_g, by_a, weight * w * w, q, e * p * d, band);
        }
    }
    add_fixtures(chain, at->r, at->u, w, band, inertia);
}
