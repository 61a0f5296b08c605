/* Random calls of the FMI 2 layer. */
#include "fuzz.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"
#include "unit.h"

static struct {
    fmi2Component it;
    bool exchange, continuous;
    Stage stage;
    double time;
    struct {
        fmi2FMUstate state;
        Stage stage;
        double time;
        bool continuous;
    } slot[SLOTS];
} now;

/* As hosts do, through printf: a stray % would be seen here. */
static void listen(fmi2ComponentEnvironment environment, fmi2String instance, fmi2Status status, fmi2String category,
                   fmi2String message, ...)
{
    char text[4096];
    va_list arguments;
    (void)environment, (void)instance;
    check(status == fmi2Discard || status == fmi2Error, "a message with another status");
    va_start(arguments, message);
    check(strncmp(category, "logStatus", 9) == 0 && vsnprintf(text, sizeof text, message, arguments) > 0,
          "an empty message");
    va_end(arguments);
}

void end2(void)
{
    for (int i = 0; now.it && i < SLOTS; i++)
        if (now.slot[i].state) check(fmi2FreeFMUstate(now.it, &now.slot[i].state) == fmi2OK, "fmi2FreeFMUstate");
    fmi2FreeInstance(now.it);
    memset(&now, 0, sizeof now);
}

static void create(void)
{
    static const fmi2CallbackFunctions hosts[] = {{listen, calloc, free, NULL, NULL}, {NULL, NULL, NULL, NULL, NULL}};
    const bool wrong = chance(0.02);
    const char *guid = wrong ? (chance(0.5) ? NULL : "{}") : towage_unit.token;
    end2();
    now.exchange = chance(0.5);
    now.it = fmi2Instantiate("100%s%n", now.exchange ? fmi2ModelExchange : fmi2CoSimulation, guid, NULL,
                             &hosts[chance(0.9) ? 0 : 1], fmi2False, fmi2True);
    counted(2);
    check((now.it == NULL) == (wrong || (now.exchange && towage_unit.steps)), "fmi2Instantiate");
    now.stage = now.it ? CREATED : NONE;
}

/* Mostly the instance, rarely none. */
static fmi2Component it(void) { return chance(0.995) ? now.it : NULL; }

static bool at(Stage stage) { return now.stage == stage || now.stage == UNSURE; }

static void move(Stage stage)
{
    if (now.stage != UNSURE) now.stage = stage;
}

static void order(void)
{
    const double start = number(0.0), stop = number(20.0);
    switch (below(9)) {
    case 0:
        if (judge("fmi2SetupExperiment", fmi2SetupExperiment(it(), fmi2False, 0.0, start, chance(0.3), stop),
                  at(CREATED), NULL, 0)
            == fmi2OK)
            now.time = start;
        break;
    case 1:
    case 2:
    case 3:
        if (judge("fmi2EnterInitializationMode", fmi2EnterInitializationMode(it()), at(CREATED), NULL, 0) == fmi2OK)
            move(INITIALIZING_NOW);
        break;
    case 4:
    case 5:
    case 6:
        if (judge("fmi2ExitInitializationMode", fmi2ExitInitializationMode(it()), at(INITIALIZING_NOW), NULL, 0)
            == fmi2OK) {
            move(RUNNING);
            now.continuous = false;
        }
        break;
    case 7:
        if (chance(0.3) && judge("fmi2Terminate", fmi2Terminate(it()), at(RUNNING), NULL, 0) == fmi2OK) move(ENDED);
        break;
    default:
        if (chance(0.3) && fmi2Reset(it()) == fmi2OK) {
            now.stage = CREATED;
            now.time = 0.0;
        }
    }
}

/* The serialised state; 0 bytes: refused. */
static size_t state_bytes(fmi2Byte *bytes, size_t room)
{
    fmi2FMUstate state = NULL;
    size_t size = 0;
    if (fmi2GetFMUstate(now.it, &state) != fmi2OK) return 0; /* with parameters that make no sense there is none */
    counted(4);
    check(fmi2SerializedFMUstateSize(now.it, state, &size) == fmi2OK && size <= room, "fmi2SerializedFMUstateSize");
    check(fmi2SerializeFMUstate(now.it, state, bytes, size) == fmi2OK, "fmi2SerializeFMUstate");
    check(fmi2FreeFMUstate(now.it, &state) == fmi2OK && !state, "fmi2FreeFMUstate");
    return size;
}

static void values(Call *c)
{
    static fmi2Byte before[1 << 16], after[1 << 16];
    const unsigned *references = chance(0.99) ? c->references : NULL;
    if (chance(0.5)) {
        const size_t size = state_bytes(before, sizeof before);
        if (judge("fmi2SetReal", fmi2SetReal(it(), references, c->count, chance(0.99) ? c->values : NULL),
                  now.stage != ENDED || c->count == 0, NULL, 0)
                != fmi2OK
            && size > 0)
            check(state_bytes(after, sizeof after) == size && memcmp(before, after, size) == 0,
                  "a refused fmi2SetReal changed something");
    } else
        judge("fmi2GetReal", fmi2GetReal(it(), references, c->count, c->results), true, c->results, c->count);
}

static void derivatives(Call *c)
{
    switch (below(3)) {
    case 0:
        judge("fmi2GetDirectionalDerivative",
              fmi2GetDirectionalDerivative(it(), c->references, c->count, c->others, c->other_count, c->values,
                                           c->results),
              now.stage != CREATED, c->results, c->count);
        break;
    case 1:
        judge("fmi2GetRealOutputDerivatives",
              fmi2GetRealOutputDerivatives(it(), c->references, c->count, c->orders, c->results),
              !now.exchange && now.stage != CREATED, c->results, c->count);
        break;
    default:
        judge("fmi2SetRealInputDerivatives",
              fmi2SetRealInputDerivatives(it(), c->references, c->count, c->orders, c->values),
              !now.exchange && now.stage != ENDED, NULL, 0);
    }
}

static void step(void)
{
    const double from = chance(0.97) ? now.time : number(1.0), size = number(0.1);
    double last;
    if (judge("fmi2DoStep", fmi2DoStep(it(), from, size, fmi2True), at(RUNNING) && !now.exchange, NULL, 0) == fmi2OK)
        now.time = from + size;
    counted(now.stage != UNSURE);
    if (now.stage != UNSURE && fmi2GetRealStatus(it(), fmi2LastSuccessfulTime, &last) == fmi2OK)
        check(last == now.time, "fmi2GetRealStatus: fmi2LastSuccessfulTime");
}

static void exchange(Call *c)
{
    fmi2EventInfo info;
    fmi2Boolean flags[2];
    const bool here = now.exchange && at(RUNNING), inside = here && (now.continuous || now.stage == UNSURE);
    const bool between = here && (!now.continuous || now.stage == UNSURE);
    const size_t states = (size_t)towage_unit.states, count = chance(0.95) ? states : below(9);
    const size_t indicators = chance(0.95) ? (size_t)towage_unit.indicators : below(9);
    double time;
    switch (below(10)) {
    case 0:
        if (judge("fmi2EnterEventMode", fmi2EnterEventMode(it()), here, NULL, 0) == fmi2OK) now.continuous = false;
        break;
    case 1:
    case 2:
        if (judge("fmi2EnterContinuousTimeMode", fmi2EnterContinuousTimeMode(it()), between, NULL, 0) == fmi2OK)
            now.continuous = true;
        break;
    case 3:
        time = number(now.time + 0.1);
        if (judge("fmi2SetTime", fmi2SetTime(it(), time), here, NULL, 0) == fmi2OK) now.time = time;
        break;
    case 4:
        judge("fmi2SetContinuousStates", fmi2SetContinuousStates(it(), c->values, count), inside && count == states,
              NULL, 0);
        break;
    case 5:
        judge("fmi2GetContinuousStates", fmi2GetContinuousStates(it(), c->results, count),
              now.exchange && count == states, c->results, count);
        break;
    case 6:
        judge("fmi2GetDerivatives", fmi2GetDerivatives(it(), c->results, count), now.exchange && count == states,
              c->results, count);
        break;
    case 7:
        judge("fmi2GetEventIndicators", fmi2GetEventIndicators(it(), c->results, indicators),
              now.exchange && indicators == (size_t)towage_unit.indicators, c->results, indicators);
        break;
    case 8:
        judge("fmi2CompletedIntegratorStep", fmi2CompletedIntegratorStep(it(), fmi2True, flags, flags + 1), inside,
              NULL, 0);
        break;
    default: judge("fmi2NewDiscreteStates", fmi2NewDiscreteStates(it(), &info), between, NULL, 0);
    }
}

static void state(void)
{
    const unsigned i = below(SLOTS);
    fmi2Byte bytes[1 << 16];
    fmi2FMUstate damaged = NULL;
    if (now.stage == UNSURE) return;
    if (chance(0.4)) {
        if (judge("fmi2GetFMUstate", fmi2GetFMUstate(it(), &now.slot[i].state), true, NULL, 0) == fmi2OK) {
            now.slot[i].stage = now.stage;
            now.slot[i].time = now.time;
            now.slot[i].continuous = now.continuous;
        }
    } else if (chance(0.9)) {
        if (judge("fmi2SetFMUstate", fmi2SetFMUstate(it(), now.slot[i].state), now.slot[i].state, NULL, 0) == fmi2OK) {
            now.stage = now.slot[i].stage;
            now.time = now.slot[i].time;
            now.continuous = now.slot[i].continuous;
        }
    } else {
        const size_t size = state_bytes(bytes, sizeof bytes);
        if (size == 0) return;
        bytes[below((unsigned)size)] ^= (fmi2Byte)(1 << below(8));
        if (judge("fmi2DeSerializeFMUstate",
                  fmi2DeSerializeFMUstate(it(), bytes, chance(0.9) ? size : below((unsigned)size + 1), &damaged), true,
                  NULL, 0)
            == fmi2OK) {
            if (judge("fmi2SetFMUstate", fmi2SetFMUstate(now.it, damaged), true, NULL, 0) == fmi2OK) now.stage = UNSURE;
            check(fmi2FreeFMUstate(now.it, &damaged) == fmi2OK, "fmi2FreeFMUstate");
        }
    }
}

static void other(Call *c)
{
    fmi2Integer integers[MOST_REFERENCES] = {0};
    fmi2String strings[MOST_REFERENCES] = {NULL}, category = chance(0.5) ? "logStatusError" : chance(0.5) ? "?" : NULL;
    judge("fmi2GetInteger", fmi2GetInteger(it(), c->references, c->count, integers), c->count == 0, NULL, 0);
    judge("fmi2SetBoolean", fmi2SetBoolean(it(), c->references, c->count, integers), c->count == 0, NULL, 0);
    judge("fmi2GetString", fmi2GetString(it(), c->references, c->count, strings), c->count == 0, NULL, 0);
    judge("fmi2CancelStep", fmi2CancelStep(it()), false, NULL, 0);
    judge("fmi2SetDebugLogging", fmi2SetDebugLogging(it(), fmi2True, below(2), chance(0.9) ? &category : NULL), true,
          NULL, 0);
}

void play2(void)
{
    static Call call; /* only its beginning is drawn */
    draw(&call);
    if (!now.it || chance(0.002) || (now.stage == UNSURE && chance(0.05))) {
        create();
        return;
    }
    switch (below(8)) {
    case 0: order(); break;
    case 1:
    case 2: values(&call); break;
    case 3: derivatives(&call); break;
    case 4: state(); break;
    case 5:
    case 6: now.exchange ? exchange(&call) : step(); break;
    default: chance(0.9) ? order() : other(&call);
    }
}
