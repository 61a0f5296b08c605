/* What bounds the model of a wire: the end of `outputs` of models/cable/units/wire.py. */
#include <math.h>

#include "chain_look.h"
#include "wire.h"

/* Change of the error by bending `stiff` curvature^2/T. */
static double bending_change(double stiff, const double *bent, const double *moved, const double *pull,
                             const double *pull_change, double size, int d)
{
    double along = 0.0;
    for (int c = 0; c < d; c++) along += pull[c] * pull_change[c];
    const double tension = size + WIRE_LEAST_ROOM, tension_change = size > 0.0 ? along / size : 0.0;
    return stiff * (moved[0] - bent[0] * tension_change / tension) / tension;
}

/* margin_surface and its change. */
static void surface(const Wire *wire, const Motion *at, const Motion *delta, WireModel *model)
{
    const int height = wire->stepper.chain.dimensions - 1;
    const double level = wire->numbers.surface_height, below = level - wire->steady[height];
    const double margin = below > 0.0 ? (level - at->r[height]) / below : 1.0;
    model->surface = fmin(1.0, margin);
    if (delta && margin < 1.0) model->surface_change = -delta->r[height] / below;
}

void wire_model(const Wire *wire, const Motion *at, const Drive *drive, const double *pulls, const Motion *delta,
                const Drive *drive_change, const double *pulls_change, WireModel *model)
{
    const Chain *chain = &wire->stepper.chain;
    const WireNumbers *numbers = &wire->numbers;
    const int d = chain->dimensions, points = chain->degree + 1, tail = numbers->tail_length > 0.0 ? chain->growing : 0;
    int bends = -1, flows = -1;
    double bent[2], moved[2];
    *model = (WireModel){0.0};
    surface(wire, at, delta, model);
    for (int k = 0; k < chain->elements * points; k++) {
        const bool below = k / points < tail;
        double square = 0.0;
        for (int c = 0; c < d; c++) square += pulls[k * d + c] * pulls[k * d + c];
        chain_bent(chain, k, at, drive->paid, bent);
        const double error =
            (below ? numbers->tail_bending : numbers->wire_bending) * bent[0] / (sqrt(square) + WIRE_LEAST_ROOM);
        const double flow = (below ? numbers->tail_diameter : numbers->wire_diameter) * bent[1];
        if (error > model->bending) {
            model->bending = error;
            bends = k;
        }
        if (flow > model->flow) {
            model->flow = flow;
            flows = k;
        }
    }
    if (!delta) return;
    if (bends >= 0) {
        double square = 0.0;
        for (int c = 0; c < d; c++) square += pulls[bends * d + c] * pulls[bends * d + c];
        chain_bent(chain, bends, at, drive->paid, bent);
        chain_bent_change(chain, bends, at, drive->paid, delta, drive_change->paid, moved);
        model->bending_change =
            bending_change(bends / points < tail ? numbers->tail_bending : numbers->wire_bending, bent, moved,
                           pulls + bends * d, pulls_change + bends * d, sqrt(square), d);
    }
    if (flows >= 0) {
        chain_bent_change(chain, flows, at, drive->paid, delta, drive_change->paid, moved);
        model->flow_change = (flows / points < tail ? numbers->tail_diameter : numbers->wire_diameter) * moved[1];
    }
}

void wire_shape(const Wire *wire, const double *r, const double *top, double *shape)
{
    const int d = wire->stepper.chain.dimensions, p = wire->stepper.chain.degree;
    for (int k = 0; k < WIRE_STATIONS; k++) {
        double place[MOST_DIMENSIONS] = {0.0};
        for (int j = 0; j <= p; j++)
            for (int c = 0; c < d; c++) place[c] += wire->at_station[k][j] * r[(wire->station[k] + j) * d + c];
        shape[3 * k + 0] = top[0] - place[0];
        shape[3 * k + 1] = d == 3 ? place[1] - top[1] : 0.0;
        shape[3 * k + 2] = -place[d - 1];
    }
}
