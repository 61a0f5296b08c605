#include "state_space.h"

#include <string.h>

#include "dense.h"

StateSpace state_space(const Layout *l, const double *c)
{
    return (StateSpace){l->states, l->inputs, l->rows, c + l->a, c + l->b, c + l->c, c + l->d, c + l->e};
}

void combine(int size, int powers, const double *a, double s, double *sum)
{
    memcpy(sum, a + (size_t)(powers - 1) * size, sizeof(double) * size);
    for (int power = powers - 2; power >= 0; power--)
        for (int i = 0; i < size; i++) sum[i] = a[i + (size_t)power * size] + s * sum[i];
}

StateSpace cut(const StateSpace *full, int states, double *room)
{
    const int n = states, k = full->k, r = full->r;
    double *b = room + n * n, *c = b + n * k, *d = c + r * n, *e = d + r * k;
    const StateSpace model = {n, k, r, room, b, c, d, e};
    memcpy(d, full->d, sizeof(double) * r * k);
    memcpy(e, full->e, sizeof(double) * r * k);
    return model;
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
