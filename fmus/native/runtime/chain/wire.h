/* The unit `wire`: models/cable/units/wire.py over the chain in C. Its numbers, inputs, outputs and calculated
 * parameters are the structures of wire_ports.h, made from wire_ports.py. */
#ifndef TOWAGE_WIRE_H
#define TOWAGE_WIRE_H

#include "chain_step.h"
#include "instance.h"
#include "wire_ports.h"

/* All that follows from the parameters, and room for a step and a look. */
struct Wire {
    WireNumbers numbers;
    ChainStepper stepper;
    int size;               /* of a vector at nodes */
    const double *cubics;   /* of the inputs, over the step that is under way */
    double *vectors;        /* all vectors that follow, in one block */
    double *x, *kept;       /* the state of the instance, and what a refused step goes back to */
    double *steady, *still; /* nodes at rest; zeros */
    double *half, *material, *share;
    int fixture_node[2];
    double fixture[2 * (MOST_DIMENSIONS + 2)], level[2], flow[2 * MOST_DIMENSIONS];
    double needed_top[MOST_DIMENSIONS], least, most, at_body; /* at rest */
    double error;                                             /* of the mesh at rest */
    double *v, *a, *dv, *da, *needed;                         /* work space of a look */
    double *n, *q, *dn, *dq, *pulls, *dpulls;
};

/* Numbers of a state behind its seven vectors, the displacement of the towpoint last. */
enum { WIRE_STEP, WIRE_WEIGHT, WIRE_PAID0, WIRE_PAID1, WIRE_PAID2, WIRE_BEFORE, WIRE_OUT, WIRE_TOP };

/* The state of the stepper is that at x, whose vectors it works on; and back. */
void wire_load(Wire *wire, double *x);
void wire_store(Wire *wire, double *x);

/* Components of a vector of three among the inputs: those that the wire has. */
void wire_components(const Wire *wire, const double *three, int stride, double *vector);

extern const Steps wire_steps;

/* For wire_steps: what is seen of a wire, and how it answers to seeds. */
Outcome wire_observe(Instance *, double *observed);
Outcome wire_forward(Instance *, double seed_t, double *sensed);
/* Forces at rest, from which outputs count, and the calculated parameters. */
void wire_rest(Wire *wire, double *calculated);

#endif
