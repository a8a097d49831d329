#include <math.h>
#include <stdbool.h>

#include "elementary/arctangent_table.h"
#include "elementary/elementary.h"
#include "platform/attributes.h"

/* An angle as a sum, most significant term first. */
typedef struct {
    double high, middle, low;
} Angle;

/* atan(t) - t, |t| <= 1/16 */
static double atan_rest(double t) {
    const double z = t * t, z2 = z * z, *c = ATAN_SERIES;
    return t * z * ((c[0] + z * c[1]) + z2 * ((c[2] + z * c[3]) + z2 * c[4]));
}

static Angle angle_from_step(int j, double t) {
    return (Angle){ATAN_STEP[j].high, t, ATAN_STEP[j].low + atan_rest(t)};
}

static int nearest_step(double x) {
    const double steps = ATAN_STEPS;
    return (int)(x * steps + 0.5);
}

static double tangent_of(int j) {
    const double steps = ATAN_STEPS;
    return j / steps;
}

/* atan(y/x) for 0 <= y <= x, x normal and far from overflow. With c = j/ATAN_STEPS close to y/x:
 * atan(y/x) = atan(c) + atan(t), t = (y - c x)/(x + c y). The parts of x times c are exact, and so is y - c x but for
 * its last rounding. */
static Angle angle_in_octant(double y, double x) {
    const double quotient = y / x;
    if (quotient < 1.0 / 16.0) {
        if (quotient < 0x1p-500) return (Angle){quotient, 0.0, 0.0};
        const DoubleDouble back = exact_product(quotient, x);
        return (Angle){quotient, atan_rest(quotient), ((y - back.hi) - back.lo) / x};
    }
    const int j = nearest_step(quotient);
    const double c = tangent_of(j), upper = upper_half(x);
    return angle_from_step(j, ((y - c * upper) - c * (x - upper)) / (x + c * y));
}

static double sum_of(Angle a) {
    const DoubleDouble sum = exact_sum(a.high, a.middle);
    return sum.hi + (sum.lo + a.low);
}

/* base + sign a, |base| > |a| */
static double turned(DoubleDouble base, double sign, Angle a) {
    const DoubleDouble first = ordered_sum(base.hi, sign * a.high), second = exact_sum(first.hi, sign * a.middle);
    return second.hi + (second.lo + (first.lo + (base.lo + sign * a.low)));
}

NOINLINE double elementary_atan(double x) {
    const double size = fabs(x);
    if (size < 1.0 / 16.0) return size < 0x1p-27 ? x : x + atan_rest(x);
    if (size <= 1.0) {
        const int j = nearest_step(size);
        const double c = tangent_of(j);
        return copysign(sum_of(angle_from_step(j, (size - c) / (1.0 + c * size))), x);
    }
    if (x != x) return x;
    if (size > 0x1p60) return copysign(HALF_PI.hi, x);
    return copysign(turned(HALF_PI, -1.0, angle_in_octant(1.0, size)), x);
}

/* The angle of the point (x, y), both between 2^-400 and 2^500; `back`: of (-x, y). */
static inline double angle_of(double y, double x, bool back) {
    if (y > x) return turned(HALF_PI, back ? 1.0 : -1.0, angle_in_octant(x, y));
    const Angle angle = angle_in_octant(y, x);
    return back ? turned(PI, -1.0, angle) : sum_of(angle);
}

/* Both numbers times a power of two, so that the larger one lies between 1 and 2. The smaller one may underflow. */
COMPACT static void scale_to_one(double *y, double *x) {
    const double larger = max_of(*x, *y), normal = larger < DBL_MIN ? 0x1p100 : 1.0;
    const int exponent = (int)(bits_of(larger * normal) >> 52) - 1023;
    const double first = power_of_two(-(exponent / 2)), second = power_of_two(-(exponent - exponent / 2));
    *x = *x * normal * first * second;
    *y = *y * normal * first * second;
}

/* The same of any sizes >= 0. An angle below 2^-60 is y/x, which may underflow; an angle so close to pi or pi/2 is
 * that. */
COMPACT static double angle_at_limits(double y, double x, bool back) {
    if (x == INFINITY && y == INFINITY) x = y = 1.0;
    if (y == 0.0 || x == INFINITY || y < x * 0x1p-60) return back ? PI.hi : y == 0.0 ? 0.0 : y / x;
    if (x == 0.0 || y == INFINITY || x < y * 0x1p-60) return HALF_PI.hi;
    scale_to_one(&y, &x);
    return angle_of(y, x, back);
}

NOINLINE double elementary_atan2(double y, double x) {
    const double across = fabs(x), up = fabs(y);
    const bool back = copysign(1.0, x) < 0.0;
    const bool usual = min_of(across, up) > 0x1p-400 && max_of(across, up) < 0x1p500;
    if (x != x || y != y) return x + y;
    return copysign(usual ? angle_of(up, across, back) : angle_at_limits(up, across, back), y);
}
