/* Model exchange: the host integrates. Modes and branches change in event mode only, where the host asks for it; so
 * they do in co-simulation with event mode, where step mode takes the place of continuous-time mode. */
#include "calls.h"

#include <string.h>

#include "message.h"
#include "observe.h"
#include "transition.h"

static Outcome expect_exchange(Instance *it, const char *what)
{
    if (it->kind != MODEL_EXCHANGE)
        return refuse(it, REFUSED, "%s of an instance for co-simulation: expected one for model exchange", what);
    return DONE;
}

static Outcome expect_mode(Instance *it, bool continuous, const char *what)
{
    Outcome outcome = it->events ? DONE : expect_exchange(it, what);
    const char *other = it->events ? "step" : "continuous-time";
    if (outcome == DONE) outcome = expect(it, STEPPING, what);
    if (outcome == DONE && it->continuous != continuous)
        outcome = refuse(it, REFUSED, "%s in %s mode, expected %s mode", what, continuous ? "event" : other,
                         continuous ? other : "event");
    return outcome;
}

static Outcome expect_count(Instance *it, size_t count, int expected, const char *what)
{
    if (count == (size_t)expected) return DONE;
    return refuse(it, REFUSED, "%zu %s, expected %d", count, what, expected);
}

/* Where derivatives and indicators may be asked for: from initialization on. */
static Outcome look(Instance *it, size_t count, int expected, const char *what)
{
    Outcome outcome = DONE;
    if (it->phase == INSTANTIATED)
        outcome = refuse(it, REFUSED, "%s in phase instantiated, expected phase initializing or later", what);
    if (outcome == DONE) outcome = expect_count(it, count, expected, what);
    if (outcome == DONE && it->phase == INITIALIZING) outcome = refresh(it);
    return outcome == DONE ? prepare(it) : outcome;
}

Outcome instance_set_time(Instance *it, double time)
{
    Number text;
    Outcome outcome = expect_exchange(it, "set time");
    if (outcome == DONE) outcome = expect(it, STEPPING, "set time");
    if (outcome != DONE) return outcome;
    if (!(-NEVER < time && time < NEVER))
        return refuse(it, REFUSED, "time = %s: expected a finite number", shortest(time, text));
    it->time = time;
    it->fresh = false;
    return DONE;
}

Outcome instance_set_states(Instance *it, const double *x, size_t count)
{
    Number text;
    Outcome outcome = expect_exchange(it, "set continuous states");
    if (outcome == DONE) outcome = expect_mode(it, true, "set continuous states");
    if (outcome == DONE) outcome = expect_count(it, count, it->unit->states, "continuous states");
    if (outcome != DONE) return outcome;
    for (size_t i = 0; i < count; i++)
        if (!is_finite(x[i]))
            return refuse(it, REFUSED, "%s = %s: expected a finite number",
                          it->unit->variable[(size_t)it->unit->first.states + i].name, shortest(x[i], text));
    memcpy(it->x, x, count * sizeof *x);
    it->fresh = false;
    return DONE;
}

Outcome instance_get_states(Instance *it, double *x, size_t count)
{
    Outcome outcome = expect_exchange(it, "continuous states");
    if (outcome == DONE) outcome = look(it, count, it->unit->states, "continuous states");
    if (outcome == DONE) memcpy(x, it->x, count * sizeof *x);
    return outcome;
}

Outcome instance_get_derivatives(Instance *it, double *dx, size_t count)
{
    Outcome outcome = expect_exchange(it, "derivatives");
    if (outcome == DONE) outcome = look(it, count, it->unit->states, "derivatives");
    return outcome == DONE ? state_rates(it, dx) : outcome;
}

Outcome instance_get_indicators(Instance *it, double *g, size_t count)
{
    Outcome outcome = look(it, count, it->unit->indicators, "event indicators"); /* in FMI 3 they are variables */
    if (outcome == DONE && count > 0) indicators_now(it, g);
    for (size_t i = 0; outcome == DONE && i < count; i++)
        if (!is_finite(g[i])) outcome = refuse(it, REFUSED, "event indicator %zu is not finite", i);
    return outcome;
}

Outcome instance_discrete_update(Instance *it, bool *states_changed, double *next_event_time)
{
    const size_t states = (size_t)it->unit->states * sizeof *it->x;
    Outcome outcome = expect_mode(it, false, "update of discrete states");
    if (outcome == DONE) outcome = prepare(it);
    if (outcome != DONE) return outcome;
    memcpy(it->kept_x, it->x, states);
    change_due(it, it->time);
    *states_changed = memcmp(it->kept_x, it->x, states) != 0;
    *next_event_time = next_event(it, it->time);
    it->fresh = false;
    return DONE;
}

Outcome instance_enter_continuous(Instance *it)
{
    const Outcome outcome = expect_mode(it, false, it->events ? "enter step mode" : "enter continuous-time mode");
    if (outcome == DONE) it->continuous = true;
    return outcome;
}

Outcome instance_enter_event(Instance *it)
{
    const Outcome outcome = expect_mode(it, true, "enter event mode");
    if (outcome == DONE) it->continuous = false;
    return outcome;
}
