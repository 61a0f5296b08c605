#include "sea_table.h"

#include <math.h>

#include "kernel_constants.h"

enum { MOST = 8 }; /* entries of a weighted sum, some of them twice */

typedef struct {
    int count, entry[MOST];
    double weight[MOST];
} Weights;

static void add(Weights *w, int entry, double weight)
{
    w->entry[w->count] = entry;
    w->weight[w->count++] = weight;
}

/* The last of `places` that is not above x; -1: all are. */
static int last_below(const double *places, int n, double x)
{
    int low = -1, high = n;
    while (high - low > 1) {
        const int middle = (low + high) / 2;
        if (places[middle] <= x)
            low = middle;
        else
            high = middle;
    }
    return low;
}

static Weights line(const double *places, int n, double x)
{
    Weights w = {0};
    if (n == 1 || x <= places[0]) {
        add(&w, 0, 1.0);
    } else if (x >= places[n - 1]) {
        add(&w, n - 1, 1.0);
    } else {
        const int k = last_below(places, n, x);
        const double s = (x - places[k]) / (places[k + 1] - places[k]);
        add(&w, k, 1.0 - s);
        add(&w, k + 1, s);
    }
    return w;
}

static int around(int i, int n) { return (i % n + n) % n; }

static double place_of(const double *places, int n, int i, double period)
{
    return period > 0.0 ? places[around(i, n)] + (double)((i - around(i, n)) / n) * period : places[i];
}

static Weights cubic(const double *places, int n, double x, double period)
{
    Weights w = {0};
    int k = last_below(places, n, x);
    if (!(period > 0.0)) k = k < 0 ? 0 : k > n - 2 ? n - 2 : k;
    const double here = place_of(places, n, k, period), h = place_of(places, n, k + 1, period) - here;
    const double s = (x - here) / h, rise = s * s * (3.0 - 2.0 * s);
    const double share[2] = {h * s * (1.0 - s) * (1.0 - s), -h * s * s * (1.0 - s)};
    add(&w, k, 1.0 - rise);
    add(&w, k + 1, rise);
    for (int e = 0; e < 2; e++) {
        if (n == 2 && !(period > 0.0)) {
            add(&w, 0, -share[e] / h);
            add(&w, 1, share[e] / h);
            continue;
        }
        const int at = k + e, middle = period > 0.0 ? at : at < 1 ? 1 : at > n - 2 ? n - 2 : at;
        const double a = place_of(places, n, middle - 1, period), b = place_of(places, n, middle, period);
        const double c = place_of(places, n, middle + 1, period), y = place_of(places, n, at, period);
        add(&w, middle - 1, share[e] * (2.0 * y - b - c) / ((a - b) * (a - c)));
        add(&w, middle, share[e] * (2.0 * y - a - c) / ((b - a) * (b - c)));
        add(&w, middle + 1, share[e] * (2.0 * y - a - b) / ((c - a) * (c - b)));
    }
    for (int i = 0; period > 0.0 && i < w.count; i++) w.entry[i] = around(w.entry[i], n);
    return w;
}

SeaTable sea_table(const double *numbers)
{
    SeaTable t = {(int)numbers[0], (int)numbers[1], (int)numbers[2], numbers + 3, 0, 0, 0};
    t.heading = t.speed + t.speeds;
    t.frequency = t.heading + t.headings;
    t.value = t.frequency + t.frequencies;
    return t;
}

static void add_motion(const SeaTable *t, int dof, const Weights *w, double factor, double *re_im)
{
    for (int i = 0; i < w[0].count; i++)
        for (int j = 0; j < w[1].count; j++)
            for (int k = 0; k < w[2].count; k++) {
                const int row = (dof * t->speeds + w[0].entry[i]) * t->headings + w[1].entry[j];
                const double weight = factor * w[0].weight[i] * w[1].weight[j] * w[2].weight[k];
                const double *value = t->value + 2 * (row * t->frequencies + w[2].entry[k]);
                re_im[0] += weight * value[0];
                re_im[1] += weight * value[1];
            }
}

void sea_table_motion(const SeaTable *t, int signal, double omega, double speed, double beta, const double *point,
                      double *re_im)
{
    const double lowest = t->frequency[0], turn = 2.0 * PI;
    re_im[0] = re_im[1] = 0.0;
    if (omega > t->frequency[t->frequencies - 1]) return;
    const Weights w[3] = {line(t->speed, t->speeds, speed),
                          cubic(t->heading, t->headings, beta - turn * floor(beta / turn), turn),
                          cubic(t->frequency, t->frequencies, omega > lowest ? omega : lowest, 0.0)};
    if (signal < POINT) {
        add_motion(t, signal, w, 1.0, re_im);
        return;
    }
    const int axis = signal - POINT, after = (axis + 1) % 3, last = (axis + 2) % 3;
    add_motion(t, axis, w, 1.0, re_im);
    add_motion(t, 3 + after, w, point[last], re_im);
    add_motion(t, 3 + last, w, -point[after], re_im);
}
