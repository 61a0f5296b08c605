/* Kernels: functions of arrays and loops, which traced functions call (models/numeric/kernel.py has the same in
 * Python).
 *
 * A kernel gets its table, which the build made, and its arguments, of which the first is the time. What it keeps in
 * its memory from call to call saves time and changes nothing: results follow from table and arguments. */
#ifndef TOWAGE_KERNEL_H
#define TOWAGE_KERNEL_H

#include <stddef.h>

typedef struct {
    void (*call)(const double *table, const double *argument, double *result, void *memory);
    size_t (*size)(const double *table); /* of its memory, bytes; zero at first */
    const double *table;
} Kernel;

/* Memory of all kernels of a unit; NULL: none left. */
void **kernels_memory(const Kernel *, int count);
void kernels_free(void **memory, int count);

/* models/sea/kernel.py */
void kernel_sea(const double *table, const double *argument, double *result, void *memory);
size_t kernel_sea_size(const double *table);

/* models/route/playback.py */
void kernel_series(const double *table, const double *argument, double *result, void *memory);
size_t kernel_series_size(const double *table);

#endif
