/* What follows from the parameters of a wire: the chain of graded elements, its equilibrium, room for all. */
#include <math.h>
#include <stdlib.h>

#include "chain_grade.h"
#include "chain_limits.h"
#include "chain_rest.h"
#include "chain_rules.h"
#include "chain_tableaus.h"
#include "message.h"
#include "wire.h"

void wire_free(Wire *wire)
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
        double *fixture = wire->fixture + k * (d + FIXTURE_OTHERS);
        wire_components(wire, masses[k], 1, fixture);
        memcpy(fixture + d, masses[k] + 3, FIXTURE_OTHERS * sizeof *fixture);
    }
    chain->fixture_node = wire->fixture_node;
    chain->fixture = wire->fixture;
    chain->levels = (int)numbers->levels;
    for (int k = 0; k < 2; k++) wire_components(wire, numbers->flow + 3 * k, 1, wire->flow + k * d);
    memcpy(wire->level, numbers->level, sizeof wire->level);
    chain->level = wire->level;
    chain->flow = wire->flow;
    const Function *const own = it->unit->point + (d == 2 ? 0 : 5);
    chain->loads = own[0].call;
    chain->derivatives = own[1].call;
    chain->change = own[2].call;
    chain->bent = own[3].call;
    chain->bent_change = own[4].call;
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

/* Places in equal parts of the length: their elements, and Lagrange's polynomials there. */
static void find_stations(Wire *wire, const GradedElement *elements, int count)
{
    const int degree = wire->stepper.chain.degree;
    const double *points = wire->stepper.chain.rule->points, all = elements[count - 1].low + elements[count - 1].length;
    for (int k = 0; k < WIRE_STATIONS; k++) {
        const double s = all * (k + 1) / (WIRE_STATIONS + 1);
        int e = 0;
        while (e < count - 1 && elements[e + 1].low <= s) e++;
        const double x = 2.0 * (s - elements[e].low) / elements[e].length - 1.0;
        wire->station[k] = e * degree;
        for (int j = 0; j <= degree; j++) {
            double value = 1.0;
            for (int i = 0; i <= degree; i++)
                if (i != j) value *= (x - points[i]) / (points[j] - points[i]);
            wire->at_station[k][j] = value;
        }
    }
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
    find_stations(wire, elements, count);
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

Wire *wire_make(Instance *it)
{
    Wire *wire = calloc(1, sizeof *wire);
    if (!wire) return NULL;
    memcpy(&wire->numbers, it->c, sizeof wire->numbers);
    wire->stepper.tableau = CHAIN_TABLEAUS + 1; /* of third order, as in Stepper */
    wire->stepper.tolerance = wire->numbers.velocity_tolerance;
    wire->stepper.largest = wire->numbers.largest_step;
    describe(it, wire);
    return wire;
}

/* From here on the lower end moves as the body's unit says. */
static void release_body(Wire *wire)
{
    Chain *chain = &wire->stepper.chain;
    chain->held = 1;
    chain->fixtures--;
    chain->fixture_node++;
    chain->fixture += chain->dimensions + FIXTURE_OTHERS;
}

Outcome wire_settle(Instance *it)
{
    Wire *wire = it->wire;
    ChainShape shape = {0};
    const Outcome outcome = settle(it, wire, &shape);
    chain_shape_end(&shape);
    if (outcome != DONE) return outcome;
    it->x = wire->x;
    it->kept_x = wire->kept;
    it->states = 7 * wire->size + WIRE_TOP + wire->stepper.chain.dimensions;
    if (wire->numbers.body_port > 0.5) release_body(wire);
    wire_rest(wire, it->values + it->unit->first.calculated);
    return DONE;
}
