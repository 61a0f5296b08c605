/* Inputs over a communication step, and the changes of state and modes at its points. */
#ifndef TOWAGE_TRANSITION_H
#define TOWAGE_TRANSITION_H

#include "instance.h"

void cubics(Instance *);                 /* k from the values of the inputs and their derivatives */
void cubics_from(Instance *, double s);  /* later: the cubics of k counted from s */
void inputs_at(Instance *, double s);    /* u at s from the begin of the cubics */
void change(Instance *, double t);       /* the model's transition at t with the inputs u */
void change_due(Instance *, double t);   /* at a communication point: an event a rounding error away is included */
bool change_waits(Instance *, double t); /* whether `change_due` would change anything */
double next_event(Instance *, double t); /* NEVER where the unit has none */

#endif
