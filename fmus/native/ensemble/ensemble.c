/* Members of an ensemble, LANES at a time: every lane has its own time, step, branch and events, and all go through the
 * same instructions. A step is as in models/numeric/integrate.py, by the tableau that model.h holds: steps under error
 * control that end on the times of the table, on time events, and just beyond the zeros of indicators.
 *
 * model.h, written by fmus/native/ensemble/build.py: NQ parameters and inputs, NC values that follow from them alone,
 * NX states, NM modes, NG indicators, NY observed variables, and the functions model_*, among them the stages of the
 * method. */
#include "events.h"

#define EXPORT __attribute__((visibility("default")))

#define MOST_STEPS 1e5 /* between two times of the table */
#define SHORT 1e-3 /* a step this much shorter than the one that error control asks for; many in a row are chatter */
#define EVEN  0.4  /* below 0.9^8: an error below it does not ask for a shorter step */

EXPORT long lanes(void) { return LANES; }

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
    EACH (l)
        if (which[l] && b->active[l]) {
            if (l < b->sink.used) {
                double *row = b->sink.series + (l * task->count + b->place[l]) * task->chosen;
                for (long j = 0; j < task->chosen; j++) row[j] = y[task->columns[j]][l];
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
    for (int i = 0; i < NX; i++) b->x[i] = pick(which, x[i], b->x[i]);
    for (int i = 0; i < NM; i++) b->m[i] = pick(which, m[i], b->m[i]);
    model_branch(b->m, b->c);
    model_rates(b->t, b->x, b->c, f);
    model_indicators(b->t, b->x, b->c, g);
    for (int i = 0; i < NX; i++) b->f[i] = pick(which, f[i], b->f[i]);
    for (int i = 0; i < NG; i++) b->g[i] = pick(which, g[i], b->g[i]);
    V due = model_next_event(b->t, b->c);
    b->due = pick(which, pick((I)(due > b->t), due, all(INFINITY)), b->due);
}

/* A step of ``h``: the state, its rates and its largest error over the tolerance; bad where that is no number. */
static I step(const Block *b, V h, V end, V *y, V *f, V *worst)
{
    V k[STAGES + 1][NX];
    I bad = {0};
    for (int i = 0; i < NX; i++) k[0][i] = b->f[i];
    model_stages(b->t, h, end, b->x, b->c, k, y);
    V largest[ERRORS];
    for (int e = 0; e < ERRORS; e++) largest[e] = all(0.0);
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

/* Steps after one of ``h`` with error ``worst``. */
static V next(V h, V worst)
{
    V r;
    EACH (l)
        r[l] = h[l]
               * (worst[l] > 1e-9 ? fmin(MOST_GROWTH, fmax(LEAST_GROWTH, SAFETY * pow(worst[l], -1.0 / ORDER)))
                                  : MOST_GROWTH);
    return r;
}

static void advance(Block *b)
{
    V y[NX], f[NX], g[NG + 1], worst;
    V wall = lesser(b->target, b->due), left = wall - b->t;
    I cutting = (I)(b->cut > all(0.0)), lands = (I)(b->h > LANDING * left) & ~cutting;
    V h = kept(b->active, pick(cutting, b->cut, pick(lands, left, b->h)));
    V end = pick(lands, wall, b->t + h);
    I bad = step(b, h, end, y, f, &worst), good = b->active & (I)(worst <= all(1.0)) & ~bad, event = {0};

    I refused = b->active & ~good;
    if (any(refused)) {
        V less = pick(bad | (I)(worst > all(NO_NUMBER)), RESCUE * h, next(h, worst));
        b->h = pick(refused, less, b->h);
        b->cut = pick(refused, all(0.0), b->cut);
        stop(b, refused & ~(I)(b->t + b->h > b->t), NO_STEP);
    }
    if (NG) event = meet(b, &good, h, end, y, f, g);
    if (any(good & ((I)(worst > all(EVEN)) | (I)(b->h < all(b->task->longest))))) {
        /* a step cut short says nothing against the longer one that was tried before */
        V grown = next(h, worst), longer = pick((I)(h < b->h), greater(b->h, grown), grown);
        b->h = pick(good, lesser(longer, all(b->task->longest)), b->h);
    }
    /* Where an indicator is zero but for rounding, as at rest, its sign changes all the time: zeros that follow each
     * other too soon are found less and less closely, so that time goes on. */
    V slower = pick((I)(h < SHORT * b->h), greater(4.0 * b->least, 1e-7 * b->h), all(0.0));
    b->least = pick(good, slower, b->least);
    b->cut = pick(good, all(0.0), b->cut);
    b->tries = pick(good, all(0.0), b->tries);
    b->t = pick(good, end, b->t);
    for (int i = 0; i < NX; i++) {
        b->x[i] = pick(good, y[i], b->x[i]);
        b->f[i] = pick(good, f[i], b->f[i]);
    }
    for (int j = 0; j < NG; j++) b->g[j] = pick(good, g[j], b->g[j]);

    I arrived = good & lands & (I)(end == b->target);
    I turns = good & (event | (lands & (I)(end == b->due)));
    b->since = pick(arrived, all(0.0), b->since + 1.0);
    stop(b, (I)(b->since > all(MOST_STEPS)), TOO_MANY);
    if (any(arrived)) /* before branches change: limits from the left */
        observe(b, arrived);
    if (any(turns)) turn(b, turns);
}

/* ``members`` of them from t = 0 to the last time. ``q`` has a row of NQ a member; ``series`` (member, time, chosen
 * column),
 * ``low`` and ``high`` (member, NY) take results; ``status`` and ``when`` tell what ended a member before its time.
 * Returns the number of steps tried, in blocks; -1 where there is no memory. */
EXPORT long run(long members, const double *q, long count, const double *times, double rtol, long chosen,
                const long *columns, double *series, double *low, double *high, long *status, double *when)
{
    Task task = {count, chosen, times, columns, rtol, times[0]};
    long steps = 0;
    for (long k = 1; k < count; k++) task.longest = fmax(task.longest, times[k] - times[k - 1]);
#ifdef KERNELS
    if (!kernels_begin()) return -1;
#endif
    for (long first = 0; first < members; first += LANES) {
        V row[NQ + 1];
        Block b = {.task = &task, .active = (I)(all(0.0) == all(0.0))};
        long used = members - first < LANES ? members - first : LANES;
        b.sink = (Sink){series + first * count * chosen,
                        low + first * NY,
                        high + first * NY,
                        status + first,
                        when + first,
                        (int)used};
        EACH (l)
            for (int i = 0; i < NQ; i++) row[i][l] = q[(first + (l < used ? l : 0)) * NQ + i];
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
        if (times[0] <= 0.0) observe(&b, b.active);
        for (; any(b.active); steps++) advance(&b);
        for (int l = 0; l < used; l++)
            for (int i = 0; i < NY; i++) {
                low[(first + l) * NY + i] = b.low[i][l];
                high[(first + l) * NY + i] = b.high[i][l];
            }
    }
#ifdef KERNELS
    kernels_end();
#endif
    return steps;
}
