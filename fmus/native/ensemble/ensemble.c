/* Members of an ensemble, LANES at a time: every lane has its own time, step, branch and events, and all go through the same
 * instructions. A step is as in models/numeric/integrate.py, by the tableau that model.h holds: steps under error control that end
 * on the times of the table, on time events, and just beyond the zeros of indicators.
 *
 * A zero is sought on the cubic through both ends of a step, and the step is repeated to end there, until its end is where
 * the zero is. The cubic is exact at both ends, so that two repetitions find what bracketing by steps finds in six.
 *
 * model.h, written by fmus/native/ensemble/build.py: NQ parameters and inputs, NC values that follow from them alone, NX states, NM modes,
 * NG indicators, NY observed variables, and the functions model_*, among them the stages of the method. */
#include "model.h"

#define EXPORT __attribute__((visibility("default")))

enum { DONE, NO_STEP, TOO_MANY, NOT_FINITE };

#define MOST_STEPS 1e5  /* between two times of the table */
#define MOST_TRIES 40.0 /* at one zero */
#define WIDTH 1e-10     /* of a zero, relative to the step that is being made when it is met */
#define SHORT 1e-3      /* a step this much shorter than the one that error control asks for; many in a row are chatter */
#define NEAR 0.1        /* share of its values at the ends below which an indicator is looked at more closely */
#define EVEN 0.4        /* below 0.9^8: an error below it does not ask for a shorter step */

typedef struct {
    long count, chosen;     /* times; series */
    const double *times;
    const long *columns;    /* of the series */
    double rtol, longest;
} Task;

typedef struct {
    double *series, *low, *high; /* of the block's first member */
    long *status;
    double *when;
    int used;                    /* lanes that hold a member of their own */
} Sink;

typedef struct {
    V c[NC + 1], t, h, x[NX], m[NM + 1], f[NX], g[NG + 1];
    V target, due, cut, least, tries, since, low[NY], high[NY];
    I active;
    long place[LANES];
    const Task *task;
    Sink sink;
} Block;

EXPORT long lanes(void) { return LANES; }

static void stop(Block *b, I which, long status)
{
    EACH(l)
        if (which[l] && b->active[l]) {
            b->active[l] = 0;
            if (l < b->sink.used) {
                b->sink.status[l] = status;
                b->sink.when[l] = b->t[l];
            }
        }
}

/* The lanes ``which`` are at their target. */
static void observe(Block *b, I which)
{
    const Task *task = b->task;
    V y[NY], sum = all(0.0);
    model_outputs(b->t, b->x, b->c, y);
    for (int i = 0; i < NY; i++) {
        sum += y[i];
        b->low[i] = pick(which & (I)(y[i] < b->low[i]), y[i], b->low[i]);
        b->high[i] = pick(which & (I)(y[i] > b->high[i]), y[i], b->high[i]);
    }
    stop(b, which & ~(I)(sum - sum == all(0.0)), NOT_FINITE);
    EACH(l)
        if (which[l] && b->active[l]) {
            if (l < b->sink.used) {
                double *row = b->sink.series + (l * task->count + b->place[l]) * task->chosen;
                for (long j = 0; j < task->chosen; j++)
                    row[j] = y[task->columns[j]][l];
            }
            if (++b->place[l] < task->count)
                b->target[l] = task->times[b->place[l]];
            else
                b->active[l] = 0;
        }
}

/* Branches of the lanes ``which`` change. */
static void turn(Block *b, I which)
{
    V x[NX], m[NM + 1], f[NX], g[NG + 1];
    model_change(b->t, b->x, b->c, x, m);
    for (int i = 0; i < NX; i++)
        b->x[i] = pick(which, x[i], b->x[i]);
    for (int i = 0; i < NM; i++)
        b->m[i] = pick(which, m[i], b->m[i]);
    model_branch(b->m, b->c);
    model_rates(b->t, b->x, b->c, f);
    model_indicators(b->t, b->x, b->c, g);
    for (int i = 0; i < NX; i++)
        b->f[i] = pick(which, f[i], b->f[i]);
    for (int i = 0; i < NG; i++)
        b->g[i] = pick(which, g[i], b->g[i]);
    V due = model_next_event(b->t, b->c);
    b->due = pick(which, pick((I)(due > b->t), due, all(INFINITY)), b->due);
}

/* A step of ``h``: the state, its rates and its largest error over the tolerance; bad where that is no number. */
static I step(const Block *b, V h, V end, V *y, V *f, V *worst)
{
    V k[STAGES + 1][NX];
    I bad = {0};
    for (int i = 0; i < NX; i++)
        k[0][i] = b->f[i];
    model_stages(b->t, h, end, b->x, b->c, k, y);
    V largest[ERRORS];
    for (int e = 0; e < ERRORS; e++)
        largest[e] = all(0.0);
    for (int i = 0; i < NX; i++) {
        V scale = h / (b->task->rtol * (1.0 + greater(size(b->x[i]), size(y[i]))));
        for (int e = 0; e < ERRORS; e++) {
            V ratio = size(scale * model_error(e, i, k));
            bad |= (I)(ratio != ratio);
            largest[e] = greater(ratio, largest[e]);
        }
        f[i] = k[STAGES][i];
    }
    *worst = largest[0];
    if (ERRORS == 2) { /* as in DOP853 */
        V both = largest[0] * largest[0] + 0.01 * largest[ERRORS - 1] * largest[ERRORS - 1];
        *worst = largest[0] * largest[0] / root(pick((I)(both > all(0.0)), both, all(1.0)));
    }
    return bad;
}

/* Indicators at ``s`` within a step of ``h`` that ended in y, f: on the cubic through both ends. */
static void within(const Block *b, V s, V h, const V *y, const V *f, V *g)
{
    V safe = pick((I)(h > all(0.0)), h, all(1.0)), q = s / safe, p = 1.0 - q, z[NX];
    for (int i = 0; i < NX; i++)
        z[i] = p * p * ((1.0 + 2.0 * q) * b->x[i] + s * b->f[i]) + q * q * ((1.0 + 2.0 * p) * y[i] - (h - s) * f[i]);
    model_indicators(b->t + s, z, b->c, g);
}

INLINE I differ(V a, V b) { return (I)(a > all(0.0)) ^ (I)(b > all(0.0)); }

/* The end of a bracket, no wider than ``width`` where that can be had, of the first zero on the cubic before ``high``, where
 * the indicators are ``g``. */
static V zero(const Block *b, I which, V high, const V *g, V h, const V *y, const V *f, V width)
{
    V first = high;
    for (int j = 0; j < NG; j++) {
        I sought = which & differ(b->g[j], g[j]), mine = sought; /* the latter: not found yet */
        V low = all(0.0), up = high, g_low = b->g[j], g_up = g[j], side = all(0.0);
        for (int n = 0; n < 24 && any(mine); n++, mine &= (I)(up - low > 0.5 * width)) {
            V s = n % 4 == 3 ? 0.5 * (low + up) : up - g_up * (up - low) / (g_up - g_low); /* Illinois, and bisection */
            V there[NG + 1];
            s = lesser(greater(s, low + 0.2 * width), up - 0.2 * width);
            within(b, s, h, y, f, there);
            I beyond = differ(b->g[j], there[j]);
            g_low = pick(beyond, pick((I)(side > all(0.0)), 0.5 * g_low, g_low), there[j]);
            g_up = pick(beyond, there[j], pick((I)(side < all(0.0)), 0.5 * g_up, g_up));
            low = pick(mine & ~beyond, s, low);
            up = pick(mine & beyond, s, up);
            side = pick(beyond, all(1.0), all(-1.0));
        }
        first = pick(sought, lesser(first, up), first);
    }
    return first;
}

/* Steps after one of ``h`` with error ``worst``: at most 5 times, at least 0.2 times as long. */
static V next(V h, V worst)
{
    V r;
    EACH(l) r[l] = h[l] * (worst[l] > 1e-9 ? fmin(5.0, fmax(0.2, 0.9 * pow(worst[l], -1.0 / ORDER))) : 5.0);
    return r;
}

/* Lanes in which an indicator has another sign inside the step: at mid-step, or where the parabola through both ends and
 * mid-step comes near zero. ``probe`` is where, ``there`` the indicators. */
static I touched(const Block *b, I which, V h, const V *y, const V *f, const V *g, V *probe, V *there)
{
    I found = {0}, near[NG + 1];
    V place[NG + 1], other[NG + 1];
    within(b, *probe, h, y, f, there);
    for (int j = 0; j < NG; j++) {
        V start = b->g[j], bend = 2.0 * (start + g[j]) - 4.0 * there[j], slope = 4.0 * there[j] - 3.0 * start - g[j];
        V s = -0.5 * slope / pick((I)(bend == all(0.0)), all(1.0), bend), bottom = start + 0.5 * s * slope;
        V limit = NEAR * greater(size(start), size(g[j]));
        found |= differ(start, there[j]);
        place[j] = s * h;
        near[j] = which & (I)(s > all(0.0)) & (I)(s < all(1.0)) & (I)(size(start) > size(bottom))
            & (differ(start, bottom) | (I)(size(bottom) < limit)) & ~differ(start, g[j]);
    }
    for (int j = 0; j < NG; j++)
        if (any(near[j] & ~found)) {
            within(b, place[j], h, y, f, other);
            I here = near[j] & ~found & differ(b->g[j], other[j]);
            *probe = pick(here, place[j], *probe);
            for (int i = 0; i < NG; i++)
                there[i] = pick(here, other[i], there[i]);
            found |= here;
        }
    return found;
}

static void advance(Block *b)
{
    V y[NX], f[NX], g[NG + 1], middle[NG + 1], worst;
    V wall = lesser(b->target, b->due), left = wall - b->t;
    I cutting = (I)(b->cut > all(0.0)), lands = (I)(b->h > 0.999999 * left) & ~cutting;
    V h = kept(b->active, pick(cutting, b->cut, pick(lands, left, b->h)));
    V end = pick(lands, wall, b->t + h);
    I bad = step(b, h, end, y, f, &worst), good = b->active & (I)(worst <= all(1.0)) & ~bad, event = {0};

    I refused = b->active & ~good;
    if (any(refused)) {
        V less = pick(bad | (I)(worst > all(1e300)), 0.1 * h, next(h, worst));
        b->h = pick(refused, less, b->h);
        b->cut = pick(refused, all(0.0), b->cut);
        stop(b, refused & ~(I)(b->t + b->h > b->t), NO_STEP);
    }
    if (NG) {
        I changed = {0};
        model_indicators(end, y, b->c, g);
        for (int j = 0; j < NG; j++)
            changed |= differ(b->g[j], g[j]);
        V probe = 0.5 * h;
        I inside = touched(b, good, h, y, f, g, &probe, middle);
        I crosses = good & (changed | inside);
        if (any(crosses)) {
            V at[NG + 1], width = greater(b->least, greater(WIDTH * b->h, 4e-16 * size(b->t)));
            for (int j = 0; j < NG; j++)
                at[j] = pick(inside, middle[j], g[j]);
            V found = zero(b, crosses, pick(inside, probe, h), at, h, y, f, width);
            event = crosses & changed & ((I)(h - found <= width) | (I)(b->tries > all(MOST_TRIES)));
            I again = crosses & ~event & (I)(b->tries <= all(MOST_TRIES));
            b->cut = pick(again, lesser(found + 0.5 * width, h), b->cut);
            b->tries = pick(again, b->tries + 1.0, b->tries);
            good &= ~again;
        }
    }
    if (any(good & ((I)(worst > all(EVEN)) | (I)(b->h < all(b->task->longest))))) {
        /* a step cut short says nothing against the longer one that was tried before */
        V grown = next(h, worst), longer = pick((I)(h < b->h), greater(b->h, grown), grown);
        b->h = pick(good, lesser(longer, all(b->task->longest)), b->h);
    }
    /* Where an indicator is zero but for rounding, as at rest, its sign changes all the time: zeros that follow each other
     * too soon are found less and less closely, so that time goes on. */
    V slower = pick((I)(h < SHORT * b->h), greater(4.0 * b->least, 1e-7 * b->h), all(0.0));
    b->least = pick(good, slower, b->least);
    b->cut = pick(good, all(0.0), b->cut);
    b->tries = pick(good, all(0.0), b->tries);
    b->t = pick(good, end, b->t);
    for (int i = 0; i < NX; i++) {
        b->x[i] = pick(good, y[i], b->x[i]);
        b->f[i] = pick(good, f[i], b->f[i]);
    }
    for (int j = 0; j < NG; j++)
        b->g[j] = pick(good, g[j], b->g[j]);

    I arrived = good & lands & (I)(end == b->target);
    I turns = good & (event | (lands & (I)(end == b->due)));
    b->since = pick(arrived, all(0.0), b->since + 1.0);
    stop(b, (I)(b->since > all(MOST_STEPS)), TOO_MANY);
    if (any(arrived)) /* before branches change: limits from the left */
        observe(b, arrived);
    if (any(turns))
        turn(b, turns);
}

/* ``members`` of them from t = 0 to the last time. ``q`` has a row of NQ a member; ``series`` (member, time, chosen column),
 * ``low`` and ``high`` (member, NY) take results; ``status`` and ``when`` tell what ended a member before its time. Returns
 * the number of steps tried, in blocks. */
EXPORT long run(long members, const double *q, long count, const double *times, double rtol, long chosen,
                const long *columns, double *series, double *low, double *high, long *status, double *when)
{
    Task task = {count, chosen, times, columns, rtol, times[0]};
    long steps = 0;
    for (long k = 1; k < count; k++)
        task.longest = fmax(task.longest, times[k] - times[k - 1]);
    for (long first = 0; first < members; first += LANES) {
        V row[NQ + 1];
        Block b = {.task = &task, .active = (I)(all(0.0) == all(0.0))};
        long used = members - first < LANES ? members - first : LANES;
        b.sink = (Sink){series + first * count * chosen, low + first * NY, high + first * NY, status + first,
                        when + first, (int)used};
        EACH(l)
            for (int i = 0; i < NQ; i++)
                row[i][l] = q[(first + (l < used ? l : 0)) * NQ + i];
        model_prepare(row, b.c);
        model_initial(b.c, b.x, b.m);
        model_branch(b.m, b.c);
        b.h = all(task.longest);
        b.target = all(times[0]);
        for (int i = 0; i < NY; i++) {
            b.low[i] = all(INFINITY);
            b.high[i] = all(-INFINITY);
        }
        turn(&b, b.active);
        if (times[0] <= 0.0)
            observe(&b, b.active);
        for (; any(b.active); steps++)
            advance(&b);
        for (int l = 0; l < used; l++)
            for (int i = 0; i < NY; i++) {
                low[(first + l) * NY + i] = b.low[i][l];
                high[(first + l) * NY + i] = b.high[i][l];
            }
    }
    return steps;
}
