/* Implicit steps of a chain: models/cable/wire/stepper.py in C, with the tableaus and limits of chain_constants.h. */
#ifndef TOWAGE_CHAIN_STEP_H
#define TOWAGE_CHAIN_STEP_H

#include "chain.h"

enum { MOST_STAGES = 6 };

typedef void ChainMotion(void *data, double t, Drive *drive);

typedef struct {
    int stages, order; /* stages after the first */
    double diagonal;
    const double *places, *rows, *error; /* rows: of MOST_STAGES numbers each */
} ChainTableau;

/* All there is of a wire in motion: five vectors at nodes, and three for the place that the factors were made at. */
typedef struct {
    double *position, *velocity, *acceleration; /* m, m/s, m/s2 */
    double *before;                             /* accelerations before the last step */
    double *made[3];                            /* positions, velocities, accelerations of the factors */
    double made_weight;                         /* 0: no factors */
    double before_step, step;                   /* 0: there is none; the next one, s */
} ChainState;

typedef struct {
    Chain chain;
    const ChainTableau *tableau;
    double tolerance, largest; /* m/s a step; s */
    ChainMotion *motion;
    void *data;
    ChainState state;
    bool factored; /* band and inertia are those of state.made */
    double *band, *inertia, *stage_r, *stage_u, *stage_k, *base_r, *base_u, *guess, *change, *us, *ks;
    long evaluations, factorisations, steps, failures, rejections;
} ChainStepper;

/* Work space for the chain that is set; false: no memory. */
bool chain_stepper_begin(ChainStepper *stepper);
void chain_stepper_end(ChainStepper *stepper);

/* One step of `step`, s, at most; returns its length, 0 where none was found. */
double chain_step(ChainStepper *stepper, double t, double step);

/* As many steps as the tolerance asks for; false: no step was found. */
bool chain_advance(ChainStepper *stepper, double t, double span);

#endif
