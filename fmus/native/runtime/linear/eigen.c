#include "eigen.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "dense.h"

#define T(i, j) t[(i) + (size_t)(j) * n]

/* Below this share of the largest eigenvalue an imaginary part is rounding: complex arithmetic does not know that those
 * of a real matrix come in pairs. */
static const double NOISE = 1e-10;

static inline double size1(Complex a) { return fabs(creal(a)) + fabs(cimag(a)); }

void hessenberg(int n, double *a, double *q, double *work)
{
    if (q) {
        memset(q, 0, sizeof(double) * n * n);
        for (int i = 0; i < n; i++) q[i * (n + 1)] = 1.0;
    }
    for (int k = 0; k + 2 < n; k++) {
        double *column = a + (size_t)k * n, *v = work, largest = 0.0, square = 0.0;
        for (int i = k + 2; i < n; i++) largest = fmax(largest, fabs(column[i]));
        if (largest == 0.0) continue;
        largest = fmax(largest, fabs(column[k + 1]));
        for (int i = k + 1; i < n; i++) {
            v[i] = column[i] / largest;
            square += v[i] * v[i];
        }
        const double alpha = -copysign(sqrt(square), v[k + 1]), factor = 1.0 / (square - alpha * v[k + 1]);
        v[k + 1] -= alpha;
        for (int j = k; j < n; j++) { /* (1 - factor v v') A */
            double *restrict x = a + (size_t)j * n, sum = 0.0;
            for (int i = k + 1; i < n; i++) sum += v[i] * x[i];
            sum *= factor;
            for (int i = k + 1; i < n; i++) x[i] -= sum * v[i];
        }
        for (double *m = a; m;
             m = m == a ? q : NULL) { /* A (1 - factor v v'), Q likewise, row by row in a block of columns */
            for (int i = 0; i < n; i++) {
                double sum = 0.0;
                for (int j = k + 1; j < n; j++) sum += m[i + (size_t)j * n] * v[j];
                sum *= factor;
                for (int j = k + 1; j < n; j++) m[i + (size_t)j * n] -= sum * v[j];
            }
        }
        for (int i = k + 2; i < n; i++) column[i] = 0.0;
    }
}

/* The root with a real part that is not negative, as csqrt, which Wine has not. */
static Complex square_root(Complex z)
{
    const double x = creal(z), y = cimag(z), larger = sqrt(0.5 * (magnitude(z) + fabs(x)));
    if (!(larger > 0.0)) return 0.0;
    const double smaller = 0.5 * (y / larger);
    return x > 0.0 ? larger + smaller * I : fabs(smaller) + copysign(larger, y) * I;
}

/* Eigenvalue of the trailing 2 by 2 block that is closer to its last element (Wilkinson). */
static Complex shift(int n, const Complex *t, int last)
{
    const Complex a = T(last - 1, last - 1), d = T(last, last), bc = times(T(last - 1, last), T(last, last - 1));
    const Complex half = 0.5 * (a - d);
    Complex root = square_root(times(half, half) + bc);
    if (creal(half) * creal(root) + cimag(half) * cimag(root) < 0.0) root = -root;
    const Complex below = half + root;
    return size1(below) > 0.0 ? d - bc / below : d;
}

bool schur(int n, Complex *t, Complex *u)
{
    enum { PATIENCE = 60, UNUSUAL = 10 }; /* sweeps for one eigenvalue; an exceptional shift every so many */
    int sweeps = 0;
    for (int last = n - 1; last > 0;) {
        int first = last;
        for (; first > 0; first--) {
            const double near = size1(T(first, first)) + size1(T(first - 1, first - 1));
            if (!(size1(T(first, first - 1)) > DBL_EPSILON * near)) break;
        }
        if (first > 0) T(first, first - 1) = 0.0;
        if (first == last) {
            last--;
            sweeps = 0;
            continue;
        }
        if (++sweeps > PATIENCE) return false;
        const Complex s = sweeps % UNUSUAL ? shift(n, t, last) : T(last, last) + size1(T(last, last - 1));
        /* without vectors the active block alone is worked on */
        const int right = u ? n : last + 1, top = u ? 0 : first;
        Complex x = T(first, first) - s, y = T(first + 1, first);
        for (int k = first; k < last; k++) {
            const double r = hypot(magnitude(x), magnitude(y));
            if (!isfinite(r)) return false;
            const Complex c = r > 0.0 ? x / r : 1.0, z = r > 0.0 ? y / r : 0.0, cc = conj(c), zc = conj(z);
            /* rows k, k+1 by G = [c* z*; -z c], columns by its adjoint */
            for (int j = k > first ? k - 1 : k; j < right; j++) {
                const Complex p = T(k, j), q = T(k + 1, j);
                T(k, j) = times(cc, p) + times(zc, q);
                T(k + 1, j) = times(c, q) - times(z, p);
            }
            const int bottom = k + 2 < last ? k + 2 : last;
            Complex *m = t;
            for (int pass = 0; pass < (u ? 2 : 1); pass++, m = u) {
                Complex *restrict left = m + (size_t)k * n, *restrict next = left + n;
                const int end = pass ? n : bottom + 1;
                for (int i = pass ? 0 : top; i < end; i++) {
                    const Complex p = left[i], q = next[i];
                    left[i] = times(p, c) + times(q, z);
                    next[i] = times(q, cc) - times(p, zc);
                }
            }
            if (k > first) T(k + 1, k - 1) = 0.0;
            if (k + 1 < last) x = T(k + 1, k), y = T(k + 2, k);
        }
    }
    return true;
}

bool schur_form(int n, const double *a, Complex *t, Complex *u, double *work)
{
    double *h = work, *q = h + n * n;
    memcpy(h, a, sizeof(double) * n * n);
    hessenberg(n, h, q, q + n * n);
    for (int i = 0; i < n * n; i++) t[i] = h[i], u[i] = q[i];
    return schur(n, t, u);
}

void clean(int n, Complex *values)
{
    double largest = 0.0;
    for (int i = 0; i < n; i++) largest = fmax(largest, size1(values[i]));
    for (int i = 0; i < n; i++)
        if (fabs(cimag(values[i])) <= NOISE * largest) values[i] = creal(values[i]);
}

bool eigenvalues(int n, double *a, Complex *values, Complex *t, double *work)
{
    balance(n, a, work);
    hessenberg(n, a, NULL, work + n);
    for (int i = 0; i < n * n; i++) t[i] = a[i];
    if (!isfinite(norm_1(n, n, a)) || !schur(n, t, NULL)) return false;
    for (int i = 0; i < n; i++) values[i] = T(i, i);
    clean(n, values);
    return true;
}

/* t_ii - t_jj, or what rounding leaves of it where eigenvalues are equal. */
static Complex gap(int n, const Complex *t, int i, int j)
{
    const Complex d = T(i, i) - T(j, j);
    const double least = DBL_EPSILON * (size1(T(0, 0)) + size1(T(n - 1, n - 1)) + size1(T(j, j)));
    return size1(d) > least ? d : least > 0.0 ? least : DBL_MIN;
}

void right_vector(int n, const Complex *t, int j, Complex *x)
{
    x[j] = 1.0;
    for (int k = j; k >= 0; k--) {
        if (k < j) x[k] = -x[k] / gap(n, t, k, j);
        for (int i = 0; i < k; i++) x[i] += times(T(i, k), x[k]);
    }
}

void left_vector(int n, const Complex *t, int j, Complex *y)
{
    y[j] = 1.0;
    for (int k = j + 1; k < n; k++) {
        Complex sum = 0.0;
        for (int i = j; i < k; i++) sum += times(conj(T(i, k)), y[i]);
        y[k] = -sum / conj(gap(n, t, k, j));
    }
}

void lyapunov(int n, const Complex *t, bool adjoint, Complex *f)
{
    for (int step = 0; step < n; step++) {
        const int j = adjoint ? step : n - 1 - step;
        Complex *restrict y = f + (size_t)j * n;
        for (int k = adjoint ? 0 : j + 1; k < (adjoint ? j : n); k++) {
            const Complex factor = adjoint ? T(k, j) : conj(T(j, k));
            const Complex *restrict other = f + (size_t)k * n;
            for (int i = 0; i < n; i++) y[i] += times(factor, other[i]);
        }
        if (adjoint)
            for (int i = 0; i < n; i++) {
                Complex sum = y[i];
                for (int k = 0; k < i; k++) sum += times(conj(T(k, i)), y[k]);
                y[i] = -sum / (conj(T(i, i)) + T(j, j));
            }
        else
            for (int i = n - 1; i >= 0; i--) {
                y[i] = -y[i] / (T(i, i) + conj(T(j, j)));
                for (int k = 0; k < i; k++) y[k] += times(T(k, i), y[i]);
            }
    }
}

void resolvent(int n, int m, const double *h, Complex s, const double *b, Complex *x, Complex *work)
{
    Complex *t = work;
    for (int i = 0; i < n * n; i++) t[i] = -h[i];
    for (int i = 0; i < n; i++) T(i, i) += s;
    for (int i = 0; i < n * m; i++) x[i] = b[i];
    for (int k = 0; k + 1 < n; k++) {
        if (size1(T(k + 1, k)) == 0.0) continue;
        const bool exchange = size1(T(k + 1, k)) > size1(T(k, k));
        const Complex factor = exchange ? T(k, k) / T(k + 1, k) : T(k + 1, k) / T(k, k);
        for (int j = k; j < n + m; j++) {
            Complex *row = j < n ? &T(k, j) : &x[k + (size_t)(j - n) * n], kept = row[exchange];
            row[1] = row[!exchange] - times(factor, kept);
            row[0] = kept;
        }
    }
    for (int j = 0; j < m; j++) {
        Complex *y = x + (size_t)j * n;
        for (int i = n - 1; i >= 0; i--) {
            y[i] = y[i] / T(i, i);
            for (int k = 0; k < i; k++) y[k] -= times(T(k, i), y[i]);
        }
    }
}
