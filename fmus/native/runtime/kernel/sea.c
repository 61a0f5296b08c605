/* Motions of a ship in a sea of many components: models/sea/motion.py in C, where the method is explained. */
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#include "kernel.h"
#include "kernel_constants.h"
#include "sea_response.h"

enum { SLOTS = 4, KEYS = 21, LISTS = 7 }; /* windows kept; arguments but time and signal; arrays of n numbers */

typedef struct {
    double key[KEYS]; /* the arguments for which the rest was made */
    bool known, steady;
    double width;
    int64_t windows, at; /* of the phasors: the window at whose start they are */
    double anchor, integral[3], interval, doppler[2][2];
    SeaState sea[2];
    SeaShip ship;
    double beyond;
    SeaComponents components;
    double place[ORDER], transform[ORDER][ORDER];
    double *phase, *rate[2], *phasor, *turn;
    double *amplitude[SIGNALS][2], *matrix[SIGNALS][2]; /* old and new sea; motion and second derivative */
    bool amplified[SIGNALS], multiplied[SIGNALS];
    double square[SIGNALS][3];
    int64_t window[SIGNALS][SLOTS];
    double series[SIGNALS][SLOTS][ORDER][4]; /* of the motion and its first three derivatives */
} Motion;

size_t kernel_sea_size(const double *table)
{
    const size_t n = (size_t)table[0], numbers = LISTS * n + SIGNALS * 2 * (2 * n + 2 * ORDER * n);
    return sizeof(Motion) + numbers * sizeof(double);
}

static void place_lists(Motion *m, const double *table)
{
    const size_t n = (size_t)table[0];
    double *next = (double *)(m + 1);
    m->components = (SeaComponents){(int)n, table + 2, table + 2 + n, table + 2 + 2 * n, table + 2 + 3 * n};
    m->ship.by_table = table[1] > 0.5;
    if (m->ship.by_table) m->ship.table = sea_table(table + 2 + 4 * n);
    m->phase = next;
    m->rate[0] = next + n;
    m->rate[1] = next + 2 * n;
    m->phasor = next + 3 * n;
    m->turn = next + 5 * n;
    next += LISTS * n;
    for (int s = 0; s < SIGNALS; s++)
        for (int k = 0; k < 2; k++) {
            m->amplitude[s][k] = next;
            m->matrix[s][k] = next + 2 * n;
            next += 2 * n + 2 * ORDER * n;
        }
    for (int j = 0; j < ORDER; j++) {
        const double angle = PI * (j + 0.5) / ORDER;
        m->place[j] = 0.5 + 0.5 * cos(angle);
        for (int k = 0; k < ORDER; k++) m->transform[k][j] = (k ? 2.0 : 1.0) / ORDER * cos(k * angle);
    }
}

static void make_rates(Motion *m)
{
    const SeaComponents *c = &m->components;
    double fastest = 0.0;
    for (int k = 0; k < 2; k++) {
        const SeaState *sea = &m->sea[k];
        const double scale = sea->frequency * sea->frequency * sea->speed / GRAVITY;
        m->doppler[k][0] = scale * cos(sea->direction);
        m->doppler[k][1] = scale * sin(sea->direction);
        for (int i = 0; i < c->count; i++) {
            const double x = c->x[i], across = c->cos[i] * m->doppler[k][0] - c->sin[i] * m->doppler[k][1];
            m->rate[k][i] = x * sea->frequency - x * x * across;
            if (fabs(m->rate[k][i]) > fastest) fastest = fabs(m->rate[k][i]);
        }
    }
    const double windows = ceil(m->interval * fastest / REACH);
    m->windows = !(windows >= 1.0) ? 1 : windows > 1e15 ? INT64_C(1000000000000000) : (int64_t)windows;
    m->width = m->interval / (double)m->windows;
    for (int i = 0; i < c->count; i++) {
        m->turn[2 * i] = cos(m->rate[0][i] * m->width);
        m->turn[2 * i + 1] = sin(m->rate[0][i] * m->width);
    }
}

/* Everything that follows from the arguments `a`, which begin with the anchor. */
static void make(Motion *m, const double *table, const double *a)
{
    if (!m->phase) place_lists(m, table);
    memcpy(m->key, a, sizeof m->key);
    m->anchor = a[0];
    memcpy(m->integral, a + 1, sizeof m->integral);
    m->sea[0] = (SeaState){a[4], a[5], a[6], a[7]};
    m->sea[1] = (SeaState){a[8], a[9], a[10], a[11]};
    m->steady = a[4] == a[8] && a[5] == a[9] && a[6] == a[10] && a[7] == a[11];
    m->interval = a[12];
    m->ship.length = a[14];
    m->ship.breadth = a[15];
    m->ship.draught = a[16];
    m->ship.smith_oblique = a[17];
    memcpy(m->ship.point, a + 18, sizeof m->ship.point);
    m->beyond = fmax(sea_share_beyond(&m->sea[0], &m->components, &m->ship),
                     sea_share_beyond(&m->sea[1], &m->components, &m->ship));
    sea_phases(a[13], m->components.count, m->phase);
    make_rates(m);
    m->at = INT64_MIN;
    memset(m->amplified, 0, sizeof m->amplified);
    memset(m->multiplied, 0, sizeof m->multiplied);
    for (int s = 0; s < SIGNALS; s++)
        for (int k = 0; k < SLOTS; k++) m->window[s][k] = INT64_MIN;
    m->known = true;
}

static void amplify(Motion *m, int signal)
{
    double **a = m->amplitude[signal], *square = m->square[signal];
    if (m->amplified[signal]) return;
    for (int k = 0; k < 2; k++) sea_amplitudes(signal, &m->sea[k], &m->components, &m->ship, a[k]);
    memset(square, 0, sizeof m->square[signal]);
    for (int i = 0; i < 2 * m->components.count; i++) {
        square[0] += 0.5 * a[0][i] * a[0][i];
        square[1] += 0.5 * a[0][i] * a[1][i];
        square[2] += 0.5 * a[1][i] * a[1][i];
    }
    m->amplified[signal] = true;
}

static double phase_at(const Motion *m, int i, double since, double area)
{
    const SeaComponents *c = &m->components;
    const double x = c->x[i];
    const double p =
        m->integral[0] + (m->sea[0].frequency * since + (m->sea[1].frequency - m->sea[0].frequency) * area);
    const double along = m->integral[1] + (m->doppler[0][0] * since + (m->doppler[1][0] - m->doppler[0][0]) * area);
    const double across = m->integral[2] + (m->doppler[0][1] * since + (m->doppler[1][1] - m->doppler[0][1]) * area);
    return x * (p - x * (c->cos[i] * along - c->sin[i] * across)) + m->phase[i];
}

static void to_window(Motion *m, int64_t n)
{
    const int64_t first = n - (n % BLOCK + BLOCK) % BLOCK;
    const int count = m->components.count;
    double *z = m->phasor;
    if (m->at < first || m->at > n) {
        for (int i = 0; i < count; i++) {
            const double phi = phase_at(m, i, (double)first * m->width, 0.0);
            z[2 * i] = cos(phi);
            z[2 * i + 1] = sin(phi);
        }
        m->at = first;
    }
    for (; m->at < n; m->at++)
        for (int i = 0; i < count; i++) {
            const double re = z[2 * i], im = z[2 * i + 1], c = m->turn[2 * i], s = m->turn[2 * i + 1];
            z[2 * i] = re * c - im * s;
            z[2 * i + 1] = re * s + im * c;
        }
}

/* From phasors at the start of a window to its two series: for every component the real, then the imaginary parts. */
static void make_products(Motion *m, int signal)
{
    for (int i = 0; i < m->components.count; i++) {
        const double w = m->rate[0][i], *a = m->amplitude[signal][0] + 2 * i;
        for (int k = 0; k < 2; k++) {
            const double re = k ? -w * w * a[0] : a[0], im = k ? -w * w * a[1] : a[1];
            double *to = m->matrix[signal][k] + 2 * ORDER * i;
            memset(to, 0, 2 * ORDER * sizeof *to);
            for (int j = 0; j < ORDER; j++) {
                const double angle = w * (m->width * m->place[j]), c = cos(angle), s = sin(angle);
                for (int l = 0; l < ORDER; l++) {
                    to[l] += m->transform[l][j] * (re * c - im * s);
                    to[ORDER + l] += m->transform[l][j] * (re * s + im * c);
                }
            }
        }
    }
    m->multiplied[signal] = true;
}

static void steady(Motion *m, int signal, int64_t n, double (*series)[4])
{
    if (!m->multiplied[signal]) make_products(m, signal);
    to_window(m, n);
    for (int k = 0; k < 2; k++) {
        const double *from = m->matrix[signal][k];
        double sum[ORDER] = {0.0};
        for (int i = 0; i < m->components.count; i++, from += 2 * ORDER) {
            const double re = m->phasor[2 * i], im = m->phasor[2 * i + 1];
            for (int l = 0; l < ORDER; l++) sum[l] += from[l] * re - from[ORDER + l] * im;
        }
        for (int l = 0; l < ORDER; l++) series[l][2 * k] = sum[l];
    }
}

static void changing(Motion *m, int signal, int64_t n, double (*series)[4])
{
    memset(series, 0, ORDER * sizeof *series);
    for (int j = 0; j < ORDER; j++) {
        const double since = ((double)n + m->place[j]) * m->width, s = since / m->interval, rest = 1.0 - s;
        const double r = s * s * s * (10.0 - 15.0 * s + 6.0 * s * s),
                     area = m->interval * s * s * s * s * (2.5 - 3.0 * s + s * s);
        const double r1 = 30.0 * s * s * rest * rest / m->interval;
        const double r2 = 60.0 * s * rest * (1.0 - 2.0 * s) / m->interval / m->interval;
        double value = 0.0, second = 0.0;
        for (int i = 0; i < m->components.count; i++) {
            const double *a0 = m->amplitude[signal][0] + 2 * i, *a1 = m->amplitude[signal][1] + 2 * i;
            const double phi = phase_at(m, i, since, area), c = cos(phi), sine = sin(phi);
            const double dw = m->rate[1][i] - m->rate[0][i], w = m->rate[0][i] + r * dw;
            const double dre = a1[0] - a0[0], dim = a1[1] - a0[1], re = a0[0] + r * dre, im = a0[1] + r * dim;
            /* of the second derivative: b = r2 da - w^2 a + j (2 r1 w da + r1 dw a) */
            const double bre = r2 * dre - w * w * re - (2.0 * r1 * w * dim + r1 * dw * im);
            const double bim = r2 * dim - w * w * im + (2.0 * r1 * w * dre + r1 * dw * re);
            value += re * c - im * sine;
            second += bre * c - bim * sine;
        }
        for (int l = 0; l < ORDER; l++) {
            series[l][0] += m->transform[l][j] * value;
            series[l][2] += m->transform[l][j] * second;
        }
    }
}

/* Coefficients of the derivatives, behind those of what is derived: series in 2 s/W - 1. */
static void derive(double (*c)[4], double scale)
{
    for (int s = 0; s < 4; s += 2) {
        double above = 0.0, last = 0.0; /* those of k + 1 and k */
        c[ORDER - 1][s + 1] = 0.0;
        for (int k = ORDER - 1; k > 0; k--) {
            const double next = above + 2.0 * k * scale * c[k][s];
            above = last;
            last = next;
            c[k - 1][s + 1] = next;
        }
        c[0][s + 1] *= 0.5;
    }
}

/* Values of four series at once, which a compiler takes for one vector. */
static void values_of(const double (*c)[4], double tau, double *value)
{
    double b1[4] = {0.0}, b2[4] = {0.0};
    for (int k = ORDER - 1; k > 0; k--)
        for (int s = 0; s < 4; s++) {
            const double b = 2.0 * tau * b1[s] - b2[s] + c[k][s];
            b2[s] = b1[s];
            b1[s] = b;
        }
    for (int s = 0; s < 4; s++) value[s] = tau * b1[s] - b2[s] + c[0][s];
}

const double *kernel_sea_series(const double *table, const double *argument, bool same, double *result, void *memory,
                                double *tau)
{
    Motion *m = memory;
    const int signal = (int)argument[1];
    if (!m->known || (!same && memcmp(m->key, argument + 2, sizeof m->key))) make(m, table, argument + 2);
    for (int k = 0; k < 5; k++) result[k] = signal == BEYOND && k == 0 ? m->beyond : 0.0;
    if (signal == BEYOND) return NULL;
    amplify(m, signal);
    if (m->square[signal][0] == 0.0 && m->square[signal][2] == 0.0) return NULL; /* does not move */
    const double since = argument[0] - m->anchor, place = floor(since / m->width);
    for (int k = 0; k < 5; k++) result[k] = NAN;
    if (!(fabs(place) < 1e15)) return NULL;
    int64_t n = (int64_t)place;
    if (!m->steady) n = n < 0 ? 0 : n > m->windows - 1 ? m->windows - 1 : n;
    const int slot = (int)((n % SLOTS + SLOTS) % SLOTS);
    double (*series)[4] = m->series[signal][slot];
    if (m->window[signal][slot] != n) {
        (m->steady ? steady : changing)(m, signal, n, series);
        derive(series, 2.0 / m->width);
        m->window[signal][slot] = n;
    }
    *tau = 2.0 * (since - (double)n * m->width) / m->width - 1.0;
    const double s = fmin(1.0, fmax(0.0, since / m->interval)), r = s * s * s * (10.0 - 15.0 * s + 6.0 * s * s);
    const double *square = m->square[signal];
    result[4] =
        m->steady ? square[0] : (1.0 - r) * (1.0 - r) * square[0] + 2.0 * (1.0 - r) * r * square[1] + r * r * square[2];
    return series[0];
}

void kernel_sea(const double *table, const double *argument, double *result, void *memory)
{
    double tau;
    const double *series = kernel_sea_series(table, argument, false, result, memory, &tau);
    if (series) values_of((const double (*)[4])series, tau, result);
}
