/* What a file recorded, played: models/route/playback.py in C. */
#include <math.h>

#include "kernel.h"
#include "kernel_constants.h"

size_t kernel_series_size(const double *table)
{
    (void)table;
    return sizeof(int); /* the row of the last call */
}

static int row_of(const double *time, int rows, double tau, int guess)
{
    if (guess >= 0 && guess < rows - 1 && time[guess] <= tau && tau < time[guess + 1]) return guess;
    int low = 0, high = rows - 1;
    while (high - low > 1) {
        const int middle = (low + high) / 2;
        if (time[middle] <= tau)
            low = middle;
        else
            high = middle;
    }
    return low;
}

void kernel_series(const double *table, const double *argument, double *result, void *memory)
{
    const int rows = (int)table[0], columns = (int)table[1], column = (int)argument[1];
    const double *time = table + 2, *f = time + (column + 1) * rows, *m = f + columns * rows;
    const double pace = argument[2], beyond = argument[4], first = time[0], last = time[rows - 1];
    double tau = argument[3] + pace * argument[0];
    int *kept = memory;
    if (!(first <= tau && tau <= last)) {
        const double slack = SLACK * (1.0 + fabs(tau));
        if (beyond < 0.5 && !(first - slack <= tau && tau <= last + slack)) {
            result[0] = result[1] = result[2] = NAN; /* refused: an output that is no number */
            return;
        }
        if (beyond < 0.5) {
            tau = tau < first ? first : last;
        } else if (beyond < 1.5) {
            result[0] = tau < first ? f[0] : f[rows - 1];
            result[1] = result[2] = 0.0;
            return;
        } else {
            tau = first + fmod(tau - first, last - first);
            if (tau < first) tau += last - first;
        }
    }
    const int k = *kept = row_of(time, rows, tau, *kept);
    const double d = time[k + 1] - time[k], s = (tau - time[k]) / d, rise = (f[k + 1] - f[k]) / d;
    const double c = 3.0 * rise - 2.0 * m[k] - m[k + 1], e = m[k] + m[k + 1] - 2.0 * rise;
    result[0] = f[k] + s * d * (m[k] + s * (c + s * e));
    result[1] = pace * (m[k] + s * (2.0 * c + 3.0 * s * e));
    result[2] = pace * pace * (2.0 * c + 6.0 * s * e) / d;
}
