/* Amplitudes of a ship's motions to the components of a sea: models/sea/heave_response.py in C. */
#ifndef TOWAGE_SEA_RESPONSE_H
#define TOWAGE_SEA_RESPONSE_H

/* Significant height, m, peak frequency, rad/s, direction, rad, speed, m/s. */
typedef struct {
    double height, frequency, direction, speed;
} SeaState;

/* Of n components: omega/omega_p, amplitude per significant height, direction relative to the mean one. */
typedef struct {
    int count;
    const double *x, *amplitude, *cos, *sin;
} SeaComponents;

/* Length, breadth times block coefficient, draught, m; whether the Smith factor is oblique. */
typedef struct {
    double length, breadth, draught, smith_oblique;
} SeaHull;

/* Complex amplitudes of a motion, real and imaginary part in turn. */
void sea_amplitudes(int signal, const SeaState *, const SeaComponents *, const SeaHull *, double *amplitude);

#endif
