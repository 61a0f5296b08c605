#include "gains.h"

#include <math.h>
#include <stdlib.h>

#include "dense.h"

void band_frequencies(double band, double *omega)
{
    const double start = fmin(BAND_START, BAND_SHARE * band), ratio = band / start;
    for (int i = 0; i < FREQUENCIES; i++) omega[i] = start * pow(ratio, (double)i / (FREQUENCIES - 1));
}

int counted_inputs(const Instance *it)
{
    const Linear *l = it->unit->linear;
    const int all = l->layout.inputs;
    return l->measured < 0 || it->c[l->measured] > all ? all : (int)it->c[l->measured];
}

bool gains(const StateSpace *s, const double *omega, int inputs, Complex *values)
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
                values[(f * inputs + j) * COMPARED + i] = sum;
            }
    }
    free(room);
    return true;
}

double relative_error(const Complex *values, const Complex *reference, int inputs)
{
    double worst = 0.0;
    /* input by input, the two rows of a pair are next to each other */
    for (int at = 0; at < FREQUENCIES * inputs * COMPARED; at += 2) {
        const double size = fmax(magnitude(reference[at]), magnitude(reference[at + 1]));
        const double first = magnitude(values[at] - reference[at]),
                     second = magnitude(values[at + 1] - reference[at + 1]);
        if (!is_finite(first + second)) return INFINITY;
        if (size > 0.0) worst = fmax(worst, fmax(first, second) / size);
    }
    return worst;
}
