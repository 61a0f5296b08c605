#include "dense.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "constants.h"

void apply_add(int m, int n, const double *restrict a, const double *restrict x, double *restrict y)
{
    int j = 0;
    for (; j + 4 <= n; j += 4) {
        const double x0 = x[j], x1 = x[j + 1], x2 = x[j + 2], x3 = x[j + 3];
        if (x0 == 0.0 && x1 == 0.0 && x2 == 0.0 && x3 == 0.0) continue; /* block matrices, inputs at rest */
        const double *restrict a0 = a + (size_t)j * m, *restrict a1 = a0 + m, *restrict a2 = a1 + m,
                               *restrict a3 = a2 + m;
        for (int i = 0; i < m; i++) y[i] += a0[i] * x0 + a1[i] * x1 + a2[i] * x2 + a3[i] * x3;
    }
    for (; j < n; j++) {
        const double *restrict a0 = a + (size_t)j * m;
        for (int i = 0; i < m; i++) y[i] += a0[i] * x[j];
    }
}

void product(int m, int k, int n, const double *a, const double *b, double *c)
{
    memset(c, 0, sizeof(double) * m * n);
    for (int j = 0; j < n; j++) apply_add(m, k, a, b + (size_t)j * k, c + (size_t)j * m);
}

static double dot(int n, const double *restrict a, const double *restrict b)
{
    double sum = 0.0;
    for (int i = 0; i < n; i++) sum += a[i] * b[i];
    return sum;
}

void product_transposed(int m, int k, int n, const double *a, const double *b, double *c)
{
    for (int j = 0; j < n; j++)
        for (int i = 0; i < m; i++) c[i + (size_t)j * m] = dot(k, a + (size_t)i * k, b + (size_t)j * k);
}

static void exchange(double *a, double *b)
{
    const double kept = *a;
    *a = *b;
    *b = kept;
}

bool lu_factor(int n, double *a, int *pivot)
{
    for (int j = 0; j < n; j++) {
        double *column = a + (size_t)j * n;
        int p = j;
        for (int i = j + 1; i < n; i++)
            if (fabs(column[i]) > fabs(column[p])) p = i;
        pivot[j] = p;
        if (!(fabs(column[p]) > 0.0) || !isfinite(column[p])) return false;
        if (p != j)
            for (int k = 0; k < n; k++) exchange(&a[j + (size_t)k * n], &a[p + (size_t)k * n]);
        const double inverse = 1.0 / column[j];
        for (int i = j + 1; i < n; i++) column[i] *= inverse;
        for (int k = j + 1; k < n; k++) {
            double *restrict other = a + (size_t)k * n;
            const double factor = other[j];
            if (factor != 0.0)
                for (int i = j + 1; i < n; i++) other[i] -= factor * column[i];
        }
    }
    return true;
}

void lu_solve(int n, int m, const double *lu, const int *pivot, double *b)
{
    for (int c = 0; c < m; c++) {
        double *restrict x = b + (size_t)c * n;
        for (int j = 0; j < n; j++)
            if (pivot[j] != j) exchange(&x[j], &x[pivot[j]]);
        for (int j = 0; j < n; j++) {
            const double *column = lu + (size_t)j * n, factor = x[j];
            if (factor != 0.0)
                for (int i = j + 1; i < n; i++) x[i] -= factor * column[i];
        }
        for (int j = n - 1; j >= 0; j--) {
            const double *column = lu + (size_t)j * n, factor = x[j] /= column[j];
            if (factor != 0.0)
                for (int i = 0; i < j; i++) x[i] -= factor * column[i];
        }
    }
}

void balance(int n, double *a, double *scale)
{
    for (int i = 0; i < n; i++) scale[i] = 1.0;
    for (bool again = true; again;) {
        again = false;
        for (int i = 0; i < n; i++) {
            double row = 0.0, column = 0.0;
            for (int j = 0; j < n; j++)
                if (j != i) {
                    row += fabs(a[i + (size_t)j * n]);
                    column += fabs(a[j + (size_t)i * n]);
                }
            if (!(row > 0.0 && column > 0.0 && isfinite(row + column))) continue;
            int exponent;
            frexp(sqrt(row / column), &exponent);
            const double f = ldexp(1.0, exponent - 1);
            /* only what pays: five percent less, as LAPACK has it */
            if (column * f + row / f >= 0.95 * (column + row)) continue;
            again = true;
            scale[i] *= f;
            for (int j = 0; j < n; j++) a[i + (size_t)j * n] /= f;
            for (int j = 0; j < n; j++) a[j + (size_t)i * n] *= f;
        }
    }
}

double norm_1(int m, int n, const double *a)
{
    double norm = 0.0;
    for (int j = 0; j < n; j++) {
        double sum = 0.0;
        for (int i = 0; i < m; i++) sum += fabs(a[i + (size_t)j * m]);
        if (!(sum <= norm)) norm = sum; /* NaN stays */
    }
    return norm;
}

/* sum = b6 a6 + b4 a4 + b2 a2 + b0 1 */
static void polynomial(int n, const double *a6, const double *a4, const double *a2, double b6, double b4, double b2,
                       double b0, double *sum)
{
    for (int i = 0; i < n * n; i++) sum[i] = b6 * a6[i] + b4 * a4[i] + b2 * a2[i];
    for (int i = 0; i < n; i++) sum[i * (n + 1)] += b0;
}

bool exponential(int n, double *a, double *work, int *pivot)
{
    const int size = n * n;
    double *a2 = work, *a4 = a2 + size, *a6 = a4 + size, *odd = a6 + size, *even = odd + size, *more = even + size;
    const double norm = norm_1(n, n, a);
    if (!isfinite(norm)) return false;
    int squarings = 0;
    if (norm > PADE_NORM) {
        squarings = (int)ceil(log2(norm / PADE_NORM));
        for (int i = 0; i < size; i++) a[i] = ldexp(a[i], -squarings);
    }
    product(n, n, n, a, a, a2);
    product(n, n, n, a2, a2, a4);
    product(n, n, n, a4, a2, a6);
    static const double b[] = PADE;
    polynomial(n, a6, a4, a2, b[13], b[11], b[9], 0.0, more);
    product(n, n, n, a6, more, even);
    polynomial(n, a6, a4, a2, b[7], b[5], b[3], b[1], more);
    for (int i = 0; i < size; i++) more[i] += even[i];
    product(n, n, n, a, more, odd);
    polynomial(n, a6, a4, a2, b[12], b[10], b[8], 0.0, more);
    product(n, n, n, a6, more, even);
    polynomial(n, a6, a4, a2, b[6], b[4], b[2], b[0], more);
    for (int i = 0; i < size; i++) {
        more[i] += even[i];
        a[i] = more[i] + odd[i];
        more[i] -= odd[i];
    }
    if (!lu_factor(n, more, pivot)) return false;
    lu_solve(n, n, more, pivot, a);
    for (; squarings > 0; squarings--) {
        product(n, n, n, a, a, a2);
        memcpy(a, a2, sizeof(double) * size);
    }
    return isfinite(norm_1(n, n, a));
}

int root_factor(int n, double *p, double *root, double *diagonal)
{
    for (int i = 0; i < n; i++) diagonal[i] = p[i * (n + 1)];
    for (int rank = 0; rank < n; rank++) {
        double share = n * DBL_EPSILON;
        int best = -1;
        for (int i = 0; i < n; i++) {
            const double left = p[i * (n + 1)];
            if (left > share * diagonal[i]) best = i, share = left / diagonal[i];
        }
        if (best < 0) return rank;
        double *column = root + (size_t)rank * n;
        const double size = sqrt(p[best * (n + 1)]);
        for (int i = 0; i < n; i++) column[i] = p[i + (size_t)best * n] / size;
        for (int j = 0; j < n; j++)
            for (int i = 0; i < n; i++) p[i + (size_t)j * n] -= column[i] * column[j];
        p[best * (n + 1)] = 0.0;
    }
    return n;
}

static void rotate(int n, double *restrict a, double *restrict b, double c, double s)
{
    for (int i = 0; i < n; i++) {
        const double x = a[i], y = b[i];
        a[i] = c * x - s * y;
        b[i] = s * x + c * y;
    }
}

void singular_values(int m, int n, double *a, double *v, double *s)
{
    enum { SWEEPS = 40 }; /* ten are many */
    memset(v, 0, sizeof(double) * n * n);
    for (int j = 0; j < n; j++) v[j * (n + 1)] = 1.0;
    bool turned = true;
    for (int sweep = 0; turned && sweep < SWEEPS; sweep++) {
        turned = false;
        for (int p = 0; p < n - 1; p++)
            for (int q = p + 1; q < n; q++) {
                double *x = a + (size_t)p * m, *y = a + (size_t)q * m;
                const double xx = dot(m, x, x), yy = dot(m, y, y), xy = dot(m, x, y);
                if (!(fabs(xy) > m * DBL_EPSILON * sqrt(xx * yy))) continue;
                turned = true;
                const double zeta = (yy - xx) / (2.0 * xy);
                const double t = copysign(1.0, zeta) / (fabs(zeta) + hypot(1.0, zeta)), c = 1.0 / hypot(1.0, t);
                rotate(m, x, y, c, c * t);
                rotate(n, v + (size_t)p * n, v + (size_t)q * n, c, c * t);
            }
    }
    for (int j = 0; j < n; j++) s[j] = sqrt(dot(m, a + (size_t)j * m, a + (size_t)j * m));
    for (int j = 0; j < n; j++) {
        int largest = j;
        for (int k = j + 1; k < n; k++)
            if (s[k] > s[largest]) largest = k;
        if (largest == j) continue;
        exchange(&s[j], &s[largest]);
        for (int i = 0; i < m; i++) exchange(&a[i + (size_t)j * m], &a[i + (size_t)largest * m]);
        for (int i = 0; i < n; i++) exchange(&v[i + (size_t)j * n], &v[i + (size_t)largest * n]);
    }
}
