/* Elements where the steady shape needs them: models/cable/wire/grading.py in C. */
#ifndef TOWAGE_CHAIN_GRADE_H
#define TOWAGE_CHAIN_GRADE_H

#include "chain_march.h"

typedef struct {
    double error, low, length;
    int section;
} GradedElement;

/* Divides `wire`, whose elements are its sections, into at most `most` elements (CHAIN_MOST_ELEMENTS of room) of
 * `degree`, or as many as `tolerance` of the length needs where that is above 0; returns how many, from the lower end
 * up. `error`: of the steady shape over the length. */
int chain_grade(const Chain *wire, const ChainShape *shape, int degree, const ChainRule *rule, int most,
                double tolerance, GradedElement *elements, double *error);

#endif
