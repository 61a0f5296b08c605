/* Ship and body on a line that cannot push, as one system with two degrees of freedom: the truth of `truth.py`.
 *
 *     x = r(t) sum a_i cos(w_i t + e_i) + z,    m1 z'' + c1 z' + K1 z = -(T - W)   (two-way; else z = 0)
 *     m2 y'' = T - W - b |y'| y',               T = K2 max(0, W/K2 + x - y)
 *
 * Classical Runge-Kutta steps of four stages, so short that a radian of the fastest frequency takes twenty (error 1e-7 a
 * radian). Taut and slack and the sign of y' hold over a step; a step in which one changes is cut just beyond the change by
 * bisection to 1e-14 of it. Written for this and nothing else: it shares no line with the models that it judges. SI. */
#include <math.h>

struct system {
    double m1, c1, k1, m2, b, k2, weight, ramp;
    long n, two_way;
    const double *a, *w, *e;
};
struct branch {
    int taut;
    double sign;
};

static double driven(const struct system *s, double t) {
    double sum = 0.0, r = 1.0;
    for (long i = 0; i < s->n; i++) sum += s->a[i] * cos(s->w[i] * t + s->e[i]);
    if (t < s->ramp) {
        double u = t / s->ramp;
        r = u * u * u * (10.0 - 15.0 * u + 6.0 * u * u);
    }
    return r * sum;
}

static double stretch(const struct system *s, double drive, const double *x) {
    return s->weight / s->k2 + drive + x[0] - x[2];
}

static void rates(const struct system *s, struct branch b, double drive, const double *x, double *f) {
    double pull = (b.taut ? s->k2 * stretch(s, drive, x) : 0.0) - s->weight;
    f[0] = x[1];
    f[1] = s->two_way ? (-pull - s->c1 * x[1] - s->k1 * x[0]) / s->m1 : 0.0;
    f[2] = x[3];
    f[3] = (pull - s->b * b.sign * x[3] * x[3]) / s->m2;
}

/* x after h from (t, x), into y; the drive at the end is returned. */
static double step(const struct system *s, struct branch b, double t, double drive, const double *x, double h, double *y) {
    double k1[4], k2[4], k3[4], k4[4], p[4];
    double half = driven(s, t + 0.5 * h), end = driven(s, t + h);
    rates(s, b, drive, x, k1);
    for (int i = 0; i < 4; i++) p[i] = x[i] + 0.5 * h * k1[i];
    rates(s, b, half, p, k2);
    for (int i = 0; i < 4; i++) p[i] = x[i] + 0.5 * h * k2[i];
    rates(s, b, half, p, k3);
    for (int i = 0; i < 4; i++) p[i] = x[i] + h * k3[i];
    rates(s, b, end, p, k4);
    for (int i = 0; i < 4; i++) y[i] = x[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]);
    return end;
}

static struct branch branch_of(const struct system *s, double drive, const double *x) {
    struct branch b = {stretch(s, drive, x) > 0.0, x[3] > 0.0 ? 1.0 : -1.0};
    return b;
}

static int same(struct branch a, struct branch b) { return a.taut == b.taut && a.sign == b.sign; }

/* From (t, x) over h, with every change of branch on an end of a step. */
static void over(const struct system *s, double t, double *x, double h) {
    double y[4], drive = driven(s, t);
    struct branch b = branch_of(s, drive, x);
    for (int tries = 0; h > 0.0; tries++) {
        double end = step(s, b, t, drive, x, h, y), low = 0.0, high = h;
        struct branch after = branch_of(s, end, y);
        if (!same(b, after) && tries < 100) {
            for (int i = 0; i < 47; i++) {
                double middle = 0.5 * (low + high);
                end = step(s, b, t, drive, x, middle, y);
                if (same(b, branch_of(s, end, y))) low = middle;
                else high = middle;
            }
            end = step(s, b, t, drive, x, high, y);
            after = branch_of(s, end, y);
        }
        for (int i = 0; i < 4; i++) x[i] = y[i];
        t += high, h -= high, drive = end, b = after;
    }
}

/* Heave of the body, m, and tension, N, at k dt, k = 0 .. samples - 1, from rest with the body at `heave_start`; steps are
 * at most `longest`, s. */
void solve(const double *p, long two_way, long n, const double *a, const double *w, const double *e, double heave_start,
           double dt, double longest, long samples, double *heave, double *tension) {
    struct system s = {p[0], p[1], p[2], p[3], p[4], p[5], p[6], p[7], n, two_way, a, w, e};
    double x[4] = {0.0, 0.0, heave_start, 0.0};
    long parts = (long)ceil(dt / longest);
    for (long k = 0; k < samples; k++) {
        double t = k * dt;
        heave[k] = x[2];
        tension[k] = fmax(0.0, s.k2 * stretch(&s, driven(&s, t), x));
        for (long j = 0; j < parts; j++) over(&s, t + j * (dt / parts), x, dt / parts);
    }
}
