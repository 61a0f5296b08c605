/* Implicit steps of a chain: models/cable/wire/stepper.py in C, with the tableaus and limits of chain_tableaus.h and
 * chain_limits.h. */
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

/* All there is of a wire in motion: five vectors at nodes, and three for the place that its factors were made at. The
 * caller's: it outlives the stepper's work space. */
typedef struct {
    double *position, *velocity, *acceleration; /* m, m/s, m/s2 */
    double *before;                             /* accelerations before the last step */
    double *made[3];                            /* positions, velocities, accelerations of the factors */
    double made_weight, made_paid[3];           /* weight 0: no factors */
    double before_step, step;                   /* 0: there is none; the next one, s */
} ChainState;

typedef struct {
    Chain chain;
    const ChainTableau *tableau;
    double tolerance, largest; /* m/s a step; s */
    ChainMotion *motion;
    void *data;
    ChainState state;
    bool factored; /* band and inertia are those of the place `kept` */
    bool hauled;   /* a step failed because the last section is hauled in */
    double *kept[3], kept_weight, kept_paid[3];
    double *band, *inertia, *stage_r, *stage_u, *stage_k, *base_r, *base_u, *guess, *change, *us, *ks;
    double failed_at, failed_step; /* s, where no step was found and the last one that was tried */
    long evaluations, factorisations, steps, failures, rejections;
} ChainStepper;

/* Nodes at which a state's vectors stand in one array of 7 vectors, in the order of ChainState. */
void chain_state_in(ChainState *state, double *vectors, int size);

/* Work space for the chain that is set; false: no memory. */
bool chain_stepper_begin(ChainStepper *stepper);
void chain_stepper_end(ChainStepper *stepper);

/* One step of `step`, s, at most; returns its length, 0 where none was found. */
double chain_step(ChainStepper *stepper, double t, double step);

/* As many steps as the tolerance asks for; false: no step was found. */
bool chain_advance(ChainStepper *stepper, double t, double span);

#endif
