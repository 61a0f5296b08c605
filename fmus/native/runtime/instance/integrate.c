/* An embedded Runge-Kutta method with the error control and event location of models/numeric/integrate.py; what a step
 * decides is explained there. stages.h is written from the tableau. */
#include "integrate.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "constants.h"
#include "stages.h"

enum { LAST = STAGES - 1 }; /* stage: the end of the step */

typedef struct {
    const System *system;
    double *k[STAGES];                /* rates of the stages; k[0] at its begin, the last at its end */
    double *y, *point;                /* the step's end; a stage */
    double *g, *g_new;                /* indicators at its begin and end */
    double *y_high, *f_high, *g_high; /* event location: the end beyond the event */
    double *g_inner;                  /* indicators at another place inside */
} Work;

int integrate_work(int states, int indicators) { return (STAGES + 4) * states + 4 * indicators; }

static Work partition(const System *system, double *work)
{
    const int n = system->states, m = system->indicators;
    double *const ends = work + STAGES * n, *const signs = ends + 4 * n;
    Work w = {
        .system = system,
        .y = ends,
        .point = ends + n,
        .y_high = ends + 2 * n,
        .f_high = ends + 3 * n,
        .g = signs,
        .g_new = signs + m,
        .g_high = signs + 2 * m,
        .g_inner = signs + 3 * m,
    };
    for (int j = 0; j < STAGES; j++) w.k[j] = work + j * n;
    return w;
}

static void rates(const System *system, double t, const double *x, double *f)
{
    system->rates(system->context, t, x, f);
}

static void indicate(const Work *w, double t, const double *x, double *g)
{
    if (w->system->indicators > 0) w->system->indicate(w->system->context, t, x, g);
}

/* A step of length h from (t, x) with the rates k[0]: its end goes to y, the rates there to the last k. */
static void advance(const Work *w, double t, const double *x, double h)
{
    stages(w->system, t, x, h, w->k, w->point, w->y);
}

/* Largest error of that step over its tolerance. */
static double error_ratio(const Work *w, const double *x, double h, double rtol, double atol)
{
    double largest = 0.0;
    for (int i = 0; i < w->system->states; i++) {
        const double a = fabs(x[i]), b = fabs(w->y[i]);
        const double error = stage_error(i, h, w->k);
        const double ratio = fabs(error) / (atol + rtol * (a > b ? a : b) + SMALLEST);
        if (!(ratio <= largest)) largest = ratio;
    }
    return largest;
}

/* Whether some indicator has another sign than at the begin. */
static bool differ(const Work *w, const double *g)
{
    for (int j = 0; j < w->system->indicators; j++)
        if ((w->g[j] > 0.0) != (g[j] > 0.0)) return true;
    return false;
}

/* A place within the step where an indicator that has one sign at both ends has the other, 0 if none is found: at
 * mid-step, or where the parabola of an indicator through begin, middle and end has its vertex near zero or beyond. */
static double inside(const Work *w, double t, const double *x, double h)
{
    const int n = w->system->states, m = w->system->indicators;
    double *const middle = w->g_high, *const there = w->g_inner;
    const double *const y = w->y, *const f = w->k[0], *const f_new = w->k[LAST];
    for (int i = 0; i < n; i++) /* the cubic Hermite interpolant */
        w->point[i] = 0.5 * (x[i] + y[i]) + 0.125 * h * (f[i] - f_new[i]);
    indicate(w, t + 0.5 * h, w->point, middle);
    for (int j = 0; j < m; j++) {
        const double a = w->g[j], b = w->g_new[j];
        if ((a > 0.0) != (b > 0.0)) continue;
        if ((a > 0.0) != (middle[j] > 0.0)) return 0.5 * h;
        const double slope = 4.0 * middle[j] - 3.0 * a - b, bend = 2.0 * (a + b) - 4.0 * middle[j];
        if (!(slope * a < 0.0 && 0.0 < bend * a)) continue;
        const double s = -0.5 * slope / bend, bottom = a + 0.5 * s * slope;
        const double largest = fabs(b) > fabs(a) ? fabs(b) : fabs(a);
        if (!(s < 1.0 && (bottom * a <= 0.0 || fabs(bottom) < NEAR * largest))) continue;
        const double q = 1.0 - s, wx = q * q * (1.0 + 2.0 * s), wy = s * s * (1.0 + 2.0 * q), wf = h * q * q * s,
                     wg = -h * s * s * q;
        for (int i = 0; i < n; i++) w->point[i] = wx * x[i] + wy * y[i] + wf * f[i] + wg * f_new[i];
        indicate(w, t + s * h, w->point, there);
        for (int i = 0; i < m; i++)
            if ((w->g[i] > 0.0) == (w->g_new[i] > 0.0) && (w->g[i] > 0.0) != (there[i] > 0.0)) return s * h;
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
        if ((w->g[j] > 0.0) == (w->g_new[j] > 0.0)) continue;
        const double share = fabs(w->g[j]) / (fabs(w->g[j]) + fabs(w->g_new[j]) + TINY);
        if (best < 0 || share < nearest) {
            best = j;
            nearest = share;
        }
    }
    return best;
}

static void copy(double *to, const double *from, int count) { memcpy(to, from, (size_t)count * sizeof *to); }

static void keep_high(const Work *w)
{
    copy(w->y_high, w->y, w->system->states);
    copy(w->f_high, w->k[LAST], w->system->states);
    copy(w->g_high, w->g_new, w->system->indicators);
}

/* Length of the step that ends just beyond the first zero before `high` in a step of h; its end is left in y, k[LAST]
 * and g_new. Where no sign has changed at `high`, 0, and the step of h is left there. A step often begins on a zero,
 * just located, where the sign is that of rounding for a while: the next is sought from `blind` of the step on, if no
 * sign has changed there. */
static double locate(const Work *w, double t, const double *x, double high, double h, double blind)
{
    int which = ahead(w, t, x, high);
    if (which < 0) {
        ahead(w, t, x, h);
        return 0.0;
    }
    keep_high(w);
    const double coarse =
        blind > 100.0 * BLIND ? blind * h : 0.0; /* nothing but rounding changes the sign that often */
    const double width = fmax(fmax(EVENT_WIDTH * h, TIME_WIDTH * fabs(t)), coarse),
                 near = fmin(blind * h, MOST_BLIND * high);
    const double g_begin = fabs(w->g[which]), *g_start = w->g;
    double g_high = w->g_new[which], start = 0.0;
    if (0.0 < g_begin && g_begin < ROUNDING * fabs(g_high) && ahead(w, t, x, near) < 0) {
        copy(w->g_inner, w->g_new, w->system->indicators);
        g_start = w->g_inner;
        start = near;
    }
    double low = start, g_low = g_start[which];
    int last = 0, slow = 0;
    for (int n = 0; n < MAX_TRIALS && high - low > width; n++) {
        double size = high - low, s;
        if (slow < 2 && g_high != g_low) { /* halved values may underflow, both to zero */
            s = high - g_high * size / (g_high - g_low) + BEYOND * width;
        } else { /* the rule stalls where the indicator touches zero */
            s = low + 0.5 * size;
            slow = 0;
        }
        if (!(s > low + 0.5 * width)) s = low + 0.5 * width;
        if (s > high - 0.5 * width) s = high - 0.5 * width;
        const int changed = ahead(w, t, x, s);
        if (changed < 0) {
            low = s;
            g_low = w->g_new[which];
            g_high *= last < 0 ? 0.5 : 1.0;
            last = -1;
        } else {
            high = s;
            keep_high(w);
            if (changed == which) {
                g_low *= last > 0 ? 0.5 : 1.0;
                last = 1;
            } else { /* another indicator changes before this one */
                which = changed;
                low = start;
                g_low = g_start[which];
                last = 0;
                size = 2.0 * high;
            }
            g_high = w->g_new[which];
        }
        slow = high - low > 0.5 * size ? slow + 1 : 0;
    }
    copy(w->y, w->y_high, w->system->states);
    copy(w->k[LAST], w->f_high, w->system->states);
    copy(w->g_new, w->g_high, w->system->indicators);
    return high;
}

int integrate(const System *system, double *t, double *x, double t_end, double rtol, double atol, double *step,
              double *work)
{
    Work w = partition(system, work);
    const int n = system->states;
    double h = *step > 0.0 ? *step : t_end - *t, blind = BLIND;
    rates(system, *t, x, w.k[0]);
    indicate(&w, *t, x, w.g);
    for (int steps = 0; t_end - *t > 0.0;) {
        if (++steps > MAX_STEPS) return 2;
        const double left = t_end - *t;
        const bool last = h > LANDING * left;
        double trial = last ? left : h, landing = last ? t_end : *t + h;
        advance(&w, *t, x, trial);
        const double ratio = error_ratio(&w, x, trial, rtol, atol);
        if (!(ratio <= 1.0)) {
            h = trial * (ratio < NO_NUMBER ? fmax(LEAST_GROWTH, SAFETY * pow(ratio, -1.0 / ORDER)) : RESCUE);
            if (!(*t + h > *t)) return 1;
            continue;
        }
        const double grown =
            ratio > EASY ? trial * fmin(MOST_GROWTH, SAFETY * pow(ratio, -1.0 / ORDER)) : MOST_GROWTH * trial;
        bool event = false;
        if (system->indicators > 0) {
            indicate(&w, landing, w.y, w.g_new);
            const double whole = trial;
            double high = differ(&w, w.g_new) ? trial : inside(&w, *t, x, trial);
            while (high > 0.0) {
                const double place = locate(&w, *t, x, high, trial, blind);
                if (!(place > 0.0)) /* only the interpolant changes its sign */
                    break;
                trial = place;
                landing = *t + trial;
                event = true;
                high = inside(&w, *t, x, trial);
            }
            if (!event)
                blind = BLIND;
            else if (trial < SHORT * whole)
                blind = fmin(4.0 * blind, MOST_BLIND);
            copy(w.g, w.g_new, system->indicators);
        }
        /* a step cut short by t_end or an event says nothing against the longer step that was tried before */
        h = trial < h && grown < h ? h : grown;
        *t = landing;
        copy(x, w.y, n);
        double *const begin = w.k[0]; /* the rates at the end are those at the next begin */
        w.k[0] = w.k[LAST];
        w.k[LAST] = begin;
        if (event) {
            if (system->on_event(system->context, *t, x)) break;
            rates(system, *t, x, w.k[0]);
            indicate(&w, *t, x, w.g);
        }
    }
    *step = h;
    return 0;
}
