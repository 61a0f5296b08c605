/* Arithmetic on lanes: one member of an ensemble in each component of a vector. A mask has all bits of a lane set, or
 * none. GCC's vector extensions, which clang shares; the width is that of the machine's registers. */
#ifndef LANES_H
#define LANES_H

#include <math.h>

#if defined(__AVX512F__)
#define LANES 8
#elif defined(__AVX__)
#define LANES 4
#else
#define LANES 2
#endif

typedef double V __attribute__((vector_size(8 * LANES)));
typedef long long I __attribute__((vector_size(8 * LANES)));

#define EACH(l) for (int l = 0; l < LANES; l++)
#define INLINE  static inline __attribute__((always_inline, unused))

INLINE V all(double a) { return (V){0} + a; }
INLINE V pick(I mask, V a, V b) { return (V)((mask & (I)a) | (~mask & (I)b)); }
INLINE V kept(I mask, V a) { return (V)(mask & (I)a); }
INLINE V number(I mask) { return (V)(mask & (I)all(1.0)); }
INLINE V lesser(V a, V b) { return pick((I)(a < b), a, b); }
INLINE V greater(V a, V b) { return pick((I)(a > b), a, b); }
INLINE V size(V a) { return (V)((I)a & 0x7fffffffffffffffLL); }
INLINE V sign(V a) { return number((I)(a > all(0.0))) - number((I)(a < all(0.0))); }

INLINE int any(I mask)
{
    long long bits = 0;
    EACH (l) bits |= mask[l];
    return bits != 0;
}

#define BY_LANE(name, function)         \
    INLINE V name(V a)                  \
    {                                   \
        V r;                            \
        EACH (l) r[l] = function(a[l]); \
        return r;                       \
    }
#define BY_LANE_2(name, function)             \
    INLINE V name(V a, V b)                   \
    {                                         \
        V r;                                  \
        EACH (l) r[l] = function(a[l], b[l]); \
        return r;                             \
    }

BY_LANE(root, sqrt)
BY_LANE(lane_exp, exp)
BY_LANE(lane_log, log)
BY_LANE(lane_log1p, log1p)
BY_LANE(lane_expm1, expm1)
BY_LANE(lane_tan, tan)
BY_LANE(lane_tanh, tanh)
BY_LANE(lane_atan, atan)
BY_LANE(lane_floor, floor)
BY_LANE_2(lane_atan2, atan2)
BY_LANE_2(lane_pow, pow)

/* Sine (``quarter`` 0) or cosine (1) to an ulp or so: the quadrant k is taken off with pi/2 in parts of 33 bits, so
 * that k times a part is exact up to REACH, and the rest, within pi/4, goes to polynomials. Beyond, the library's.
 * Source: fdlibm 5.3 (Sun Microsystems, 1993), __ieee754_rem_pio2, __kernel_sin, __kernel_cos. */
#define REACH 1.0e6

INLINE V wave(V a, int quarter)
{
    const V magic = all(6755399441055744.0); /* 1.5 * 2^52: its last bits are those of the nearest whole number */
    V sum = a * 6.36619772367581382433e-01 + magic;
    V k = sum - magic;
    I quadrant = (I)sum + quarter;
    V r = ((a - k * 1.57079632673412561417e+00) - k * 6.07710050630396597660e-11) - k * 2.02226624879595063154e-21;
    V z = r * r;
    V s = r
          + r * z
                * (-1.66666666666666324348e-01
                   + z
                         * (8.33333333332248946124e-03
                            + z
                                  * (-1.98412698298579493134e-04
                                     + z
                                           * (2.75573137070700676789e-06
                                              + z * (-2.50507602534068634195e-08 + z * 1.58969099521155010221e-10)))));
    V c = 1.0 - 0.5 * z
          + z * z
                * (4.16666666666666019037e-02
                   + z
                         * (-1.38888888888741095749e-03
                            + z
                                  * (2.48015872894767294178e-05
                                     + z
                                           * (-2.75573143513906633035e-07
                                              + z * (2.08757232129817482790e-09 + z * -1.13596475577881948265e-11)))));
    V value = pick((I)((quadrant & 1) != 0), c, s);
    value = (V)((I)value ^ ((quadrant & 2) << 62));
    if (any((I)(size(a) > all(REACH))))
        EACH (l)
            if (fabs(a[l]) > REACH) value[l] = quarter ? cos(a[l]) : sin(a[l]);
    return value;
}

INLINE V lane_sin(V a) { return wave(a, 0); }
INLINE V lane_cos(V a) { return wave(a, 1); }

#endif
