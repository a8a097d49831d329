#include <math.h>

#include "elementary/double_double.h"
#include "elementary/elementary.h"
#include "elementary/exponential_table.h"
#include "platform/attributes.h"

enum { STEPS = EXP_STEPS };

/* exp(x) = power (1 + rest), power = 2^(k/STEPS) rounded. With x = k log(2)/STEPS + r and |r| <= log(2)/(2 STEPS):
 * rest = tail + r + r^2/2 + ..., where tail is the relative rounding of the power. */
typedef struct {
    double power, rest;
} Factors;

/* |x| < 1000. The powers are those of k modulo STEPS times 2^(k/STEPS - shift), shift: a multiple of a binade. */
static inline Factors factors_of(double x, int shift) {
    const double shifted = x * EXP_STEPS_PER_UNIT + 0x1.8p52, k = shifted - 0x1.8p52; /* to the nearest integer */
    const double r = (x - k * EXP_STEP_HIGH) - k * EXP_STEP_LOW;
    const uint64_t steps = bits_of(shifted); /* the last bits are those of k, in two's complement */
    const ExpPower *entry = &EXP_POWER[steps % STEPS];
    const uint64_t binades = steps / STEPS - (uint64_t)(int64_t)shift;
    const double r2 = r * r, *c = EXP_SERIES;
    return (Factors){
        .power = double_of(bits_of(entry->power) + (binades << 52)),
        .rest = entry->tail + r + r2 * (c[0] + r * c[1]) + r2 * r2 * (c[2] + r * c[3]),
    };
}

/* exp(x) where 2^(k/STEPS) may leave the normal numbers. The last product rounds once more, only below them. */
static double exp_at_limits(double x) {
    if (x != x) return x;
    if (x > EXP_OVERFLOW) return INFINITY;
    if (x < EXP_UNDERFLOW) return 0.0;
    const int shift = x > 0.0 ? 1000 : -1000;
    const Factors f = factors_of(x, shift);
    return (f.power + f.power * f.rest) * power_of_two(shift);
}

NOINLINE double elementary_exp(double x) {
    if (!(fabs(x) < 700.0)) return exp_at_limits(x);
    const Factors f = factors_of(x, 0);
    return f.power + f.power * f.rest;
}

/* x + x^2/2 + x^3/6 + ..., |x| <= 1/4 */
static double expm1_series(double x) {
    const double *c = EXPM1_SERIES;
    const double x2 = x * x, x4 = x2 * x2;
    const double low = (c[0] + x * c[1]) + x2 * (c[2] + x * c[3]);
    const double high = (c[4] + x * c[5]) + x2 * (c[6] + x * c[7]);
    return x + (0.5 * x2 + x * x2 * (low + x4 * (high + x4 * c[8])));
}

NOINLINE double elementary_expm1(double x) {
    if (fabs(x) <= 0.25) return fabs(x) < 0x1p-54 ? x : expm1_series(x);
    if (x < -40.0) return -1.0;                /* exp(-40) < 2^-57 */
    if (!(x < 60.0)) return elementary_exp(x); /* exp(60) > 2^86 */
    const Factors f = factors_of(x, 0);
    const DoubleDouble less = exact_sum(f.power, -1.0);
    return less.hi + (less.lo + f.power * f.rest);
}
