/* Dormand-Prince 5(4), J. Comp. Appl. Math. 6 (1980) 19-26, with the error control and event location of
 * models/numeric/integrate.py; what a step decides is explained there. Stages are written out: a loop over the tableau costs more
 * than a right-hand side of two components. */

#include "integrate.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <string.h>

enum { STAGES = 7, MAX_TRIALS = 200 }; /* MAX_TRIALS: to locate an event */

/* Below this ratio of error to tolerance the step grows fivefold: 0.9 r^(-1/5) > 5 for r < 1.89e-4; saves the power. */
#define EASY 1.8e-4

/* Share of its values at both ends of a step below which the vertex of an indicator's parabola is looked at. */
#define NEAR 0.1

/* Share of its value beyond the next zero below which an indicator is zero but for rounding. */
#define ROUNDING 1e-9

/* Share of a step, begun on a zero, in which the sign is not trusted; four times as much, up to a tenth, with every event
 * that cuts a step to less than SHORT of itself: where an indicator is zero but for rounding, time goes on. */
#define BLIND 1e-6
#define SHORT 1e-3

typedef struct {
    const System *system;
    double *k[STAGES]; /* rates of the stages; k[0] at the begin, k[6] at the end of the step */
    double *y, *point; /* the step's end; a stage */
    double *g, *g_new; /* indicators at its begin and end */
    double *y_high, *f_high, *g_high; /* event location: the end beyond the event */
    double *g_inner; /* indicators at another place inside */
} Work;

int integrate_work(int states, int indicators)
{
    return (STAGES + 4) * states + 4 * indicators;
}

static Work partition(const System *system, double *work)
{
    const int n = system->states, m = system->indicators;
    double *const ends = work + STAGES * n, *const signs = ends + 4 * n;
    const Work w = {
        .system = system,
        .k = {work, work + n, work + 2 * n, work + 3 * n, work + 4 * n, work + 5 * n, work + 6 * n},
        .y = ends, .point = ends + n, .y_high = ends + 2 * n, .f_high = ends + 3 * n,
        .g = signs, .g_new = signs + m, .g_high = signs + 2 * m, .g_inner = signs + 3 * m,
    };
    return w;
}

static void rates(const Work *w, double t, const double *x, double *f)
{
    w->system->rates(w->system->context, t, x, f);
}

static void indicate(const Work *w, double t, const double *x, double *g)
{
    if (w->system->indicators > 0)
        w->system->indicate(w->system->context, t, x, g);
}

/* A step of length h from (t, x) with the rates k[0]: its end goes to y, the rates there to k[6]. */
static void advance(const Work *w, double t, const double *x, double h)
{
    const int n = w->system->states;
    double *const q = w->point, *const y = w->y;
    const double *const k0 = w->k[0], *const k1 = w->k[1], *const k2 = w->k[2], *const k3 = w->k[3], *const k4 = w->k[4],
                 *const k5 = w->k[5];
    for (int i = 0; i < n; i++)
        q[i] = x[i] + h * (1.0 / 5 * k0[i]);
    rates(w, t + 1.0 / 5 * h, q, w->k[1]);
    for (int i = 0; i < n; i++)
        q[i] = x[i] + h * (3.0 / 40 * k0[i] + 9.0 / 40 * k1[i]);
    rates(w, t + 3.0 / 10 * h, q, w->k[2]);
    for (int i = 0; i < n; i++)
        q[i] = x[i] + h * (44.0 / 45 * k0[i] - 56.0 / 15 * k1[i] + 32.0 / 9 * k2[i]);
    rates(w, t + 4.0 / 5 * h, q, w->k[3]);
    for (int i = 0; i < n; i++)
        q[i] = x[i] + h * (19372.0 / 6561 * k0[i] - 25360.0 / 2187 * k1[i] + 64448.0 / 6561 * k2[i] - 212.0 / 729 * k3[i]);
    rates(w, t + 8.0 / 9 * h, q, w->k[4]);
    for (int i = 0; i < n; i++)
        q[i] = x[i] + h * (9017.0 / 3168 * k0[i] - 355.0 / 33 * k1[i] + 46732.0 / 5247 * k2[i] + 49.0 / 176 * k3[i]
                           - 5103.0 / 18656 * k4[i]);
    rates(w, t + h, q, w->k[5]);
    for (int i = 0; i < n; i++)
        y[i] = x[i] + h * (35.0 / 384 * k0[i] + 500.0 / 1113 * k2[i] + 125.0 / 192 * k3[i] - 2187.0 / 6784 * k4[i]
                           + 11.0 / 84 * k5[i]);
    rates(w, t + h, y, w->k[6]);
}

/* Largest error of that step over its tolerance. */
static double error_ratio(const Work *w, const double *x, double h, double rtol, double atol)
{
    double *const *k = w->k;
    double largest = 0.0;
    for (int i = 0; i < w->system->states; i++) {
        const double a = fabs(x[i]), b = fabs(w->y[i]);
        const double error = h * (71.0 / 57600 * k[0][i] - 71.0 / 16695 * k[2][i] + 71.0 / 1920 * k[3][i]
                                  - 17253.0 / 339200 * k[4][i] + 22.0 / 525 * k[5][i] - 1.0 / 40 * k[6][i]);
        const double ratio = fabs(error) / (atol + rtol * (a > b ? a : b) + DBL_MIN);
        if (!(ratio <= largest))
            largest = ratio;
    }
    return largest;
}

/* Whether some indicator has another value at the end of the step than at its begin. */
static bool changed(const Work *w)
{
    for (int j = 0; j < w->system->indicators; j++)
        if (w->g[j] != w->g_new[j])
            return true;
    return false;
}

/* Whether some indicator has another sign than at the begin. */
static bool differ(const Work *w, const double *g)
{
    for (int j = 0; j < w->system->indicators; j++)
        if ((w->g[j] > 0.0) != (g[j] > 0.0))
            return true;
    return false;
}

/* Whether some indicator has one sign at both ends and the other, in `middle`, between them. */
static bool hidden(const Work *w, const double *middle)
{
    for (int j = 0; j < w->system->indicators; j++)
        if ((w->g[j] > 0.0) == (w->g_new[j] > 0.0) && (w->g[j] > 0.0) != (middle[j] > 0.0))
            return true;
    return false;
}

/* A place within the step where an indicator that has one sign at both ends has the other, 0 if none is found: at mid-step,
 * or where the parabola of an indicator through begin, middle and end has its vertex near zero or beyond. */
static double inside(const Work *w, double t, const double *x, double h)
{
    const int n = w->system->states, m = w->system->indicators;
    double *const middle = w->g_high, *const there = w->g_inner;
    const double *const y = w->y, *const f = w->k[0], *const f_new = w->k[6];
    for (int i = 0; i < n; i++) /* the cubic Hermite interpolant */
        w->point[i] = 0.5 * (x[i] + y[i]) + 0.125 * h * (f[i] - f_new[i]);
    indicate(w, t + 0.5 * h, w->point, middle);
    if (hidden(w, middle))
        return 0.5 * h;
    for (int j = 0; j < m; j++) {
        const double a = w->g[j], b = w->g_new[j];
        const double slope = 4.0 * middle[j] - 3.0 * a - b, bend = 2.0 * (a + b) - 4.0 * middle[j];
        if (!(slope * a < 0.0 && 0.0 < bend * a) || (a > 0.0) != (b > 0.0))
            continue;
        const double s = -0.5 * slope / bend, bottom = a + 0.5 * s * slope;
        const double largest = fabs(b) > fabs(a) ? fabs(b) : fabs(a);
        if (!(s < 1.0 && (bottom * a <= 0.0 || fabs(bottom) < NEAR * largest)))
            continue;
        const double q = 1.0 - s, wx = q * q * (1.0 + 2.0 * s), wy = s * s * (1.0 + 2.0 * q), wf = h * q * q * s,
                     wg = -h * s * s * q;
        for (int i = 0; i < n; i++)
            w->point[i] = wx * x[i] + wy * y[i] + wf * f[i] + wg * f_new[i];
        indicate(w, t + s * h, w->point, there);
        if (hidden(w, there))
            return s * h;
    }
    return 0.0;
}

/* The step of length s; returns the indicator that changed and is nearest to its zero at the begin, -1 if none did. */
static int ahead(const Work *w, double t, const double *x, double s)
{
    int best = -1;
    double nearest = INFINITY;
    advance(w, t, x, s);
    indicate(w, t + s, w->y, w->g_new);
    for (int j = 0; j < w->system->indicators; j++) {
        if ((w->g[j] > 0.0) == (w->g_new[j] > 0.0))
            continue;
        const double share = fabs(w->g[j]) / (fabs(w->g[j]) + fabs(w->g_new[j]) + 1e-300);
        if (best < 0 || share < nearest) {
            best = j;
            nearest = share;
        }
    }
    return best;
}

static void copy(double *to, const double *from, int count)
{
    memcpy(to, from, (size_t)count * sizeof *to);
}

static void keep_high(const Work *w)
{
    copy(w->y_high, w->y, w->system->states);
    copy(w->f_high, w->k[6], w->system->states);
    copy(w->g_high, w->g_new, w->system->indicators);
}

/* Length of the step that ends just beyond the first zero before `high` in a step of h; its end is left in y, k[6] and
 * g_new. Where no sign has changed at `high`, 0, and the step of h is left there. A step often begins on a zero, just
 * located, where the sign is that of rounding for a while: the next is sought from `blind` of the step on, if no sign has
 * changed there. */
static double locate(const Work *w, double t, const double *x, double high, double h, double blind)
{
    int which = ahead(w, t, x, high);
    if (which < 0) {
        ahead(w, t, x, h);
        return 0.0;
    }
    keep_high(w);
    double g_high = w->g_new[which], width = fmax(1e-12 * h, 1e-15 * fabs(t)), start = 0.0;
    const double *g_start = w->g;
    const double g_begin = fabs(w->g[which]);
    if (0.0 < g_begin && g_begin < ROUNDING * fabs(g_high)) {
        const double s = fmin(blind * h, 0.1 * high);
        if (ahead(w, t, x, s) < 0) {
            start = s;
            copy(w->g_inner, w->g_new, w->system->indicators);
            g_start = w->g_inner;
        }
    }
    if (blind > 100.0 * BLIND) /* nothing but rounding changes the sign that often: go on */
        width = fmax(width, blind * h);
    double low = start, g_low = g_start[which];
    int last = 0, slow = 0;
    for (int n = 0; n < MAX_TRIALS && high - low > width; n++) {
        double size = high - low, s;
        if (slow < 2 && g_high != g_low) { /* halved values may underflow, both to zero */
            s = high - g_high * size / (g_high - g_low) + 0.3 * width;
        } else { /* the rule stalls where the indicator touches zero */
            s = low + 0.5 * size;
            slow = 0;
        }
        if (!(s > low + 0.5 * width))
            s = low + 0.5 * width;
        if (s > high - 0.5 * width)
            s = high - 0.5 * width;
        const int changed = ahead(w, t, x, s);
        if (changed < 0) {
            low = s;
            g_low = w->g_new[which];
            g_high *= last < 0 ? 0.5 : 1.0;
            last = -1;
        } else if (changed != which) { /* another indicator changes before this one */
            which = changed;
            high = s;
            g_high = w->g_new[which];
            keep_high(w);
            low = start;
            g_low = g_start[which];
            last = 0;
            size = 2.0 * high;
        } else {
            high = s;
            g_high = w->g_new[which];
            keep_high(w);
            g_low *= last > 0 ? 0.5 : 1.0;
            last = 1;
        }
        slow = high - low > 0.5 * size ? slow + 1 : 0;
    }
    copy(w->y, w->y_high, w->system->states);
    copy(w->k[6], w->f_high, w->system->states);
    copy(w->g_new, w->g_high, w->system->indicators);
    return high;
}

int integrate(const System *system, double *t, double *x, double t_end, double rtol, double atol, double *step, double *work)
{
    Work w = partition(system, work);
    const int n = system->states;
    double h = *step > 0.0 ? *step : t_end - *t, blind = BLIND;
    rates(&w, *t, x, w.k[0]);
    indicate(&w, *t, x, w.g);
    for (int steps = 0; t_end - *t > 0.0;) {
        if (++steps > INTEGRATE_MAX_STEPS)
            return 2;
        const double left = t_end - *t;
        const bool last = h > 0.999999 * left;
        double trial = last ? left : h, landing = last ? t_end : *t + h;
        advance(&w, *t, x, trial);
        const double ratio = error_ratio(&w, x, trial, rtol, atol);
        if (!(ratio <= 1.0)) {
            h = trial * (ratio < 1e300 ? fmax(0.2, 0.9 * pow(ratio, -0.2)) : 0.1);
            if (!(*t + h > *t))
                return 1;
            continue;
        }
        const double grown = ratio > EASY ? trial * fmin(5.0, 0.9 * pow(ratio, -0.2)) : 5.0 * trial;
        bool event = false;
        if (system->indicators > 0) {
            indicate(&w, landing, w.y, w.g_new);
            const double whole = trial;
            double high = changed(&w) ? differ(&w, w.g_new) ? trial : inside(&w, *t, x, trial) : 0.0;
            while (high > 0.0) {
                const double found = locate(&w, *t, x, high, trial, blind);
                if (!(found > 0.0)) /* only the interpolant changes its sign */
                    break;
                trial = found;
                landing = *t + trial;
                event = true;
                high = inside(&w, *t, x, trial);
            }
            blind = event && trial < SHORT * whole ? fmin(4.0 * blind, 0.1) : BLIND;
            copy(w.g, w.g_new, system->indicators);
        }
        /* a step cut short by t_end or an event says nothing against the longer step that was tried before */
        h = trial < h && grown < h ? h : grown;
        *t = landing;
        copy(x, w.y, n);
        double *const begin = w.k[0]; /* the rates at the end are those at the next begin */
        w.k[0] = w.k[6];
        w.k[6] = begin;
        if (event) {
            system->on_event(system->context, *t, x);
            rates(&w, *t, x, w.k[0]);
            indicate(&w, *t, x, w.g);
        }
    }
    *step = h;
    return 0;
}
