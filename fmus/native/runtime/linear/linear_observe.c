/* What a linear unit shows: outputs, rates of its states, directional derivatives. */
#include "linear.h"

#include <math.h>
#include <string.h>

#include "call.h"
#include "dense.h"
#include "eigen.h"
#include "message.h"
#include "solver.h"

double schedule_of(Instance *it, const double *u)
{
    const Linear *l = it->unit->linear;
    double s = 0.0;
    if (l->schedule.call) evaluate(it, &l->schedule, (Arguments){{u, it->p, it->c}}, (Results){{&s}});
    return s;
}

/* Brings what depends on the schedule to s: [A | B] and the rows of y'. */
static void bring_to(Instance *it, double schedule)
{
    Solver *s = it->solver;
    const Linear *l = it->unit->linear;
    const int n = s->model.n, k = s->model.k, r = l->layout.rows, few = l->rate_rows, powers = l->layout.powers,
              rows = r + few;
    const size_t stride = s->model.r; /* of C, D and E, which go on where the model is reduced */
    if (s->current && s->schedule == schedule) return;
    combine(n * n, powers, s->model.a, schedule, s->rates);
    combine(n * k, powers, s->model.b, schedule, s->rates + n * n);
    memset(s->observer, 0, sizeof(double) * rows * (n + 3 * k));
    for (int j = 0; j < n + k; j++) { /* C [A B] */
        double *column = s->observer + (size_t)j * rows + r;
        for (int i = 0; i < n; i++)
            for (int row = 0; row < few; row++) column[row] += s->model.c[row + i * stride] * s->rates[i + j * n];
    }
    const double *const shown[] = {s->model.c, s->model.d, s->model.e};
    for (int part = 0, column = 0; part < 3; part++)
        for (int j = 0; j < (part ? k : n); j++, column++) {
            memcpy(s->observer + (size_t)column * rows, shown[part] + j * stride, sizeof(double) * r);
            /* v' and v'' act on y' as v and v' do on y */
            if (part)
                memcpy(s->observer + (size_t)(column + k) * rows + r, shown[part] + j * stride, sizeof(double) * few);
        }
    s->schedule = schedule;
    s->current = true;
    s->grown = false;
}

/* M' = M1 + 2 s M2 of matrices of `size` elements that follow each other. */
static void slope_of(int size, int powers, const double *m, double s, double *sum)
{
    for (int i = 0; i < size; i++) {
        sum[i] = 0.0;
        for (int power = powers - 1; power > 0; power--) sum[i] = power * m[i + (size_t)power * size] + s * sum[i];
    }
}

/* Place of the eigenvalue with the largest real part among those below the limit in magnitude, -1: none. */
static int leading(int n, const Complex *values, double limit)
{
    int place = -1;
    for (int i = 0; i < n; i++)
        if (magnitude(values[i]) < limit && (place < 0 || creal(values[i]) > creal(values[place]))) place = i;
    return place;
}

/* The growth at the schedule that was brought in, once for each. */
static Outcome grow(Instance *it)
{
    Solver *s = it->solver;
    const int n = s->model.n, limit = it->unit->linear->growth;
    Complex *t = (Complex *)s->work, *values = t + n * n;
    if (limit < 0 || s->grown) return DONE;
    memcpy(s->a, s->rates, sizeof(double) * n * n);
    if (!eigenvalues(n, s->a, values, t, (double *)(values + n)))
        return refuse(it, NO_STEP, "the eigenvalues at a schedule of %g were not found", s->schedule);
    const int place = leading(n, values, it->c[limit]);
    s->growth = place < 0 ? 0.0 : creal(values[place]);
    s->grown = true;
    return DONE;
}

/* Derivative of the growth by the schedule: y^H A' x / y^H x with the left and right vectors of its eigenvalue. */
static double growth_slope(Instance *it)
{
    Solver *s = it->solver;
    const int n = s->model.n, size = n * n;
    Complex *t = (Complex *)s->work, *u = t + size, *x = u + size, *y = x + n, above = 0.0, below = 0.0;
    memcpy(s->a, s->rates, sizeof(double) * size);
    balance(n, s->a, s->scale);
    if (!schur_form(n, s->a, t, u, (double *)(y + n))) return NAN;
    for (int i = 0; i < n; i++) x[i] = t[i * (n + 1)];
    const int place = leading(n, x, it->c[it->unit->linear->growth]);
    if (place < 0) return 0.0;
    memset(x, 0, sizeof(Complex) * 2 * n);
    right_vector(n, t, place, x);
    left_vector(n, t, place, y);
    /* to the coordinates of A, in place of t */
    Complex *right = t, *left = t + n;
    memset(t, 0, sizeof(Complex) * 2 * n);
    for (int j = 0; j < n; j++)
        for (int i = 0; i < n; i++) {
            right[i] += s->scale[i] * times(u[i + j * n], x[j]);
            left[i] += times(u[i + j * n], y[j]) / s->scale[i];
        }
    slope_of(size, it->unit->linear->layout.powers, s->model.a, s->schedule, s->a);
    for (int j = 0; j < n; j++) {
        below += times(conj(left[j]), right[j]);
        for (int i = 0; i < n; i++) above += s->a[i + j * n] * times(conj(left[i]), right[j]);
    }
    return creal(above / below);
}

/* (z, v, v', v'') of the present point. */
static void core_at(Instance *it, const double *u, const double *du)
{
    Solver *s = it->solver;
    double *v = s->vector + s->model.n;
    const int k = s->model.k;
    memcpy(s->vector, it->x, sizeof(double) * s->model.n);
    evaluate(it, &it->unit->linear->core, (Arguments){{own_states(it), u, du, it->p, it->c}},
             (Results){{v, v + k, v + 2 * k}});
}

/* y and y' of a vector; y' is zero in the rows whose rates nobody uses. */
static void look(const Solver *s, const Linear *l, const double *vector, double *y)
{
    memset(y, 0, sizeof(double) * 2 * l->layout.rows);
    apply_add(l->layout.rows + l->rate_rows, s->model.n + 3 * s->model.k, s->observer, vector, y);
}

Outcome solver_observe(Instance *it, double t, const double *u, const double *du, double *observed, double *extras)
{
    Solver *s = it->solver;
    const Linear *l = it->unit->linear;
    bring_to(it, schedule_of(it, u));
    const Outcome outcome = grow(it);
    if (outcome != DONE) return outcome;
    core_at(it, u, du);
    look(s, l, s->vector, s->y);
    evaluate(it, &l->observe,
             (Arguments){{&t, own_states(it), s->y, s->y + l->layout.rows, u, du, &s->growth, it->p, it->c}},
             (Results){{observed, extras}});
    return DONE;
}

Outcome solver_derivatives(Instance *it, const double *u, const double *du, double *dx)
{
    Solver *s = it->solver;
    const Linear *l = it->unit->linear;
    bring_to(it, schedule_of(it, u));
    core_at(it, u, du);
    memset(dx, 0, sizeof(double) * l->layout.states);
    apply_add(s->model.n, s->model.n + s->model.k, s->rates, s->vector, dx);
    if (l->own)
        evaluate(it, &l->own_rates, (Arguments){{own_states(it), u, du, it->p, it->c}},
                 (Results){{dx + l->layout.states}});
    return DONE;
}

void solver_expand(Instance *it, double *x, double *dx)
{
    Solver *s = it->solver;
    const int n = s->model.n, k = s->model.k, all = it->unit->linear->layout.states,
              first = it->unit->linear->layout.rows;
    if (n == all) return; /* nothing was left out */
    core_at(it, it->u, it->du);
    memcpy(s->next, dx, sizeof(double) * n);
    for (int row = 0; row < all; row++) {
        const double *c = s->model.c + first + row, *d = s->model.d + first + row, *e = s->model.e + first + row;
        const double *z = s->vector, *v = z + n, *dv = v + k, *ddv = dv + k;
        x[row] = dx[row] = 0.0;
        for (int j = 0; j < n; j++, c += s->model.r) {
            x[row] += *c * z[j];
            dx[row] += *c * s->next[j];
        }
        for (int j = 0; j < k; j++, d += s->model.r, e += s->model.r) {
            x[row] += *d * v[j] + *e * dv[j];
            dx[row] += *d * dv[j] + *e * ddv[j];
        }
    }
}

/* ds (A' z + B' v), in s->next. */
static void scheduled_rates(Instance *it, double seed)
{
    Solver *s = it->solver;
    const int n = s->model.n, k = s->model.k, powers = it->unit->linear->layout.powers;
    memset(s->next, 0, sizeof(double) * n);
    if (seed == 0.0 || powers == 1) return;
    slope_of(n * n, powers, s->model.a, s->schedule, s->a);
    slope_of(n * k, powers, s->model.b, s->schedule, s->b);
    apply_add(n, n, s->a, s->vector, s->next);
    apply_add(n, k, s->b, s->vector + n, s->next);
    for (int i = 0; i < n; i++) s->next[i] *= seed;
}

Outcome solver_forward(Instance *it, double t, const double *u, const double *du, const double *seed_x,
                       const double *seed_u, const double *seed_du, double *observed, double *dx)
{
    Solver *s = it->solver;
    const Linear *l = it->unit->linear;
    const int n = s->model.n, k = s->model.k, r = l->layout.rows;
    const double *own = own_states(it), *seed_own = seed_x + l->layout.states, *p = it->p, *c = it->c;
    double seed_s = 0.0, seed_growth = 0.0, *seed_v = s->seed_vector + n;
    bring_to(it, schedule_of(it, u));
    core_at(it, u, du);
    memcpy(s->seed_vector, seed_x, sizeof(double) * n);
    evaluate(it, &l->core_forward,
             (Arguments){{own, u, du, p, c, NULL, NULL, NULL, seed_own, seed_u, seed_du, NULL, NULL}},
             (Results){{seed_v, seed_v + k, seed_v + 2 * k}});
    if (l->schedule.call)
        evaluate(it, &l->schedule_forward, (Arguments){{u, p, c, NULL, seed_u, NULL, NULL}}, (Results){{&seed_s}});
    scheduled_rates(it, seed_s);
    if (dx) {
        memset(dx, 0, sizeof(double) * l->layout.states);
        memcpy(dx, s->next, sizeof(double) * n);
        apply_add(n, n + k, s->rates, s->seed_vector, dx);
        if (l->own)
            evaluate(it, &l->own_rates_forward,
                     (Arguments){{own, u, du, p, c, NULL, seed_own, seed_u, seed_du, NULL, NULL}},
                     (Results){{dx + l->layout.states}});
    }
    if (!observed) return DONE;
    const Outcome outcome = grow(it);
    if (outcome != DONE) return outcome;
    look(s, l, s->vector, s->y);
    look(s, l, s->seed_vector, s->seed_y);
    for (int j = 0; j < n; j++)
        for (int i = 0; i < l->rate_rows; i++) s->seed_y[r + i] += s->model.c[i + j * s->model.r] * s->next[j];
    if (l->growth >= 0 && seed_s != 0.0) seed_growth = seed_s * growth_slope(it);
    evaluate(
        it, &l->observe_forward,
        (Arguments){{&t,   own,      s->y,      s->y + r,      u,      du,      &s->growth,   p,    c,   NULL, NULL,
                     NULL, seed_own, s->seed_y, s->seed_y + r, seed_u, seed_du, &seed_growth, NULL, NULL}},
        (Results){{observed, NULL}});
    return DONE;
}
