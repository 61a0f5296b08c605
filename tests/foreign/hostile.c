/* A foreign FMI 2 co-simulation unit that does one thing wrong: y' = gain u, and a misdeed.
 *
 * The GUID that the host passes on is "<where>:<what>@<time>": at the first call of <where> at or after <time> (s), <what>
 * happens. Where: instantiate, setup, enter, exit, set, step, get, save, restore, terminate, free. Without a misdeed it is a
 * sound unit with variables of all types and no derivatives, units or display units.
 * Value references: Real 0 u, 1 y, 2 gain, 3 x0; Integer 0 factor, 1 steps; Boolean 0 reversed, 1 moving; String 0 label, 1 word. */
#define _POSIX_C_SOURCE 200809L
#include <fenv.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

enum { OK, WARNING, DISCARD, ERROR, FATAL };
typedef void (*Logger)(void *, const char *, int, const char *, const char *, ...);
typedef struct { Logger logger; void *(*allocate)(size_t, size_t); void (*release)(void *); void *finished, *environment; } Callbacks;
typedef struct {
    double u, y, gain, x0, time, hidden;
    int factor, reversed, steps, gone;
    char label[64], name[64], misdeed[96];
    const Callbacks *callbacks;
} Unit;

static volatile int *const nowhere = 0;
static volatile int zero = 0;
static int (*volatile deeper)(int);
static int deep(int level) { volatile char frame[4096]; frame[level & 4095] = 1; return deeper(level + 1) + frame[0]; }

/* Tell the clock of the test (tests/held_clock.py) that this process hangs from now on. */
static void announce(void)
{
    const char *directory = getenv("TOWAGE_TEST_HUNG");
    char path[4096];
    if (!directory) return;
    snprintf(path, sizeof path, "%s/%ld", directory, (long)getpid());
    fclose(fopen(path, "w"));
}

/* The status that a call returns; what is worse happens here. */
static int due(Unit *unit, const char *where)
{
    const char *what = strchr(unit->misdeed, ':'), *at = strchr(unit->misdeed, '@');
    size_t length = strlen(where);
    if (unit->gone) raise(SIGKILL); /* no call may follow on Fatal */
    if (!what || strncmp(unit->misdeed, where, length) || unit->misdeed[length] != ':')
        return OK;
    if (unit->time < (at ? atof(at + 1) : 0.0) - 1e-9)
        return OK;
    what++;
#define IS(word) (!strncmp(what, word, strlen(word)))
    if (IS("segv")) *nowhere = 1;
    if (IS("overflow")) { deeper = deep; return deep(0); }
    if (IS("divide")) return 7 / zero;
    if (IS("abort")) abort();
    if (IS("kill")) raise(SIGKILL);
    if (IS("leave")) exit(0);
    if (IS("hang") || IS("spin")) announce();
    if (IS("hang")) for (;;) sleep(1);
    if (IS("spin")) while (!zero) ;
    if (IS("free twice")) { void *volatile p = malloc(64); free(p); free(p); }
    if (IS("smash")) memset((char *)unit - 4096, 0x55, 3 * 4096);
    if (IS("glutton")) for (;;) *(volatile char *)malloc(64u << 20) = 1;
    if (IS("close")) for (int k = 0; k < 64; k++) close(k);
    if (IS("flood")) for (int k = 0; k < 2000; k++) puts("{\"done\": null} this unit likes to talk about itself");
    if (IS("torrent")) for (int k = 0; k < 100; k++) fwrite(unit->name, 1, sizeof unit->name, stdout), printf("%099999d", k);
    if (IS("babble")) for (int k = 0; k < 20000; k++)
        unit->callbacks->logger(unit->callbacks->environment, unit->name, WARNING, "\xff", "\xff\xfe %d %s", k, "\x80");
    if (IS("silent log")) unit->callbacks->logger(0, 0, ERROR, 0, 0);
    if (IS("chdir") && chdir("/")) return ERROR;
    if (IS("umask")) umask(0);
    if (IS("mask")) { sigset_t all; sigfillset(&all); sigprocmask(SIG_BLOCK, &all, 0); }
    if (IS("rounding")) fesetround(FE_UPWARD);
    if (IS("fork") && !fork()) for (;;) sleep(1);
    if (IS("daemon") && !fork()) { setsid(); if (fork()) _exit(0); for (;;) sleep(1); }
    if (IS("twin") && !fork()) return OK; /* and the copy goes on with the run */
    if (IS("descriptors")) while (dup(2) >= 0) ;
    if (IS("short files")) { struct rlimit none = {0, 0}; setrlimit(RLIMIT_FSIZE, &none); }
    if (IS("escape")) puts("\033]0;hacked\007\033[2J");
    if (IS("nan")) unit->y = NAN;
    if (IS("inf")) unit->y = HUGE_VAL;
    if (IS("discard")) return DISCARD;
    if (IS("error")) return ERROR;
    if (IS("fatal")) { unit->gone = 1; return FATAL; }
    if (IS("nonsense")) return 77;
    if (IS("pending")) return 5;
    return OK;
}
static int does(const Unit *unit, const char *what) { return strstr(unit->misdeed, what) != 0; }

void *fmi2Instantiate(const char *name, int type, const char *guid, const char *resources, const Callbacks *callbacks,
                      int visible, int logging)
{
    Unit *unit = calloc(1, sizeof(Unit));
    (void)type, (void)resources, (void)visible, (void)logging;
    unit->callbacks = callbacks;
    unit->gain = unit->factor = 1;
    strncpy(unit->name, name, sizeof unit->name - 1);
    strncpy(unit->misdeed, guid, sizeof unit->misdeed - 1);
    return due(unit, "instantiate") ? NULL : unit;
}
void fmi2FreeInstance(Unit *unit) { due(unit, "free"); free(unit); }
int fmi2SetupExperiment(Unit *unit, int defined, double tolerance, double start, int stop_defined, double stop)
{
    (void)defined, (void)tolerance, (void)stop_defined, (void)stop;
    unit->time = start;
    return due(unit, "setup");
}
int fmi2EnterInitializationMode(Unit *unit) { return due(unit, "enter"); }
int fmi2ExitInitializationMode(Unit *unit) { unit->y = unit->x0; return due(unit, "exit"); }
#ifdef NEEDS_MORE
int a_function_of_a_library_that_is_not_there(void);
int fmi2Terminate(Unit *unit) { return due(unit, "terminate") + a_function_of_a_library_that_is_not_there(); }
#else
int fmi2Terminate(Unit *unit) { return due(unit, "terminate"); }
#endif
int fmi2Reset(Unit *unit) { unit->y = 0; return OK; }

int fmi2SetReal(Unit *unit, const unsigned *references, size_t count, const double *values)
{
    for (size_t i = 0; i < count; i++)
        switch (references[i]) {
        case 0: if (!does(unit, "deaf")) unit->u = values[i]; break;
        case 2: unit->gain = values[i]; break;
        case 3: unit->x0 = values[i]; break;
        default: return ERROR;
        }
    return due(unit, "set");
}
int fmi2GetReal(Unit *unit, const unsigned *references, size_t count, double *values)
{
    int status = due(unit, "get");
    for (size_t i = 0; i < count; i++)
        values[i] = references[i] == 0 ? unit->u : references[i] == 1 ? unit->y : references[i] == 2 ? unit->gain : unit->x0;
    return status;
}
int fmi2SetInteger(Unit *unit, const unsigned *references, size_t count, const int *values)
{
    for (size_t i = 0; i < count; i++)
        if (references[i] == 0) unit->factor = values[i]; else return ERROR;
    return OK;
}
int fmi2GetInteger(Unit *unit, const unsigned *references, size_t count, int *values)
{
    for (size_t i = 0; i < count; i++) values[i] = references[i] == 0 ? unit->factor : unit->steps;
    return OK;
}
int fmi2SetBoolean(Unit *unit, const unsigned *references, size_t count, const int *values)
{
    for (size_t i = 0; i < count; i++)
        if (references[i] == 0) unit->reversed = values[i]; else return ERROR;
    return OK;
}
int fmi2GetBoolean(Unit *unit, const unsigned *references, size_t count, int *values)
{
    for (size_t i = 0; i < count; i++) values[i] = references[i] == 0 ? unit->reversed : unit->u != 0.0;
    return OK;
}
int fmi2SetString(Unit *unit, const unsigned *references, size_t count, const char *const *values)
{
    for (size_t i = 0; i < count; i++)
        if (references[i] == 0) strncpy(unit->label, values[i], sizeof unit->label - 1); else return ERROR;
    return strcmp(unit->label, "") ? OK : ERROR;
}
int fmi2GetString(Unit *unit, const unsigned *references, size_t count, const char **values)
{
    for (size_t i = 0; i < count; i++) values[i] = references[i] == 0 ? unit->label : "sound";
    return OK;
}
int fmi2DoStep(Unit *unit, double time, double step, int final)
{
    (void)final;
    unit->time = time;
    int status = due(unit, "step");
    if (status > WARNING || does(unit, "frozen"))
        return status;
    unit->hidden += step * unit->gain * unit->factor * (unit->reversed ? -unit->u : unit->u);
    if (isfinite(unit->y))
        unit->y = unit->x0 + unit->hidden;
    unit->steps++;
    return OK;
}
int fmi2GetFMUstate(Unit *unit, Unit **state)
{
    int status = due(unit, "save");
    if (status > WARNING)
        return status;
    if (!*state)
        *state = malloc(sizeof(Unit));
    **state = *unit;
    return OK;
}
int fmi2SetFMUstate(Unit *unit, Unit *state)
{
    int status = due(unit, "restore");
    double kept = unit->hidden;
    if (status > WARNING)
        return status;
    *unit = *state;
    if (does(unit, "forgetful")) /* as a unit whose integral is no registered variable: y is right until the next step */
        unit->hidden = kept;
    return OK;
}
int fmi2FreeFMUstate(Unit *unit, Unit **state) { due(unit, "release"); free(*state); *state = NULL; return OK; }
int fmi2GetRealStatus(Unit *unit, int kind, double *value) { (void)kind; *value = unit->time + 1e6; return OK; } /* a lie */
const char *fmi2GetTypesPlatform(void) { return "default"; }
const char *fmi2GetVersion(void) { return "2.0"; }

/* The standard wants every function exported. */
#define ABSENT(name) int fmi2##name(void) { return ERROR; }
ABSENT(SetDebugLogging) ABSENT(SetRealInputDerivatives) ABSENT(GetRealOutputDerivatives) ABSENT(GetDirectionalDerivative)
ABSENT(SerializedFMUstateSize) ABSENT(SerializeFMUstate) ABSENT(DeSerializeFMUstate)
ABSENT(CancelStep) ABSENT(GetStatus) ABSENT(GetIntegerStatus) ABSENT(GetBooleanStatus)
#ifndef NO_STRING_STATUS
ABSENT(GetStringStatus)
#endif
