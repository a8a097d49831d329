#include <math.h>

#include "elementary/double_double.h"
#include "elementary/elementary.h"
#include "elementary/logarithm_table.h"
#include "platform/attributes.h"

static const uint64_t FIRST = 0x3fe6a00000000000; /* 0.707: where a binade of m begins; 1 is the middle of a step */
static const uint64_t BITS_OF_FRACTION = 52;

/* log((x + rest) 2^shift), x normal and |rest| below the last bit of x. With x = 2^n m and c close to 1/m from the table:
 * log(x) = n log 2 - log c + log(1 + r), r = m c - 1. c has so few bits that the first difference in r is exact. */
static inline double log_of_sum(double x, double rest, int shift) {
    const uint64_t bits = bits_of(x), above = bits - FIRST;
    const int64_t n = (int64_t)above >> BITS_OF_FRACTION;
    const double binades = (double)(n + shift);
    const LogStep *step = &LOG_STEP[(above >> (BITS_OF_FRACTION - LOG_BITS)) % (1 << LOG_BITS)];
    const double m = double_of(bits - ((uint64_t)n << BITS_OF_FRACTION));
    const double m_high = double_of(bits_of(m) & 0xffffffff00000000), m_low = m - m_high;
    const double first = (m_high * step->c - 1.0) + m_low * step->c;
    DoubleDouble split = {first, 0.0};
    if (rest != 0.0) split = exact_sum(first, rest * step->c * power_of_two((int)-n));
    const double r = split.hi;
    const double r2 = r * r, *c = LOG_SERIES;
    const double series = r2 * (-0.5 + r * ((c[0] + r * c[1]) + r2 * ((c[2] + r * c[3]) + r2 * (c[4] + r * c[5]))));
    const DoubleDouble sum = ordered_sum(binades * LOG_2_HIGH + step->log_high, r);
    return sum.hi + (sum.lo + (binades * LOG_2_LOW + step->log_low) + (split.lo + series));
}

NOINLINE double elementary_log(double x) {
    const uint64_t least = bits_of(DBL_MIN), infinite = bits_of(INFINITY);
    if (bits_of(x) - least < infinite - least) return log_of_sum(x, 0.0, 0); /* positive and normal */
    if (x == 0.0) return -INFINITY;
    if (!(x > 0.0)) return x != x ? x : NAN;
    return x > DBL_MAX ? x : log_of_sum(x * 0x1p54, 0.0, -54);
}

NOINLINE double elementary_log1p(double x) {
    if (fabs(x) < 0x1p-54) return x;
    if (!(x > -1.0 && x < 0x1p60)) return elementary_log(1.0 + x);
    const DoubleDouble sum = exact_sum(1.0, x);
    return log_of_sum(sum.hi, sum.lo, 0);
}
