/* A foreign FMI 2 unit in C: y' = u, whose slope comes by fmi2SetRealInputDerivatives (order 1 only) and whose rate goes by
 * fmi2GetRealOutputDerivatives; it keeps no state for others. Value references: 0 u, 1 y. */
#include <stdlib.h>

typedef struct { double u, slope, y, rate; } Unit;
enum { OK, ERROR = 3 };

void *fmi2Instantiate(const char *name, int type, const char *guid, const char *resources, const void *callbacks,
                      int visible, int logging)
{
    (void)name, (void)type, (void)guid, (void)resources, (void)callbacks, (void)visible, (void)logging;
    return calloc(1, sizeof(Unit));
}
void fmi2FreeInstance(void *c) { free(c); }
int fmi2SetupExperiment(void *c, int defined, double tolerance, double start, int stop_defined, double stop)
{
    (void)c, (void)defined, (void)tolerance, (void)start, (void)stop_defined, (void)stop;
    return OK;
}
int fmi2EnterInitializationMode(void *c) { (void)c; return OK; }
int fmi2ExitInitializationMode(void *c) { (void)c; return OK; }
int fmi2Terminate(void *c) { (void)c; return OK; }
int fmi2SetReal(void *c, const unsigned *references, size_t count, const double *values)
{
    Unit *unit = c;
    for (size_t i = 0; i < count; i++) {
        if (references[i] != 0)
            return ERROR;
        unit->u = values[i];
    }
    return OK;
}
int fmi2GetReal(void *c, const unsigned *references, size_t count, double *values)
{
    Unit *unit = c;
    for (size_t i = 0; i < count; i++)
        values[i] = references[i] == 0 ? unit->u : unit->y;
    return OK;
}
int fmi2SetRealInputDerivatives(void *c, const unsigned *references, size_t count, const int *orders, const double *values)
{
    for (size_t i = 0; i < count; i++) {
        if (references[i] != 0 || orders[i] != 1)
            return ERROR;
        ((Unit *)c)->slope = values[i];
    }
    return OK;
}
int fmi2GetRealOutputDerivatives(void *c, const unsigned *references, size_t count, const int *orders, double *values)
{
    for (size_t i = 0; i < count; i++) {
        if (references[i] != 1 || orders[i] != 1)
            return ERROR;
        values[i] = ((Unit *)c)->rate;
    }
    return OK;
}
int fmi2DoStep(void *c, double time, double step, int final)
{
    Unit *unit = c;
    (void)time, (void)final;
    unit->y += step * (unit->u + 0.5 * step * unit->slope);
    unit->rate = unit->u + step * unit->slope;
    return OK;
}
const char *fmi2GetTypesPlatform(void) { return "default"; }
const char *fmi2GetVersion(void) { return "2.0"; }

/* The standard wants every function exported. */
#define ABSENT(name) int fmi2##name(void) { return ERROR; }
ABSENT(SetDebugLogging) ABSENT(Reset)
ABSENT(GetInteger) ABSENT(GetBoolean) ABSENT(GetString) ABSENT(SetInteger) ABSENT(SetBoolean) ABSENT(SetString)
ABSENT(GetFMUstate) ABSENT(SetFMUstate) ABSENT(FreeFMUstate)
ABSENT(SerializedFMUstateSize) ABSENT(SerializeFMUstate) ABSENT(DeSerializeFMUstate) ABSENT(GetDirectionalDerivative)
ABSENT(CancelStep) ABSENT(GetStatus) ABSENT(GetRealStatus)
ABSENT(GetIntegerStatus) ABSENT(GetBooleanStatus) ABSENT(GetStringStatus)
