#include "wire.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "chain_grade.h"
#include "chain_limits.h"
#include "chain_rest.h"
#include "chain_rules.h"
#include "chain_tableaus.h"
#include "message.h"

void wire_components(const Wire *wire, const double *three, int stride, double *vector)
{
    const int d = wire->stepper.chain.dimensions;
    vector[0] = three[0];
    if (d == 3) vector[1] = three[stride];
    vector[d - 1] = three[2 * stride];
}

void wire_load(Wire *wire, double *x)
{
    ChainState *state = &wire->stepper.state;
    const double *number = x + 7 * wire->size;
    chain_state_in(state, x, wire->size);
    state->step = number[WIRE_STEP];
    state->made_weight = number[WIRE_WEIGHT];
    memcpy(state->made_paid, number + WIRE_PAID0, sizeof state->made_paid);
    state->before_step = number[WIRE_BEFORE];
}

void wire_store(Wire *wire, double *x)
{
    const ChainState *state = &wire->stepper.state;
    double *number = x + 7 * wire->size;
    number[WIRE_STEP] = state->step;
    number[WIRE_WEIGHT] = state->made_weight;
    memcpy(number + WIRE_PAID0, state->made_paid, sizeof state->made_paid);
    number[WIRE_BEFORE] = state->before_step;
}

static double value(const double *k, double s) { return k[0] + s * (k[1] + s * (k[2] + s * k[3])); }
static double rate(const double *k, double s) { return k[1] + s * (2.0 * k[2] + s * 3.0 * k[3]); }
static double integral(const double *k, double s)
{
    return s * (k[0] + s * (k[1] / 2.0 + s * (k[2] / 3.0 + s * k[3] / 4.0)));
}

/* What is done to the wire at s of the step that is under way: ChainMotion. */
static void motion(void *data, double s, Drive *drive)
{
    const Wire *wire = data;
    const double *number = wire->x + 7 * wire->size;
    double place[3], speed[3], change[3], force[3];
    for (int i = 0; i < 3; i++) {
        const double *k = wire->cubics + CUBIC * (IN_VELOCITY_SURGE + i);
        place[i] = integral(k, s);
        speed[i] = value(k, s);
        change[i] = rate(k, s);
        force[i] = value(wire->cubics + CUBIC * (IN_BODY_FORCE_SURGE + i), s);
    }
    wire_components(wire, place, 1, drive->top[0]);
    wire_components(wire, speed, 1, drive->top[1]);
    wire_components(wire, change, 1, drive->top[2]);
    wire_components(wire, force, 1, drive->force);
    for (int c = 0; c < wire->stepper.chain.dimensions; c++) drive->top[0][c] += number[WIRE_TOP + c];
    const double *winch = wire->cubics + CUBIC * IN_PAYOUT_SPEED;
    drive->paid[0] = number[WIRE_OUT] + integral(winch, s);
    drive->paid[1] = value(winch, s);
    drive->paid[2] = rate(winch, s);
}

static void free_wire(Wire *wire)
{
    if (!wire) return;
    chain_stepper_end(&wire->stepper);
    free(wire->vectors);
    free(wire);
}

/* What the chain takes from the numbers, but for its elements. */
static void describe(Instance *it, Wire *wire)
{
    const WireNumbers *numbers = &wire->numbers;
    Chain *chain = &wire->stepper.chain;
    const int d = chain->dimensions = (int)numbers->dimensions, sections = numbers->tail_length > 0.0 ? 2 : 1;
    const double *masses[] = {numbers->body, numbers->clump};
    chain->held = 0;
    chain->damped = numbers->wire[CHAIN_DAMPING] > 0.0;
    chain->fixtures = sections;
    for (int k = 0; k < sections; k++) {
        double *fixture = wire->fixture + k * (d + 2);
        wire_components(wire, masses[k], 1, fixture);
        fixture[d] = masses[k][3];
        fixture[d + 1] = masses[k][4];
    }
    chain->fixture_node = wire->fixture_node;
    chain->fixture = wire->fixture;
    chain->levels = (int)numbers->levels;
    for (int k = 0; k < 2; k++) wire_components(wire, numbers->flow + 3 * k, 1, wire->flow + k * d);
    memcpy(wire->level, numbers->level, sizeof wire->level);
    chain->level = wire->level;
    chain->flow = wire->flow;
    const Function *const own = it->unit->point + (d == 2 ? 0 : 3);
    chain->loads = own[0].call;
    chain->derivatives = own[1].call;
    chain->change = own[2].call;
    chain->work = it->w;
}

/* Material and length of a section, from the lower end up. */
static const double *material_of(const Wire *wire, int section)
{
    return section < wire->stepper.chain.fixtures - 1 ? wire->numbers.tail : wire->numbers.wire;
}

static double length_of(const Wire *wire, int section)
{
    return section < wire->stepper.chain.fixtures - 1 ? wire->numbers.tail_length : wire->numbers.wire_length;
}

/* Room for vectors of so many nodes and elements, and their parts. */
static bool make_room(Wire *wire)
{
    const Chain *chain = &wire->stepper.chain;
    const int points = chain->elements * (chain->degree + 1), d = chain->dimensions, n = wire->size;
    const int state = 7 * n + WIRE_TOP + d;
    const struct {
        double **part;
        int size;
    } parts[] = {
        {&wire->x, state},
        {&wire->kept, state},
        {&wire->steady, n},
        {&wire->still, n},
        {&wire->half, chain->elements},
        {&wire->material, chain->elements * POINT_MATERIAL},
        {&wire->share, points},
        {&wire->v, n},
        {&wire->a, n},
        {&wire->dv, n},
        {&wire->da, n},
        {&wire->needed, n},
        {&wire->n, points * d},
        {&wire->q, points * d},
        {&wire->dn, points * d},
        {&wire->dq, points * d},
        {&wire->pulls, points * d},
        {&wire->dpulls, points * d},
    };
    size_t total = 0;
    for (size_t i = 0; i < sizeof parts / sizeof *parts; i++) total += (size_t)parts[i].size;
    double *block = wire->vectors = calloc(total, sizeof *block);
    for (size_t i = 0; block && i < sizeof parts / sizeof *parts; block += parts[i++].size) *parts[i].part = block;
    return wire->vectors;
}

/* The chain of the graded elements. */
static bool divide(Wire *wire, const GradedElement *elements, int count)
{
    const WireNumbers *numbers = &wire->numbers;
    Chain *chain = &wire->stepper.chain;
    const int sections = chain->fixtures, degree = (int)numbers->degree;
    chain->rule = CHAIN_RULES + degree - 1;
    chain->degree = degree;
    chain->elements = count;
    chain->nodes = count * degree + 1;
    wire->size = chain->nodes * chain->dimensions;
    if (!make_room(wire)) return false;
    chain->last = numbers->wire_length;
    chain->growing = count;
    const double begin = sections == 2 ? numbers->tail_length : 0.0;
    for (int e = count - 1; e >= 0; e--) {
        const GradedElement *one = elements + e;
        wire->half[e] = 0.5 * one->length;
        memcpy(wire->material + e * POINT_MATERIAL, material_of(wire, one->section), POINT_MATERIAL * sizeof(double));
        if (one->section < sections - 1) continue;
        chain->growing = e;
        for (int q = 0; q <= degree; q++) {
            const double s = one->low + 0.5 * one->length * (chain->rule->points[q] + 1.0);
            wire->share[e * (degree + 1) + q] = fmax(0.0, (s - begin) / chain->last);
        }
    }
    chain->half = wire->half;
    chain->material = wire->material;
    chain->share = wire->share;
    wire->fixture_node[1] = chain->growing * degree;
    return true;
}

/* The wire divided as its sections are. */
static void by_sections(Wire *wire, double *half, double *material, Chain *coarse)
{
    const int sections = wire->stepper.chain.fixtures;
    *coarse = wire->stepper.chain;
    coarse->elements = sections;
    coarse->degree = 1;
    wire->fixture_node[1] = 1;
    for (int k = 0; k < sections; k++) {
        half[k] = 0.5 * length_of(wire, k);
        memcpy(material + k * POINT_MATERIAL, material_of(wire, k), POINT_MATERIAL * sizeof(double));
    }
    coarse->half = half;
    coarse->material = material;
}

/* Steady shape, elements, equilibrium. */
static Outcome settle(Instance *it, Wire *wire, ChainShape *shape)
{
    const WireNumbers *numbers = &wire->numbers;
    const double zero[MOST_DIMENSIONS] = {0.0};
    const int degree = (int)numbers->degree, asked = (int)numbers->elements;
    double half[2], material[2 * POINT_MATERIAL];
    Chain coarse;
    by_sections(wire, half, material, &coarse);
    if (!chain_march(&coarse, zero, shape))
        return refuse(it, REFUSED, "the steady shape of the wire was not found beyond s = %g m", shape->reached);
    GradedElement *elements = malloc((size_t)(CHAIN_MOST_ELEMENTS + 1) * sizeof *elements);
    if (!elements) return NO_MEMORY;
    const int count = chain_grade(&coarse, shape, degree, CHAIN_RULES + degree - 1, asked ? asked : CHAIN_MOST_ELEMENTS,
                                  asked ? 0.0 : numbers->tolerance, elements, &wire->error);
    bool done = divide(wire, elements, count);
    free(elements);
    if (!asked && wire->error > numbers->tolerance)
        return refuse(it, REFUSED,
                      "elements: %d of degree %d leave an error of %.2g of the length, about %.0f would reach "
                      "tolerance = %g: raise degree or tolerance",
                      CHAIN_MOST_ELEMENTS, degree, wire->error,
                      ceil(CHAIN_MOST_ELEMENTS * pow(wire->error / numbers->tolerance, 1.0 / (degree + 1.0))),
                      numbers->tolerance);
    if (!done || !chain_stepper_begin(&wire->stepper)) return NO_MEMORY;
    wire_load(wire, wire->x);
    done = chain_rest(&wire->stepper, zero, shape);
    if (!done) return refuse(it, REFUSED, "the wire's equilibrium was not found");
    memcpy(wire->steady, wire->stepper.state.position, (size_t)wire->size * sizeof(double));
    return DONE;
}

static void end(Instance *it)
{
    free_wire(it->wire);
    it->wire = NULL;
    it->states = 0;
    it->x = it->kept_x = it->next_x;
}

static Outcome make(Instance *it)
{
    ChainShape shape = {0};
    Wire *wire = calloc(1, sizeof *wire);
    end(it);
    it->wire = wire;
    if (!wire) return NO_MEMORY;
    memcpy(&wire->numbers, it->c, sizeof wire->numbers);
    ChainStepper *stepper = &wire->stepper;
    stepper->tableau = CHAIN_TABLEAUS + 1; /* of third order, as in Stepper */
    stepper->tolerance = wire->numbers.velocity_tolerance;
    stepper->largest = wire->numbers.largest_step;
    stepper->motion = motion;
    stepper->data = wire;
    describe(it, wire);
    const Outcome outcome = settle(it, wire, &shape);
    chain_shape_end(&shape);
    if (outcome != DONE) return outcome;
    it->x = wire->x;
    it->kept_x = wire->kept;
    it->states = 7 * wire->size + WIRE_TOP + stepper->chain.dimensions;
    wire_rest(wire, it->values + it->unit->first.calculated);
    return DONE;
}

static void begin(Instance *it)
{
    const Wire *wire = it->wire;
    memcpy(it->x, wire->steady, (size_t)wire->size * sizeof *it->x);
}

static Outcome advance(Instance *it, double step)
{
    Wire *wire = it->wire;
    ChainStepper *stepper = &wire->stepper;
    double *number = it->x + 7 * wire->size;
    Drive drive;
    wire->cubics = it->k;
    wire_load(wire, it->x);
    if (!chain_advance(stepper, 0.0, step)) {
        if (stepper->hauled)
            return refuse(it, NO_STEP, "the last section of %g m is hauled in: give it more length",
                          stepper->chain.last);
        return refuse(it, NO_STEP,
                      "the wire's motion was not found at t = %g s, with steps down to %.3g s: a tension or a speed "
                      "changes faster than that, or the wire is folded; give the wire internal damping, or make the "
                      "motion smoother",
                      stepper->failed_at, stepper->failed_step);
    }
    motion(wire, step, &drive);
    wire_store(wire, it->x);
    number[WIRE_OUT] = drive.paid[0];
    memcpy(number + WIRE_TOP, drive.top[0], (size_t)stepper->chain.dimensions * sizeof(double));
    return DONE;
}

const Steps wire_steps = {make, end, begin, advance, wire_observe, wire_forward};
