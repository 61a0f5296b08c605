/* A nonlinear wire under a towpoint that moves as in a sea: the chain of the native runtime, without FMI around it.
 *
 * The towpoint is displaced by r(t) sum Re X_i exp(-i omega_i t), r a rise over `ramp`; `sea` has for each component
 * omega and the real and imaginary parts of X forward and up, five numbers. `nodes` is the equilibrium. Rows of tension
 * at the top and at the body and of the motion of the body, forward and up, at multiples of `step`. */
#include "chain_rules.h"
#include "chain_step.h"
#include "chain_tableaus.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { ROW = 4, COMPONENT = 5, D = 2, VECTORS = 7 };

PointFunction point_loads_2d, point_derivatives_2d;

typedef struct {
    long count;
    const double *sea;
    double ramp;
} Waves;

static void motion(void *data, double t, Drive *drive)
{
    const Waves *waves = data;
    const double s = fmin(t / waves->ramp, 1.0), r = s * s * s * (10.0 - 15.0 * s + 6.0 * s * s);
    const double r1 = 30.0 * s * s * (1.0 - s) * (1.0 - s) / waves->ramp;
    const double r2 = 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s) / (waves->ramp * waves->ramp);
    memset(drive, 0, sizeof *drive);
    for (int c = 0; c < D; c++) {
        double x = 0.0, x1 = 0.0, x2 = 0.0;
        for (long i = 0; i < waves->count; i++) {
            const double *k = waves->sea + COMPONENT * i, w = k[0], re = k[1 + 2 * c], im = k[2 + 2 * c];
            const double value = re * cos(w * t) + im * sin(w * t);
            x += value;
            x1 += w * (im * cos(w * t) - re * sin(w * t));
            x2 -= w * w * value;
        }
        drive->top[0][c] = r * x;
        drive->top[1][c] = r * x1 + r1 * x;
        drive->top[2][c] = r * x2 + 2.0 * r1 * x1 + r2 * x;
    }
}

static void observe(ChainStepper *stepper, double t, const double *nodes, double *needed, double *row)
{
    const Chain *chain = &stepper->chain;
    const ChainState *state = &stepper->state;
    Drive drive;
    motion(stepper->data, t, &drive);
    const Motion at = {state->position, state->velocity, state->acceleration};
    chain_needed(chain, &at, &drive, needed);
    const double *top = needed + D * (chain->nodes - 1);
    double body[MOST_DIMENSIONS] = {0.0};
    chain_fixture(chain, 0, state->position, state->velocity, state->acceleration, body);
    row[0] = hypot(top[0], top[1]);
    row[1] = hypot(body[0], body[1]);
    for (int c = 0; c < D; c++) row[2 + c] = state->position[c] - nodes[c];
}

/* 0, or 1 where no memory is left or no step is found. `elements`: of `degree`; their `half` lengths and materials;
 * `body`: masses, weight, drag; `flow` of the water. */
int solve(long degree, long elements, const double *half, const double *material, const double *body,
          const double *flow, const double *nodes, double tolerance, double largest, long count, const double *sea,
          double ramp, long rows, double step, double *found)
{
    const int fixture_node = 0, number = (int)(degree * elements) + 1;
    const double level = 0.0;
    Waves waves = {count, sea, ramp};
    ChainStepper stepper;
    memset(&stepper, 0, sizeof stepper);
    Chain chain = {.dimensions = D, .degree = (int)degree, .elements = (int)elements, .nodes = number};
    chain.half = half;
    chain.material = material;
    chain.rule = CHAIN_RULES + degree - 1;
    chain.growing = chain.elements; /* nothing is paid out */
    chain.last = 1.0;
    chain.fixtures = 1;
    chain.fixture_node = &fixture_node;
    chain.fixture = body;
    chain.levels = 1;
    chain.level = &level;
    chain.flow = flow;
    chain.loads = point_loads_2d;
    chain.derivatives = point_derivatives_2d;
    double *needed = calloc((size_t)((1 + VECTORS) * D * number + chain_work(&chain)), sizeof(double));
    chain.work = needed + (1 + VECTORS) * D * number;
    stepper.chain = chain;
    stepper.tableau = &CHAIN_TABLEAUS[1];
    stepper.tolerance = tolerance;
    stepper.largest = largest;
    stepper.motion = motion;
    stepper.data = &waves;
    bool done = chain_stepper_begin(&stepper) && needed;
    if (done) chain_state_in(&stepper.state, needed + D * number, D * number);
    if (done) memcpy(stepper.state.position, nodes, (size_t)(D * number) * sizeof *nodes);
    for (long k = 0; done && k < rows; k++) {
        done = k == 0 || chain_advance(&stepper, (double)(k - 1) * step, step);
        if (done) observe(&stepper, (double)k * step, nodes, needed, found + ROW * k);
    }
    chain_stepper_end(&stepper);
    free(needed);
    return done ? 0 : 1;
}
