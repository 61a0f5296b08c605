#include "chain_grade.h"
#include <math.h>
#include <stdlib.h>

#include "chain_limits.h"
#include "chain_rules.h"

/* Slope of the wire over s, at x in [-1, 1] of an element. */
static void slope_at(const Chain *wire, const ChainShape *shape, const GradedElement *element, double x, double *g)
{
    const int d = wire->dimensions;
    const double margin = CHAIN_INSIDE * element->length, s = element->low + 0.5 * element->length * (x + 1.0);
    double y[MARCH_SIZE], size = 0.0;
    chain_shape_at(shape, element->section,
                   fmin(element->low + element->length - margin, fmax(element->low + margin, s)), y);
    for (int c = 0; c < d; c++) size += y[d + c] * y[d + c];
    const double factor =
        1.0 / (sqrt(size) + CHAIN_NO_TENSION) + 1.0 / wire->material[element->section * POINT_MATERIAL];
    for (int c = 0; c < d; c++) g[c] = factor * y[d + c];
}

/* Error of an element: of the interpolation of its slope, and of the bends of a motion. */
static void judge(const Chain *wire, const ChainShape *shape, int degree, const ChainRule *rule, double length,
                  GradedElement *element)
{
    const int d = wire->dimensions, points = degree + 1;
    double at[MOST_DEGREE + 1][MOST_DIMENSIONS], worst = 0.0;
    for (int j = 0; j < points; j++) slope_at(wire, shape, element, rule->points[j], at[j]);
    for (int k = 0; k < CHAIN_SAMPLES; k++) {
        double g[MOST_DIMENSIONS];
        slope_at(wire, shape, element, CHAIN_INNER[k], g);
        for (int c = 0; c < d; c++) {
            double interpolated = 0.0;
            for (int j = 0; j < points; j++) interpolated += rule->samples[k * points + j] * at[j][c];
            worst = fmax(worst, fabs(g[c] - interpolated));
        }
    }
    element->error =
        0.5 * element->length * worst + CHAIN_BEND * element->length * pow(element->length / length, degree);
}

/* Of the elements with the largest error, equal ones but for rounding, the lowest. */
static int worst_of(const GradedElement *elements, int count)
{
    double most = 0.0;
    int place = 0;
    for (int k = 0; k < count; k++) most = fmax(most, elements[k].error);
    while (elements[place].error < most * (1.0 - CHAIN_EQUAL)) place++;
    return place;
}

int chain_grade(const Chain *wire, const ChainShape *shape, int degree, const ChainRule *rule, int most,
                double tolerance, GradedElement *elements, double *error)
{
    double length = 0.0;
    int count = 0;
    for (; count < wire->elements; count++) {
        elements[count] = (GradedElement){0.0, length, 2.0 * wire->half[count], count};
        length += elements[count].length;
    }
    for (int k = 0; k < count; k++) judge(wire, shape, degree, rule, length, elements + k);
    for (;;) {
        *error = 0.0;
        for (int k = 0; k < count; k++) *error += elements[k].error / length;
        if (count >= most || (tolerance > 0.0 && *error <= tolerance)) return count;
        const int at = worst_of(elements, count);
        for (int k = count++; k > at + 1; k--) elements[k] = elements[k - 1];
        elements[at].length *= 0.5;
        elements[at + 1] = elements[at];
        elements[at + 1].low += elements[at].length;
        for (int k = at; k < at + 2; k++) judge(wire, shape, degree, rule, length, elements + k);
    }
}
