/* FMI 2.0 over an Instance: co-simulation and model exchange.
 *
 * A refused call is Error, but a step that could not be computed Discard; either leaves the instance as it was. Without
 * memory there is no going on: Fatal. */
#include "fmi2.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "message.h"

static const char *const CATEGORY[] = LOG_CATEGORIES;

/* Percent signs are doubled: hosts take the message for a format of printf, as the standard has it. */
static void say(Component *c, fmi2Status status, const char *text)
{
    char sender[256], message[2 * (sizeof c->it->message + sizeof sender)], *to = message;
    const int category = (int)status - (int)fmi2Discard;
    if (!c->logger || !c->logged[category]) return;
    snprintf(sender, sizeof sender, "%s (%s): ", c->name, towage_unit.name);
    const char *const parts[] = {sender, text};
    for (int i = 0; i < 2; i++)
        for (const char *from = parts[i]; *from && to < message + sizeof message - 2; from++) {
            *to++ = *from;
            if (*from == '%') *to++ = '%';
        }
    *to = '\0';
    c->logger(c->environment, c->name, status, CATEGORY[category], message);
}

fmi2Status fmi2_decline(Component *c, const char *format, ...)
{
    char text[sizeof c->it->message];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    say(c, fmi2Error, text);
    return fmi2Error;
}

fmi2Status fmi2_report(Component *c, Outcome outcome)
{
    static const fmi2Status status[] = {
        [DONE] = fmi2OK, [REFUSED] = fmi2Error, [NO_STEP] = fmi2Discard, [NO_MEMORY] = fmi2Fatal};
    if (outcome == NO_MEMORY) c->it->phase = FAILED;
    if (outcome != DONE) say(c, status[outcome], c->it->message);
    return status[outcome];
}

fmi2Status fmi2SetDebugLogging(fmi2Component component, fmi2Boolean on, size_t count, const fmi2String categories[])
{
    Component *c = component;
    bool chosen[LOG_KINDS] = {false, false, false};
    NEEDS(!count || categories);
    for (size_t i = 0; i < count; i++) {
        int k = 0;
        while (k < LOG_KINDS && categories[i] && strcmp(categories[i], CATEGORY[k]) != 0) k++;
        if (!categories[i] || k == LOG_KINDS)
            return fmi2_decline(c, "there is no log category %s", categories[i] ? categories[i] : "(null)");
        chosen[k] = true;
    }
    for (int k = 0; k < LOG_KINDS; k++)
        if (!count || chosen[k]) c->logged[k] = on;
    return fmi2OK;
}

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }

const char *fmi2GetVersion(void) { return fmi2Version; }

/* A component without its instance; NULL: no memory. The model description says canNotUseMemoryManagementFunctions, so
 * that the host's functions for memory stay unused: the core, which knows no FMI, could not call them. */
static Component *component_new(const char *name, const fmi2CallbackFunctions *functions, bool logging)
{
    Component *c = calloc(1, sizeof *c);
    if (!c) return NULL;
    c->logger = functions->logger;
    c->environment = functions->componentEnvironment;
    for (int k = 0; k < LOG_KINDS; k++) c->logged[k] = logging;
    c->name = malloc(strlen(name) + 1);
    if (!c->name) {
        free(c);
        return NULL;
    }
    strcpy(c->name, name);
    return c;
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible, fmi2Boolean logging)
{
    (void)resources, (void)visible;
    Component *c = functions ? component_new(name ? name : "", functions, logging) : NULL;
    if (!c) return NULL;
    if (c->name[0] == '\0')
        fmi2_decline(c, "an instance needs a name");
    else if (type != fmi2ModelExchange && type != fmi2CoSimulation)
        fmi2_decline(c, "type %d: expected model exchange (0) or co-simulation (1)", (int)type);
    else if (type == fmi2ModelExchange && towage_unit.steps)
        fmi2_decline(c, "%s steps by itself: expected co-simulation (1)", towage_unit.name);
    else if (!guid || strcmp(guid, towage_unit.token) != 0)
        fmi2_decline(c, "guid %s: expected %s", guid ? guid : "(null)", towage_unit.token);
    else if (!(c->it = instance_new(&towage_unit, type == fmi2CoSimulation ? CO_SIMULATION : MODEL_EXCHANGE)))
        say(c, fmi2Fatal, "no memory");
    else
        return c;
    fmi2FreeInstance(c);
    return NULL;
}

void fmi2FreeInstance(fmi2Component component)
{
    Component *c = component;
    if (!c) return;
    instance_free(c->it);
    free(c->name);
    free(c);
}

fmi2Status fmi2SetupExperiment(fmi2Component component, fmi2Boolean tolerance_defined, fmi2Real tolerance,
                               fmi2Real start, fmi2Boolean stop_defined, fmi2Real stop)
{
    Component *c = component;
    (void)tolerance_defined, (void)tolerance; /* units are set by their parameter integration_tolerance */
    NEEDS(true);
    return fmi2_report(c, instance_set_up(c->it, start, stop_defined, stop));
}

fmi2Status fmi2EnterInitializationMode(fmi2Component component)
{
    Component *c = component;
    NEEDS(true);
    return fmi2_report(c, instance_enter_initialization(c->it));
}

fmi2Status fmi2ExitInitializationMode(fmi2Component component)
{
    Component *c = component;
    NEEDS(true);
    return fmi2_report(c, instance_exit_initialization(c->it));
}

fmi2Status fmi2Terminate(fmi2Component component)
{
    Component *c = component;
    NEEDS(true);
    return fmi2_report(c, instance_terminate(c->it));
}

fmi2Status fmi2Reset(fmi2Component component)
{
    Component *c = component;
    NEEDS(true);
    instance_reset(c->it);
    c->last_step = fmi2OK;
    return fmi2OK;
}

fmi2Status fmi2GetReal(fmi2Component component, const fmi2ValueReference references[], size_t count, fmi2Real values[])
{
    Component *c = component;
    NEEDS(!count || (references && values));
    return fmi2_report(c, instance_get(c->it, references, count, values));
}

fmi2Status fmi2SetReal(fmi2Component component, const fmi2ValueReference references[], size_t count,
                       const fmi2Real values[])
{
    Component *c = component;
    NEEDS(!count || (references && values));
    return fmi2_report(c, instance_set(c->it, references, count, values));
}

fmi2Status fmi2GetDirectionalDerivative(fmi2Component component, const fmi2ValueReference unknowns[],
                                        size_t unknown_count, const fmi2ValueReference knowns[], size_t known_count,
                                        const fmi2Real seed[], fmi2Real sensitivity[])
{
    Component *c = component;
    NEEDS((!unknown_count || (unknowns && sensitivity)) && (!known_count || (knowns && seed)));
    return fmi2_report(
        c, instance_directional_derivative(c->it, unknowns, unknown_count, knowns, known_count, seed, sensitivity));
}

/* A state of `size` bytes at *state; one that the host gives back is used again. */
static fmi2Status make_room(Component *c, fmi2FMUstate *state, size_t size)
{
    void *made = state_room(*state, size);
    if (made) *state = made;
    if (made) return fmi2OK;
    say(c, fmi2Fatal, "no memory for a state");
    return fmi2Fatal;
}

fmi2Status fmi2GetFMUstate(fmi2Component component, fmi2FMUstate *state)
{
    Component *c = component;
    NEEDS(state);
    const bool made = !*state;
    fmi2Status status = make_room(c, state, instance_state_size(c->it));
    if (status != fmi2OK) return status;
    status = fmi2_report(c, instance_save(c->it, state_block(*state)));
    if (status != fmi2OK && made) fmi2FreeFMUstate(component, state);
    return status;
}

fmi2Status fmi2SetFMUstate(fmi2Component component, fmi2FMUstate state)
{
    Component *c = component;
    NEEDS(state);
    return fmi2_report(c, instance_restore(c->it, state_block(state), ((StateHead *)state)->size));
}

fmi2Status fmi2FreeFMUstate(fmi2Component component, fmi2FMUstate *state)
{
    Component *c = component;
    NEEDS(state);
    free(*state);
    *state = NULL;
    return fmi2OK;
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component component, fmi2FMUstate state, size_t *size)
{
    Component *c = component;
    NEEDS(state && size);
    *size = instance_serialized_size(((StateHead *)state)->size);
    return fmi2OK;
}

fmi2Status fmi2SerializeFMUstate(fmi2Component component, fmi2FMUstate state, fmi2Byte bytes[], size_t size)
{
    Component *c = component;
    NEEDS(state && bytes);
    const size_t held = ((StateHead *)state)->size, needed = instance_serialized_size(held);
    if (size < needed) return fmi2_decline(c, "room for %zu bytes of a state, expected %zu", size, needed);
    instance_serialize(state_block(state), held, bytes);
    return fmi2OK;
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component component, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state)
{
    Component *c = component;
    NEEDS(bytes && state);
    const size_t needed = instance_serialized_size(instance_state_size(c->it)), least = instance_serialized_size(0);
    const bool varies = towage_unit.steps != NULL;
    if (varies ? size < least : size != needed) /* of the right size but another unit's: refused when it is set */
        return fmi2_decline(c, "%zu bytes are not a state of %s: expected %zu", size, towage_unit.name, needed);
    const bool made = !*state;
    fmi2Status status = make_room(c, state, size - least);
    if (status != fmi2OK) return status;
    status = fmi2_report(c, instance_deserialize(c->it, bytes, size, state_block(*state)));
    if (status != fmi2OK && made) fmi2FreeFMUstate(component, state);
    return status;
}
