/* Amplitudes of a ship's motions to the components of a sea: models/sea/kernel.py and heave_response.py in C. */
#ifndef TOWAGE_SEA_RESPONSE_H
#define TOWAGE_SEA_RESPONSE_H

#include <stdbool.h>

#include "sea_table.h"

/* Significant height, m, peak frequency, rad/s, direction, rad, speed, m/s. */
typedef struct {
    double height, frequency, direction, speed;
} SeaState;

/* Of n components: omega/omega_p, amplitude per significant height, direction relative to the mean one. */
typedef struct {
    int count;
    const double *x, *amplitude, *cos, *sin;
} SeaComponents;

/* What answers: a table of responses, or the box of a hull (length, breadth times block coefficient, draught, m;
 * whether the Smith factor is oblique); the point, m ahead, to port and up. */
typedef struct {
    bool by_table;
    SeaTable table;
    double length, breadth, draught, smith_oblique, point[3];
} SeaShip;

/* Complex amplitudes of a motion, real and imaginary part in turn. */
void sea_amplitudes(int signal, const SeaState *, const SeaComponents *, const SeaShip *, double *amplitude);
/* n phases of a seed, rad: SplitMix64, as models/sea/waves.py. */
void sea_phases(double seed, int n, double *phase);
/* Share of the wave energy at frequencies that the table lacks. */
double sea_share_beyond(const SeaState *, const SeaComponents *, const SeaShip *);

#endif
