#include "reduce.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "basis.h"

/* Doubles that the elements of a basis, and of the room in which it is made, take for n states, k inputs, r rows. */
static size_t basis_size(size_t n, size_t k, size_t r) { return 2 * n * n + 3 * n * (k + r) + 8 * n; }
static size_t making_size(size_t n, size_t k, size_t r) { return 18 * n * n + 4 * n * (k + r) + 8 * n; }

static Outcome search(Instance *it, Measure *m, StateSpace *model, double *room)
{
    const StateSpace full = *m->full;
    const Linear *l = it->unit->linear;
    const size_t n = full.n, k = full.k, r = full.r, gain = (size_t)FREQUENCIES * COMPARED * m->inputs;
    const double tolerance = it->p[l->tolerance], spent = l->error < 0 ? 0.0 : it->c[l->error];
    const double allowed = fmax(LEAST_SHARE * tolerance, tolerance - spent);
    double *block = malloc(sizeof(double) * (4 * gain + basis_size(n, k, r) + making_size(n, k, r)));
    int *places = malloc(sizeof(int) * 3 * n);
    bool done = false;
    Outcome outcome = NO_MEMORY;
    if (block && places) {
        m->exact = (Complex *)block;
        m->reduced = m->exact + gain;
        Basis basis = {.values = m->reduced + gain, .width = places, .order = places + n, .pivot = places + 2 * n};
        basis.left = basis.values + n;
        basis.right = basis.left + n * k;
        basis.a = (double *)(basis.right + n * r);
        basis.b = basis.a + n * n;
        basis.c = basis.b + n * k;
        basis.work = basis.c + r * n; /* of a candidate; while the basis is made, all of the room */
        outcome = DONE;
        if (gains(&full, m->omega, m->inputs, m->exact)
            && (l->modal ? modal_basis : balanced_basis)(m, &basis, basis.work)) {
            for (int states = 1; !done && states < (int)n; states++) {
                StateSpace candidate;
                if (!l->modal && states >= basis.count) break;
                if (!(l->modal ? modal_model : balanced_model)(m, &basis, states, room, &candidate)) continue;
                if (!gains(&candidate, m->omega, m->inputs, m->reduced)) continue;
                const double error = relative_error(m->reduced, m->exact, m->inputs);
                if (!(error <= allowed)) continue;
                done = true;
                *model = candidate;
                if (l->error >= 0) it->c[l->error] += error;
            }
        }
    }
    free(block);
    free(places);
    return outcome;
}

size_t reduced_size(const StateSpace *full)
{
    const size_t n = full->n, k = full->k, r = full->r + n;
    return n * n + n * k + r * n + 2 * r * k;
}

/* `rows` by `columns` at the top of `all`, ones or zeros below. */
static void extend(int rows, int all, int columns, const double *a, double one, double *extended)
{
    memset(extended, 0, sizeof(double) * all * columns);
    for (int j = 0; j < columns; j++) {
        memcpy(extended + (size_t)j * all, a + (size_t)j * rows, sizeof(double) * rows);
        if (rows + j < all) extended[rows + j + (size_t)j * all] = one;
    }
}

Outcome reduce(Instance *it, StateSpace *model, double *room)
{
    const int n = model->n, k = model->k, r = model->r, rows = r + n;
    double *c = malloc(sizeof(double) * rows * (n + 2 * k)), *d = c + rows * n, *e = d + rows * k;
    if (!c) return NO_MEMORY;
    extend(r, rows, n, model->c, 1.0, c);
    extend(r, rows, k, model->d, 0.0, d);
    extend(r, rows, k, model->e, 0.0, e);
    const StateSpace full = {n, k, rows, model->a, model->b, c, d, e};
    Measure m = {.full = &full, .inputs = counted_inputs(it)};
    band_frequencies(it->p[it->unit->linear->band], m.omega);
    const Outcome outcome = search(it, &m, model, room);
    free(c);
    return outcome;
}
