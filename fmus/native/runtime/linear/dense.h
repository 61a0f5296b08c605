/* Dense matrices of doubles, column by column, of the size of a model's state. Work space is the caller's. */
#ifndef TOWAGE_DENSE_H
#define TOWAGE_DENSE_H

#include <stdbool.h>

/* y += A x, A m by n; the loop runs down columns, four at a time. */
void apply_add(int m, int n, const double *a, const double *x, double *y);
/* C = A B; A m by k, B k by n. */
void product(int m, int k, int n, const double *a, const double *b, double *c);
/* C = A' B; A k by m, B k by n. */
void product_transposed(int m, int k, int n, const double *a, const double *b, double *c);

/* LU factors with row exchanges in place; false: singular. */
bool lu_factor(int n, double *a, int *pivot);
/* X of A X = B in place of B, n by m. */
void lu_solve(int n, int m, const double *lu, const int *pivot, double *b);

/* A becomes D^-1 A D with D = diag(scale) powers of two, rows and columns of like size (Osborne; Parlett and Reinsch).
 */
void balance(int n, double *a, double *scale);

double norm_1(int m, int n, const double *a);

/* exp(A) in place by scaling and squaring of the Pade approximant of order 13 (Higham, SIAM J. Matrix Analysis 26
 * (2005) 1179-1193); work: 6 n^2 doubles, pivot: n. False: not finite. */
bool exponential(int n, double *a, double *work, int *pivot);

/* R with R R' = P for P symmetric and not negative, which is used up; returns the number of columns of R. Each is taken
 * where the largest share of a diagonal element is left, until none is above rounding. diagonal: work space, n. */
int root_factor(int n, double *p, double *root, double *diagonal);

/* Singular values and vectors by one-sided Jacobi rotations: A, m by n, becomes U diag(s), s falling; V is n by n. */
void singular_values(int m, int n, double *a, double *v, double *s);

#endif
