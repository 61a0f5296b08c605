/* Outputs of the unit `wire` and their changes, as `outputs` of models/cable/units/wire.py has them. */
#include <math.h>
#include <stddef.h>
#include <string.h>

#include "chain_look.h"
#include "wire.h"

enum { WIRE_SHAPE = offsetof(WireOutputs, shape1_layback) / sizeof(double) };

/* Forces behind the outputs, or their changes. */
typedef struct {
    double needed[MOST_DIMENSIONS], lower[MOST_DIMENSIONS]; /* at the top and at a held lower end, N */
    const double *pulls;
} Forces;

static double size_of(const double *x, int d)
{
    double square = 0.0;
    for (int c = 0; c < d; c++) square += x[c] * x[c];
    return sqrt(square);
}

/* Change of a size. */
static double size_change(const double *x, const double *dx, int d)
{
    const double size = size_of(x, d);
    double along = 0.0;
    for (int c = 0; c < d; c++) along += x[c] * dx[c];
    return size > 0.0 ? along / size : 0.0;
}

/* Needed forces and pulls from loads at points and on what is fixed. */
static void balance(Wire *wire, const double *n, const double *q, const double *fixtures, double *pulls, Forces *forces)
{
    const Chain *chain = &wire->stepper.chain;
    chain_gather(chain, n, q, fixtures, wire->needed);
    memcpy(forces->needed, wire->needed + wire->size - chain->dimensions, (size_t)chain->dimensions * sizeof(double));
    memset(forces->lower, 0, sizeof forces->lower);
    if (chain->held) memcpy(forces->lower, wire->needed, (size_t)chain->dimensions * sizeof(double));
    chain_pulls(chain, q, fixtures, wire->needed, pulls);
    forces->pulls = pulls;
}

/* Motion of the nodes with the ends where the inputs have them, at the present point. */
static void present(const Wire *wire, const double *x, const double *u, const double *du, Motion *at, Drive *drive)
{
    const size_t bytes = (size_t)wire->size * sizeof(double);
    const int top = wire->size - wire->stepper.chain.dimensions;
    memcpy(wire->v, x + wire->size, bytes);
    memcpy(wire->a, x + 2 * wire->size, bytes);
    wire_components(wire, u + IN_VELOCITY_SURGE, 1, wire->v + top);
    wire_components(wire, du + IN_VELOCITY_SURGE, 1, wire->a + top);
    if (wire->stepper.chain.held) {
        wire_components(wire, u + IN_LOWER_VELOCITY_SURGE, 1, wire->v);
        wire_components(wire, du + IN_LOWER_VELOCITY_SURGE, 1, wire->a);
    }
    wire_components(wire, u + IN_BODY_FORCE_SURGE, 1, drive->force);
    drive->paid[0] = x[7 * wire->size + WIRE_OUT];
    drive->paid[1] = u[IN_PAYOUT_SPEED];
    drive->paid[2] = du[IN_PAYOUT_SPEED];
    *at = (Motion){x, wire->v, wire->a};
}

/* Places of the least and of the largest pull. */
static void extremes(const Wire *wire, const double *pulls, int *least, int *most)
{
    const Chain *chain = &wire->stepper.chain;
    const int d = chain->dimensions, count = chain->elements * (chain->degree + 1);
    *least = *most = 0;
    for (int k = 1; k < count; k++) {
        const double size = size_of(pulls + k * d, d);
        if (size < size_of(pulls + *least * d, d)) *least = k;
        if (size > size_of(pulls + *most * d, d)) *most = k;
    }
}

static Forces forces_at(Wire *wire, const Motion *at, const Drive *drive)
{
    Forces forces;
    double fixtures[2 * MOST_DIMENSIONS];
    chain_loads(&wire->stepper.chain, at, drive->paid, wire->n, wire->q);
    chain_fixture_loads(&wire->stepper.chain, at, drive->force, fixtures);
    balance(wire, wire->n, wire->q, fixtures, wire->pulls, &forces);
    return forces;
}

void wire_rest(Wire *wire, double *calculated)
{
    ChainStepper *stepper = &wire->stepper;
    const int d = stepper->chain.dimensions;
    const Motion at = {wire->steady, wire->still, wire->still};
    Drive drive;
    int least, most;
    memset(&drive, 0, sizeof drive);
    const Forces forces = forces_at(wire, &at, &drive);
    extremes(wire, forces.pulls, &least, &most);
    memcpy(wire->needed_top, forces.needed, sizeof wire->needed_top);
    memcpy(wire->needed_lower, forces.lower, sizeof wire->needed_lower);
    wire->least = size_of(forces.pulls + least * d, d);
    wire->most = size_of(forces.pulls + most * d, d);
    chain_band(&stepper->chain, &at, drive.paid, 0.0, stepper->band, stepper->inertia);
    stepper->factored = false;
    const WireCalculated values = {
        .port_mass = stepper->inertia[wire->size * d - 1],
        .steady_tension_top = size_of(forces.needed, d),
        .steady_tension_body = size_of(forces.pulls, d),
        .steady_depth = -wire->steady[d - 1],
        .elements_used = stepper->chain.elements,
        .mesh_error = wire->error,
    };
    memcpy(calculated, &values, sizeof values);
}

static double breaking_scale(const Wire *wire)
{
    return fmax(wire->numbers.breaking_load - wire->most, WIRE_LEAST_ROOM);
}

Outcome wire_observe(Instance *it, double *observed)
{
    Wire *wire = it->wire;
    const int d = wire->stepper.chain.dimensions;
    const bool space = d == 3;
    const double *r = it->x, *top = it->x + 7 * wire->size + WIRE_TOP, *rest = wire->steady;
    int least, most;
    Motion at;
    Drive drive;
    present(wire, it->x, it->u, it->du, &at, &drive);
    const Forces forces = forces_at(wire, &at, &drive);
    const double *f = forces.needed, *f0 = wire->needed_top, *v = wire->v, breaking = wire->numbers.breaking_load;
    extremes(wire, forces.pulls, &least, &most);
    const double smallest = size_of(forces.pulls + least * d, d), largest = size_of(forces.pulls + most * d, d);
    const double error = chain_shape_error(&wire->stepper.chain, r, drive.paid[0], NULL, 0.0, NULL);
    const double *low = forces.lower, *low0 = wire->needed_lower;
    WireModel model;
    wire_model(wire, &at, &drive, forces.pulls, NULL, NULL, NULL, &model);
    const WireOutputs out = {
        .reaction_surge = f[0] - f0[0],
        .reaction_sway = space ? f[1] - f0[1] : 0.0,
        .reaction_heave = f[d - 1] - f0[d - 1],
        .tension_top = size_of(f, d),
        .tension_body = size_of(forces.pulls, d),
        .tension_least = smallest,
        .tension_most = largest,
        .angle_top = atan2(f[d - 1], size_of(f, d - 1)),
        .depth = -r[d - 1],
        .layback = top[0] - r[0],
        .offset = space ? r[1] - top[1] : 0.0,
        .body_surge = r[0] - rest[0],
        .body_sway = space ? r[1] - rest[1] : 0.0,
        .body_heave = r[d - 1] - rest[d - 1],
        .body_velocity_surge = v[0],
        .body_velocity_sway = space ? v[1] : 0.0,
        .body_velocity_heave = v[d - 1],
        .lower_force_surge = low0[0] - low[0],
        .lower_force_sway = space ? low0[1] - low[1] : 0.0,
        .lower_force_heave = low0[d - 1] - low[d - 1],
        .length = wire->numbers.wire_length + fmax(0.0, wire->numbers.tail_length) + drive.paid[0],
        .margin_slack = fmin(1.0, smallest / wire->least),
        .margin_breaking = breaking > 0.0 ? (breaking - largest) / breaking_scale(wire) : 1.0,
        .margin_resolution = 1.0 - error / wire->numbers.tolerance,
        .margin_bending = 1.0 - fmin(model.bending, WIRE_MOST_BENDING) / WIRE_BENDING_LIMIT,
        .margin_surface = model.surface,
        .margin_drag = 1.0 - model.flow / (WIRE_VISCOSITY * WIRE_REYNOLDS_LIMIT),
        .body_surge_rate = v[0],
        .body_sway_rate = space ? v[1] : 0.0,
        .body_heave_rate = v[d - 1],
    };
    memcpy(observed, &out, sizeof out);
    wire_shape(wire, r, top, observed + WIRE_SHAPE);
    return DONE;
}

/* A change of motion and drive: that of the inputs' seeds, or in time, where the wire's own rates come with it. */
static void seeded(Instance *it, double seed_t, Motion *delta, Drive *drive)
{
    Wire *wire = it->wire;
    const size_t bytes = (size_t)wire->size * sizeof(double);
    const int top = wire->size - wire->stepper.chain.dimensions;
    memset(wire->dv, 0, bytes);
    memset(wire->da, 0, bytes);
    memset(drive, 0, sizeof *drive);
    if (seed_t != 0.0) memcpy(wire->dv, wire->a, bytes);
    wire_components(wire, it->seed_u + IN_VELOCITY_SURGE, 1, wire->dv + top);
    wire_components(wire, it->seed_du + IN_VELOCITY_SURGE, 1, wire->da + top);
    if (wire->stepper.chain.held) {
        wire_components(wire, it->seed_u + IN_LOWER_VELOCITY_SURGE, 1, wire->dv);
        wire_components(wire, it->seed_du + IN_LOWER_VELOCITY_SURGE, 1, wire->da);
    }
    wire_components(wire, it->seed_u + IN_BODY_FORCE_SURGE, 1, drive->force);
    drive->paid[0] = seed_t * it->u[IN_PAYOUT_SPEED];
    drive->paid[1] = it->seed_u[IN_PAYOUT_SPEED];
    drive->paid[2] = it->seed_du[IN_PAYOUT_SPEED];
    *delta = (Motion){seed_t != 0.0 ? wire->v : wire->still, wire->dv, wire->da};
}

static Forces forces_change(Wire *wire, const Motion *at, const Drive *drive, const Motion *delta,
                            const Drive *drive_change)
{
    const Chain *chain = &wire->stepper.chain;
    double fixtures[2 * MOST_DIMENSIONS];
    Forces forces;
    chain_loads_change(chain, at, drive->paid, delta, drive_change->paid, wire->dn, wire->dq);
    chain_fixture_loads_change(chain, at, delta, drive_change->force, fixtures);
    balance(wire, wire->dn, wire->dq, fixtures, wire->dpulls, &forces);
    return forces;
}

/* Rates of the free nodes' accelerations, into da: nothing is needed at them at any time. */
static bool accelerate(Wire *wire, const Motion *at, const Drive *drive, const Motion *delta, const Drive *drive_change)
{
    ChainStepper *stepper = &wire->stepper;
    const int d = stepper->chain.dimensions, n = wire->size - d, first = stepper->chain.held ? d : 0;
    forces_change(wire, at, drive, delta, drive_change);
    chain_band(&stepper->chain, at, drive->paid, 0.0, stepper->band, stepper->inertia);
    stepper->factored = false;
    if (!chain_factor(&stepper->chain, stepper->band)) return false;
    chain_solve(&stepper->chain, stepper->band, wire->needed);
    for (int i = first; i < n; i++) wire->da[i] = -wire->needed[i];
    return true;
}

Outcome wire_forward(Instance *it, double seed_t, double *sensed)
{
    Wire *wire = it->wire;
    const int d = wire->stepper.chain.dimensions;
    const bool space = d == 3;
    int least, most;
    Motion at, delta;
    Drive drive, drive_change;
    double error_change;
    present(wire, it->x, it->u, it->du, &at, &drive);
    seeded(it, seed_t, &delta, &drive_change);
    if (seed_t != 0.0 && !accelerate(wire, &at, &drive, &delta, &drive_change)) wire->da[0] = NAN;
    const Forces forces = forces_at(wire, &at, &drive);
    const Forces df = forces_change(wire, &at, &drive, &delta, &drive_change);
    const double *f = forces.needed, *g = df.needed, *dr = delta.r, *dv = delta.u;
    extremes(wire, forces.pulls, &least, &most);
    const double smallest = size_of(forces.pulls + least * d, d);
    const double dleast = size_change(forces.pulls + least * d, df.pulls + least * d, d);
    const double dmost = size_change(forces.pulls + most * d, df.pulls + most * d, d);
    const double level = size_of(f, d - 1), tension2 = level * level + f[d - 1] * f[d - 1];
    chain_shape_error(&wire->stepper.chain, it->x, drive.paid[0], dr, drive_change.paid[0], &error_change);
    WireModel model;
    wire_model(wire, &at, &drive, forces.pulls, &delta, &drive_change, df.pulls, &model);
    const double *const top_change = dr + wire->size - d; /* seed_t is 0 or 1 */
    const WireOutputs out = {
        .reaction_surge = g[0],
        .reaction_sway = space ? g[1] : 0.0,
        .reaction_heave = g[d - 1],
        .tension_top = size_change(f, g, d),
        .tension_body = size_change(forces.pulls, df.pulls, d),
        .tension_least = dleast,
        .tension_most = dmost,
        .angle_top = (level * g[d - 1] - f[d - 1] * size_change(f, g, d - 1)) / tension2,
        .depth = -dr[d - 1],
        .layback = top_change[0] - dr[0],
        .offset = space ? dr[1] - top_change[1] : 0.0,
        .body_surge = dr[0],
        .body_sway = space ? dr[1] : 0.0,
        .body_heave = dr[d - 1],
        .body_velocity_surge = dv[0],
        .body_velocity_sway = space ? dv[1] : 0.0,
        .body_velocity_heave = dv[d - 1],
        .lower_force_surge = -df.lower[0],
        .lower_force_sway = space ? -df.lower[1] : 0.0,
        .lower_force_heave = -df.lower[d - 1],
        .length = drive_change.paid[0],
        .margin_slack = smallest < wire->least ? dleast / wire->least : 0.0,
        .margin_breaking = wire->numbers.breaking_load > 0.0 ? -dmost / breaking_scale(wire) : 0.0,
        .margin_resolution = -error_change / wire->numbers.tolerance,
        .margin_bending = model.bending < WIRE_MOST_BENDING ? -model.bending_change / WIRE_BENDING_LIMIT : 0.0,
        .margin_surface = model.surface_change,
        .margin_drag = -model.flow_change / (WIRE_VISCOSITY * WIRE_REYNOLDS_LIMIT),
        .body_surge_rate = dv[0],
        .body_sway_rate = space ? dv[1] : 0.0,
        .body_heave_rate = dv[d - 1],
    };
    memcpy(sensed, &out, sizeof out);
    wire_shape(wire, dr, top_change, sensed + WIRE_SHAPE);
    return DONE;
}
