/* A wire divided into elements of Gauss-Lobatto points: models/cable/wire/chain.py in C.
 *
 * Vectors at nodes are node by node, `dimensions` components each, from the lower end. The physics of a point is traced
 * from models/cable/wire/point.py. Matrices of Newton's method are banded, row by row: row i begins at i (2 w + 1), its
 * diagonal stands at w. */
#ifndef TOWAGE_CHAIN_H
#define TOWAGE_CHAIN_H

#include <stdbool.h>

enum { MOST_DIMENSIONS = 3, MOST_DEGREE = 6, POINT_MATERIAL = 16, FIXTURE_OTHERS = 3 };

/* Points of an element of one degree (elements.py): slope of polynomial j at point q is slopes[q (p + 1) + j], its
 * integral up to there integrals[...] likewise; rows of the last two Legendre coefficients of values at points; values
 * of the polynomials at CHAIN_SAMPLES inner places. */
typedef struct {
    const double *points, *weights, *slopes, *integrals, *last, *before, *samples;
} ChainRule;

/* A traced function: results of g, its rate, velocity, acceleration, material; columns, derivatives column by column.
 */
typedef int PointFunction(const double **arguments, double **results, long long *iw, double *w, int memory);

typedef struct {
    int dimensions, degree, elements, nodes, held; /* held: the lower end is; the top always is */
    const double *half;                            /* half the length of an element, m */
    const double *material;                        /* POINT_MATERIAL numbers an element */
    bool damped;                                   /* any internal damping */
    int growing;                                   /* first element of the section that is paid out */
    double last;                                   /* length of that section at the start, m */
    const double *share;                           /* of that section below a point, p + 1 an element */
    const ChainRule *rule;
    int fixtures;
    const int *fixture_node;
    const double *fixture; /* of each: masses by component, weight, drag, force aft */
    int levels;            /* of the flow */
    const double *level, *flow;
    PointFunction *loads, *derivatives, *change; /* change: of loads in a moment, for chain_look.c */
    PointFunction *bent, *bent_change;           /* likewise */
    double *work;                                /* chain_work() numbers */
} Chain;

/* What is done to a wire at a time: position, velocity, acceleration of the top and of a held lower end; force on the
 * body; wire paid out, m, its rate, m/s, and m/s2. */
typedef struct {
    double top[3][MOST_DIMENSIONS], lower[3][MOST_DIMENSIONS], force[MOST_DIMENSIONS], paid[3];
} Drive;

/* Motion of the nodes: positions, velocities, accelerations. */
typedef struct {
    const double *r, *u, *b;
} Motion;

/* Half the length of an element with so much wire paid out, m. */
double chain_half(const Chain *chain, int element, const double *paid);

/* What the functions of a point take at point q of an element, with the place of the point in the band's derivatives.
 */
typedef struct {
    double g[MOST_DIMENSIONS], rate[MOST_DIMENSIONS], v[MOST_DIMENSIONS], a[MOST_DIMENSIONS], slope[MOST_DIMENSIONS];
    double half, slide; /* slide: movement over the material, m/s */
    const double *arguments[5];
} Point;

void chain_point(const Chain *chain, int element, int q, const Motion *at, const double *paid, Point *point);

/* Speed of a fixture through the water, with what keeps its derivative finite (point.py); the velocity, and the slope
 * of the water's over z where asked for. */
double chain_fixture_speed(const Chain *chain, const double *r, const double *u, double *v, double *slope);

/* Velocity of the water at height z, and its slope over z where asked for. */
void chain_flow(const Chain *chain, double z, double *velocity, double *slope);

/* Adds the load of a fixture at r with u, b to `load`, N. */
void chain_fixture(const Chain *chain, int fixture, const double *r, const double *u, const double *b, double *load);

/* Numbers of work space of a chain. */
int chain_work(const Chain *chain);

/* Forces that the motion r, u, b of the nodes needs at every node, N; zero where nothing holds the node. */
void chain_needed(const Chain *chain, const Motion *at, const Drive *drive, double *needed);

/* Band of M + w C + w^2 K and inertia, one block a node, column by column; how payout changes the acceleration is left
 * out. */
void chain_band(const Chain *chain, const Motion *at, const double *paid, double w, double *band, double *inertia);

/* Half the width of the band. */
int chain_width(const Chain *chain);

/* LU in place for the free nodes, without row exchanges; false: a pivot is zero or not finite. */
bool chain_factor(const Chain *chain, double *band);

/* Solution in place, for values at all nodes; those that are held become zero. */
void chain_solve(const Chain *chain, const double *band, double *x);

#endif
