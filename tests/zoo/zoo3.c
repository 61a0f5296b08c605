/* The zoo as FMI 3.0 co-simulation; the manner of a unit is its instantiation token. Beside the variables of the FMI 2.0 zoo
 * it has arrays, a text of bytes, and numbers of other widths, which it passes on. */
#include "zoo.h"

#include "fmi3Functions.h"

enum { ARRAY_IN = 30, ARRAY_OUT, BINARY_IN, BINARY_OUT, SINGLE_IN, SINGLE_OUT, BYTE_IN, BYTE_OUT, WIDE_IN, WIDE_OUT };

typedef struct {
    Zoo zoo;
    double array[3], level, next_event;
    float single;
    int8_t byte;
    uint64_t wide;
    uint8_t bytes[64];
    size_t size;
    bool events, in_event, seen;
    fmi3InstanceEnvironment environment;
    fmi3LogMessageCallback log;
} Unit;

static void say(Zoo *z, int status, const char *text)
{
    const Unit *unit = z->host;
    unit->log(unit->environment, (fmi3Status)status, "zoo", text);
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                         fmi3Boolean logging, fmi3Boolean events, fmi3Boolean early,
                                         const fmi3ValueReference required[], size_t n, fmi3InstanceEnvironment environment,
                                         fmi3LogMessageCallback log, fmi3IntermediateUpdateCallback update)
{
    Unit *unit = calloc(1, sizeof *unit);
    unit->environment = environment;
    unit->log = log;
    unit->events = events;
    zoo_begin(&unit->zoo, name, token);
    unit->zoo.host = unit;
    unit->zoo.say = say;
    unit->next_event = is(&unit->zoo, "clockwork") || is(&unit->zoo, "surprise") || is(&unit->zoo, "forgets") ? 0.55 : INFINITY;
    return unit;
}
void fmi3FreeInstance(fmi3Instance c) { free(c); }
fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean defined, fmi3Float64 tolerance, fmi3Float64 start,
                                       fmi3Boolean stops, fmi3Float64 stop)
{
    Zoo *z = c;
    z->time = start;
    z->real[TOLERANCE] = defined ? tolerance : -1.0;
    z->initialising = true;
    return fmi3OK;
}
fmi3Status fmi3ExitInitializationMode(fmi3Instance c)
{
    Unit *unit = c;
    zoo_initial(&unit->zoo);
    unit->zoo.initialising = false;
    unit->in_event = unit->events;
    zoo_outputs(&unit->zoo);
    return fmi3OK;
}
fmi3Status fmi3EnterEventMode(fmi3Instance c) { ((Unit *)c)->in_event = true; return fmi3OK; }
fmi3Status fmi3EnterStepMode(fmi3Instance c) { ((Unit *)c)->in_event = false; return fmi3OK; }
fmi3Status fmi3UpdateDiscreteStates(fmi3Instance c, fmi3Boolean *more, fmi3Boolean *over, fmi3Boolean *nominals,
                                    fmi3Boolean *values, fmi3Boolean *defined, fmi3Float64 *next)
{
    Unit *unit = c;
    if (!unit->in_event) return fmi3Error;
    *more = *over = *nominals = *values = false;
    if (unit->zoo.time >= unit->next_event - 1e-12) { /* the level falls by 10, once */
        unit->zoo.x -= 10.0;
        unit->next_event = INFINITY;
        *more = true;
    }
    *defined = isfinite(unit->next_event) && is(&unit->zoo, "clockwork");
    *next = unit->next_event;
    return fmi3OK;
}
fmi3Status fmi3Terminate(fmi3Instance c) { return fmi3OK; }

fmi3Status fmi3SetFloat64(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3Float64 value[], size_t m)
{
    Unit *unit = c;
    for (size_t i = 0; i < n; i++) {
        if (vr[i] == ARRAY_IN) memcpy(unit->array, value, sizeof unit->array), value += 3;
        else unit->zoo.real[vr[i]] = *value++;
    }
    return fmi3OK;
}
fmi3Status fmi3GetFloat64(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3Float64 value[], size_t m)
{
    Unit *unit = c;
    if (unit->zoo.initialising) zoo_initial(&unit->zoo);
    zoo_outputs(&unit->zoo);
    for (size_t i = 0; i < n; i++) {
        if (vr[i] == ARRAY_OUT) memcpy(value, unit->array, sizeof unit->array), value += 3;
        else *value++ = unit->zoo.real[vr[i]];
    }
    return fmi3OK;
}
#define PASSES(type, field)                                                                                            \
    fmi3Status fmi3Set##type(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3##type value[], size_t m) \
    {                                                                                                                  \
        if (n) ((Unit *)c)->field = value[0];                                                                          \
        return fmi3OK;                                                                                                 \
    }                                                                                                                  \
    fmi3Status fmi3Get##type(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3##type value[], size_t m)     \
    {                                                                                                                  \
        if (n) value[0] = ((Unit *)c)->field;                                                                          \
        return fmi3OK;                                                                                                 \
    }
PASSES(Float32, single)
PASSES(Int8, byte)
PASSES(UInt64, wide)
fmi3Status fmi3SetInt32(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3Int32 value[], size_t m)
{
    Unit *unit = c;
    if (unit->events && !unit->in_event && !unit->zoo.initialising && unit->zoo.stepped) return fmi3Error;
    if (n) unit->zoo.integer_in = value[0];
    return fmi3OK;
}
fmi3Status fmi3GetInt32(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3Int32 value[], size_t m)
{
    zoo_outputs(c);
    if (n) value[0] = ((Zoo *)c)->integer_out;
    return fmi3OK;
}
fmi3Status fmi3SetBoolean(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3Boolean value[], size_t m)
{
    if (n) ((Zoo *)c)->boolean_in = value[0];
    return fmi3OK;
}
fmi3Status fmi3GetBoolean(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3Boolean value[], size_t m)
{
    if (n) value[0] = !((Zoo *)c)->boolean_in;
    return fmi3OK;
}
fmi3Status fmi3SetString(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3String value[], size_t m)
{
    if (n) strncpy(((Zoo *)c)->text_in, value[0], 63);
    return fmi3OK;
}
fmi3Status fmi3GetString(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3String value[], size_t m)
{
    Zoo *z = c;
    if (n) value[0] = is(z, "counter") ? (z->integer_out % 2 ? "odd" : "even") : z->text_in;
    return fmi3OK;
}
fmi3Status fmi3SetBinary(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const size_t size[],
                         const fmi3Binary value[], size_t m)
{
    Unit *unit = c;
    if (n) memcpy(unit->bytes, value[0], unit->size = size[0]);
    return fmi3OK;
}
fmi3Status fmi3GetBinary(fmi3Instance c, const fmi3ValueReference vr[], size_t n, size_t size[], fmi3Binary value[], size_t m)
{
    Unit *unit = c;
    if (n) value[0] = unit->bytes, size[0] = unit->size;
    return fmi3OK;
}

fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 time, fmi3Float64 step, fmi3Boolean never_before, fmi3Boolean *event,
                      fmi3Boolean *over, fmi3Boolean *early, fmi3Float64 *reached)
{
    Unit *unit = c;
    *event = *early = false;
    if (unit->in_event) return fmi3Error;
    if (unit->events && time + step > unit->next_event + 1e-12) {
        step = unit->next_event - time;
        *early = *event = unit->seen = true;
    } else if (unit->events && time + step >= unit->next_event - 1e-12)
        *event = true;
    const int status = zoo_step(&unit->zoo, time, step, never_before, over, reached);
    if (is(&unit->zoo, "astray")) *reached = time + 0.5 * step; /* a whole step, as it says, but not to there */
    return *over ? fmi3OK : (fmi3Status)status;
}
fmi3Status fmi3GetOutputDerivatives(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3Int32 order[],
                                    fmi3Float64 value[], size_t m)
{
    const Zoo *z = c;
    for (size_t i = 0; i < n; i++) value[i] = z->stepped ? z->real[RATE] : INFINITY;
    return fmi3OK;
}
fmi3Status fmi3GetFMUState(fmi3Instance c, fmi3FMUState *state)
{
    if (!*state) *state = malloc(sizeof(Unit));
    memcpy(*state, c, sizeof(Unit));
    return fmi3OK;
}
fmi3Status fmi3SetFMUState(fmi3Instance c, fmi3FMUState state)
{
    Unit *unit = c;
    const Zoo zoo = unit->zoo;
    const bool seen = unit->seen;
    *unit = *(Unit *)state;
    unit->zoo = zoo;
    unit->seen = seen;
    if (is(&zoo, "forgets") && seen) unit->next_event = 1e300; /* that an event is due is no part of its state */
    zoo_restore(&unit->zoo, state);
    return fmi3OK;
}
fmi3Status fmi3FreeFMUState(fmi3Instance c, fmi3FMUState *state) { free(*state); *state = NULL; return fmi3OK; }
const char *fmi3GetVersion(void) { return "3.0"; }
