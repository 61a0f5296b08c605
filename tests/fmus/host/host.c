/* A C host for native FMUs, on Linux and Windows.
 *
 *     host LIBRARY 2|3 TOKEN COMMAND [NUMBER] < SCRIPT
 *
 * The script says what to run, a line each:
 *     start REFERENCE VALUE                     before initialization
 *     sine REFERENCE AMPLITUDE FREQUENCY FIRST  an input and its derivatives, at references FIRST to FIRST + 2
 *     get REFERENCE ...                         what to read
 *     step SIZE COUNT                           communication steps, s
 *
 * Commands:
 *     run           prints time and what is read after each step, as hexadecimal floats
 *     events        the same, with event mode and early return (FMI 3)
 *     states        rolls back, serialises, restores into other instances, compares to the last bit
 *     many NUMBER   instances side by side equal one alone
 *     growth NUMBER of lives, states and steps: prints by how many bytes memory grew
 *     time NUMBER   prints microseconds per set, step and get: the least mean of five batches
 *
 * Ends with 0, or with 1 and a line that says what was wrong. */
#include "fmu.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#ifndef _WIN32
#include <unistd.h>
#endif

enum { MOST = 64, ORDERS = 4 };

static struct {
    unsigned start[MOST], input[ORDERS * MOST], get[MOST];
    double value[MOST], amplitude[MOST], frequency[MOST], size;
    size_t starts, inputs, gets;
    int count;
} script;

static Fmu fmu;

static void must(bool condition, const char *what)
{
    if (condition) return;
    fprintf(stderr, "%s\n", what);
    exit(1);
}

#define OK(call) must((call) == 0, #call)

static void read_script(void)
{
    char line[1024], word[16];
    int used;
    while (fgets(line, sizeof line, stdin) && sscanf(line, "%15s%n", word, &used) == 1) {
        const char *rest = line + used;
        size_t s = script.starts, i = script.inputs;
        unsigned first;
        must(s < MOST && i < MOST, "the script is too long");
        if (strcmp(word, "start") == 0) {
            must(sscanf(rest, "%u %lf", &script.start[s], &script.value[s]) == 2, line);
            script.starts++;
        } else if (strcmp(word, "sine") == 0) {
            must(sscanf(rest, "%u %lf %lf %u", &script.input[ORDERS * i], &script.amplitude[i], &script.frequency[i],
                        &first)
                     == 4,
                 line);
            for (unsigned k = 1; k < ORDERS; k++) script.input[ORDERS * i + k] = first + k - 1;
            script.inputs++;
        } else if (strcmp(word, "get") == 0) {
            for (; sscanf(rest, "%u%n", &first, &used) == 1; rest += used) {
                must(script.gets < MOST, "the script is too long");
                script.get[script.gets++] = first;
            }
        } else {
            must(strcmp(word, "step") == 0 && sscanf(rest, "%lf %d", &script.size, &script.count) == 2, line);
        }
    }
}

/* Inputs at time t with their derivatives: a sin(w t), a w cos(w t), ... */
static void set_inputs(void *it, double t)
{
    double values[ORDERS * MOST];
    for (size_t i = 0; i < script.inputs; i++) {
        double a = script.amplitude[i], w = script.frequency[i], *v = values + ORDERS * i;
        v[0] = a * sin(w * t);
        v[1] = a * w * cos(w * t);
        v[2] = -w * w * v[0];
        v[3] = -w * w * v[1];
    }
    OK(fmu_set(&fmu, it, script.input, ORDERS * script.inputs, values));
}

static void *instantiate(void)
{
    void *it = fmu_instantiate(&fmu, "it");
    must(it != NULL, "no instance");
    return it;
}

static void *begin(void)
{
    void *it = instantiate();
    OK(fmu_set(&fmu, it, script.start, script.starts, script.value));
    OK(fmu_initialize(&fmu, it, 0.0));
    return it;
}

/* Step number k, and what is read after it. */
static void step(void *it, int k, double *seen)
{
    set_inputs(it, k * script.size);
    OK(fmu_step(&fmu, it, k * script.size, script.size));
    OK(fmu_get(&fmu, it, script.get, script.gets, seen));
}

static bool same(const double *a, const double *b) { return memcmp(a, b, script.gets * sizeof *a) == 0; }

static void run(void)
{
    double seen[MOST];
    void *it = begin();
    for (int k = 0; k < script.count; k++) {
        step(it, k, seen);
        printf("%a", (k + 1) * script.size);
        for (size_t i = 0; i < script.gets; i++) printf(" %a", seen[i]);
        putchar('\n');
    }
    fmu_free(&fmu, it);
}

/* From a state at each step, a few steps into the future and back. */
static void states(void)
{
    enum { AHEAD = 5 };
    double here[MOST], expected[AHEAD][MOST], seen[MOST];
    void *it = begin(), *other = begin();
    for (int k = 0; k + AHEAD < script.count; k++) {
        void *state, *copy, *fresh = instantiate(), *targets[3];
        size_t size;
        step(it, k, here);
        OK(fmu_get_state(&fmu, it, &state));
        for (int a = 0; a < AHEAD; a++) step(it, k + 1 + a, expected[a]);
        OK(fmu_state_size(&fmu, it, state, &size));
        char *bytes = malloc(size), *again = malloc(size);
        must(bytes && again, "no memory");
        OK(fmu_serialize(&fmu, it, state, bytes, size));
        OK(fmu_deserialize(&fmu, other, bytes, size, &copy));
        OK(fmu_serialize(&fmu, other, copy, again, size));
        must(memcmp(bytes, again, size) == 0, "bytes differ");
        targets[0] = it, targets[1] = other, targets[2] = fresh;
        for (int n = 0; n < 3; n++) {
            OK(fmu_set_state(&fmu, targets[n], n == 0 ? state : copy));
            OK(fmu_get(&fmu, targets[n], script.get, script.gets, seen));
            must(same(seen, here), "outputs differ after a restored state");
            for (int a = 0; a < AHEAD; a++) {
                step(targets[n], k + 1 + a, seen);
                must(same(seen, expected[a]), "outputs differ in steps after a restored state");
            }
        }
        OK(fmu_set_state(&fmu, it, state));
        OK(fmu_free_state(&fmu, it, &state));
        OK(fmu_free_state(&fmu, other, &copy));
        fmu_free(&fmu, fresh);
        free(bytes);
        free(again);
    }
    fmu_free(&fmu, it);
    fmu_free(&fmu, other);
}

static void many(int number)
{
    double expected[MOST], seen[MOST];
    void *alone = begin(), **its = malloc((size_t)number * sizeof *its);
    must(its != NULL, "no memory");
    for (int n = 0; n < number; n++) its[n] = begin();
    for (int k = 0; k < script.count; k++) {
        step(alone, k, expected);
        for (int n = 0; n < number; n++) {
            step(its[n], k, seen);
            must(same(seen, expected), "instances differ");
        }
    }
    for (int n = 0; n < number; n++) fmu_free(&fmu, its[n]);
    fmu_free(&fmu, alone);
    free(its);
}

/* Resident memory, bytes. */
static long resident(void)
{
    long pages = 0;
#ifndef _WIN32
    FILE *file = fopen("/proc/self/statm", "r");
    must(file && fscanf(file, "%*d %ld", &pages) == 1, "no /proc/self/statm");
    fclose(file);
    pages *= sysconf(_SC_PAGESIZE);
#endif
    must(pages > 0, "this system does not tell its memory");
    return pages;
}

/* A life with a refused call in it; then steps with a state taken and set at each. */
static void growth(int number)
{
    double seen[MOST], bad = nan("");
    long before = 0;
    fmu.silent = true;
    for (int n = 0; n < number; n++) {
        if (n == number / 10) /* once the allocator has what it needs */
            before = resident();
        void *state, *it = begin();
        must(fmu_set(&fmu, it, script.input, 1, &bad) != 0, "NaN was accepted");
        for (int k = 0; k < 10; k++) {
            OK(fmu_get_state(&fmu, it, &state));
            step(it, k, seen);
            OK(fmu_set_state(&fmu, it, state));
            OK(fmu_free_state(&fmu, it, &state));
            step(it, k, seen);
        }
        fmu_free(&fmu, it);
    }
    printf("%ld\n", resident() - before);
}

static double now(void) { return (double)clock() / CLOCKS_PER_SEC; }

static void measure(int number)
{
    double seen[MOST], least = INFINITY;
    void *it = begin();
    for (int batch = 0, k = 0; batch < 5; batch++) {
        double start = now();
        for (int n = 0; n < number; n++) step(it, k++, seen);
        least = fmin(least, (now() - start) / number);
    }
    printf("%.4f\n", 1e6 * least);
    fmu_free(&fmu, it);
}

int main(int count, char **words)
{
    int number = count > 5 ? atoi(words[5]) : 1;
    const char *command = count > 4 ? words[4] : "";
    must(count > 4 && (words[2][0] == '2' || words[2][0] == '3') && number > 0,
         "host LIBRARY 2|3 TOKEN run|events|states|many|growth|time [NUMBER] < SCRIPT");
    must(fmu_load(&fmu, words[1], words[2][0] - '0', words[3]), words[1]);
    read_script();
    fmu.events = strcmp(command, "events") == 0;
    if (fmu.events || strcmp(command, "run") == 0)
        run();
    else if (strcmp(command, "states") == 0)
        states();
    else if (strcmp(command, "many") == 0)
        many(number);
    else if (strcmp(command, "growth") == 0)
        growth(number);
    else if (strcmp(command, "time") == 0)
        measure(number);
    else
        must(false, "unknown command");
    fmu_unload(&fmu);
    return 0;
}
