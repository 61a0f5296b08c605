/* The least that a step can cost: the integrator on a unit's traced derivatives, with neither events nor FMI around it.
 *
 *     bare NUMBER < SCRIPT      (the script of tests/fmus/host/host.c; compiled with unit.c, model.c and integrate.c)
 *
 * Prints microseconds a step, the least mean of five batches, and the state at the end of NUMBER steps. */
#define _POSIX_C_SOURCE 200809L
#include "integrate.h"
#include "unit.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { MOST = 256 };

typedef struct {
    double begin, m[MOST], u[MOST], p[MOST], k[4 * MOST];
    const double *arguments[MOST];
    double *results[MOST], w[16 * MOST];
    Integer iw[MOST];
} Model;

static Model model;
static double amplitude[MOST], frequency[MOST], size = 0.01;

static void rates(void *unused, double s, const double *x, double *f)
{
    const double t = model.begin + s;
    (void)unused;
    for (int i = 0; i < towage_unit.inputs; i++) {
        const double *k = model.k + 4 * i;
        model.u[i] = k[0] + s * (k[1] + s * (k[2] + s * k[3]));
    }
    model.arguments[0] = &t;
    model.arguments[1] = x;
    model.results[0] = f;
    towage_unit.derivatives.call(model.arguments, model.results, model.iw, model.w, 0);
}

static void initial(double *x)
{
    model.arguments[0] = model.p;
    model.arguments[1] = NULL;
    model.results[0] = x;
    model.results[1] = model.m;
    towage_unit.initial.call(model.arguments, model.results, model.iw, model.w, 0);
    const double *fixed[] = {NULL, NULL, model.m, model.u, model.p, NULL};
    memcpy(model.arguments, fixed, sizeof fixed);
}

static void run(int number, double *x)
{
    const System system = {NULL, towage_unit.states, 0, rates, NULL, NULL};
    static double work[64 * MOST];
    double first = 0.0;
    initial(x);
    for (int n = 0; n < number; n++) {
        double s = 0.0, t = model.begin = n * size;
        for (int i = 0; i < towage_unit.inputs; i++) {
            const double a = amplitude[i], w = frequency[i], sine = a * sin(w * t), cosine = a * w * cos(w * t);
            const double k[] = {sine, cosine, -w * w * sine / 2.0, -w * w * cosine / 6.0};
            memcpy(model.k + 4 * i, k, sizeof k);
        }
        if (integrate(&system, &s, x, size, 1e-8, 1e-8, &first, work) != 0) exit(1);
    }
}

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

int main(int count, char **words)
{
    const int number = count > 1 ? atoi(words[1]) : 0, first = towage_unit.parameters + 1 + towage_unit.calculated;
    double x[MOST] = {0.0}, value, w, least = INFINITY;
    char line[1024];
    unsigned reference;
    if (number < 1 || towage_unit.variables > MOST || integrate_work(towage_unit.states, 0) > 64 * MOST) return 1;
    for (int i = 0; i < towage_unit.parameters; i++) model.p[i] = towage_unit.variable[i].start;
    while (fgets(line, sizeof line, stdin)) {
        if (sscanf(line, "start %u %lf", &reference, &value) == 2 && reference < MOST)
            model.p[reference] = value;
        else if (sscanf(line, "sine %u %lf %lf", &reference, &value, &w) == 3 && reference >= (unsigned)first) {
            amplitude[reference - (unsigned)first] = value;
            frequency[reference - (unsigned)first] = w;
        } else {
            sscanf(line, "step %lf", &size);
        }
    }
    for (int batch = 0; batch < 5; batch++) {
        const double start = now();
        run(number, x);
        least = fmin(least, (now() - start) / number);
    }
    printf("%.4f", 1e6 * least);
    for (int i = 0; i < towage_unit.states; i++) printf(" %.17g", x[i]);
    putchar('\n');
    return 0;
}
