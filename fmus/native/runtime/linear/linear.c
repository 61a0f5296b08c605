/* Steps and observation of a linear unit: one product of a prepared matrix with (z, coefficients of the inputs) each.
 *
 * The exact step for polynomial inputs is one exponential of [[A, B, 0], [0, 0, 1], ...] (Van Loan, IEEE Trans.
 * Automatic Control 23 (1978) 395-404), as in models/numeric/exact_step.py and models/slender/damping.py. It is kept
 * with the step and the schedule it was made for: a master goes back and forth between a few. */
#include "linear.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "call.h"
#include "dense.h"
#include "message.h"
#include "reduce.h"
#include "solver.h"
#include "study.h"

/* All arrays of a solver for n core states, one after the other; returns how many doubles they are. */
static size_t divide(Solver *s, const Linear *l, size_t n, double *data)
{
    const size_t k = l->layout.inputs, r = l->layout.rows, size = n + k * (l->degree + 1), wide = n + 3 * k;
    const struct {
        double **part;
        size_t count;
    } parts[] = {
        {&s->observer, (r + l->rate_rows) * wide},
        {&s->rates, n * (n + k)},
        {&s->a, n * n},
        {&s->b, n * k},
        {&s->scale, n},
        {&s->block, size * size},
        {&s->work, 6 * size * size + 8 * size},
        {&s->vector, size > wide ? size : wide},
        {&s->seed_vector, wide},
        {&s->y, 2 * r},
        {&s->seed_y, 2 * r},
        {&s->next, n + l->own},
        {&s->seed_next, n + l->own},
    };
    size_t total = 0;
    for (size_t i = 0; i < sizeof parts / sizeof *parts; total += parts[i++].count)
        if (data) *parts[i].part = data + total;
    for (int i = 0; i < OPERATORS; i++, total += n * size)
        if (data) s->operators[i].matrix = data + total;
    return total;
}

static Outcome study(Instance *it, Solver *s)
{
    const Linear *l = it->unit->linear;
    Outcome outcome = compare(it);
    s->model = state_space(&l->layout, it->c);
    if (outcome == DONE && l->reduced >= 0 && it->p[l->reduced] > 0.5) {
        /* model exchange keeps all states, and says the same of the error, which is a bound there */
        StateSpace smaller = s->model;
        s->room = malloc(sizeof(double) * reduced_size(&smaller));
        outcome = s->room ? reduce(it, &smaller, s->room) : NO_MEMORY;
        s->reduced = it->kind == CO_SIMULATION;
        if (s->reduced) s->model = smaller;
    }
    if (outcome == DONE) outcome = resolve(it);
    if (l->states_used >= 0) it->c[l->states_used] = s->model.n;
    for (int i = 0; l->direct >= 0 && i < 4; i++) /* D of the model in force */
        it->c[l->direct + i] = s->model.d[l->direct_row + i / 2 + (l->direct_column + i % 2) * s->model.r];
    return outcome;
}

Outcome solver_make(Instance *it)
{
    const Linear *l = it->unit->linear;
    for (int i = 0; i < l->layout.constants; i++)
        if (!is_finite(it->c[i]))
            return refuse(it, REFUSED, "%s: these parameters have no finite matrices", it->unit->name);
    solver_free(it->solver);
    Solver *s = it->solver = calloc(1, sizeof *s);
    if (!s) return NO_MEMORY;
    const Outcome outcome = study(it, s);
    if (outcome != DONE) return outcome;
    const size_t n = s->model.n, size = n + (size_t)l->layout.inputs * (l->degree + 1);
    s->data = calloc(divide(s, l, n, NULL), sizeof(double));
    s->pivot = calloc(size, sizeof(int));
    if (!s->data || !s->pivot) return NO_MEMORY;
    divide(s, l, n, s->data);
    return DONE;
}

void solver_free(Solver *s)
{
    if (!s) return;
    free(s->room);
    free(s->data);
    free(s->pivot);
    free(s);
}

bool solver_reduced(const Instance *it) { return it->solver && it->solver->reduced; }

static bool make_operator(Instance *it, double step, double schedule, double *matrix)
{
    Solver *s = it->solver;
    const Linear *l = it->unit->linear;
    const int n = s->model.n, k = s->model.k, orders = l->degree + 1, size = n + k * orders;
    combine(n * n, l->layout.powers, s->model.a, schedule, s->a);
    combine(n * k, l->layout.powers, s->model.b, schedule, s->b);
    balance(n, s->a, s->scale);
    memset(s->block, 0, sizeof(double) * size * size);
    for (int j = 0; j < n; j++)
        for (int i = 0; i < n; i++) s->block[i + (size_t)j * size] = s->a[i + j * n] * step;
    /* inputs in units that leave the norm to A: forces and velocities differ by many orders of magnitude */
    const double norm = fmax(1.0, norm_1(n, n, s->a) * step);
    for (int j = 0; j < k; j++) {
        double *column = s->b + j * n, unit = 1.0;
        for (int i = 0; i < n; i++) column[i] *= step / s->scale[i];
        const double own_norm = norm_1(n, 1, column);
        if (own_norm > 0.0) unit = exp2(floor(log2(norm / own_norm)));
        for (int i = 0; i < n; i++) s->block[i + (size_t)(n + j * orders) * size] = column[i] * unit;
        for (int i = n + j * orders; i + 1 < n + (j + 1) * orders; i++) s->block[i + (size_t)(i + 1) * size] = 1.0;
        column[0] = unit; /* the column has done its duty */
    }
    if (!exponential(size, s->block, s->work, s->pivot)) return false;
    for (int j = 0; j < n; j++)
        for (int i = 0; i < n; i++) matrix[i + j * n] = s->block[i + (size_t)j * size] * s->scale[i] / s->scale[j];
    for (int j = 0; j < k; j++) {
        double factor =
            1.0 / s->b[j * n]; /* i! step^i: the integrators hold derivatives, the inputs come as polynomials */
        for (int power = 0; power < orders; power++, factor *= power * step) {
            const size_t column = n + j * orders + power;
            for (int i = 0; i < n; i++) matrix[i + column * n] = s->block[i + column * size] * s->scale[i] * factor;
        }
    }
    return true;
}

static const double *operator_for(Instance *it, double step, double schedule)
{
    Solver *s = it->solver;
    Operator *oldest = s->operators;
    s->uses++;
    for (Operator *each = s->operators; each < s->operators + OPERATORS; each++) {
        if (each->used && each->step == step && each->schedule == schedule) {
            each->used = s->uses;
            return each->matrix;
        }
        if (each->used < oldest->used) oldest = each;
    }
    oldest->used = 0;
    if (!make_operator(it, step, schedule, oldest->matrix)) return NULL;
    oldest->step = step;
    oldest->schedule = schedule;
    oldest->used = s->uses;
    return oldest->matrix;
}

/* The inputs in the middle of the step, in it->u. A scheduled unit has no meaning below the declared minimum of an
 * input. */
static Outcome middle(Instance *it, double step)
{
    for (int i = 0; i < it->unit->inputs; i++) {
        const Variable *v = &it->unit->variable[it->unit->first.inputs + i];
        const double *k = it->k + CUBIC * i, h = 0.5 * step, u = it->u[i] = k[0] + h * (k[1] + h * (k[2] + h * k[3]));
        const double least = fmin(u, k[0]);
        if (least < v->min)
            return refuse(it, NO_STEP, "%s = %g %s: expected at least %g", v->name, least, v->unit, v->min);
    }
    return DONE;
}

Outcome solver_advance(Instance *it, double step)
{
    Solver *s = it->solver;
    const Linear *l = it->unit->linear;
    const int n = s->model.n, columns = n + s->model.k * (l->degree + 1);
    const Outcome outcome = l->schedule.call ? middle(it, step) : DONE;
    if (outcome != DONE) return outcome;
    const double *matrix = operator_for(it, step, schedule_of(it, it->u));
    if (!matrix) return refuse(it, NO_STEP, "the step has no finite matrix exponential");
    memcpy(s->vector, it->x, sizeof(double) * n);
    evaluate(it, &l->drive, (Arguments){{own_states(it), it->k, it->p, it->c}}, (Results){{s->vector + n}});
    memset(s->next, 0, sizeof(double) * n);
    apply_add(n, columns, matrix, s->vector, s->next);
    if (l->own)
        evaluate(it, &l->own_after, (Arguments){{&step, own_states(it), it->k, it->p, it->c}},
                 (Results){{s->next + n}});
    memcpy(it->x, s->next, sizeof(double) * n);
    memcpy(it->x + l->layout.states, s->next + n, sizeof(double) * l->own);
    return DONE;
}
