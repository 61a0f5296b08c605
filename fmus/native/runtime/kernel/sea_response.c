#include "sea_response.h"

#include <math.h>
#include <stdint.h>

#include "kernel_constants.h"

static double sinc(double u) { return fabs(u) < 1e-4 ? 1.0 - u * u / 6.0 : sin(u) / u; }

/* What heave and pitch share. */
static double lift(double omega, double k, double speed, double cos_beta, const SeaShip *ship)
{
    const double a = 1.0 - k * speed * cos_beta / (omega > 0.0 ? omega : 1.0), a2 = a * a;
    const double kb = k * ship->breadth, kt = k * ship->draught, c = sinc(0.5 * kb * a2);
    const double damping = kb * c * c * exp(-2.0 * kt * a2), q = damping * a2;
    const double square = (1.0 - 2.0 * kt * a2) * (1.0 - 2.0 * kt * a2) + q * q;
    const double eta = 1.0 / sqrt(square > RESONANCE ? square : RESONANCE);
    const double f = sqrt((1.0 - kt) * (1.0 - kt) + (damping * a) * (damping * a));
    return eta * exp(-kt * (ship->smith_oblique > 0.5 ? fabs(cos_beta) : 1.0)) * f;
}

static void by_hull(const SeaShip *ship, int signal, double omega, double speed, double beta, double *re_im)
{
    const double cos_beta = cos(beta), k = omega * omega / GRAVITY, s = 0.5 * k * cos_beta * ship->length;
    re_im[0] = re_im[1] = 0.0;
    if (signal != HEAVE && signal != PITCH && signal != POINT + 2) return;
    const double lifted = lift(omega, k, speed, cos_beta, ship);
    const double slope = fabs(s) < 1e-2 ? s * (1.0 - 0.1 * s * s) / 3.0 : (sin(s) - s * cos(s)) / (s * s);
    const double pitch = lifted * 6.0 / ship->length * slope;
    if (signal != PITCH) re_im[0] = lifted * sinc(fabs(s));
    if (signal != HEAVE) re_im[1] = signal == PITCH ? pitch : -ship->point[0] * pitch;
}

void sea_amplitudes(int signal, const SeaState *sea, const SeaComponents *c, const SeaShip *ship, double *amplitude)
{
    const double cosine = cos(sea->direction), sine = sin(sea->direction);
    for (int i = 0; i < c->count; i++) {
        const double beta = atan2(sine * c->cos[i] + cosine * c->sin[i], cosine * c->cos[i] - sine * c->sin[i]);
        const double omega = sea->frequency * c->x[i], height = sea->height * c->amplitude[i];
        double *h = amplitude + 2 * i;
        if (ship->by_table)
            sea_table_motion(&ship->table, signal, omega, sea->speed, beta, ship->point, h);
        else
            by_hull(ship, signal, omega, sea->speed, beta, h);
        h[0] *= height;
        h[1] *= height;
    }
}

double sea_share_beyond(const SeaState *sea, const SeaComponents *c, const SeaShip *ship)
{
    double share = 0.0;
    if (!ship->by_table) return 0.0;
    for (int i = 0; i < c->count; i++) {
        const double omega = sea->frequency * c->x[i];
        if (omega < ship->table.frequency[0] || omega > ship->table.frequency[ship->table.frequencies - 1])
            share += 16.0 * (0.5 * c->amplitude[i] * c->amplitude[i]);
    }
    return share;
}

void sea_phases(double seed, int n, double *phase)
{
    uint64_t state = (uint64_t)(int64_t)floor(seed + 0.5);
    for (int i = 0; i < n; i++) {
        state += UINT64_C(0x9E3779B97F4A7C15);
        uint64_t z = state;
        z = (z ^ (z >> 30)) * UINT64_C(0xBF58476D1CE4E5B9);
        z = (z ^ (z >> 27)) * UINT64_C(0x94D049BB133111EB);
        z ^= z >> 31;
        phase[i] = 2.0 * PI * ((double)(z >> 11) * 0x1p-53);
    }
}
