#define _POSIX_C_SOURCE 200809L
#include "fmu.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#ifdef _WIN32
#include <windows.h>
#else
#include <dlfcn.h>
#endif

#include "fmi2Functions.h"
#include "fmi3Functions.h"

static void print2(fmi2ComponentEnvironment fmu, fmi2String instance, fmi2Status status, fmi2String category,
                   fmi2String message, ...)
{
    va_list arguments;
    if (((const Fmu *)fmu)->silent) return;
    fprintf(stderr, "%s: %d %s: ", instance, (int)status, category);
    va_start(arguments, message);
    vfprintf(stderr, message, arguments);
    va_end(arguments);
    fputc('\n', stderr);
}

static void print3(fmi3InstanceEnvironment fmu, fmi3Status status, fmi3String category, fmi3String message)
{
    if (!((const Fmu *)fmu)->silent) fprintf(stderr, "%d %s: %s\n", (int)status, category, message);
}

/* The functions of either standard, in order of use. */
#define FMI2(use)                                                                                                    \
    use(Instantiate) use(FreeInstance) use(SetupExperiment) use(EnterInitializationMode) use(ExitInitializationMode) \
        use(Reset) use(SetReal) use(GetReal) use(DoStep) use(GetFMUstate) use(SetFMUstate) use(FreeFMUstate)         \
            use(SerializedFMUstateSize) use(SerializeFMUstate) use(DeSerializeFMUstate)
#define FMI3(use)                                                                                                      \
    use(InstantiateCoSimulation) use(FreeInstance) use(EnterInitializationMode) use(ExitInitializationMode) use(Reset) \
        use(SetFloat64) use(GetFloat64) use(DoStep) use(GetFMUState) use(SetFMUState) use(FreeFMUState)                \
            use(SerializedFMUStateSize) use(SerializeFMUState) use(DeserializeFMUState) use(EnterEventMode)            \
                use(UpdateDiscreteStates) use(EnterStepMode)
#define POINTER2(name) fmi2##name##TYPE *name;
#define POINTER3(name) fmi3##name##TYPE *name;
static struct {
    FMI2(POINTER2)
} two; /* of the one library that a host loads */
static struct {
    FMI3(POINTER3)
} three;
static fmi2CallbackFunctions callbacks = {print2, calloc, free, NULL, NULL};

#ifdef _WIN32
static void *opened(const char *path)
{
    void *library = LoadLibraryA(path);
    if (!library) fprintf(stderr, "%s: error %lu\n", path, GetLastError());
    return library;
}
static void *symbol(void *library, const char *name) { return (void *)GetProcAddress(library, name); }
#else
static void *opened(const char *path)
{
    void *library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    if (!library) fprintf(stderr, "%s\n", dlerror());
    return library;
}
static void *symbol(void *library, const char *name) { return dlsym(library, name); }
#endif

static bool find(void *library, const char *name, void *pointer)
{
    *(void **)pointer = symbol(library, name); /* the way POSIX offers from an object to a function pointer */
    if (!*(void **)pointer) fprintf(stderr, "the library has no %s\n", name);
    return *(void **)pointer != NULL;
}

bool fmu_load(Fmu *fmu, const char *path, int version, const char *token)
{
    bool complete = true;
    fmu->version = version;
    fmu->token = token;
    fmu->silent = fmu->events = false;
    callbacks.componentEnvironment = fmu;
    fmu->library = opened(path);
    if (!fmu->library) return false;
#define FIND2(name) complete = find(fmu->library, "fmi2" #name, &two.name) && complete;
#define FIND3(name) complete = find(fmu->library, "fmi3" #name, &three.name) && complete;
    if (version == 2) {
        FMI2(FIND2)
    } else {
        FMI3(FIND3)
    }
    return complete;
}

void fmu_unload(Fmu *fmu)
{
#ifdef _WIN32
    FreeLibrary(fmu->library);
#else
    dlclose(fmu->library);
#endif
}

void *fmu_instantiate(const Fmu *fmu, const char *name)
{
    if (fmu->version == 3)
        return three.InstantiateCoSimulation(name, fmu->token, NULL, false, true, fmu->events, fmu->events, NULL, 0,
                                             (void *)fmu, print3, NULL);
    return two.Instantiate(name, fmi2CoSimulation, fmu->token, "", &callbacks, fmi2False, fmi2True);
}

/* From event mode to step mode. */
static int update(void *it)
{
    bool more = true, terminate, nominals, values, defined;
    double next;
    int status = 0;
    while (!status && more)
        status = (int)three.UpdateDiscreteStates(it, &more, &terminate, &nominals, &values, &defined, &next);
    return status ? status : (int)three.EnterStepMode(it);
}

int fmu_initialize(const Fmu *fmu, void *it, double start)
{
    int status;
    if (fmu->version == 3) {
        status = three.EnterInitializationMode(it, false, 0.0, start, false, 0.0);
        status = status ? status : (int)three.ExitInitializationMode(it);
        return status || !fmu->events ? status : update(it);
    }
    status = two.SetupExperiment(it, fmi2False, 0.0, start, fmi2False, 0.0);
    status = status ? status : (int)two.EnterInitializationMode(it);
    return status ? status : (int)two.ExitInitializationMode(it);
}

int fmu_reset(const Fmu *fmu, void *it) { return fmu->version == 3 ? (int)three.Reset(it) : (int)two.Reset(it); }

void fmu_free(const Fmu *fmu, void *it)
{
    if (fmu->version == 3)
        three.FreeInstance(it);
    else
        two.FreeInstance(it);
}

int fmu_set(const Fmu *fmu, void *it, const unsigned *references, size_t count, const double *values)
{
    return fmu->version == 3 ? (int)three.SetFloat64(it, references, count, values, count)
                             : (int)two.SetReal(it, references, count, values);
}

int fmu_get(const Fmu *fmu, void *it, const unsigned *references, size_t count, double *values)
{
    return fmu->version == 3 ? (int)three.GetFloat64(it, references, count, values, count)
                             : (int)two.GetReal(it, references, count, values);
}

int fmu_step(const Fmu *fmu, void *it, double time, double step)
{
    bool events, terminate, early = true;
    const double end = time + step;
    double last = time;
    int status = 0;
    if (fmu->version == 2) return (int)two.DoStep(it, time, step, fmi2True);
    for (double left = step; !status && early; left = end - last) { /* end - time is not step, by rounding */
        status = (int)three.DoStep(it, last, left, true, &events, &terminate, &early, &last);
        if (!status && (early || events)) {
            status = (int)three.EnterEventMode(it);
            status = status ? status : update(it);
        }
    }
    return status;
}

int fmu_get_state(const Fmu *fmu, void *it, void **state)
{
    *state = NULL;
    return fmu->version == 3 ? (int)three.GetFMUState(it, state) : (int)two.GetFMUstate(it, state);
}

int fmu_set_state(const Fmu *fmu, void *it, void *state)
{
    return fmu->version == 3 ? (int)three.SetFMUState(it, state) : (int)two.SetFMUstate(it, state);
}

int fmu_free_state(const Fmu *fmu, void *it, void **state)
{
    return fmu->version == 3 ? (int)three.FreeFMUState(it, state) : (int)two.FreeFMUstate(it, state);
}

int fmu_state_size(const Fmu *fmu, void *it, void *state, size_t *size)
{
    return fmu->version == 3 ? (int)three.SerializedFMUStateSize(it, state, size)
                             : (int)two.SerializedFMUstateSize(it, state, size);
}

int fmu_serialize(const Fmu *fmu, void *it, void *state, void *bytes, size_t size)
{
    return fmu->version == 3 ? (int)three.SerializeFMUState(it, state, bytes, size)
                             : (int)two.SerializeFMUstate(it, state, bytes, size);
}

int fmu_deserialize(const Fmu *fmu, void *it, const void *bytes, size_t size, void **state)
{
    *state = NULL;
    return fmu->version == 3 ? (int)three.DeserializeFMUState(it, bytes, size, state)
                             : (int)two.DeSerializeFMUstate(it, bytes, size, state);
}
