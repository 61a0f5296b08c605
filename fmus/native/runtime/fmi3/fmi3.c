/* FMI 3.0 over an Instance: co-simulation, with event mode and early return where the unit has events, without
 * intermediate update; and model exchange.
 *
 * Value references are those of unit.h, of an array that of its first element. Two follow that only FMI 3 knows: the
 * number of variables is time, the next one the array of event indicators.
 *
 * A refused call is Error, but a refused step Discard; either leaves the instance as it was. Without memory there is no
 * going on: Fatal. */
#include "fmi3.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *const CATEGORY[] = LOG_CATEGORIES;

static void say(Component *c, fmi3Status status, const char *text)
{
    const int category = (int)status - (int)fmi3Discard;
    char message[sizeof c->it->message + 256];
    if (!c->log || !c->logged[category]) return;
    snprintf(message, sizeof message, "%s (%s): %s", c->name, towage_unit.name, text);
    c->log(c->environment, status, CATEGORY[category], message);
}

fmi3Status fmi3_decline(Component *c, fmi3Status status, const char *format, ...)
{
    char text[512];
    va_list arguments;
    if (!c) return status;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    say(c, status, text);
    return status;
}

fmi3Status fmi3_report(Component *c, Outcome outcome)
{
    static const fmi3Status STATUS[] = {
        [DONE] = fmi3OK, [REFUSED] = fmi3Error, [NO_STEP] = fmi3Discard, [NO_MEMORY] = fmi3Fatal};
    if (outcome == NO_MEMORY) c->it->phase = FAILED;
    if (outcome != DONE) say(c, STATUS[outcome], c->it->message);
    return STATUS[outcome];
}

static unsigned mode(const Component *c, const char **name)
{
    static const struct {
        unsigned bit;
        const char *name;
    } MODES[] = {
        [INSTANTIATED] = {INSTANTIATED_MODE, "instantiated"},
        [INITIALIZING] = {INITIALIZATION_MODE, "initialization mode"},
        [STEPPING] = {STEP_MODE, "step mode"},
        [TERMINATED] = {TERMINATED_MODE, "terminated"},
        [FAILED] = {FAILED_MODE, "failed"},
    };
    const bool exchange = c->it->kind == MODEL_EXCHANGE, running = c->it->phase == STEPPING;
    if (running && (exchange || c->it->events) && !c->it->continuous) {
        *name = "event mode";
        return EVENT_MODE;
    }
    *name = running && exchange ? "continuous-time mode" : MODES[c->it->phase].name;
    return running && exchange ? CONTINUOUS_TIME_MODE : MODES[c->it->phase].bit;
}

bool fmi3_allowed(Component *c, unsigned modes, const char *call)
{
    const char *name;
    if (!c) return false;
    if ((mode(c, &name) & modes) && (c->it->kind == MODEL_EXCHANGE || !(modes & EXCHANGE))) return true;
    fmi3_decline(c, fmi3Error, "%s is not allowed here: %s, %s", call,
                 c->it->kind == CO_SIMULATION ? "co-simulation" : "model exchange", name);
    return false;
}

const char *fmi3GetVersion(void) { return fmi3Version; }

void fmi3FreeInstance(fmi3Instance instance)
{
    Component *c = instance;
    if (!c) return;
    if (c->it) instance_free(c->it);
    free(c->name);
    free(c->knowns);
    free(c->unknowns);
    free(c->column);
    free(c);
}

static Component *make(Kind kind, fmi3String name, fmi3String token, bool logging, fmi3InstanceEnvironment environment,
                       fmi3LogMessageCallback log)
{
    size_t n = (size_t)towage_unit.variables, length = name ? strlen(name) : 0;
    Component *c = calloc(1, sizeof *c);
    if (!c) return NULL;
    c->environment = environment;
    c->log = log;
    for (int k = 0; k < LOG_KINDS; k++) c->logged[k] = logging;
    c->name = calloc(length + 1, 1);
    c->knowns = calloc(n, sizeof *c->knowns);
    c->unknowns = calloc(n, sizeof *c->unknowns);
    c->column = calloc(n, sizeof *c->column);
    if (c->name && length) memcpy(c->name, name, length);
    if (c->name && (!token || strcmp(token, towage_unit.token) != 0))
        fmi3_decline(c, fmi3Error, "instantiation token %s: expected %s", token ? token : "(null)", towage_unit.token);
    else if (c->name && kind == MODEL_EXCHANGE && towage_unit.steps)
        fmi3_decline(c, fmi3Error, "%s steps by itself: expected co-simulation", towage_unit.name);
    else if (c->name && c->knowns && c->unknowns && c->column && (c->it = instance_new(&towage_unit, kind)))
        return c;
    fmi3FreeInstance(c);
    return NULL;
}

fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                          fmi3Boolean logging, fmi3InstanceEnvironment environment,
                                          fmi3LogMessageCallback log)
{
    (void)resources, (void)visible;
    return make(MODEL_EXCHANGE, name, token, logging, environment, log);
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                         fmi3Boolean logging, fmi3Boolean events, fmi3Boolean early_return,
                                         const fmi3ValueReference intermediate[], size_t intermediate_count,
                                         fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
                                         fmi3IntermediateUpdateCallback update)
{
    Component *c = make(CO_SIMULATION, name, token, logging, environment, log);
    (void)resources, (void)visible, (void)intermediate, (void)intermediate_count, (void)update;
    if (c && events && !has_events(&towage_unit)) {
        fmi3_decline(c, fmi3Error, "eventModeUsed, but this unit has no events in co-simulation (hasEventMode)");
        fmi3FreeInstance(c);
        return NULL;
    }
    if (c) {
        c->it->events = events;
        c->it->early = events && early_return;
    }
    return c;
}

fmi3Status fmi3SetDebugLogging(fmi3Instance instance, fmi3Boolean on, size_t count, const fmi3String categories[])
{
    Component *c = instance;
    if (!c) return fmi3Error;
    NEEDS(!count || categories);
    for (size_t i = 0; i < count; i++) {
        int k = 0;
        while (k < LOG_KINDS && (!categories[i] || strcmp(categories[i], CATEGORY[k]) != 0)) k++;
        if (k == LOG_KINDS)
            return fmi3_decline(c, fmi3Error, "there is no log category %s", categories[i] ? categories[i] : "(null)");
    }
    for (int k = 0; k < LOG_KINDS; k++) {
        bool named = count == 0;
        for (size_t i = 0; i < count; i++) named = named || strcmp(categories[i], CATEGORY[k]) == 0;
        if (named) c->logged[k] = on;
    }
    return fmi3OK;
}

fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, fmi3Boolean tolerance_defined, fmi3Float64 tolerance,
                                       fmi3Float64 start, fmi3Boolean stop_defined, fmi3Float64 stop)
{
    Component *c = instance;
    (void)tolerance_defined, (void)tolerance; /* the parameter integration_tolerance says it */
    ONLY_IN(INSTANTIATED_MODE);
    Outcome outcome = instance_set_up(c->it, start, stop_defined, stop);
    return fmi3_report(c, outcome == DONE ? instance_enter_initialization(c->it) : outcome);
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance instance)
{
    Component *c = instance;
    ONLY_IN(INITIALIZATION_MODE);
    return fmi3_report(c, instance_exit_initialization(c->it));
}

fmi3Status fmi3Terminate(fmi3Instance instance)
{
    Component *c = instance;
    ONLY_IN(STEP_MODE | EVENT_MODE | CONTINUOUS_TIME_MODE);
    return fmi3_report(c, instance_terminate(c->it));
}

fmi3Status fmi3Reset(fmi3Instance instance)
{
    Component *c = instance;
    if (!c) return fmi3Error;
    instance_reset(c->it);
    return fmi3OK;
}

fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 time, fmi3Float64 step, fmi3Boolean no_return,
                      fmi3Boolean *events, fmi3Boolean *terminate, fmi3Boolean *early, fmi3Float64 *last)
{
    Component *c = instance;
    (void)no_return;
    if (!c) return fmi3Error;
    NEEDS(events && terminate && early && last);
    *events = *terminate = *early = false;
    *last = c->it->time;
    if (c->it->kind != CO_SIMULATION || (c->it->events && !c->it->continuous)) ONLY_IN(STEP_MODE);
    Outcome outcome = instance_step(c->it, time, step);
    fmi3Status status = fmi3_report(c, outcome);
    *last = c->it->time;
    *events = outcome == DONE && c->it->event_due;
    *early = outcome == DONE && c->it->early && c->it->time < time + step;
    return outcome == REFUSED ? fmi3Discard
                              : status; /* as in the Python flavour: nothing happened, another step may do */
}
