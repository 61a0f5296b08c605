/* The zoo as FMI 2.0 co-simulation; the manner of a unit is its GUID. */
#include "zoo.h"

#include "fmi2Functions.h"

typedef struct {
    Zoo zoo;
    const fmi2CallbackFunctions *host;
    bool over;
    double reached;
} Unit;

static void say(Zoo *z, int status, const char *text)
{
    const Unit *unit = z->host;
    unit->host->logger(unit->host->componentEnvironment, z->name, (fmi2Status)status, "zoo", "%s", text);
}

static int living; /* instances of this library */

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible, fmi2Boolean logging)
{
    (void)type, (void)resources, (void)visible, (void)logging;
    if (!strcmp(guid, "alone") && living) return NULL;
    living++;
    Unit *unit = calloc(1, sizeof *unit);
    unit->host = functions;
    zoo_begin(&unit->zoo, name, guid);
    unit->zoo.host = unit;
    unit->zoo.say = say;
    return unit;
}
void fmi2FreeInstance(fmi2Component c) { free(c), living--; }
fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean defined, fmi2Real tolerance, fmi2Real start, fmi2Boolean stops,
                               fmi2Real stop)
{
    Zoo *z = c;
    z->stop = stops ? stop : INFINITY;
    z->time = start;
    z->real[TOLERANCE] = defined ? tolerance : -1.0;
    if (is(z, "forgets")) z->real[GAIN] = 1.0, z->real[X0] = 0.0; /* what was set before the experiment, as 20-sim's do */
    return fmi2OK;
}
fmi2Status fmi2EnterInitializationMode(fmi2Component c) { ((Zoo *)c)->initialising = true; return fmi2OK; }
fmi2Status fmi2ExitInitializationMode(fmi2Component c)
{
    zoo_initial(c);
    ((Zoo *)c)->initialising = false;
    zoo_outputs(c);
    return fmi2OK;
}
fmi2Status fmi2Terminate(fmi2Component c) { (void)c; return fmi2OK; }
fmi2Status fmi2Reset(fmi2Component c) { (void)c; return fmi2OK; }

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real value[])
{
    Zoo *z = c;
    for (size_t i = 0; i < n; i++)
        if (!(is(z, "ignores") && vr[i] == GAIN)) z->real[vr[i]] = value[i];
    return fmi2OK;
}
fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real value[])
{
    Zoo *z = c;
    if (z->initialising) zoo_initial(z);
    zoo_outputs(z);
    for (size_t i = 0; i < n; i++) value[i] = z->real[vr[i]];
    return fmi2OK;
}
fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Integer value[])
{
    (void)vr;
    if (n) ((Zoo *)c)->integer_in = value[0];
    return fmi2OK;
}
fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Integer value[])
{
    (void)vr;
    zoo_outputs(c);
    for (size_t i = 0; i < n; i++) value[i] = ((Zoo *)c)->integer_out;
    return fmi2OK;
}
fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Boolean value[])
{
    (void)vr;
    if (n) ((Zoo *)c)->boolean_in = value[0] != 0;
    return fmi2OK;
}
fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Boolean value[])
{
    (void)vr;
    Zoo *z = c;
    if (n) value[0] = z->boolean_in ? 0 : is(z, "truthy") ? -1 : 1;
    return fmi2OK;
}
fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2String value[])
{
    (void)vr;
    if (n) strncpy(((Zoo *)c)->text_in, value[0], 63);
    return fmi2OK;
}
fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2String value[])
{
    Zoo *z = c;
    (void)vr;
    if (n) value[0] = is(z, "counter") ? (z->integer_out % 2 ? "odd" : "even") : z->text_in;
    return fmi2OK;
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real step, fmi2Boolean never_before)
{
    Unit *unit = c;
    return (fmi2Status)zoo_step(&unit->zoo, time, step, never_before, &unit->over, &unit->reached);
}
fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value)
{
    if (is(c, "mute")) return fmi2Error;
    *value = kind == fmi2Terminated && ((Unit *)c)->over;
    return kind == fmi2Terminated ? fmi2OK : fmi2Error;
}
fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value)
{
    *value = ((Unit *)c)->reached;
    return kind == fmi2LastSuccessfulTime ? fmi2OK : fmi2Error;
}
fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Integer order[],
                                        fmi2Real value[])
{
    const Zoo *z = c;
    (void)vr, (void)order;
    for (size_t i = 0; i < n; i++) value[i] = z->stepped ? z->real[RATE] : INFINITY;
    return is(z, "no rates") ? fmi2Error : fmi2OK;
}
fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state)
{
    if (!*state) *state = malloc(sizeof(Zoo));
    memcpy(*state, c, sizeof(Zoo));
    return fmi2OK;
}
fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) { zoo_restore(c, state); return fmi2OK; }
fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state) { (void)c; free(*state); *state = NULL; return fmi2OK; }
fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Integer order[],
                                       const fmi2Real value[])
{
    (void)vr;
    if (n && order[0] == 1) ((Zoo *)c)->slope = value[0];
    return fmi2OK;
}
fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t *size)
{
    (void)c, (void)state;
    *size = sizeof(Zoo);
    return fmi2OK;
}
fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size)
{
    memcpy(bytes, state, size);
    if (is(c, "forgetful")) ((Zoo *)bytes)->x = 0.0; /* what is written down lacks a state */
    return fmi2OK;
}
fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state)
{
    const Zoo now = *(Zoo *)c;
    Zoo *z = *state = malloc(size);
    memcpy(z, bytes, size);
    z->say = now.say, z->host = now.host; /* of this process */
    return fmi2OK;
}
const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char *fmi2GetVersion(void) { return "2.0"; }

/* The standard wants every function exported. */
#define ABSENT(name, ...) fmi2Status fmi2##name(__VA_ARGS__) { return fmi2Error; }
ABSENT(SetDebugLogging, fmi2Component c, fmi2Boolean on, size_t n, const fmi2String categories[])
ABSENT(GetDirectionalDerivative, fmi2Component c, const fmi2ValueReference unknown[], size_t n,
       const fmi2ValueReference known[], size_t m, const fmi2Real seed[], fmi2Real value[])
ABSENT(CancelStep, fmi2Component c)
ABSENT(GetStatus, fmi2Component c, const fmi2StatusKind kind, fmi2Status *value)
ABSENT(GetIntegerStatus, fmi2Component c, const fmi2StatusKind kind, fmi2Integer *value)
ABSENT(GetStringStatus, fmi2Component c, const fmi2StatusKind kind, fmi2String *value)
