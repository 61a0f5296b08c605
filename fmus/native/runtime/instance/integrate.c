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
} Work;

int integrate_work(int states, int indicators) { return (STAGES + 4) * states + 3 * indicators; }

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
        const double ratio = fabs(error) / (atol + rtol * (a > b ? a : b));
        if (!(ratio <= largest)) largest = ratio;
    }
    return largest;
}

/* Whether some indicator changes sign within the step, looked for at its end and at mid-step. */
static bool crossing(const Work *w, double t, const double *x, double h)
{
    const int n = w->system->states, m = w->system->indicators;
    bool same = true;
    for (int j = 0; j < m; j++) {
        if ((w->g[j] > 0.0) != (w->g_new[j] > 0.0)) return true;
        same = same && w->g[j] == w->g_new[j];
    }
    if (same) return false;
    for (int i = 0; i < n; i++) /* the cubic Hermite interpolant */
        w->point[i] = 0.5 * (x[i] + w->y[i]) + 0.125 * h * (w->k[0][i] - w->k[LAST][i]);
    indicate(w, t + 0.5 * h, w->point, w->g_high);
    for (int j = 0; j < m; j++)
        if ((w->g[j] > 0.0) != (w->g_high[j] > 0.0)) return true;
    return false;
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

/* Length of the step that ends just beyond the first zero; its end is left in y, k[LAST] and g_new. */
static double locate(const Work *w, double t, const double *x, double h)
{
    double low = 0.0, high = h;
    int which = ahead(w, t, x, high);
    if (which < 0) { /* the sign changes only inside: the middle is beyond the first of two zeros */
        high = 0.5 * h;
        which = ahead(w, t, x, high);
        if (which < 0) {
            ahead(w, t, x, h);
            return h;
        }
    }
    keep_high(w);
    double g_low = w->g[which], g_high = w->g_new[which];
    const double width = fmax(EVENT_WIDTH * h, TIME_WIDTH * fabs(t));
    int last = 0, slow = 0;
    for (int n = 0; n < MAX_TRIALS && high - low > width; n++) {
        double size = high - low, s;
        if (slow < 2) {
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
        } else if (changed != which) { /* another indicator changes before this one */
            which = changed;
            high = s;
            g_high = w->g_new[which];
            keep_high(w);
            low = 0.0;
            g_low = w->g[which];
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
    copy(w->k[LAST], w->f_high, w->system->states);
    copy(w->g_new, w->g_high, w->system->indicators);
    return high;
}

int integrate(const System *system, double *t, double *x, double t_end, double rtol, double atol, double *step,
              double *work)
{
    Work w = partition(system, work);
    const int n = system->states;
    double h = *step > 0.0 ? *step : t_end - *t;
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
            event = crossing(&w, *t, x, trial);
            if (event) {
                trial = locate(&w, *t, x, trial);
                landing = *t + trial;
            }
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
            system->on_event(system->context, *t, x);
            rates(system, *t, x, w.k[0]);
            indicate(&w, *t, x, w.g);
        }
    }
    *step = h;
    return 0;
}
