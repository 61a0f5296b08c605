/* Kernels: functions of arrays and loops, which traced functions call (models/numeric/kernel.py has the same in
 * Python).
 *
 * A kernel gets its table, which the build made, and its arguments, of which the first is the time. What it keeps in
 * its memory from call to call saves time and changes nothing: results follow from table and arguments. */
#ifndef TOWAGE_KERNEL_H
#define TOWAGE_KERNEL_H

#include <stdbool.h>
#include <stddef.h>

typedef struct {
    void (*call)(const double *table, const double *argument, double *result, void *memory);
    size_t (*size)(const double *table); /* of its memory, bytes; zero at first */
    const double *table;
    /* For ensembles, which sum the series of many members at once; NULL where a kernel has none. Fills `result` but for
     * its first four values, which are the sums of the ORDER rows of four that it returns, Chebyshev series at `tau`;
     * or, where it returns NULL, all of it. `same`: only the first two arguments have changed since the last call, and
     * only they are given. */
    const double *(*series)(const double *table, const double *argument, bool same, double *result, void *memory,
                            double *tau);
} Kernel;

/* Memory of all kernels of a unit; NULL: none left. */
void **kernels_memory(const Kernel *, int count);
void kernels_free(void **memory, int count);

/* models/sea/kernel.py */
void kernel_sea(const double *table, const double *argument, double *result, void *memory);
size_t kernel_sea_size(const double *table);
const double *kernel_sea_series(const double *table, const double *argument, bool same, double *result, void *memory,
                                double *tau);

/* models/route/playback.py */
void kernel_series(const double *table, const double *argument, double *result, void *memory);
size_t kernel_series_size(const double *table);

#endif
