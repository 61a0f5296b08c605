/* What is found out about a linear unit at its start: errors of comparisons, how far its modes are resolved. */
#include "study.h"

#include <math.h>
#include <stdlib.h>

#include "call.h"
#include "gains.h"

/* Gains of a set-up over the band. */
static Outcome gains_of(Instance *it, const Function *setup, const Layout *layout, const double *omega, int inputs,
                        Complex *values)
{
    double *constants = malloc(sizeof(double) * layout->constants);
    if (!constants) return NO_MEMORY;
    evaluate(it, setup, (Arguments){{it->p}}, (Results){{constants}});
    const StateSpace model = state_space(layout, constants);
    const bool done = gains(&model, omega, inputs, values);
    free(constants);
    return done ? DONE : NO_MEMORY;
}

Outcome compare(Instance *it)
{
    const Linear *l = it->unit->linear;
    const int inputs = counted_inputs(it), size = FREQUENCIES * COMPARED * inputs;
    if (!l->comparisons) return DONE;
    double omega[FREQUENCIES];
    band_frequencies(it->p[l->band], omega);
    Complex *own = malloc(sizeof(Complex) * 3 * size), *other = own + size, *stand_in = other + size;
    const StateSpace model = state_space(&l->layout, it->c);
    Outcome outcome = own && gains(&model, omega, inputs, own) ? DONE : NO_MEMORY;
    for (const Comparison *each = l->comparison; outcome == DONE && each < l->comparison + l->comparisons; each++) {
        double wanted = 1.0;
        if (each->when.call) evaluate(it, &each->when, (Arguments){{it->p}}, (Results){{&wanted}});
        if (!(wanted > 0.0)) continue;
        const Complex *one = each->stand_in.call ? stand_in : own;
        outcome = gains_of(it, &each->setup, &each->layout, omega, inputs, other);
        if (outcome == DONE && each->stand_in.call)
            outcome = gains_of(it, &each->stand_in, &each->stand_in_layout, omega, inputs, stand_in);
        if (outcome == DONE)
            it->c[each->target] +=
                each->weight * (each->truer ? relative_error(one, other, inputs) : relative_error(other, one, inputs));
    }
    free(own);
    return outcome;
}

static int by_size(const void *a, const void *b)
{
    const double x = magnitude(*(const Complex *)a), y = magnitude(*(const Complex *)b);
    return (x > y) - (x < y);
}

/* Eigenvalues of A(s) of `layout`, by magnitude; room: 2 n^2 complex and n^2 + 2 n doubles. */
static bool modes_at(const Layout *l, const double *c, double s, Complex *values, Complex *room)
{
    double *a = (double *)(room + l->states * l->states);
    combine(l->states * l->states, l->powers, c + l->a, s, a);
    if (!eigenvalues(l->states, a, values, room, a + l->states * l->states)) return false;
    qsort(values, l->states, sizeof(Complex), by_size);
    return true;
}

/* Whether the first modes of the finer set-up are met at schedule s. */
static bool resolved(const Instance *it, const double *finer, double s, Complex *wanted, Complex *own, Complex *room)
{
    const Linear *l = it->unit->linear;
    const Resolution *r = l->resolution;
    const double below = r->below < 0 ? INFINITY : it->c[r->below];
    if (!modes_at(&r->layout, finer, s, wanted, room) || !modes_at(&l->layout, it->c, s, own, room)) return false;
    for (int i = 0, seen = 0; i < r->layout.states && seen < r->modes; i++) {
        if (cimag(wanted[i]) < 0.0) continue;
        seen++;
        double nearest = INFINITY;
        for (int j = 0; j < l->layout.states; j++) nearest = fmin(nearest, magnitude(own[j] - wanted[i]));
        if (magnitude(wanted[i]) < below && !(nearest <= r->error * magnitude(wanted[i]))) return false;
    }
    return true;
}

Outcome resolve(Instance *it)
{
    const Linear *l = it->unit->linear;
    const Resolution *r = l->resolution;
    if (!r) return DONE;
    const size_t n = l->layout.states > r->layout.states ? l->layout.states : r->layout.states;
    Complex *wanted = malloc(sizeof(Complex) * (2 * n * n + 3 * n)), *own = wanted + n, *room = own + n;
    double *finer = malloc(sizeof(double) * r->layout.constants);
    Outcome outcome = NO_MEMORY;
    if (wanted && finer) {
        evaluate(it, &r->setup, (Arguments){{it->p}}, (Results){{finer}});
        int steps = 0;
        while ((steps + 1) * r->grid <= r->end && resolved(it, finer, (steps + 1) * r->grid, wanted, own, room))
            steps++;
        it->c[r->target] = fmax(steps, 0.5) * r->grid;
        outcome = DONE;
    }
    free(wanted);
    free(finer);
    return outcome;
}
