/* A chain on its own, timed: the least that the motion of a wire can cost, without FMI around it.
 *
 *     wire_host < CASE
 *
 * A case is numbers in this order: dimensions degree elements held damped; half lengths; material; number of
 * fixtures, then node and numbers of each; levels, z and flow of each; tolerance, largest step,
 * order; kind of motion (0: heave, 1: turn) and its four numbers (speed, amplitude, omega, ramp; or speed, radius,
 * angle, unused); positions and velocities of the nodes; number of times, the times. Prints a line a time: t, place of
 * the body, pull on the top; and last the processor time of the motion and of the set-up, s, the number of steps,
 * evaluations and factorisations. */
#include "chain_rest.h"
#include "chain_rules.h"
#include "chain_tableaus.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

PointFunction point_loads_2d, point_derivatives_2d, point_loads_3d, point_derivatives_3d;

typedef struct {
    int kind, dimensions;
    double number[4];
} Path;

static double next(void)
{
    double x = 0.0;
    if (scanf("%lf", &x) != 1) exit(2);
    return x;
}

static double *several(int count)
{
    double *x = malloc((size_t)(count + 1) * sizeof *x);
    for (int i = 0; i < count; i++) x[i] = next();
    return x;
}

static void turn(const Path *path, double t, double *r, double *u, double *a)
{
    const double c = path->number[0], radius = path->number[1], whole = path->number[2];
    const double angle = t > 0.0 ? fmin(c * t / radius, whole) : 0.0, sine = sin(angle), cosine = cos(angle);
    const double after = t > 0.0 ? fmax(0.0, t - whole * radius / c) : t;
    const double bend = t > 0.0 && c * t / radius < whole ? c * c / radius : 0.0;
    u[0] = c * cosine;
    u[1] = c * sine;
    r[0] = radius * sine + u[0] * after;
    r[1] = radius * (1.0 - cosine) + u[1] * after;
    a[0] = -bend * sine;
    a[1] = bend * cosine;
}

static void motion(void *data, double t, Drive *drive)
{
    const Path *path = data;
    const int up = path->dimensions - 1;
    if (path->kind == 1) {
        turn(path, t, drive->top[0], drive->top[1], drive->top[2]);
        return;
    }
    const double amplitude = path->number[1], omega = path->number[2], ramp = path->number[3];
    const double x = fmin(t / ramp, 1.0), s = x * x * x * (10.0 - 15.0 * x + 6.0 * x * x);
    const double s1 = 30.0 * x * x * (1.0 - x) * (1.0 - x) / ramp;
    const double s2 = 60.0 * x * (1.0 - x) * (1.0 - 2.0 * x) / ramp / ramp;
    const double sine = sin(omega * t), cosine = cos(omega * t);
    drive->top[0][0] = path->number[0] * t;
    drive->top[1][0] = path->number[0];
    drive->top[0][up] = amplitude * s * sine;
    drive->top[1][up] = amplitude * (s1 * sine + s * omega * cosine);
    drive->top[2][up] = amplitude * (s2 * sine + 2.0 * s1 * omega * cosine - s * omega * omega * sine);
}

static void read_chain(Chain *chain)
{
    chain->dimensions = (int)next();
    chain->degree = (int)next();
    chain->elements = (int)next();
    chain->nodes = chain->elements * chain->degree + 1;
    chain->held = (int)next();
    chain->damped = next() > 0.0;
    const int d = chain->dimensions;
    chain->half = several(chain->elements);
    chain->material = several(chain->elements * POINT_MATERIAL);
    chain->rule = CHAIN_RULES + chain->degree - 1;
    chain->growing = chain->elements; /* nothing is paid out */
    chain->last = 1.0;
    chain->fixtures = (int)next();
    int *nodes = malloc((size_t)(chain->fixtures + 1) * sizeof *nodes);
    double *fixture = malloc((size_t)((chain->fixtures + 1) * (d + 3)) * sizeof *fixture);
    for (int k = 0; k < chain->fixtures; k++) {
        nodes[k] = (int)next();
        for (int i = 0; i < d + 3; i++) fixture[k * (d + 3) + i] = next();
    }
    chain->fixture_node = nodes;
    chain->fixture = fixture;
    chain->levels = (int)next();
    chain->level = several(chain->levels);
    chain->flow = several(chain->levels * d);
    chain->loads = d == 2 ? point_loads_2d : point_loads_3d;
    chain->derivatives = d == 2 ? point_derivatives_2d : point_derivatives_3d;
    chain->work = malloc((size_t)chain_work(chain) * sizeof(double));
}

int main(void)
{
    ChainStepper stepper;
    Path path;
    memset(&stepper, 0, sizeof stepper);
    read_chain(&stepper.chain);
    stepper.tolerance = next();
    stepper.largest = next();
    stepper.tableau = &CHAIN_TABLEAUS[(int)next() - 2];
    path.kind = (int)next();
    path.dimensions = stepper.chain.dimensions;
    for (int i = 0; i < 4; i++) path.number[i] = next();
    stepper.motion = motion;
    stepper.data = &path;
    const int d = path.dimensions, n = stepper.chain.nodes * d;
    double *vectors = calloc((size_t)(7 * n), sizeof *vectors);
    if (!vectors || !chain_stepper_begin(&stepper)) return 2;
    chain_state_in(&stepper.state, vectors, n);
    const int count = (int)next();
    double *times = several(count), *pull = malloc((size_t)n * sizeof *pull), t = 0.0;
    const double velocity[MOST_DIMENSIONS] = {path.number[0]};
    const clock_t first = clock();
    ChainShape shape;
    if (!chain_march(&stepper.chain, velocity, &shape) || !chain_rest(&stepper, velocity, &shape)) return 4;
    chain_shape_end(&shape);
    const clock_t begin = clock();
    for (int k = 0; k < count; k++) {
        Drive drive;
        if (!chain_advance(&stepper, t, times[k] - t)) return 3;
        t = times[k];
        memset(&drive, 0, sizeof drive);
        motion(&path, t, &drive);
        const ChainState *state = &stepper.state;
        const Motion at = {state->position, state->velocity, state->acceleration};
        chain_needed(&stepper.chain, &at, &drive, pull);
        printf("%.17g", t);
        for (int c = 0; c < d; c++) printf(" %.17g", state->position[c] - drive.top[0][c]);
        for (int c = 0; c < d; c++) printf(" %.17g", -pull[n - d + c]);
        printf("\n");
    }
    printf("%.9g %.9g %ld %ld %ld %ld %ld\n", (double)(clock() - begin) / CLOCKS_PER_SEC,
           (double)(begin - first) / CLOCKS_PER_SEC, stepper.steps, stepper.evaluations, stepper.factorisations,
           stepper.failures, stepper.rejections);
    chain_stepper_end(&stepper);
    free(vectors);
    return 0;
}
