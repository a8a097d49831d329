#include <math.h>
#include <stdbool.h>

#include "elementary/arctangent_table.h"
#include "elementary/elementary.h"
#include "platform/attributes.h"

/* atan(t) - t, |t| <= 1/32 */
static inline double short_rest(double t) {
    const double z = t * t, *c = ATAN_SERIES;
    return t * z * ((c[0] + z * c[1]) + z * z * (c[2] + z * c[3]));
}

/* The same, |t| <= 1/8 */
static inline double near_rest(double t) {
    const double z = t * t, z2 = z * z, *c = ATAN_NEAR_SERIES;
    return t * z * ((c[0] + z * c[1]) + z2 * ((c[2] + z * c[3]) + z2 * (c[4] + z * c[5])));
}

/* The step of a tangent. Steps are equal in its bits; others than 0 to COUNT_OF_STEPS - 1 are outside of the table. */
enum { COUNT_OF_STEPS = sizeof ATAN_STEPS.centre / sizeof ATAN_STEPS.centre[0] };

static inline uint64_t step_of(double tangent) {
    const int shift = 52 - ATAN_BITS;
    return (bits_of(tangent) >> shift) - (bits_of(ATAN_FIRST) >> shift);
}

/* With c from the table: atan(x) = atan(c) + atan(t), t = (x - c)/(1 + c x). The difference x - c is exact, and t is
 * less than 1/15 of the angle. */
NOINLINE double elementary_atan(double x) {
    const double size = fabs(x);
    const uint64_t step = step_of(size);
    if (step < COUNT_OF_STEPS) {
        const double c = ATAN_STEPS.centre[step], t = (size - c) / (1.0 + c * size);
        return copysign(ATAN_STEPS.angle[step] + (t + short_rest(t)), x);
    }
    const double t = size < ATAN_FIRST ? size : 1.0 / size, rest = near_rest(t);
    return copysign(size < ATAN_FIRST ? t + rest : HALF_PI.hi - (t + (rest - HALF_PI.lo)), x);
}

/* An angle as a sum, the larger term first. */
static inline DoubleDouble angle_in_step(uint64_t step, double y, double x) {
    const double c = ATAN_STEPS.centre[step], upper = upper_half(x);
    const double t = ((y - c * upper) - c * (x - upper)) / (x + c * y);
    return (DoubleDouble){ATAN_STEPS.angle[step], t + short_rest(t)};
}

/* The angle of the point (x, y), both between 2^-400 and 2^500; `back`: of (-x, y). Near the axes a quotient below 1/8
 * is its own tangent; the parts of x times c, and y less their sum, are exact but for the last rounding. */
static inline double angle_of(double y, double x, bool back) {
    const double quotient = y / x;
    const uint64_t step = step_of(quotient);
    DoubleDouble angle;
    if (step < COUNT_OF_STEPS) {
        angle = angle_in_step(step, y, x);
    } else {
        const bool flat = quotient < ATAN_FIRST;
        const double t = flat ? quotient : x / y, rest = near_rest(t);
        const DoubleDouble product = exact_product(t, x);
        angle = flat ? (DoubleDouble){t, rest + ((y - product.hi) - product.lo) / x}
                     : (DoubleDouble){HALF_PI.hi, HALF_PI.lo - (t + rest)};
    }
    if (!back) return angle.hi + angle.lo;
    const DoubleDouble first = ordered_sum(PI.hi, -angle.hi);
    return first.hi + ((first.lo + PI.lo) - angle.lo);
}

/* The same of any sizes >= 0. An angle below 2^-60 is y/x, which may underflow; an angle so close to pi or pi/2 is
 * that. Other numbers differ by less than 2^60. A power of two brings both between the limits and keeps the angle. */
static double angle_at_limits(double y, double x, bool back) {
    if (x == INFINITY && y == INFINITY) x = y = 1.0;
    if (y == 0.0 || x == INFINITY || y < x * 0x1p-60) return back ? PI.hi : y == 0.0 ? 0.0 : y / x;
    if (x == 0.0 || y == INFINITY || x < y * 0x1p-60) return HALF_PI.hi;
    const double scale = x > 1.0 ? 0x1p-600 : 0x1p700;
    return elementary_atan2(y * scale, back ? -x * scale : x * scale);
}

NOINLINE double elementary_atan2(double y, double x) {
    const double across = fabs(x), up = fabs(y);
    const bool back = copysign(1.0, x) < 0.0;
    const bool usual = min_of(across, up) > 0x1p-400 && max_of(across, up) < 0x1p500;
    if (x != x || y != y) return x + y;
    return copysign(usual ? angle_of(up, across, back) : angle_at_limits(up, across, back), y);
}
