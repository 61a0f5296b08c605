/* Singular perturbation of balanced systems: Liu and Anderson, Int. J. Control 50 (1989). */
#include "basis.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "dense.h"

/* Gramian of A X + X A' + B B' = 0, or of its adjoint with C' C, from T = U^H A U; the factor R of X = R R', its
 * columns. */
static int gramian_root(int n, int m, const Complex *t, const Complex *u, const double *b, bool adjoint, double *root,
                        Complex *work, double *real)
{
    Complex *f = work, *turned = f + n * n; /* turned: U^H B, later U Y */
    memset(turned, 0, sizeof(Complex) * n * m);
    for (int j = 0; j < m; j++)
        for (int i = 0; i < n; i++)
            for (int k = 0; k < n; k++)
                turned[i + j * n] += conj(u[k + i * n]) * (adjoint ? b[j + k * m] : b[k + j * n]);
    memset(f, 0, sizeof(Complex) * n * n);
    for (int l = 0; l < m; l++)
        for (int j = 0; j < n; j++)
            for (int i = 0; i < n; i++) f[i + j * n] += times(turned[i + l * n], conj(turned[j + l * n]));
    lyapunov(n, t, adjoint, f);
    memset(turned, 0, sizeof(Complex) * n * n);
    for (int j = 0; j < n; j++)
        for (int k = 0; k < n; k++)
            for (int i = 0; i < n; i++) turned[i + j * n] += times(u[i + k * n], f[k + j * n]);
    memset(real, 0, sizeof(double) * n * n);
    for (int k = 0; k < n; k++)
        for (int j = 0; j < n; j++)
            for (int i = 0; i < n; i++) real[i + j * n] += creal(times(turned[i + k * n], conj(u[j + k * n])));
    for (int j = 0; j < n; j++) /* symmetric but for rounding */
        for (int i = 0; i < j; i++) real[i + j * n] = real[j + i * n] = 0.5 * (real[i + j * n] + real[j + i * n]);
    return root_factor(n, real, root, (double *)work);
}

/* What the compared outputs and inputs are measured by: what passes between them in the band. */
static void weigh(const Measure *m, double *b, double *c, int n)
{
    double out[COMPARED] = {0.0}, force = 0.0;
    for (int f = 0; f < FREQUENCIES; f++)
        for (int j = 0; j < m->inputs; j++)
            for (int i = 0; i < COMPARED; i++) {
                const double size = magnitude(m->exact[(f * m->inputs + j) * COMPARED + i]);
                if (j < 2)
                    out[i] = fmax(out[i], size);
                else if (i < 2)
                    force = fmax(force, size);
            }
    for (int j = 2; j < m->inputs; j++)
        for (int i = 0; i < n; i++) b[i + j * n] *= out[0] / fmax(force, DBL_MIN);
    for (int k = 0; k < n; k++)
        for (int i = 0; i < COMPARED; i++) c[i + k * COMPARED] /= fmax(out[i], DBL_MIN);
}

bool balanced_basis(const Measure *m, Basis *basis, double *room)
{
    const StateSpace *s = m->full;
    const int n = s->n, size = n * n;
    Complex *t = (Complex *)room, *u = t + size,
            *work = u + size; /* work: f and turned, which may be wider than high */
    double *a = (double *)(work + 2 * size + n * (s->k + COMPARED)), *x = a + size, *y = x + size, *v = y + size,
           *more = v + size;
    double *b = more + 3 * size, *c = b + n * s->k, *few_b = c + s->r * n, *few_c = few_b + n * s->k;
    double *scale = few_c + COMPARED * n, *hankel = scale + n;
    balanced_copy(s, s->k, s->r, a, b, c, scale);
    memcpy(few_b, b, sizeof(double) * n * m->inputs);
    for (int k = 0; k < n; k++) memcpy(few_c + k * COMPARED, c + (size_t)k * s->r, sizeof(double) * COMPARED);
    weigh(m, few_b, few_c, n);
    if (!schur_form(n, a, t, u, more)) return false;
    const int p = gramian_root(n, m->inputs, t, u, few_b, false, x, work, more);
    const int q = gramian_root(n, COMPARED, t, u, few_c, true, y, work, more);
    double *between = more; /* Y' X = U S V' */
    product_transposed(q, n, p, y, x, between);
    singular_values(q, p, between, v, hankel);
    int count = 0;
    while (count < p && hankel[count] > NEGLIGIBLE * hankel[0]) count++;
    double *right = more + size, *left = right + size; /* X V S^-1/2, Y U S^-1/2 */
    for (int j = 0; j < count; j++) {
        for (int i = 0; i < q; i++) between[i + j * q] /= hankel[j] * sqrt(hankel[j]);
        for (int i = 0; i < p; i++) v[i + j * p] /= sqrt(hankel[j]);
    }
    product(n, p, count, x, v, right);
    product(n, q, count, y, between, left);
    product(n, n, count, a, right, x);
    product_transposed(count, n, count, left, x, basis->a);
    product_transposed(count, n, s->k, left, b, basis->b);
    product(s->r, n, count, c, right, basis->c);
    basis->count = count;
    return true;
}

bool balanced_model(const Measure *m, const Basis *basis, int states, double *room, StateSpace *model)
{
    const int n = states, count = basis->count, fast = count - n, k = m->full->k, r = m->full->r;
    double *ff = basis->work, *x = ff + fast * fast; /* x: A_ff^-1 [A_fs B_f] */
    *model = cut(m->full, n, room);
    double *a = room, *b = a + n * n, *c = b + n * k, *d = c + r * n;
    for (int j = 0; j < fast; j++) memcpy(ff + j * fast, basis->a + n + (size_t)(n + j) * count, sizeof(double) * fast);
    for (int j = 0; j < n; j++) memcpy(x + j * fast, basis->a + n + (size_t)j * count, sizeof(double) * fast);
    for (int j = 0; j < k; j++) memcpy(x + (n + j) * fast, basis->b + n + (size_t)j * count, sizeof(double) * fast);
    if (!lu_factor(fast, ff, basis->pivot)) return false;
    lu_solve(fast, n + k, ff, basis->pivot, x);
    for (int i = 0; i < fast * (n + k); i++) x[i] = -x[i];
    double *sf = x + fast * (n + k); /* A_sf */
    for (int j = 0; j < fast; j++) memcpy(sf + j * n, basis->a + (size_t)(n + j) * count, sizeof(double) * n);
    for (int j = 0; j < n; j++) memcpy(a + j * n, basis->a + (size_t)j * count, sizeof(double) * n);
    for (int j = 0; j < k; j++) memcpy(b + j * n, basis->b + (size_t)j * count, sizeof(double) * n);
    memcpy(c, basis->c, sizeof(double) * r * n);
    for (int j = 0; j < n + k; j++) {
        const double *response = x + (size_t)j * fast;
        apply_add(n, fast, sf, response, j < n ? a + j * n : b + (j - n) * n);
        apply_add(r, fast, basis->c + (size_t)r * n, response, j < n ? c + (size_t)j * r : d + (size_t)(j - n) * r);
    }
    Complex *values = (Complex *)(sf + n * fast), *t = values + n;
    double *copy = (double *)(t + n * n);
    memcpy(copy, a, sizeof(double) * n * n);
    if (!eigenvalues(n, copy, values, t, copy + n * n)) return false;
    for (int i = 0; i < n; i++)
        if (!(creal(values[i]) < 0.0)) return false;
    return true;
}
