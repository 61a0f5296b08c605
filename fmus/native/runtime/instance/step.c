/* A communication step: the integrator, the exact step of linear units, transitions inside the step. */
#include "calls.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "call.h"
#include "integrate.h"
#include "linear.h"
#include "message.h"
#include "observe.h"
#include "parameters.h"
#include "transition.h"

typedef struct {
    Instance *instance;
    double begin; /* of the communication step; the integrator counts from there */
    bool moving;  /* some input changes over the step */
    bool stopped; /* at an event, which waits for the host */
} Motion;

/* Where a step ended, counted from its begin and as a time. */
typedef struct {
    double s, time;
} End;

/* A function of (t, x, m, u, p, c); `run` has set the last four, and a transition sets them to the same. */
static void evaluate_at(Motion *motion, const Function *function, double s, const double *x, double *result)
{
    Instance *it = motion->instance;
    const double t = motion->begin + s;
    if (motion->moving) inputs_at(it, s);
    it->arguments[0] = &t;
    it->arguments[1] = x;
    it->results[0] = result;
    function->call(it->arguments, it->results, it->iw, it->w, 0);
}

static void rates(void *context, double s, const double *x, double *f)
{
    Motion *motion = context;
    if (motion->instance->unit->states > 0) evaluate_at(motion, &motion->instance->unit->derivatives, s, x, f);
}

static void indicators(void *context, double s, const double *x, double *g)
{
    Motion *motion = context;
    evaluate_at(motion, &motion->instance->unit->indicate, s, x, g);
}

/* `x` is the state of the instance itself: the integrator works on it in place. */
static bool event(void *context, double s, double *x)
{
    Motion *motion = context;
    Instance *it = motion->instance;
    (void)x;
    if (it->frozen || !it->unit->change.call) return false;
    inputs_at(it, s);
    if (it->early)
        motion->stopped = change_waits(it, motion->begin + s);
    else
        change(it, motion->begin + s);
    return motion->stopped;
}

static void append_vector(char *text, size_t size, const double *vector, int count)
{
    Number number;
    for (int i = 0; i < count; i++) {
        const size_t used = strlen(text);
        snprintf(text + used, size - used, "%s%s", i ? ", " : "", shortest(vector[i], number));
    }
}

static Outcome no_integration(Motion *motion, int reason, double s, double end)
{
    Instance *it = motion->instance;
    char x[300] = "", f[300] = "";
    Number at, until, begin;
    rates(motion, s, it->x, it->next_x);
    append_vector(x, sizeof x, it->x, it->unit->states);
    append_vector(f, sizeof f, it->next_x, it->unit->states);
    if (reason == 1)
        refuse(it, NO_STEP, "no step is small enough at t = %s, x = (%s): the rates are (%s)", shortest(s, at), x, f);
    else
        refuse(it, NO_STEP, "%d steps were not enough to reach t = %s (now t = %s, x = (%s))", MAX_STEPS,
               shortest(end, until), shortest(s, at), x);
    const size_t used = strlen(it->message);
    snprintf(it->message + used, sizeof it->message - used, "; t counts from %s, x is (%s)",
             shortest(motion->begin, begin), it->unit->state_names);
    return NO_STEP;
}

/* Continuous state from `begin` + *s to `begin` + `end`, or to where it is stopped. */
static Outcome run(Motion *motion, double *s, double end)
{
    Instance *it = motion->instance;
    const Unit *unit = it->unit;
    const System system = {motion, unit->states, unit->indicators, rates, indicators, event};
    const double tolerance = unit->tolerance < 0 ? 1.0 : it->values[unit->tolerance]; /* 1: there are no states */
    inputs_at(it, *s);
    const double *arguments[] = {NULL, NULL, it->m, it->u, it->p, it->c};
    memcpy(it->arguments, arguments, sizeof arguments);
    const int reason = integrate(&system, s, it->x, end, tolerance, tolerance, &it->first_step, it->scratch);
    return reason ? no_integration(motion, reason, *s, end) : DONE;
}

/* The exact step of a unit in closed form, from `begin` + `start` to `begin` + `end`. */
static void run_exactly(Instance *it, double begin, double start, double end)
{
    const Unit *unit = it->unit;
    const double here = begin + start, step = end - start;
    if (start > 0.0) cubics_from(it, start);
    const double *arguments[] = {&here, &step, it->x, it->m, start > 0.0 ? it->later : it->k, it->p, it->c};
    memcpy(it->arguments, arguments, sizeof arguments);
    it->results[0] = it->next_x;
    traced(it, &unit->advance, it->arguments, it->results);
    memcpy(it->x, it->next_x, (size_t)unit->states * sizeof *it->x);
}

/* State to `end`, or to the event that waits for the host; `*s`: from where, and where it ended. */
static Outcome move(Motion *motion, double *s, double end)
{
    const Unit *unit = motion->instance->unit;
    if (unit->states == 0 || unit->tolerance >= 0) return run(motion, s, end);
    run_exactly(motion->instance, motion->begin, *s, end);
    *s = end;
    return DONE;
}

/* State and modes to `end`, with the transitions that fall before it. */
static Outcome move_to(Instance *it, double begin, End *end)
{
    Motion motion = {it, begin, false, false};
    const double step = end->s;
    double done = 0.0;
    for (int i = 0; i < it->unit->inputs; i++) {
        const double *k = it->k + CUBIC * i;
        motion.moving = motion.moving || k[1] != 0.0 || k[2] != 0.0 || k[3] != 0.0;
    }
    for (int events = 0;; events++) {
        const double due_time = next_event(it, begin + done), due = due_time - begin;
        const bool inside = done < due && due < step * (1.0 - EVENT_TOLERANCE);
        if (inside && events == MAX_STEPS) {
            Number at;
            return refuse(it, NO_STEP, "more than %d events until t = %s: take shorter steps", MAX_STEPS,
                          shortest(due_time, at));
        }
        const Outcome outcome = move(&motion, &done, inside ? due : step);
        if (outcome != DONE) return outcome;
        if (motion.stopped) *end = (End){done, begin + done};
        if (motion.stopped || !inside) return DONE;
        done = due;
        if (it->early) {
            *end = (End){due, due_time};
            return DONE;
        }
        inputs_at(it, due);
        change(it, due_time); /* not begin + due, which may round to just before the event */
    }
}

/* State and modes to the end of the step, transitions that fall inside included; or to the first of them, where the
 * host handles events. */
static Outcome advance(Instance *it, double begin, End *end)
{
    const Unit *unit = it->unit;
    cubics(it);
    inputs_at(it, 0.0);
    if (it->early && change_waits(it, begin)) { /* inputs that have just been set demand it */
        *end = (End){0.0, begin};
        return DONE;
    }
    change_due(it, begin);
    if (unit->linear) return solver_advance(it, end->s);
    if (unit->steps) return unit->steps->advance(it, end->s);
    const bool watched = it->early && unit->indicators > 0; /* inputs alone may make events */
    if (unit->states == 0 && !watched) return DONE;
    return move_to(it, begin, end);
}

static Outcome check_step(Instance *it, double time, double step)
{
    Number a, b;
    const double slack = TIME_TOLERANCE * (1.0 + fabs(time));
    if (it->kind != CO_SIMULATION)
        return refuse(it, REFUSED, "step of an instance for model exchange: expected one for co-simulation");
    const Outcome outcome = expect(it, STEPPING, "step");
    if (outcome != DONE) return outcome;
    if (it->events && !it->continuous) return refuse(it, REFUSED, "step in event mode, expected step mode");
    if (!(0.0 < step && step < NEVER))
        return refuse(it, REFUSED, "step size %s: expected a positive, finite number of seconds", shortest(step, a));
    if (!(fabs(time - it->time) <= slack && slack < NEVER))
        return refuse(it, REFUSED, "step from t = %s: expected t = %s, where the last step ended", shortest(time, a),
                      shortest(it->time, b));
    if (time + step > it->stop_time + slack)
        return refuse(it, REFUSED, "step to t = %s: expected at most the stop time %s", shortest(time + step, a),
                      shortest(it->stop_time, b));
    return it->stale ? retune(it) : DONE;
}

Outcome instance_step(Instance *it, double time, double step)
{
    const size_t modes = (size_t)it->unit->modes * sizeof *it->m;
    const double first_step = it->first_step, here = it->time, offset = it->offset;
    const bool touched = it->touched;
    End reached = {step, time + step};
    Number begin, end;
    Outcome outcome = check_step(it, time, step);
    if (outcome != DONE) return outcome;
    const size_t states = (size_t)it->states * sizeof *it->x; /* known once parameters are in force */
    memcpy(it->kept_x, it->x, states);
    memcpy(it->kept_m, it->m, modes);
    outcome = advance(it, time, &reached);
    if (outcome == DONE) {
        it->time = reached.time;
        it->offset = reached.s;
        it->touched = false;
        outcome = observe(it);
    }
    if (outcome == DONE) {
        it->event_due = it->events && change_waits(it, it->time);
        return DONE;
    }
    memcpy(it->x, it->kept_x, states);
    memcpy(it->m, it->kept_m, modes);
    it->first_step = first_step;
    it->time = here;
    it->offset = offset;
    it->touched = touched;
    it->fresh = false;
    if (outcome != NO_STEP) return outcome;
    return explain(it, NO_STEP, "step from t = %s to %s: ", shortest(time, begin), shortest(time + step, end));
}
