/* Modal acceleration: Craig, Structural Dynamics (1981), chapter 15. */
#include "basis.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "dense.h"

/* Places of the modes, the most important first. */
static void sort_modes(const double *importance, int count, int *order)
{
    for (int i = 0; i < count; i++) {
        int place = i;
        for (; place > 0 && importance[order[place - 1]] < importance[i]; place--) order[place] = order[place - 1];
        order[place] = i;
    }
}

/* Eigenvalues, eigenvectors V and B in their coordinates, from T = U^H A U; x: work space, n^2. All zero at the start.
 */
static void eigenvectors(int n, int k, const Complex *t, const Complex *u, const double *b, Complex *x, Complex *values,
                         Complex *v, Complex *turned)
{
    for (int j = 0; j < n; j++) {
        values[j] = t[j * (n + 1)];
        right_vector(n, t, j, x + j * n);
        for (int l = 0; l <= j; l++)
            for (int i = 0; i < n; i++) v[i + j * n] += times(u[i + l * n], x[l + j * n]);
    }
    clean(n, values);
    for (int j = 0; j < k; j++) { /* X^-1 U^H B, X with a diagonal of ones */
        Complex *y = turned + j * n;
        for (int i = 0; i < n; i++)
            for (int l = 0; l < n; l++) y[i] += conj(u[l + i * n]) * b[l + j * n];
        for (int i = n - 1; i >= 0; i--)
            for (int l = 0; l < i; l++) y[l] -= times(x[l + i * n], y[i]);
    }
}

/* What a mode leaves behind in the band when static and acceleration correction stand for it. */
static double importance_of(const Measure *m, Complex value, const Complex *left, const Complex *right, int width)
{
    double importance = 0.0;
    for (int f = 0; f < FREQUENCIES; f++) {
        const Complex at = -m->omega[f] * _Complex_I, ratio = at / value;
        const double rest = magnitude(times(ratio, ratio) / (at - value));
        for (int i = 0; i < m->inputs; i++) {
            double strength = 0.0, whole = DBL_MIN;
            for (int row = 0; row < COMPARED; row++) {
                /* |left| |right| over the gain, input by input; the largest of each */
                whole = fmax(whole, magnitude(m->exact[(f * m->inputs + i) * COMPARED + row]));
                strength = fmax(strength, magnitude(right[row]));
            }
            importance = fmax(importance, rest * strength * magnitude(left[i]) / whole * width);
        }
    }
    return importance;
}

bool modal_basis(const Measure *m, Basis *basis, double *room)
{
    const StateSpace *s = m->full;
    const int n = s->n, size = n * n, k = s->k, r = s->r;
    Complex *t = (Complex *)room, *u = t + size, *x = u + size, *v = x + size, *turned = v + size;
    double *a = (double *)(turned + n * k), *b = a + size, *c = b + n * k, *scale = c + r * n, *more = scale + n;
    balanced_copy(s, k, r, a, b, c, scale);
    if (!schur_form(n, a, t, u, more)) return false;
    memset(x, 0, sizeof(Complex) * size);
    memset(v, 0, sizeof(Complex) * size);
    memset(turned, 0, sizeof(Complex) * n * k);
    Complex *values = basis->values;
    eigenvectors(n, k, t, u, b, x, values, v, turned);
    double *importance = more;
    int count = 0, states = 0;
    for (int j = 0; j < n; j++) {
        if (cimag(values[j]) < 0.0) continue;
        Complex *left = basis->left + count * k, *right = basis->right + count * r;
        const int width = cimag(values[j]) > 0.0 ? 2 : 1;
        int largest = 0;
        for (int i = 1; i < n; i++)
            if (magnitude(v[i + j * n]) > magnitude(v[largest + j * n])) largest = i;
        /* the phase of a vector is free: that of a real mode is such that it is real */
        const Complex phase = v[largest + j * n] / magnitude(v[largest + j * n]);
        for (int i = 0; i < k; i++) left[i] = times(turned[j + i * n], phase);
        for (int i = 0; i < r; i++) {
            right[i] = 0.0;
            for (int l = 0; l < n; l++) right[i] += c[i + l * r] * times(v[l + j * n], conj(phase));
        }
        values[count] = values[j];
        basis->width[count] = width;
        states += width;
        importance[count] = importance_of(m, values[count], left, right, width);
        count++;
    }
    basis->count = count;
    sort_modes(importance, count, basis->order);
    return states == n;
}

bool modal_model(const Measure *m, const Basis *basis, int states, double *room, StateSpace *model)
{
    const int n = states, k = m->full->k, r = m->full->r;
    int kept = 0, used = 0;
    while (kept < basis->count && used < n) used += basis->width[basis->order[kept++]];
    if (used != n) return false;
    *model = cut(m->full, n, room);
    double *a = room, *b = a + n * n, *c = b + n * k, *d = c + r * n, *e = d + r * k;
    memset(a, 0, sizeof(double) * n * n);
    for (int place = 0, row = 0; place < basis->count; place++) {
        const int mode = basis->order[place], width = basis->width[mode];
        const Complex value = basis->values[mode], *left = basis->left + mode * k, *right = basis->right + mode * r;
        if (place >= kept) {
            for (int j = 0; j < k; j++) { /* conjugates double the real part of a pair */
                const Complex statics = -width * left[j] / value, acceleration = statics / value;
                for (int i = 0; i < r; i++) {
                    d[i + j * r] += creal(times(right[i], statics));
                    e[i + j * r] += creal(times(right[i], acceleration));
                }
            }
            continue;
        }
        if (!(creal(value) < 0.0)) return false;
        for (int i = 0; i < width; i++) a[(row + i) * (n + 1)] = creal(value);
        if (width == 2) {
            a[row + (row + 1) * n] = cimag(value);
            a[row + 1 + row * n] = -cimag(value);
        }
        for (int j = 0; j < k; j++) {
            b[row + j * n] = width * creal(left[j]);
            if (width == 2) b[row + 1 + j * n] = -2.0 * cimag(left[j]);
        }
        for (int i = 0; i < r; i++) {
            c[i + row * r] = creal(right[i]);
            if (width == 2) c[i + (row + 1) * r] = cimag(right[i]);
        }
        row += width;
    }
    return true;
}
