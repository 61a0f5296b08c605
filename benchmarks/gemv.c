/* The least that a linear unit's step can cost: its matrix-vector products, by the runtime's own routine.
 *
 *     gemv NUMBER ROWS COLUMNS [ROWS COLUMNS ...]      (compiled with dense.c)
 *
 * Prints microseconds for one product of each size, the least mean of five batches. */
#define _POSIX_C_SOURCE 200809L
#include "dense.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { MOST = 512 };

static double matrix[2][MOST * MOST], x[MOST], y[MOST];

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

int main(int count, char **words)
{
    const int number = count > 3 ? atoi(words[1]) : 0, products = (count - 2) / 2;
    int rows[2], columns[2];
    double least = INFINITY;
    if (number < 1 || products > 2) return 1;
    for (int i = 0; i < products; i++) {
        rows[i] = atoi(words[2 + 2 * i]);
        columns[i] = atoi(words[3 + 2 * i]);
        if (rows[i] > MOST || columns[i] > MOST) return 1;
        for (int k = 0; k < rows[i] * columns[i]; k++) matrix[i][k] = 1e-3 * (k % 7);
    }
    for (int k = 0; k < MOST; k++) x[k] = 1.0 + k;
    for (int batch = 0; batch < 5; batch++) {
        const double start = now();
        for (int n = 0; n < number; n++)
            for (int i = 0; i < products; i++) {
                x[0] = n; /* so that no product can be left out */
                memset(y, 0, sizeof *y * (size_t)rows[i]);
                apply_add(rows[i], columns[i], matrix[i], x, y);
            }
        least = fmin(least, (now() - start) / number);
    }
    printf("%.4f %g\n", 1e6 * least, y[0]);
    return 0;
}
