#include <math.h>
#include <stdbool.h>

#include "elementary/double_double.h"
#include "elementary/elementary.h"
#include "elementary/tangent_table.h"
#include "elementary/trigonometric_table.h"
#include "platform/attributes.h"

/* x = quadrant pi/2 + r, |r| <= pi/4 up to rounding */
typedef struct {
    DoubleDouble r;
    uint64_t quadrant; /* modulo 4 */
} Reduced;

/* ---- any |x| >= pi/4 ---- */

enum {
    WORDS = 7,         /* of 2/pi: what is left out is less than 2^-138 of a quadrant */
    LIMBS = WORDS + 2, /* of the product with the 53 bits of x */
    FRACTION_LIMBS = 6 /* 192 bits: no double is closer to a multiple of pi/2 than 2^-62 quadrants */
};

/* 32 bits of a number in limbs of 32 bits, least limb first, from bit `first` upwards; bits outside are 0. */
static uint32_t bits_from(const uint32_t limb[LIMBS], int first) {
    uint64_t pair = 0;
    const int index = first >= 0 ? first / 32 : -1, above = first - 32 * index;
    for (int j = 1; j >= 0; j--) {
        const bool inside = index + j >= 0 && index + j < LIMBS;
        pair = pair << 32 | (inside ? limb[index + j] : 0);
    }
    return (uint32_t)(pair >> above);
}

/* The fraction of `product` below bit `point` in quadrants, in [-1/2, 1/2]: less 1 where `negative`. */
static DoubleDouble fraction_of(const uint32_t product[LIMBS], int point, bool negative) {
    DoubleDouble sum = {0.0, 0.0};
    double unit = 0x1p-32;
    for (int j = 1; j <= FRACTION_LIMBS; j++, unit *= 0x1p-32) {
        const uint32_t bits = bits_from(product, point - 32 * j);
        const DoubleDouble next = exact_sum(sum.hi, (double)(negative ? ~bits : bits) * unit);
        sum = (DoubleDouble){next.hi, sum.lo + next.lo};
    }
    return negative ? (DoubleDouble){-sum.hi, -sum.lo} : sum;
}

/* The product of x and 2/pi in integers, or NaN for an infinite x; multiples of 4 quadrants are left out before they
 * arise. (M. H. Payne, R. N. Hanek, Radian reduction for trigonometric functions, ACM SIGNUM Newsletter 18, 1983) */
static Reduced reduce_exactly(double x) {
    if (!(fabs(x) <= DBL_MAX)) return (Reduced){{x - x, 0.0}, 0};
    const uint64_t bits = bits_of(x), fraction = (bits & 0xfffffffffffff) | 0x10000000000000;
    const int exponent = (int)(bits >> 52 & 0x7ff) - 1075; /* |x| = fraction 2^exponent */
    const int first = exponent > 2 ? (exponent - 2) / 32 : 0;
    const uint32_t factor[2] = {(uint32_t)fraction, (uint32_t)(fraction >> 32)};
    uint32_t product[LIMBS] = {0};
    for (int i = 0; i < 2; i++) {
        uint64_t carry = 0;
        for (int j = 0; j < WORDS; j++) {
            carry += (uint64_t)factor[i] * TWO_BY_PI[first + WORDS - 1 - j] + product[i + j];
            product[i + j] = (uint32_t)carry;
            carry >>= 32;
        }
        product[i + WORDS] = (uint32_t)carry;
    }
    const int point = 32 * (first + WORDS) - exponent;
    const bool up = bits_from(product, point - 1) & 1; /* to the next quadrant */
    const uint64_t quadrant = bits_from(product, point) + (uint64_t)up;
    const DoubleDouble y = fraction_of(product, point, up), full = exact_product(y.hi, HALF_PI_HIGH);
    const DoubleDouble r = ordered_sum(full.hi, full.lo + (y.hi * HALF_PI_LOW + y.lo * HALF_PI_HIGH));
    if (x > 0.0) return (Reduced){r, quadrant};
    return (Reduced){{-r.hi, -r.lo}, -quadrant};
}

static const double QUARTER_PI = 0.78539816339744828;

/* ---- |x| below 2^20 quadrants ---- */

static const double CODY_WAITE_LIMIT = 0x1p20;

/* x less its multiple of pi/2 in four parts. Products with the first three parts are exact, and so is the difference
 * with the first one. The error is below 2^-104. Where r is small, the next differences are exact too, and the error is
 * below 2^-134, while no double is closer to a multiple of pi/2 than 2^-61. (W. J. Cody, W. Waite, Software Manual for
 * the Elementary Functions, 1980) */
static inline Reduced reduce(double x) {
    const double shifted = x * TWO_BY_PI_ROUNDED + 0x1.8p52, n = shifted - 0x1.8p52; /* to the nearest integer */
    const double rest = x - n * HALF_PI_1, second = n * -HALF_PI_2, third = n * HALF_PI_3;
    const double less = rest + second, lost = (rest - less) + second;
    const double hi = less - third;
    return (Reduced){{hi, (((less - hi) - third) + lost) - n * HALF_PI_4}, bits_of(shifted)};
}

/* ---- |r| <= pi/4 ---- */

typedef int64_t Masks __attribute__((vector_size(16)));

/* sin(r) = r.hi + r.lo cos(r) - r^3/6 + ... and cos(r) = (1 - r^2/2) - r.hi r.lo + r^4/24 - ..., side by side in one
 * register of the processor. A processor without such registers computes the same bits one after the other. */
static inline Pair of_reduced(DoubleDouble r) {
    const Pair *c = SIN_COS_SERIES;
    const double x = r.hi, z = x * x, half = 0.5 * z, near = 1.0 - half;
    const Pair zz = {z, z}, z2 = zz * zz;
    const Pair series = (c[0] + zz * c[1]) + z2 * ((c[2] + zz * c[3]) + z2 * (c[4] + zz * c[5]));
    const Pair head = {x, near}, low = {r.lo * near, ((1.0 - near) - half) - x * r.lo}, power = {x, z};
    return head + (power * zz * series + low);
}

/* sin and cos of r + quadrant pi/2 */
static inline SinCos turned(Reduced reduced) {
    static const Masks SIGN[4] = {{0, 0}, {0, INT64_MIN}, {INT64_MIN, INT64_MIN}, {INT64_MIN, 0}};
    const Pair f = of_reduced(reduced.r);
    const Masks signs = SIGN[reduced.quadrant % 4];
    if (reduced.quadrant % 2 == 1) {
        const Pair g = (Pair)((Masks)(Pair){f[1], f[0]} ^ signs);
        return (SinCos){g[0], g[1]};
    }
    const Pair g = (Pair)((Masks)f ^ signs);
    return (SinCos){g[0], g[1]};
}

NOINLINE SinCos elementary_sin_cos(double x) {
    Reduced reduced = {{x, 0.0}, 0};
    if (!(fabs(x) <= QUARTER_PI)) {
        reduced = fabs(x) < CODY_WAITE_LIMIT ? reduce(x) : reduce_exactly(x);
    } else if (fabs(x) < 0x1p-27) {
        return (SinCos){x, 1.0};
    }
    return turned(reduced);
}

/* ---- tan ---- */

/* tan(h) - h, |h| <= 1/8 */
static inline double tan_rest(double h) {
    const double z = h * h, z2 = z * z, *c = TAN_SERIES;
    return h * z * ((c[0] + z * c[1]) + z2 * ((c[2] + z * c[3]) + z2 * (c[4] + z * c[5])));
}

/* tan(r + rest), 0 <= r < TAN_FIRST or r NaN, or -1/tan(r + rest) in odd quadrants. There the quotient q has 26 bits,
 * and with what is left, e = 1 - q t, 1/t = q/(1 - e) = q + e/t. */
static double tan_near_zero(double r, double rest, uint64_t quadrant) {
    const double more = rest + tan_rest(r), sum = r + more;
    if (quadrant % 2 == 0) return sum;
    const double quotient = 1.0 / sum, q = upper_half(quotient), upper = upper_half(sum);
    const double e = ((1.0 - q * upper) - q * (sum - upper)) - q * ((r - sum) + more);
    return -q - e * quotient;
}

/* With r = c + h, c from the table, u = tan(c) tan(h) and v = tan(h)/tan(c):
 * tan(r) = tan(c) + (tan(h) + tan(c) u)/(1 - u), 1/tan(r) = 1/tan(c) - (tan(h) + v/tan(c))/(1 + v).
 * The second terms are less than 1/14 of the first ones. In odd quadrants the tangent is -1/tan(r). */
static inline double tan_of_reduced(Reduced reduced) {
    const double r = fabs(reduced.r.hi), sign = copysign(1.0, reduced.r.hi), rest = reduced.r.lo * sign;
    if (!(r >= TAN_FIRST)) return sign * tan_near_zero(r, rest, reduced.quadrant);
    const int shift = 52 - TAN_BITS;
    const uint64_t step = (bits_of(r) >> shift) - (bits_of(TAN_FIRST) >> shift);
    const double h = (r - TAN_STEPS.centre[step]) + rest, t = h + tan_rest(h);
    if (reduced.quadrant % 2 == 0) {
        const double c = TAN_STEPS.tangent[step], u = c * t;
        return sign * (c + (t + c * u) / (1.0 - u));
    }
    const double c = TAN_STEPS.cotangent[step], v = c * t;
    return sign * ((t + c * v) / (1.0 + v) - c);
}

NOINLINE double elementary_tan(double x) {
    return tan_of_reduced(fabs(x) < CODY_WAITE_LIMIT ? reduce(x) : reduce_exactly(x));
}
