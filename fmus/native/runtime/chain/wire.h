/* The unit `wire`: models/cable/units/wire.py over the chain in C. Its numbers, inputs, outputs and calculated
 * parameters are the structures of wire_ports.h, made from wire_ports.py. */
#ifndef TOWAGE_WIRE_H
#define TOWAGE_WIRE_H

#include <string.h>

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
    double fixture[2 * (MOST_DIMENSIONS + FIXTURE_OTHERS)], level[2], flow[2 * MOST_DIMENSIONS];
    double begun[MOST_DIMENSIONS]; /* place of the lower end before the step that is under way */
    double needed_top[MOST_DIMENSIONS], needed_lower[MOST_DIMENSIONS], least, most, at_body; /* at rest */
    int station[WIRE_STATIONS];                        /* first node of the element of each */
    double at_station[WIRE_STATIONS][MOST_DEGREE + 1]; /* what its nodes count there */
    double error;                                      /* of the mesh at rest */
    double *v, *a, *dv, *da, *needed;                  /* work space of a look */
    double *n, *q, *dn, *dq, *pulls, *dpulls;
};

/* Numbers of a state behind its seven vectors, the displacement of the towpoint last. */
enum { WIRE_STEP, WIRE_WEIGHT, WIRE_PAID0, WIRE_PAID1, WIRE_PAID2, WIRE_BEFORE, WIRE_OUT, WIRE_TOP };

/* Components of a vector of three among the inputs: those that the wire has. */
static inline void wire_components(const Wire *wire, const double *three, int stride, double *vector)
{
    const int d = wire->stepper.chain.dimensions;
    vector[0] = three[0];
    if (d == 3) vector[1] = three[stride];
    vector[d - 1] = three[2 * stride];
}

/* The state of the stepper is that at x, whose vectors it works on; and back. */
static inline void wire_load(Wire *wire, double *x)
{
    ChainState *state = &wire->stepper.state;
    const double *number = x + 7 * wire->size;
    chain_state_in(state, x, wire->size);
    state->step = number[WIRE_STEP];
    state->made_weight = number[WIRE_WEIGHT];
    memcpy(state->made_paid, number + WIRE_PAID0, sizeof state->made_paid);
    state->before_step = number[WIRE_BEFORE];
}

static inline void wire_store(Wire *wire, double *x)
{
    const ChainState *state = &wire->stepper.state;
    double *number = x + 7 * wire->size;
    number[WIRE_STEP] = state->step;
    number[WIRE_WEIGHT] = state->made_weight;
    memcpy(number + WIRE_PAID0, state->made_paid, sizeof state->made_paid);
    number[WIRE_BEFORE] = state->before_step;
}

/* What bounds the model at a moment, and its change where there is a `delta`: margin_surface; error of the tension by
 * bending, diameter times speed of the water across the wire, m2/s, the largest of each. */
typedef struct {
    double bending, flow, surface, bending_change, flow_change, surface_change;
} WireModel;

void wire_model(const Wire *wire, const Motion *at, const Drive *drive, const double *pulls, const Motion *delta,
                const Drive *drive_change, const double *pulls_change, WireModel *model);

/* (Distance behind and to port of the towpoint at `top`, depth) of each station, for places of nodes or their changes.
 */
void wire_shape(const Wire *wire, const double *r, const double *top, double *shape);

extern const Steps wire_steps;

/* For wire_steps. A wire of its parameters, without its elements; NULL: no memory. Then all the rest. */
Wire *wire_make(Instance *);
Outcome wire_settle(Instance *);
void wire_free(Wire *);
/* What is seen of a wire, and how it answers to seeds. */
Outcome wire_observe(Instance *, double *observed);
Outcome wire_forward(Instance *, double seed_t, double *sensed);
/* Forces at rest, from which outputs count, and the calculated parameters. */
void wire_rest(Wire *wire, double *calculated);

#endif
