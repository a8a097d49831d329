/* This room holds the elementary functions of the core: exp, log, sin, cos and the others. May include:
 * platform.
 *
 * The C standard leaves the last digits of exp() and sin() to each C library. These functions use additions,
 * multiplications, divisions, square roots and integers alone, which IEEE 754 rounds in one way only. So every platform
 * computes the same bits, and with them the same trajectory. No file of the core calls exp(), sin() or fmax() of the C
 * library (test_elementary.py); sqrt(), fabs(), floor(), ceil() and copysign() are exact everywhere.
 *
 * Errors are below 1 unit in the last place: tests/verification/elementary and its test compare with 60 digits.
 * Coefficients and tables are written by tools/make_elementary.py. No flag of the floating-point unit is promised.
 * Steps call all functions but tan, which the start of a run calls. */
#ifndef DUALCAM_ELEMENTARY_H
#define DUALCAM_ELEMENTARY_H

#include <float.h>

_Static_assert(FLT_EVAL_METHOD == 0, "double needs its own rounding: on 32-bit x86 compile with -msse2 -mfpmath=sse");
#ifdef __FAST_MATH__
#error "-ffast-math changes sums and removes tests for NaN: compile without this option"
#endif

double elementary_exp(double x);
double elementary_expm1(double x); /* exp(x) - 1 */

double elementary_log(double x);
double elementary_log1p(double x); /* log(1 + x) */

typedef struct {
    double sin, cos;
} SinCos;

SinCos elementary_sin_cos(double x);
double elementary_tan(double x);

double elementary_atan(double x);
double elementary_atan2(double y, double x); /* the angle of the point (x, y), from -pi to pi */

double elementary_cbrt(double x); /* third root */

/* The larger and the smaller number. A NaN counts as missing, as in fmax(); of two equal numbers the result is y. The C
 * standard leaves open which zero fmax(0.0, -0.0) gives. */
static inline double max_of(double x, double y) {
    return x > y || y != y ? x : y;
}

static inline double min_of(double x, double y) {
    return x < y || y != y ? x : y;
}

#endif
