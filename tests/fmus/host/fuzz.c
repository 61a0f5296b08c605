/* Hostile random calls of the FMI 2 and FMI 3 layers, for the sanitizers: wrong order, wrong references, wrong sizes,
 * null pointers, NaN, damaged states.
 *
 *     fuzz SEED TURNS
 *
 * A turn is one hostile call and what it takes to judge it, as the state before and after. Beside not crashing and not
 * leaking: no status is Fatal (there is memory), OK only where the order of calls allows it, no number that comes with
 * OK is infinite or NaN, and a refused setting changes nothing. */
#include "fuzz.h"

#include <float.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "unit.h"

static uint64_t seed;
static long turn, calls, accepted;
static size_t width; /* the most values that a legal call has */

/* xorshift64*: the same on every machine */
static uint64_t bits(void)
{
    seed ^= seed >> 12;
    seed ^= seed << 25;
    seed ^= seed >> 27;
    return seed * 2685821657736338717u;
}

double uniform(void) { return (double)(bits() >> 11) / 9007199254740992.0; }
bool chance(double probability) { return uniform() < probability; }
unsigned below(unsigned bound) { return (unsigned)(bits() >> 32) % bound; }

double hostile(void)
{
    const double pool[] = {NAN, INFINITY, -INFINITY, DBL_MAX, -DBL_MAX, 1e300, -1e300, DBL_MIN, 5e-324, -0.0, 1e17};
    return pool[below(sizeof pool / sizeof *pool)];
}

double number(double usual)
{
    if (chance(0.02)) return hostile();
    if (chance(0.05)) return pow(10.0, 12.0 * uniform() - 6.0) * (chance(0.5) ? 1.0 : -1.0);
    return usual * (chance(0.5) ? 1.0 : 0.5 + uniform());
}

static unsigned reference(void)
{
    const unsigned variables = (unsigned)towage_unit.variables;
    return chance(0.98) ? below(variables + 2) : chance(0.5) ? variables + below(10) : (unsigned)bits();
}

void draw(Call *call)
{
    const unsigned variables = (unsigned)towage_unit.variables;
    call->count = chance(0.5) ? 1 : below(MOST_REFERENCES + 1);
    call->other_count = chance(0.5) ? 1 : below(MOST_REFERENCES + 1);
    for (size_t i = 0; i < MOST_REFERENCES; i++) {
        call->references[i] = reference();
        call->others[i] = reference();
        call->orders[i] = chance(0.9) ? 1 : (int)below(6) - 1;
    }
    for (size_t i = 0; i < width; i++) {
        const unsigned r = call->references[i % MOST_REFERENCES];
        const double start = r < variables ? towage_unit.variable[r].start : 1.0;
        call->values[i] = number(start != 0.0 ? start : uniform() - 0.5);
        call->results[i] = NAN; /* what is not written is seen */
    }
}

static void measure(void)
{
    const size_t states = (size_t)towage_unit.states, indicators = (size_t)towage_unit.indicators;
    size_t longest = indicators > 1 ? indicators : 1;
    for (int r = 0; towage_unit.length && r < (int)towage_unit.variables; r++)
        if ((size_t)towage_unit.length[r] > longest) longest = (size_t)towage_unit.length[r];
    width = MOST_REFERENCES * longest > states ? MOST_REFERENCES * longest : states;
    if (width < 9) width = 9;
    if (width > MOST_VALUES) width = MOST_VALUES;
}

void counted(int made) { calls += made; }

static void verify(bool condition, const char *what, const char *how)
{
    if (condition) return;
    fprintf(stderr, "turn %ld: %s%s\n", turn, what, how);
    abort();
}

void check(bool condition, const char *what) { verify(condition, what, ""); }

int judge(const char *what, int status, bool legal, const double *results, size_t count)
{
    enum { OK, DISCARD = 2, ERROR };
    counted(1);
    verify(status == OK || status == DISCARD || status == ERROR, what, ": neither OK, Discard nor Error");
    if (status == OK) {
        verify(legal, what, ": OK where it may not be called so");
        accepted++;
        for (size_t i = 0; i < count; i++) verify(isfinite(results[i]), what, ": OK with a number that is not finite");
    }
    return status;
}

int main(int count, char **words)
{
    if (count != 3) {
        fprintf(stderr, "fuzz SEED TURNS\n");
        return 2;
    }
    seed = strtoull(words[1], NULL, 10) * 0x9E3779B97F4A7C15u + 1;
    measure();
    const long last = atol(words[2]);
    for (turn = 0; turn < last; turn++) {
        if (chance(0.5))
            play2();
        else
            play3();
    }
    end2();
    end3();
    printf("%ld turns, %ld calls, %ld accepted\n", turn, calls, accepted);
    return 0;
}
