#include "sea_response.h"

#include <math.h>
#include <stdbool.h>

#include "sea_constants.h"

static double sinc(double u) { return fabs(u) < 1e-4 ? 1.0 - u * u / 6.0 : sin(u) / u; }

/* Signed heave per wave amplitude. */
static double heave_rao(double omega, double speed, double cos_beta, const SeaHull *hull)
{
    const double k = omega * omega / GRAVITY, a = 1.0 - k * speed * cos_beta / (omega > 0.0 ? omega : 1.0), a2 = a * a;
    const double kb = k * hull->breadth, kt = k * hull->draught, c = sinc(0.5 * kb * a2);
    const double damping = kb * c * c * exp(-2.0 * kt * a2), q = damping * a2;
    const double square = (1.0 - 2.0 * kt * a2) * (1.0 - 2.0 * kt * a2) + q * q;
    const double eta = 1.0 / sqrt(square > RESONANCE ? square : RESONANCE);
    const double f = sqrt((1.0 - kt) * (1.0 - kt) + (damping * a) * (damping * a));
    const double along = fabs(cos_beta), depth = hull->smith_oblique > 0.5 ? along : 1.0;
    return eta * exp(-kt * depth) * f * sinc(0.5 * k * along * hull->length);
}

void sea_amplitudes(int signal, const SeaState *sea, const SeaComponents *c, const SeaHull *hull, double *amplitude)
{
    const bool moves = signal == HEAVE || signal == HEAVE_OF_POINT;
    const double cos_beta = cos(sea->direction), sin_beta = sin(sea->direction);
    for (int i = 0; i < c->count; i++) {
        const double along = cos_beta * c->cos[i] - sin_beta * c->sin[i];
        amplitude[2 * i] =
            moves ? sea->height * c->amplitude[i] * heave_rao(sea->frequency * c->x[i], sea->speed, along, hull) : 0.0;
        amplitude[2 * i + 1] = 0.0;
    }
}
