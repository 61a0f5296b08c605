#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "core.h"
#include "dense.h"
#include "gains.h"

static const double BAND_START = 0.02; /* rad/s */

void evaluate(Instance *it, const Function *f, Arguments a, Results r)
{
    const size_t arguments = sizeof a.at / sizeof *a.at, results = sizeof r.at / sizeof *r.at;
    /* into the instance's lists: traced functions use what is beyond their own arguments as work space */
    for (size_t i = 0; i < arguments && i < (size_t)f->arguments; i++) it->arguments[i] = a.at[i];
    for (size_t i = 0; i < results && i < (size_t)f->results; i++) it->results[i] = r.at[i];
    traced(it, f, it->arguments, it->results);
}

StateSpace state_space(const Layout *l, const double *c)
{
    const StateSpace found = {l->states, l->inputs, l->rows, c + l->a, c + l->b, c + l->c, c + l->d, c + l->e};
    return found;
}

void band_frequencies(double band, double *omega)
{
    const double start = fmin(BAND_START, 0.1 * band), ratio = band / start;
    for (int i = 0; i < FREQUENCIES; i++) omega[i] = start * pow(ratio, (double)i / (FREQUENCIES - 1));
}

int counted_inputs(const Instance *it)
{
    const Linear *l = it->unit->linear;
    const int all = l->layout.inputs;
    return l->measured < 0 || it->c[l->measured] > all ? all : (int)it->c[l->measured];
}

void balanced_copy(const StateSpace *s, int inputs, int rows, double *a, double *b, double *c, double *scale)
{
    const int n = s->n;
    memcpy(a, s->a, sizeof(double) * n * n);
    balance(n, a, scale);
    for (int j = 0; j < inputs; j++)
        for (int i = 0; i < n; i++) b[i + j * n] = s->b[i + j * n] / scale[i];
    for (int j = 0; j < n; j++)
        for (int i = 0; i < rows; i++) c[i + j * rows] = s->c[i + j * s->r] * scale[j];
}

bool gains(const StateSpace *s, const double *omega, int inputs, Complex *found)
{
    const size_t n = s->n, m = inputs;
    double *room = malloc(sizeof(double) * (4 * n * n + 3 * n * m + 2 * COMPARED * n + 2 * n + n * m));
    if (!room) return false;
    Complex *work = (Complex *)room, *x = work + n * n;
    double *a = (double *)(x + n * m), *q = a + n * n, *b = q + n * n, *c = b + n * m, *turned_b = c + COMPARED * n;
    double *turned_c = turned_b + n * m, *scale = turned_c + COMPARED * n, *v = scale + n;
    balanced_copy(s, inputs, COMPARED, a, b, c, scale);
    hessenberg(s->n, a, q, v);
    product_transposed(s->n, s->n, inputs, q, b, turned_b);
    product(COMPARED, s->n, s->n, c, q, turned_c);
    for (int f = 0; f < FREQUENCIES; f++) {
        const Complex s_ = -omega[f] * _Complex_I;
        resolvent(s->n, inputs, a, s_, turned_b, x, work);
        for (int j = 0; j < inputs; j++)
            for (int i = 0; i < COMPARED; i++) {
                Complex sum = s->d[i + j * s->r] + s_ * s->e[i + j * s->r];
                for (size_t k = 0; k < n; k++) sum += turned_c[i + k * COMPARED] * x[k + j * n];
                found[(f * inputs + j) * COMPARED + i] = sum;
            }
    }
    free(room);
    return true;
}

double relative_error(const Complex *found, const Complex *reference, int inputs)
{
    double worst = 0.0;
    /* input by input, the two rows of a pair are next to each other */
    for (int at = 0; at < FREQUENCIES * inputs * COMPARED; at += 2) {
        const double size = fmax(cabs(reference[at]), cabs(reference[at + 1]));
        const double first = cabs(found[at] - reference[at]), second = cabs(found[at + 1] - reference[at + 1]);
        if (!is_finite(first + second)) return INFINITY;
        if (size > 0.0) worst = fmax(worst, fmax(first, second) / size);
    }
    return worst;
}

/* Gains of a set-up over the band. */
static Outcome gains_of(Instance *it, const Function *setup, const Layout *layout, const double *omega, int inputs,
                        Complex *found)
{
    double *constants = malloc(sizeof(double) * layout->constants);
    if (!constants) return NO_MEMORY;
    evaluate(it, setup, (Arguments){{it->p}}, (Results){{constants}});
    const StateSpace model = state_space(layout, constants);
    const bool done = gains(&model, omega, inputs, found);
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
            it->c[each->target] += each->weight * (each->truer ? relative_error(one, other, inputs)
                                                               : relative_error(other, one, inputs));
    }
    free(own);
    return outcome;
}

static int by_size(const void *a, const void *b)
{
    const double x = cabs(*(const Complex *)a), y = cabs(*(const Complex *)b);
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

void combine(int size, int powers, const double *a, double s, double *sum)
{
    memcpy(sum, a + (size_t)(powers - 1) * size, sizeof(double) * size);
    for (int power = powers - 2; power >= 0; power--)
        for (int i = 0; i < size; i++) sum[i] = a[i + (size_t)power * size] + s * sum[i];
}

/* Whether the first modes of the finer set-up are met at schedule s. */
static bool resolved(const Instance *it, const double *finer, double s, Complex *wanted, Complex *found, Complex *room)
{
    const Linear *l = it->unit->linear;
    const Resolution *r = l->resolution;
    const double below = r->below < 0 ? INFINITY : it->c[r->below];
    if (!modes_at(&r->layout, finer, s, wanted, room) || !modes_at(&l->layout, it->c, s, found, room)) return false;
    for (int i = 0, seen = 0; i < r->layout.states && seen < r->modes; i++) {
        if (cimag(wanted[i]) < 0.0) continue;
        seen++;
        double nearest = INFINITY;
        for (int j = 0; j < l->layout.states; j++) nearest = fmin(nearest, cabs(found[j] - wanted[i]));
        if (cabs(wanted[i]) < below && !(nearest <= r->error * cabs(wanted[i]))) return false;
    }
    return true;
}

Outcome resolve(Instance *it)
{
    const Linear *l = it->unit->linear;
    const Resolution *r = l->resolution;
    if (!r) return DONE;
    const size_t n = l->layout.states > r->layout.states ? l->layout.states : r->layout.states;
    Complex *wanted = malloc(sizeof(Complex) * (2 * n * n + 3 * n)), *found = wanted + n, *room = found + n;
    double *finer = malloc(sizeof(double) * r->layout.constants);
    Outcome outcome = NO_MEMORY;
    if (wanted && finer) {
        evaluate(it, &r->setup, (Arguments){{it->p}}, (Results){{finer}});
        int steps = 0;
        while ((steps + 1) * r->grid <= r->end && resolved(it, finer, (steps + 1) * r->grid, wanted, found, room)) steps++;
        it->c[r->target] = fmax(steps, 0.5) * r->grid;
        outcome = DONE;
    }
    free(wanted);
    free(finer);
    return outcome;
}
