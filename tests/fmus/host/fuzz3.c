/* Random calls of the FMI 3 layer. */
#include "fuzz.h"

#include <stdlib.h>
#include <string.h>

#include "fmi3Functions.h"
#include "unit.h"

static struct {
    fmi3Instance it;
    bool exchange, events, continuous; /* events: co-simulation with event mode, and `continuous` is step mode */
    Stage stage;
    double time;
    struct {
        fmi3FMUState state;
        Stage stage;
        double time;
        bool continuous;
    } slot[SLOTS];
} now;

static void listen(fmi3InstanceEnvironment environment, fmi3Status status, fmi3String category, fmi3String message)
{
    (void)environment;
    check(status == fmi3Discard || status == fmi3Error, "a message with another status");
    check(category && strncmp(category, "logStatus", 9) == 0 && message && strlen(message) > 0, "an empty message");
}

void end3(void)
{
    for (int i = 0; now.it && i < SLOTS; i++)
        if (now.slot[i].state) check(fmi3FreeFMUState(now.it, &now.slot[i].state) == fmi3OK, "fmi3FreeFMUState");
    fmi3FreeInstance(now.it);
    memset(&now, 0, sizeof now);
}

static void create(void)
{
    const bool has_events = towage_unit.change.call && (towage_unit.indicators > 0 || towage_unit.next_event.call);
    const bool wrong = chance(0.02), events = chance(has_events ? 0.5 : 0.02);
    const char *token = wrong ? (chance(0.5) ? NULL : "{}") : towage_unit.token,
               *name = chance(0.05) ? NULL : "100%s%n";
    end3();
    now.exchange = chance(0.5);
    now.it = now.exchange ? fmi3InstantiateModelExchange(name, token, NULL, false, true, NULL, listen)
                          : fmi3InstantiateCoSimulation(name, token, NULL, false, true, events, true, NULL, 0, NULL,
                                                        chance(0.1) ? NULL : listen, NULL);
    now.events = events && !now.exchange;
    counted(2);
    const bool lacks = now.exchange ? towage_unit.steps != NULL : events && !has_events;
    check((now.it == NULL) == (wrong || lacks), "fmi3Instantiate");
    now.stage = now.it ? CREATED : NONE;
}

/* Mostly the instance, rarely none. */
static fmi3Instance it(void) { return chance(0.995) ? now.it : NULL; }

static bool at(Stage stage) { return now.stage == stage || now.stage == UNSURE; }

static void move(Stage stage)
{
    if (now.stage != UNSURE) now.stage = stage;
}

static void order(void)
{
    const double start = number(0.0), stop = number(20.0);
    const unsigned turn = below(8), stops = chance(0.3);
    int status;
    if (turn < 3) {
        status = fmi3EnterInitializationMode(it(), false, 0.0, start, stops, stop);
        if (judge("fmi3EnterInitializationMode", status, at(CREATED), NULL, 0) != fmi3OK) return;
        move(INITIALIZING_NOW);
        now.time = start;
    } else if (turn < 6) {
        status = fmi3ExitInitializationMode(it());
        if (judge("fmi3ExitInitializationMode", status, at(INITIALIZING_NOW), NULL, 0) != fmi3OK) return;
        move(RUNNING);
        now.continuous = false;
    } else if (turn < 7 && chance(0.3)) {
        if (judge("fmi3Terminate", fmi3Terminate(it()), at(RUNNING), NULL, 0) == fmi3OK) move(ENDED);
    } else if (chance(0.3) && fmi3Reset(it()) == fmi3OK) {
        now.stage = CREATED;
        now.time = 0.0;
    }
}

/* The serialised state; 0 bytes: refused. */
static size_t state_bytes(fmi3Byte *bytes, size_t room)
{
    fmi3FMUState state = NULL;
    size_t size = 0;
    if (fmi3GetFMUState(now.it, &state) != fmi3OK) return 0; /* with parameters that make no sense there is none */
    counted(4);
    check(fmi3SerializedFMUStateSize(now.it, state, &size) == fmi3OK && size <= room, "fmi3SerializedFMUStateSize");
    check(fmi3SerializeFMUState(now.it, state, bytes, size) == fmi3OK, "fmi3SerializeFMUState");
    check(fmi3FreeFMUState(now.it, &state) == fmi3OK && !state, "fmi3FreeFMUState");
    return size;
}

static void values(Call *c)
{
    static fmi3Byte before[1 << 16], after[1 << 16];
    const size_t given = chance(0.97) ? c->count : below(MOST_VALUES);
    const unsigned *references = chance(0.99) ? c->references : NULL;
    if (chance(0.5)) {
        const size_t size = state_bytes(before, sizeof before);
        if (judge("fmi3SetFloat64", fmi3SetFloat64(it(), references, c->count, chance(0.99) ? c->values : NULL, given),
                  now.stage != ENDED || c->count == 0, NULL, 0)
                != fmi3OK
            && size > 0)
            check(state_bytes(after, sizeof after) == size && memcmp(before, after, size) == 0,
                  "a refused fmi3SetFloat64 changed something");
        return;
    }
    size_t expected = 0;
    for (size_t i = 0; i < c->count; i++) {
        const unsigned r = c->references[i], variables = (unsigned)towage_unit.variables;
        expected += r < variables        ? (towage_unit.length ? (size_t)towage_unit.length[r] : 1)
                    : r == variables     ? 1
                    : r == variables + 1 ? (size_t)towage_unit.indicators
                                         : 0;
    }
    const size_t asked = chance(0.9) && expected <= MOST_VALUES ? expected : given;
    judge("fmi3GetFloat64", fmi3GetFloat64(it(), references, c->count, c->results, asked), asked == expected,
          c->results, asked);
}

static void derivatives(Call *c)
{
    const size_t seeds = chance(0.97) ? c->other_count : below(MOST_VALUES),
                 results = chance(0.97) ? c->count : below(9);
    const bool legal = now.stage != CREATED;
    switch (below(3)) {
    case 0:
        judge("fmi3GetDirectionalDerivative",
              fmi3GetDirectionalDerivative(it(), c->references, c->count, c->others, c->other_count, c->values, seeds,
                                           c->results, results),
              legal, c->results, results);
        break;
    case 1:
        judge("fmi3GetAdjointDerivative",
              fmi3GetAdjointDerivative(it(), c->others, c->other_count, c->references, c->count, c->values, seeds,
                                       c->results, results),
              legal, c->results, results);
        break;
    default:
        judge("fmi3GetOutputDerivatives",
              fmi3GetOutputDerivatives(it(), c->references, c->count, c->orders, c->results, results),
              !now.exchange && at(RUNNING), c->results, results);
    }
}

static void step(void)
{
    const double from = chance(0.97) ? now.time : number(1.0), size = number(0.1);
    bool events = true, terminate = true, early = true;
    double last = -1.0;
    fmi3Instance component = it();
    const int status =
        fmi3DoStep(component, from, size, true, &events, &terminate, &early, chance(0.99) ? &last : NULL);
    const bool here = at(RUNNING) && !now.exchange && (!now.events || now.continuous || now.stage == UNSURE);
    judge("fmi3DoStep", status, here && !terminate && (!events || now.events) && (!early || events), NULL, 0);
    if (status == fmi3OK)
        now.time = last;
    else if (status == fmi3Discard)
        check(now.stage == UNSURE || last == now.time, "fmi3DoStep: lastSuccessfulTime");
}

static void modes(void)
{
    bool flags[5];
    double time;
    const bool here = (now.exchange || now.events) && at(RUNNING);
    const bool inside = here && (now.continuous || now.stage == UNSURE);
    const bool between = here && (!now.continuous || now.stage == UNSURE);
    switch (below(3)) {
    case 0:
        if (judge("fmi3EnterEventMode", fmi3EnterEventMode(it()), inside, NULL, 0) == fmi3OK) now.continuous = false;
        break;
    case 1:
        if (judge("fmi3EnterStepMode", fmi3EnterStepMode(it()), between && now.events, NULL, 0) == fmi3OK
            || judge("fmi3EnterContinuousTimeMode", fmi3EnterContinuousTimeMode(it()), between && now.exchange, NULL, 0)
                   == fmi3OK)
            now.continuous = true;
        break;
    default:
        judge("fmi3UpdateDiscreteStates",
              fmi3UpdateDiscreteStates(it(), flags, flags + 1, flags + 2, flags + 3, flags + 4, &time), between, NULL,
              0);
    }
}

static void exchange(Call *c)
{
    double time;
    const bool here = now.exchange && at(RUNNING), inside = here && (now.continuous || now.stage == UNSURE);
    const size_t states = (size_t)towage_unit.states, count = chance(0.95) ? states : below(9);
    const size_t indicators = chance(0.95) ? (size_t)towage_unit.indicators : below(9);
    switch (below(6)) {
    case 0:
        time = number(now.time + 0.1);
        if (judge("fmi3SetTime", fmi3SetTime(it(), time), here, NULL, 0) == fmi3OK) now.time = time;
        break;
    case 1:
        judge("fmi3SetContinuousStates", fmi3SetContinuousStates(it(), c->values, count), inside && count == states,
              NULL, 0);
        break;
    case 2:
        judge("fmi3GetContinuousStates", fmi3GetContinuousStates(it(), c->results, count),
              now.exchange && count == states, c->results, count);
        break;
    case 3:
        judge("fmi3GetContinuousStateDerivatives", fmi3GetContinuousStateDerivatives(it(), c->results, count),
              now.exchange && count == states, c->results, count);
        break;
    case 4:
        judge("fmi3GetEventIndicators", fmi3GetEventIndicators(it(), c->results, indicators),
              now.exchange && indicators == (size_t)towage_unit.indicators, c->results, indicators);
        break;
    default: modes();
    }
}

static void state(void)
{
    const unsigned i = below(SLOTS);
    fmi3Byte bytes[1 << 16];
    fmi3FMUState damaged = NULL;
    if (now.stage == UNSURE) return;
    if (chance(0.4)) {
        if (judge("fmi3GetFMUState", fmi3GetFMUState(it(), &now.slot[i].state), true, NULL, 0) == fmi3OK) {
            now.slot[i].stage = now.stage;
            now.slot[i].time = now.time;
            now.slot[i].continuous = now.continuous;
        }
    } else if (chance(0.9)) {
        if (judge("fmi3SetFMUState", fmi3SetFMUState(it(), now.slot[i].state), now.slot[i].state, NULL, 0) == fmi3OK) {
            now.stage = now.slot[i].stage;
            now.time = now.slot[i].time;
            now.continuous = now.slot[i].continuous;
        }
    } else {
        const size_t size = state_bytes(bytes, sizeof bytes);
        if (size == 0) return;
        bytes[below((unsigned)size)] ^= (fmi3Byte)(1u << below(8));
        if (judge("fmi3DeserializeFMUState",
                  fmi3DeserializeFMUState(it(), bytes, chance(0.9) ? size : below((unsigned)size + 1), &damaged), true,
                  NULL, 0)
            == fmi3OK) {
            if (judge("fmi3SetFMUState", fmi3SetFMUState(now.it, damaged), true, NULL, 0) == fmi3OK) now.stage = UNSURE;
            check(fmi3FreeFMUState(now.it, &damaged) == fmi3OK, "fmi3FreeFMUState");
        }
    }
}

static void other(Call *c)
{
    fmi3Int32 integers[MOST_REFERENCES] = {0};
    fmi3Boolean booleans[MOST_REFERENCES] = {false};
    fmi3String strings[MOST_REFERENCES] = {NULL}, category = chance(0.5) ? "logStatusError" : chance(0.5) ? "?" : NULL;
    const size_t n = c->count;
    judge("fmi3GetInt32", fmi3GetInt32(it(), c->references, n, integers, n), n == 0, NULL, 0);
    judge("fmi3SetBoolean", fmi3SetBoolean(it(), c->references, n, booleans, n), n == 0, NULL, 0);
    judge("fmi3GetString", fmi3GetString(it(), c->references, n, strings, n), n == 0, NULL, 0);
    judge("fmi3EnterConfigurationMode", fmi3EnterConfigurationMode(it()), false, NULL, 0);
    judge("fmi3SetDebugLogging", fmi3SetDebugLogging(it(), true, below(2), chance(0.9) ? &category : NULL), true, NULL,
          0);
}

void play3(void)
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
    case 6: now.exchange ? exchange(&call) : chance(now.events ? 0.5 : 0.05) ? modes() : step(); break;
    default: chance(0.9) ? order() : other(&call);
    }
}
