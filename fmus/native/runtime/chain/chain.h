/* A wire divided into elements of Gauss-Lobatto points: models/cable/wire/chain.py in C, without payout.
 *
 * Vectors at nodes are node by node, `dimensions` components each, from the lower end. The physics of a point is traced
 * from models/cable/wire/point.py. Matrices of Newton's method are banded, row by row: row i begins at i (2 w + 1), its
 * diagonal stands at w. */
#ifndef TOWAGE_CHAIN_H
#define TOWAGE_CHAIN_H

#include <stdbool.h>

enum { MOST_DIMENSIONS = 3, MOST_DEGREE = 6, POINT_MATERIAL = 15 };

/* A traced function: results of g, its rate, velocity, acceleration, material; columns, derivatives column by column.
 */
typedef int PointFunction(const double **arguments, double **results, long long *iw, double *w, int memory);

typedef struct {
    int dimensions, degree, elements, nodes, held; /* held: the lower end is; the top always is */
    const double *half;                            /* half the length of an element, m */
    const double *material;                        /* POINT_MATERIAL numbers an element */
    bool damped;                                   /* any internal damping */
    const double *points, *weights,
        *slopes; /* in [-1, 1]; of the points; slope of polynomial j at q: [q (p + 1) + j] */
    int fixtures;
    const int *fixture_node;
    const double *fixture; /* of each: masses by component, weight, drag */
    int levels;            /* of the flow */
    const double *level, *flow;
    PointFunction *loads, *derivatives;
    double *work; /* chain_work() numbers */
} Chain;

/* What is done to a wire at a time: position, velocity, acceleration of the top and of a held lower end; force on the
 * body. */
typedef struct {
    double top[3][MOST_DIMENSIONS], lower[3][MOST_DIMENSIONS], force[MOST_DIMENSIONS];
} Drive;

/* Velocity of the water at height z, and its slope over z where asked for. */
void chain_flow(const Chain *chain, double z, double *velocity, double *slope);

/* Adds the load of a fixture at r with u, b to `load`, N. */
void chain_fixture(const Chain *chain, int fixture, const double *r, const double *u, const double *b, double *load);

/* Numbers of work space of a chain. */
int chain_work(const Chain *chain);

/* Forces that the motion r, u, b of the nodes needs at every node, N; zero where nothing holds the node. */
void chain_needed(const Chain *chain, const double *r, const double *u, const double *b, const Drive *drive,
                  double *needed);

/* Band of M + w C + w^2 K and inertia, one block a node, column by column. */
void chain_band(const Chain *chain, const double *r, const double *u, const double *b, double w, double *band,
                double *inertia);

/* Half the width of the band. */
int chain_width(const Chain *chain);

/* LU in place for the free nodes, without row exchanges; false: a pivot is zero or not finite. */
bool chain_factor(const Chain *chain, double *band);

/* Solution in place, for values at all nodes; those that are held become zero. */
void chain_solve(const Chain *chain, const double *band, double *x);

#endif
