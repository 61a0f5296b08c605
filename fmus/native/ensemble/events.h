/* Zeros of indicators within a step.
 *
 * A zero is sought on the cubic through both ends of a step, and the step is repeated to end there, until its end is
 * where the zero is. The cubic is exact at both ends, so that two repetitions find what bracketing by steps finds in
 * six. */
#ifndef EVENTS_H
#define EVENTS_H

#include "block.h"

#define MOST_TRIES 40.0  /* at one zero */
#define WIDTH      1e-10 /* of a zero, relative to the step that is being made when it is met */
#define NEAR       0.1   /* share of its values at the ends below which an indicator is looked at more closely */

/* Indicators at ``s`` within a step of ``h`` that ended in y, f: on the cubic through both ends. */
static void within(const Block *b, V s, V h, const V *y, const V *f, V *g)
{
    V safe = pick((I)(h > all(0.0)), h, all(1.0)), q = s / safe, p = 1.0 - q, z[NX];
    for (int i = 0; i < NX; i++)
        z[i] = p * p * ((1.0 + 2.0 * q) * b->x[i] + s * b->f[i]) + q * q * ((1.0 + 2.0 * p) * y[i] - (h - s) * f[i]);
    model_indicators(b->t + s, z, b->c, g);
}

INLINE I differ(V a, V b) { return (I)(a > all(0.0)) ^ (I)(b > all(0.0)); }

/* The end of a bracket, no wider than ``width`` where that can be had, of the first zero on the cubic before ``high``,
 * where the indicators are ``g``. */
static V zero(const Block *b, I which, V high, const V *g, V h, const V *y, const V *f, V width)
{
    V first = high;
    for (int j = 0; j < NG; j++) {
        I sought = which & differ(b->g[j], g[j]), mine = sought; /* the latter: not found yet */
        V low = all(0.0), up = high, g_low = b->g[j], g_up = g[j], side = all(0.0);
        for (int n = 0; n < 24 && any(mine); n++, mine &= (I)(up - low > 0.5 * width)) {
            V s = n % 4 == 3 ? 0.5 * (low + up) : up - g_up * (up - low) / (g_up - g_low); /* Illinois, and bisection */
            V there[NG + 1];
            s = lesser(greater(s, low + 0.2 * width), up - 0.2 * width);
            within(b, s, h, y, f, there);
            I beyond = differ(b->g[j], there[j]);
            g_low = pick(beyond, pick((I)(side > all(0.0)), 0.5 * g_low, g_low), there[j]);
            g_up = pick(beyond, there[j], pick((I)(side < all(0.0)), 0.5 * g_up, g_up));
            low = pick(mine & ~beyond, s, low);
            up = pick(mine & beyond, s, up);
            side = pick(beyond, all(1.0), all(-1.0));
        }
        first = pick(sought, lesser(first, up), first);
    }
    return first;
}

/* Lanes in which an indicator has another sign inside the step: at mid-step, or where the parabola through both ends
 * and mid-step comes near zero. ``probe`` is where, ``there`` the indicators. */
static I touched(const Block *b, I which, V h, const V *y, const V *f, const V *g, V *probe, V *there)
{
    I inside = {0}, near[NG + 1];
    V place[NG + 1], other[NG + 1];
    within(b, *probe, h, y, f, there);
    for (int j = 0; j < NG; j++) {
        V start = b->g[j], bend = 2.0 * (start + g[j]) - 4.0 * there[j], slope = 4.0 * there[j] - 3.0 * start - g[j];
        V s = -0.5 * slope / pick((I)(bend == all(0.0)), all(1.0), bend), bottom = start + 0.5 * s * slope;
        V limit = NEAR * greater(size(start), size(g[j]));
        inside |= differ(start, there[j]);
        place[j] = s * h;
        near[j] = which & (I)(s > all(0.0)) & (I)(s < all(1.0)) & (I)(size(start) > size(bottom))
                  & (differ(start, bottom) | (I)(size(bottom) < limit)) & ~differ(start, g[j]);
    }
    for (int j = 0; j < NG; j++)
        if (any(near[j] & ~inside)) {
            within(b, place[j], h, y, f, other);
            I here = near[j] & ~inside & differ(b->g[j], other[j]);
            *probe = pick(here, place[j], *probe);
            for (int i = 0; i < NG; i++) there[i] = pick(here, other[i], there[i]);
            inside |= here;
        }
    return inside;
}

/* Lanes whose step of ``h`` to y, f ends just beyond a zero. ``g`` becomes the indicators at the end. Lanes that must
 * repeat the step, to end where the zero was found, are no longer ``good``, and cut is the length of their next step.
 */
static I meet(Block *b, I *good, V h, V end, const V *y, const V *f, V *g)
{
    I changed = {0};
    V probe = 0.5 * h, middle[NG + 1], at[NG + 1];
    model_indicators(end, y, b->c, g);
    for (int j = 0; j < NG; j++) changed |= differ(b->g[j], g[j]);
    I inside = touched(b, *good, h, y, f, g, &probe, middle);
    I crosses = *good & (changed | inside);
    if (!any(crosses)) return (I){0};
    V width = greater(b->least, greater(WIDTH * b->h, 4e-16 * size(b->t)));
    for (int j = 0; j < NG; j++) at[j] = pick(inside, middle[j], g[j]);
    V place = zero(b, crosses, pick(inside, probe, h), at, h, y, f, width);
    I event = crosses & changed & ((I)(h - place <= width) | (I)(b->tries > all(MOST_TRIES)));
    I again = crosses & ~event & (I)(b->tries <= all(MOST_TRIES));
    b->cut = pick(again, lesser(place + 0.5 * width, h), b->cut);
    b->tries = pick(again, b->tries + 1.0, b->tries);
    *good &= ~again;
    return event;
}

#endif
