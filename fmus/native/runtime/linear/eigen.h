/* Eigenvalues of real matrices, and what a Schur form gives besides: eigenvectors, Lyapunov equations, gains. */
#ifndef TOWAGE_EIGEN_H
#define TOWAGE_EIGEN_H

#include <complex.h>
#include <math.h>
#include <stdbool.h>

typedef double _Complex Complex;

/* A product without the standard's care for infinities, which would be a call each time. */
static inline Complex times(Complex a, Complex b)
{
    const union {
        double part[2];
        Complex value;
    } product = {{creal(a) * creal(b) - cimag(a) * cimag(b), creal(a) * cimag(b) + cimag(a) * creal(b)}};
    return product.value;
}

/* As cabs, which Wine has not. */
static inline double magnitude(Complex z) { return hypot(creal(z), cimag(z)); }

/* A becomes H = Q' A Q, upper Hessenberg, by Householder reflections; Q n by n or NULL. work: n. */
void hessenberg(int n, double *a, double *q, double *work);

/* T = U^H A U upper triangular by shifted QR from a Hessenberg T; U goes on from what it is. Without U (NULL) only the
 * diagonal of T is right. False: no convergence. */
bool schur(int n, Complex *t, Complex *u);

/* The same from a real, balanced A; work: 2 n^2 + n. */
bool schur_form(int n, const double *a, Complex *t, Complex *u, double *work);

/* Eigenvalues of A, which is used up, without order; imaginary parts at the level of rounding are zero. t: work space,
 * n^2; work: 2 n. */
bool eigenvalues(int n, double *a, Complex *values, Complex *t, double *work);

/* Imaginary parts of eigenvalues of a real matrix that are rounding become zero. */
void clean(int n, Complex *values);

/* Right and left eigenvectors of a triangular T: T x = t_jj x, y^H T = t_jj y^H; from a column of zeros, n. */
void right_vector(int n, const Complex *t, int j, Complex *x);
void left_vector(int n, const Complex *t, int j, Complex *y);

/* Y of T Y + Y T^H + F = 0, or of T^H Y + Y T + F = 0 (adjoint), in place of F; T triangular. */
void lyapunov(int n, const Complex *t, bool adjoint, Complex *f);

/* X of (s - H) X = B for a Hessenberg H; work: n^2. */
void resolvent(int n, int m, const double *h, Complex s, const double *b, Complex *x, Complex *work);

#endif
