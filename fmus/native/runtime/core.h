/* What the files of an instance share: positions of the variables, messages, and the steps that calls are made of. */
#ifndef TOWAGE_CORE_H
#define TOWAGE_CORE_H

#include "instance.h"

/* First value reference of each kind, in the order of unit.h. */
static inline int first_calculated(const Unit *u) { return u->parameters + (u->tolerance >= 0); }
static inline int first_input(const Unit *u) { return first_calculated(u) + u->calculated; }
static inline int first_derivative(const Unit *u) { return first_input(u) + u->inputs; }
static inline int first_observed(const Unit *u) { return first_derivative(u) + 3 * u->inputs; }
static inline int first_state(const Unit *u) { return first_observed(u) + u->observed; }
static inline int first_rate(const Unit *u) { return first_state(u) + u->states; }
static inline int first_extra(const Unit *u) { return first_rate(u) + u->states; }

/* message.c */
typedef char Number[32];
const char *shortest(double value, Number text);              /* as Python's repr: the shortest that reads back */
Outcome explain(Instance *, Outcome, const char *format, ...); /* puts the text in front of the message */
const char *phase_name(Phase);
Outcome expect(Instance *, Phase, const char *what);
Outcome known_reference(Instance *, unsigned reference);

/* parameters.c */
Outcome constants(Instance *);     /* all that follows from the parameters; refuses those that make no sense */
Outcome retune(Instance *);        /* tuned parameters; refused, the previous ones are in force again */
Outcome first_outputs(Instance *); /* initial state and outputs, in the initialization phase */

/* observe.c */
void cubics(Instance *);                   /* k from the values of the inputs and their derivatives */
void inputs_at(Instance *, double s);      /* u at s from the begin of the cubics */
void change(Instance *, double t);         /* the model's transition at t with the inputs u */
void change_due(Instance *, double t);     /* at a communication point: an event a rounding error away is included */
double next_event(Instance *, double t);   /* NEVER where the unit has none */
Outcome prepare(Instance *);               /* constants, branches, inputs u and du at the present point */
Outcome observe(Instance *);               /* NO_STEP where a number is not finite */
Outcome refresh(Instance *);               /* `observe` as the phase demands, REFUSED instead of NO_STEP */
Outcome rates_now(Instance *, double *dx); /* derivatives of the state at the present point, after `prepare` */
void indicators_now(Instance *, double *g);
/* Sensitivities of the outputs at the present point; seed_t 1: their rate of change in time. */
Outcome outputs_forward(Instance *, double seed_t, double *sensed);

/* exchange.c */
Outcome state_rates(Instance *, double *dx); /* of the present point, refused where they are not finite */

static inline bool is_finite(double value) { return value - value == 0.0; }

#endif
