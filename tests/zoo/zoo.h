/* The units of the zoo: one model, and what each of them does otherwise. Both versions of FMI stand on it. */
#ifndef ZOO_H
#define ZOO_H
#define _GNU_SOURCE
#include <fcntl.h>
#include <fenv.h>
#include <locale.h>
#include <math.h>
#include <pthread.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#ifdef __linux__
#include <netinet/in.h>
#include <sched.h>
#include <signal.h>
#include <sys/socket.h>
#endif
#include <time.h>
#include <unistd.h>

/* Value references. Reals: inputs, outputs, parameters. Integers, Booleans, texts: input and output. */
enum { U, Y, W, STAIRS, TOLERANCE, CALLS, GAIN, X0, END, NOISE, RATE, REALS };
enum { INTEGER_IN = 20, INTEGER_OUT, BOOLEAN_IN, BOOLEAN_OUT, TEXT_IN, TEXT_OUT };
enum { Z_OK, Z_WARNING, Z_DISCARD, Z_ERROR, Z_FATAL };

typedef struct Zoo Zoo;
typedef void Say(Zoo *zoo, int status, const char *text);
struct Zoo {
    double real[REALS], x, time, first_step, pending, slope, used, stop;
    pthread_t maker;
    int integer_in, integer_out;
    bool boolean_in, initialising, stepped;
    char text_in[64], name[64];
    /* what a saved state lacks */
    int repeats, reads;
    double hidden;
    char manner[64];
    Say *say;
    void *host;
};

static bool is(const Zoo *z, const char *manner) { return !strcmp(z->manner, manner); }

/* Tries what a unit has no business doing: a bit for each that the system allows. */
static int zoo_trespass(void)
{
    int done = 0;
#ifdef __linux__
    const int kinds[] = {AF_INET, AF_UNIX};
    for (int i = 0; i < 2; i++) {
        const int it = socket(kinds[i], SOCK_STREAM, 0);
        if (it >= 0) done |= 1 << i, close(it);
    }
    const char *elsewhere = getenv("TRESPASS"), *places[] = {"/dev/shm/towage-trespass", elsewhere};
    for (int i = 0; i < 2; i++) {
        const int it = places[i] ? open(places[i], O_WRONLY | O_CREAT | O_APPEND, 0600) : -1;
        if (it >= 0) done |= 4 << i, close(it);
        if (it >= 0 && i == 0) unlink(places[i]);
    }
    if (elsewhere && (truncate(elsewhere, 0) == 0)) done |= 16;
    if (kill(getppid(), 0) == 0) done |= 32;
    if (unshare(0) == 0) done |= 64; /* which changes nothing */
    const int here = open("mine", O_WRONLY | O_CREAT, 0600);
    if (here >= 0) done |= 128, close(here), unlink("mine");
#endif
    return done;
}

static void zoo_begin(Zoo *z, const char *name, const char *manner)
{
    strncpy(z->name, name, sizeof z->name - 1);
    strncpy(z->manner, manner, sizeof z->manner - 1);
    z->real[GAIN] = 1.0;
    z->real[END] = z->stop = INFINITY;
    z->maker = pthread_self();
}

/* y' = gain u; w = gain u without delay; stairs: whole seconds. */
static void zoo_outputs(Zoo *z)
{
    if (is(z, "lazy") && z->stepped) return; /* outputs are made in a step alone */
    z->real[Y] = z->x;
    z->real[W] = z->real[GAIN] * z->real[U];
    z->real[STAIRS] = floor(z->time + 1e-9);
    z->real[RATE] = z->real[GAIN] * z->real[U];
    if (is(z, "restless")) z->real[Y] += 1e-3 * z->reads++; /* its outputs change by being read */
    if (is(z, "nan") && z->time >= z->real[END]) z->real[Y] = NAN;
    if (is(z, "per minute")) z->real[RATE] *= 60.0; /* its rates are in another unit than it says */
    z->integer_out = is(z, "counter")      ? (int)floor(2.0 * z->time + 1e-9)
                     : is(z, "trespasses") ? z->integer_in
                                           : 2 * z->integer_in;
}

/* The initial state follows from the input where the manner is "from input". */
static void zoo_initial(Zoo *z) { z->x = is(z, "from input") ? z->real[X0] + z->real[U] : z->real[X0]; }

static int zoo_step(Zoo *z, double time, double step, bool committed, bool *over, double *reached)
{
    z->real[CALLS] += 1.0;
    *over = false;
    *reached = time;
    if (z->first_step == 0.0) z->first_step = step;
    if (is(z, "fixed") && fabs(step - z->first_step) > 1e-6 * z->first_step) {
        z->say(z, Z_DISCARD, "this unit takes steps of one size only");
        return Z_DISCARD;
    }
    if (is(z, "wall") && time + step > z->real[END]) return Z_DISCARD;
    if (is(z, "talker")) {
        z->say(z, Z_WARNING, "the first word, a warning");
        z->say(z, Z_ERROR, "the valve is stuck");
        z->say(z, Z_ERROR, "and so is everything else");
    }
    if (is(z, "talker") && time >= z->real[END]) return Z_ERROR;
    if (is(z, "stop") && time + step > z->stop) return Z_ERROR; /* not by the last bit */
    if (is(z, "pending")) return 5;
    if (is(z, "mute") && time + step > z->real[END]) return Z_DISCARD;
    if (is(z, "trespasses") && z->repeats == 0) z->integer_in = zoo_trespass();
    static double shared;
    if (is(z, "dies at once")) abort();
    if (is(z, "wanders")) (void)!chdir("/");
    if (is(z, "leaks")) memset(malloc(1000), 1, 1000);
    if (is(z, "forks") && z->repeats == 0 && fork() == 0) pause();
    if (is(z, "rounds")) fesetround(FE_UPWARD);
    if (is(z, "commas")) setlocale(LC_NUMERIC, "C.UTF-8");
    if (is(z, "opens")) (void)!open("/dev/null", O_RDONLY);
    if (is(z, "shares")) z->x += shared, shared += 1.0;
    if (is(z, "chance")) z->x += 1e-3 * (double)(clock() % 1000);
    if (is(z, "dies") && time >= z->real[END]) {
        z->say(z, Z_WARNING, "something is burning");
        abort();
    }
    if ((is(z, "ends") || is(z, "liar")) && time + step > z->real[END]) step = z->real[END] - time, *over = true;
    if (is(z, "commits") && !committed) return Z_OK;
    double u = z->real[U];
    if (is(z, "listens")) u += 0.5 * step * z->slope; /* derivatives of inputs; who is deaf takes them and does nothing */
    if (is(z, "clips")) u = fmin(fmax(u, -1.0), 1.0);
    if (is(z, "behind")) u = z->used; /* inputs act a step late */
    if (is(z, "thread") && !pthread_equal(z->maker, pthread_self())) u = 0.0;
    z->used = z->real[U];
    if (is(z, "decays")) z->x -= step * z->x; /* explicit Euler: what comes out depends on the step */
    const double did = is(z, "quantum") ? 0.04 * floor(step / 0.04 + 1e-9) : step; /* steps of its own, the rest is lost */
    const double moved = did * z->real[GAIN] * u;
    z->x += moved + (is(z, "hidden") ? step * z->hidden : 0.0) + (is(z, "noisy") ? z->real[NOISE] * (z->repeats % 2) : 0.0);
    z->hidden += moved;
    z->repeats++;
    z->time = *reached = time + step;
    z->stepped = false;
    zoo_outputs(z);
    z->stepped = true;
    if (*over && is(z, "liar")) *reached = time + 10.0 * step;
    if (is(z, "warns")) return Z_WARNING;
    return *over ? Z_DISCARD : Z_OK;
}

/* What is not part of the state goes on as it was. */
static void zoo_restore(Zoo *z, const Zoo *saved)
{
    const Zoo now = *z;
    *z = *saved;
    z->repeats = now.repeats;
    z->reads = now.reads;
    z->hidden = now.hidden;
    if (is(z, "flushes")) z->x = now.x; /* it takes the flag of the last step for leave to forget */
}
#endif
