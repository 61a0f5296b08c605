/* Kernels (runtime/kernel) lane by lane, each with a memory of its own. Included where the equations call any. */
#ifndef KERNELS_H
#define KERNELS_H

#include <stdint.h>

#include "lanes.h"

#define KERNELS 1
enum { ARGUMENTS = 40, RESULTS = 8 };

void *kernels_make(void);
void kernels_drop(void *);
int towage_kernel(int number, const double *argument, double *result, const long long *memory);

static __thread long long kernel_memory[LANES]; /* addresses */

static void kernels_end(void)
{
    EACH (l) {
        if (kernel_memory[l]) kernels_drop((void *)(intptr_t)kernel_memory[l]);
        kernel_memory[l] = 0;
    }
}

static int kernels_begin(void)
{
    int done = 1;
    EACH (l) done &= (kernel_memory[l] = (long long)(intptr_t)kernels_make()) != 0;
    if (!done) kernels_end();
    return done;
}

static void kernel_lanes(int number, const V *argument, int arguments, V *result, int results)
{
    double a[ARGUMENTS], r[RESULTS];
    EACH (l) {
        for (int i = 0; i < arguments; i++) a[i] = argument[i][l];
        towage_kernel(number, a, r, &kernel_memory[l]);
        for (int i = 0; i < results; i++) result[i][l] = r[i];
    }
}

#endif
