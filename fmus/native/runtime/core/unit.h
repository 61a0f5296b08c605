/* A unit as its generated source describes it: sizes, variables, and the functions that CasADi traced from the model.
 *
 * Value references are positions in `variable`, kind after kind as `References` names them (fmus/declare/interface.py).
 *
 * Vectors: t time; x states; m modes; u inputs; du, ddu their first and second derivatives; p parameters in the order
 * of the declaration (without integration_tolerance); c constants that `setup` computed from p; k cubics of the inputs,
 * four numbers (u, d1, d2/2, d3/6) an input. All in SI, all double. */
#ifndef TOWAGE_UNIT_H
#define TOWAGE_UNIT_H

#include <stdbool.h>

#include "constants.h"

typedef long long Integer; /* CasADi's casadi_int */

/* A traced function with its needs for work space; `call` is NULL where a unit has none. Results must not overlap
 * arguments: they are written while arguments are still read. */
typedef struct {
    int (*call)(const double **arguments, double **results, Integer *iw, double *w, int memory);
    int arguments, results, integers, doubles; /* sz_arg, sz_res, sz_iw, sz_w of CasADi */
} Function;

typedef struct {
    const char *name, *unit;
    double start, min, max; /* min and max are infinite where none is declared */
    Causality causality;
    Variability variability;
} Variable;

/* Where the matrices of a linear unit are in its constants, column by column; A1, A2 follow A0, B1, B2 follow B0. */
typedef struct {
    int states, inputs, rows, powers; /* n, k, r, 1 to 3 */
    int constants;                    /* length of c */
    int a, b, c, d, e;
} Layout;

/* Another set-up of a linear unit, against which this one is measured: the same tow with half the segments, or with
 * axial stiffness. error = weight * (largest relative difference of the gains over the band), relative to this unit or,
 * if that is truer, to the other. Only if `when(p)` > 0. */
typedef struct {
    Function setup; /* (p) -> c of the other */
    Layout layout;
    Function when; /* (p) -> 0 or 1; no call: always */
    double weight;
    bool truer;
    int target;        /* constant of the unit to which the error is added */
    Function stand_in; /* (p) -> c of the model that stands for the unit in this comparison; no call: the unit itself */
    Layout stand_in_layout;
} Comparison;

/* Up to which schedule modes are resolved: all of the first `modes` (Im >= 0, by magnitude) of the other set-up are met
 * to the relative `error` by modes of this one, at multiples of `grid` up to `end`. `below`: constant with the
 * magnitude from which on modes do not count (-1: all do). The result, at least grid/2, goes to the constant `target`.
 */
typedef struct {
    Function setup;
    Layout layout;
    int modes, below, target;
    double error, grid, end;
} Resolution;

/* A linear unit: core states z of z' = A(s) z + B(s) v, y = C z + D v + E v', A(s) = A0 + s A1 + s^2 A2, likewise B,
 * with s the schedule (0 where there is none), stepped exactly while v are polynomials of time. x = (z, own): the own
 * states follow from polynomials of the inputs. */
typedef struct {
    Layout layout;
    int own, degree, rate_rows; /* -, q, the first rows of y whose rates are used */
    Function schedule;          /* (u, p, c) -> s */
    Function drive;             /* (own, k, p, c) -> (q+1) coefficients of 1, h, h^2, ... for each of v in turn */
    Function own_after;         /* (h, own, k, p, c) -> own */
    Function own_rates;         /* (own, u, du, p, c) -> own' (model exchange) */
    Function core;              /* (own, u, du, p, c) -> v, v', v'' */
    Function observe;           /* (t, own, y, y', u, du, growth, p, c) -> outputs, extras */
    Function schedule_forward, own_rates_forward, core_forward, observe_forward; /* arguments, results, seeds */
    int growth; /* constant c: growth is the largest real part of the eigenvalues of A(s) below it in magnitude; -1: 0
                 */
    /* reduction at the start of a co-simulation; parameters by position, -1: none */
    int reduced, tolerance, band;
    bool modal;             /* keep modes (elastic cables); else balance */
    int measured;           /* constant with the number of the first of v that count in errors, -1: all */
    int states_used, error; /* constants for the number of states used and the error, -1: nowhere */
    int direct, direct_row, direct_column; /* four constants that hold a 2 by 2 block of D, row by row; -1: none */
    const Comparison *comparison;
    int comparisons;
    const Resolution *resolution; /* NULL: none */
} Linear;

/* First value reference of each kind, as `Layout` of fmus/declare/unit.py has them; integration_tolerance is the last
 * parameter if the integrator steps the unit. Each input has INPUT_ORDERS derivatives; states, their derivatives and
 * extras are native only. */
typedef struct {
    int parameters, calculated, inputs, input_derivatives, observed, states, state_derivatives, extras;
} References;

struct Steps; /* instance.h */

typedef struct {
    const char *name, *token; /* token: guid of FMI 2, instantiationToken of FMI 3 */
    References first;
    int variables, parameters, calculated, inputs, observed, states, modes, indicators, requirements, constants, extras;
    int tolerance; /* value reference of integration_tolerance, -1: not stepped by the integrator */
    int frozen;    /* position of freeze_branches among the parameters, -1: none */
    const Variable *variable;
    const int *rate;   /* observed i has its time derivative at observed rate[i], -1: by directional derivative */
    const int *length; /* elements that one FMI 3 reference delivers: n of an array at its first, 0 at its others,
                          else 1; NULL: no arrays */
    const char *const *requirement; /* messages, one for each result of `required` */
    const char *state_names;        /* "heave, velocity", for messages */
    Function setup;                 /* (p) -> c */
    Function required;              /* (p, c) -> values that must all be > 0; NaN counts as not met */
    Function calculate;             /* (p, c) -> calculated parameters */
    Function initial;               /* (p, c) -> x, m */
    Function derivatives;           /* (t, x, m, u, p, c) -> x' */
    Function advance;               /* (t, h, x, m, k, p, c) -> x: exact step in closed form (no linear, not stepped) */
    Function indicate;              /* (t, x, m, u, p, c) -> indicators */
    Function change;                /* (t, x, m, u, p, c) -> x, m: the model's transition */
    Function next_event;            /* (t, m, p, c) -> time */
    Function outputs;               /* (t, x, m, u, du, p, c) -> observed */
    Function derivatives_forward,
        outputs_forward;        /* CasADi's fwd1: arguments, results, one seed an argument -> derivatives */
    const Linear *linear;       /* NULL: not a linear unit */
    void *(*memory_make)(void); /* of kernels (kernel.h), whose address traced functions find in iw[0]; NULL: none */
    void (*memory_drop)(void *);
    const struct Steps *steps; /* NULL: not a unit that steps by itself; it has no states that others know */
    /* Of a wire, in the plane and then in space: pull and load of a point (dr/ds, its rate, velocity through the water,
     * acceleration, material), their derivatives, the change of both in a moment, curvature and flow, and their change
     * (chain/chain_look.c). */
    Function point[10];
} Unit;

extern const Unit towage_unit; /* in the generated unit.c */

#endif
