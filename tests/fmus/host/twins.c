/* Parts of the runtime that have no call of their own, for tests/fmus/test_twins.py. */
#include <stdlib.h>
#include <string.h>

#include "gains.h"
#include "reduce.h"
#include "stages.h"

int twin_step(const System *system, double t, const double *x, double h, double *end, double *error);
int twin_reduce(bool modal, const int *sizes, const double *const *matrices, double band, double tolerance,
                double *error, Complex *values);

/* One step of the integrator's method and its error; 0, or 1 without memory. */
int twin_step(const System *system, double t, const double *x, double h, double *end, double *error)
{
    const int n = system->states;
    double *k[STAGES], *room = malloc(sizeof(double) * (STAGES + 1) * n);
    if (!room) return 1;
    for (int j = 0; j < STAGES; j++) k[j] = room + j * n;
    system->rates(system->context, t, x, k[0]);
    stages(system, t, x, h, k, room + STAGES * n, end);
    for (int i = 0; i < n; i++) error[i] = stage_error(i, h, k);
    free(room);
    return 0;
}

/* Reduces the model of `sizes` states, inputs and rows and of the matrices a, b, c, d, e. Its states, its error and its
 * gains over the band; 0: no memory. */
int twin_reduce(bool modal, const int *sizes, const double *const *matrices, double band, double tolerance,
                double *error, Complex *values)
{
    const Linear linear = {
        .layout = {.states = sizes[0], .inputs = sizes[1], .rows = sizes[2]},
        .tolerance = 0,
        .band = 1,
        .modal = modal,
        .measured = -1,
        .error = 0,
    };
    const Unit unit = {.linear = &linear};
    double p[] = {tolerance, band}, omega[FREQUENCIES];
    Instance it = {.unit = &unit, .p = p, .c = error};
    StateSpace model = {sizes[0], sizes[1], sizes[2], matrices[0], matrices[1], matrices[2], matrices[3], matrices[4]};
    double *room = malloc(sizeof(double) * reduced_size(&model));
    *error = 0.0;
    band_frequencies(band, omega);
    const bool done = room && reduce(&it, &model, room) == DONE && gains(&model, omega, sizes[1], values);
    free(room);
    return done ? model.n : 0;
}
