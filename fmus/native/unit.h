/* A unit as its generated source describes it: sizes, variables, and the functions that CasADi traced from the model.
 *
 * Value references are positions in `variable`, in the order of fmus/unit.py:
 *
 *   parameters | integration_tolerance if stepped | calculated | inputs | d1, d2, d3 of each input | observed
 *   and, native only: states | derivatives of the states | extras
 *
 * Vectors: t time; x states; m modes; u inputs; du, ddu their first and second derivatives; p parameters in the order of
 * the declaration (without integration_tolerance); c constants that `setup` computed from p; k cubics of the inputs, four
 * numbers (u, d1, d2/2, d3/6) an input. All in SI, all double. */
#ifndef TOWAGE_UNIT_H
#define TOWAGE_UNIT_H

#include <stdbool.h>

typedef long long Integer; /* CasADi's casadi_int */

/* A traced function with its needs for work space; `call` is NULL where a unit has none. */
typedef struct {
    int (*call)(const double **arguments, double **results, Integer *iw, double *w, int memory);
    int arguments, results, integers, doubles; /* sz_arg, sz_res, sz_iw, sz_w of CasADi */
} Function;

typedef enum { PARAMETER, CALCULATED, INPUT, OUTPUT, LOCAL } Causality;
typedef enum { FIXED, TUNABLE, DISCRETE, CONTINUOUS } Variability;

typedef struct {
    const char *name, *unit;
    double start, min, max; /* min and max are infinite where none is declared */
    Causality causality;
    Variability variability;
} Variable;

/* A variant of a linear unit's set-up, against which an error is measured: the same tow with half the segments, or with
 * axial stiffness. error = weight * (largest relative difference of the gains over the band). Only if `when(p)` > 0. */
typedef struct {
    Function setup; /* (p) -> c of the variant */
    int states, constants, offset_a, offset_b, offset_c, offset_d, offset_e;
    Function when;  /* (p) -> 0 or 1; no call: always */
    double weight;
    int target;     /* constant of the unit to which the error is added */
} Comparison;

/* A linear unit: core states z of z' = A(s) z + B(s) v, y = C z + D v + E v', A(s) = A0 + s A1 + s^2 A2, likewise B, with
 * s the schedule (0 where there is none), stepped exactly while v are polynomials of time. x = (z, own): the own states
 * follow from polynomials of the inputs. All matrices are part of c, column by column, at the offsets given. */
typedef struct {
    int states, own, inputs, degree, rows, powers;      /* n, -, k, q, r, 1 to 3 */
    int offset_a, offset_b, offset_c, offset_d, offset_e; /* of A0, B0, ...; A1, A2 follow A0 */
    Function schedule;  /* (u, p, c) -> s */
    Function drive;     /* (own, k, p, c) -> (q+1) coefficients of 1, h, h^2, ... for each of v in turn */
    Function own_after; /* (h, own, k, p, c) -> own */
    Function own_rates; /* (own, u, du, p, c) -> own' (model exchange) */
    Function core;      /* (own, u, du, p, c) -> v, v', v'' */
    Function core_forward;    /* core with seeds (d own, du, ddu): CasADi's fwd1 of core */
    Function observe;         /* (t, own, y, y', u, du, growth, p, c) -> outputs, extras */
    Function observe_forward; /* CasADi's fwd1 of observe */
    double growth_cutoff; /* > 0: growth is the largest real part of the eigenvalues of A(s) below it in magnitude, else 0 */
    /* reduction at the start of a co-simulation; parameters by position, -1: none */
    int reduced, tolerance, band;
    bool modal;           /* keep modes (elastic cables); else balance */
    int measured_inputs;  /* the first of v that count in errors */
    int constant_states, constant_error; /* where the number of states used and the error go, in c; -1: nowhere */
    const Comparison *comparison;
    int comparisons;
    /* resolution of the modes by schedule: s up to which the first `resolved_modes` (those below `resolved_cutoff` in
     * magnitude, 0: all) agree to `resolved_error` with those of the variant `finer`, on a grid; goes to c */
    const Comparison *finer;
    int resolved_modes, constant_resolved;
    double resolved_error, resolved_grid, resolved_end, resolved_cutoff;
} Linear;

typedef struct {
    const char *name, *token; /* token: guid of FMI 2, instantiationToken of FMI 3 */
    int variables, parameters, calculated, inputs, observed, states, modes, indicators, requirements, constants, extras;
    int tolerance; /* value reference of integration_tolerance, -1: not stepped by the integrator */
    int frozen;    /* position of freeze_branches among the parameters, -1: none */
    const Variable *variable;
    const int *rate;                /* observed i has its time derivative at observed rate[i], -1: by directional derivative */
    const char *const *requirement; /* messages, one for each result of `required` */
    const char *state_names;        /* "heave, velocity", for messages */
    Function setup;       /* (p) -> c */
    Function required;    /* (p, c) -> values that must all be > 0; NaN counts as not met */
    Function calculate;   /* (p, c) -> calculated parameters */
    Function initial;     /* (p, c) -> x, m */
    Function derivatives; /* (t, x, m, u, p, c) -> x' */
    Function advance;     /* (t, h, x, m, k, p, c) -> x: exact step in closed form (no linear, not stepped) */
    Function indicate;    /* (t, x, m, u, p, c) -> indicators */
    Function change;      /* (t, x, m, u, p, c) -> x, m: the model's transition */
    Function next_event;  /* (t, m, p, c) -> time */
    Function outputs;     /* (t, x, m, u, du, p, c) -> observed */
    Function derivatives_forward, outputs_forward; /* CasADi's fwd1: arguments, results, one seed an argument -> derivatives */
    const Linear *linear; /* NULL: not a linear unit */
} Unit;

extern const Unit towage_unit; /* in the generated unit.c */

#endif
