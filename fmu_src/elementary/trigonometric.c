#include <math.h>
#include <stdbool.h>

#include "elementary/double_double.h"
#include "elementary/elementary.h"
#include "elementary/trigonometric_table.h"
#include "platform/attributes.h"

/* x = quadrant pi/2 + r, |r| <= pi/4 up to rounding */
typedef struct {
    DoubleDouble r;
    int quadrant; /* modulo 4 */
} Reduced;

/* ---- any |x| >= pi/4 ---- */

enum {
    WORDS = 7,         /* of 2/pi: what is left out is less than 2^-138 of a quadrant */
    LIMBS = WORDS + 2, /* of the product with the 53 bits of x */
    FRACTION_LIMBS = 6 /* 192 bits: no double is closer to a multiple of pi/2 than 2^-62 quadrants */
};

/* 32 bits of a number in limbs of 32 bits, least limb first, from bit `first` upwards; bits outside are 0. */
COMPACT static uint32_t bits_from(const uint32_t limb[LIMBS], int first) {
    uint64_t pair = 0;
    const int index = first >= 0 ? first / 32 : -1, above = first - 32 * index;
    for (int j = 1; j >= 0; j--) {
        const bool inside = index + j >= 0 && index + j < LIMBS;
        pair = pair << 32 | (inside ? limb[index + j] : 0);
    }
    return (uint32_t)(pair >> above);
}

/* The fraction of `product` below bit `point` in quadrants, in [-1/2, 1/2]: less 1 where `negative`. */
COMPACT static DoubleDouble fraction_of(const uint32_t product[LIMBS], int point, bool negative) {
    DoubleDouble sum = {0.0, 0.0};
    double unit = 0x1p-32;
    for (int j = 1; j <= FRACTION_LIMBS; j++, unit *= 0x1p-32) {
        const uint32_t bits = bits_from(product, point - 32 * j);
        const DoubleDouble next = exact_sum(sum.hi, (double)(negative ? ~bits : bits) * unit);
        sum = (DoubleDouble){next.hi, sum.lo + next.lo};
    }
    return negative ? (DoubleDouble){-sum.hi, -sum.lo} : sum;
}

/* The product of x and 2/pi in integers; multiples of 4 quadrants are left out before they arise.
 * (M. H. Payne, R. N. Hanek, Radian reduction for trigonometric functions, ACM SIGNUM Newsletter 18, 1983) */
COMPACT static Reduced reduce_exactly(double x) {
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
    const int quadrant = (int)(bits_from(product, point) & 3) + up;
    const DoubleDouble y = fraction_of(product, point, up), full = exact_product(y.hi, HALF_PI_HIGH);
    const DoubleDouble r = ordered_sum(full.hi, full.lo + (y.hi * HALF_PI_LOW + y.lo * HALF_PI_HIGH));
    if (x > 0.0) return (Reduced){r, quadrant};
    return (Reduced){{-r.hi, -r.lo}, -quadrant};
}

/* ---- |x| below 2^20 quadrants ---- */

/* x less its multiple of pi/2 in three parts. Products with the first two parts are exact, and so is the difference
 * with the first one. The error is below 2^-98; where r is so small that this counts, and beyond 2^20 quadrants,
 * reduce_exactly() takes over. (W. J. Cody, W. Waite, Software Manual for the Elementary Functions, 1980) */
static inline Reduced reduce(double x) {
    if (fabs(x) <= 0.78539816339744828) return (Reduced){{x, 0.0}, 0};
    if (!(fabs(x) < 0x1p20)) return reduce_exactly(x);
    const double shifted = x * TWO_BY_PI_ROUNDED + 0x1.8p52, n = shifted - 0x1.8p52; /* to the nearest integer */
    const double rest = x - n * HALF_PI_1, second = n * HALF_PI_2, third = n * HALF_PI_3;
    const double less = rest - second, lost = (rest - less) - second;
    const double hi = less - third;
    if (fabs(hi) < 0x1p-30) return reduce_exactly(x);
    return (Reduced){{hi, ((less - hi) - third) + lost}, (int)(bits_of(shifted) & 3)};
}

/* ---- |r| <= pi/4 ---- */

/* sin(r) less r.hi: r.lo cos(r) - r^3/6 + ... */
static inline double sine_rest(DoubleDouble r) {
    const double x = r.hi, z = x * x, z2 = z * z, *c = SIN_SERIES;
    const double series = (c[0] + z * c[1]) + z2 * ((c[2] + z * c[3]) + z2 * (c[4] + z * c[5]));
    return x * z * series + r.lo * (1.0 - 0.5 * z);
}

/* cos(r) as sum: 1 - r^2/2 and the rest */
static inline DoubleDouble cosine_sum(DoubleDouble r) {
    const double x = r.hi, z = x * x, z2 = z * z, *c = COS_SERIES, half = 0.5 * z;
    const double series = (c[0] + z * c[1]) + z2 * ((c[2] + z * c[3]) + z2 * (c[4] + z * c[5]));
    const DoubleDouble sum = ordered_sum(1.0, -half);
    return (DoubleDouble){sum.hi, sum.lo + (z2 * series - x * r.lo)};
}

NOINLINE SinCos elementary_sin_cos(double x) {
    if (!(fabs(x) <= DBL_MAX)) return (SinCos){x - x, x - x};
    if (fabs(x) < 0x1p-27) return (SinCos){x, 1.0};
    const Reduced reduced = reduce(x);
    const DoubleDouble cosine = cosine_sum(reduced.r);
    const double s = reduced.r.hi + sine_rest(reduced.r), c = cosine.hi + cosine.lo;
    switch (reduced.quadrant & 3) {
        case 0: return (SinCos){s, c};
        case 1: return (SinCos){c, -s};
        case 2: return (SinCos){-s, -c};
        default: return (SinCos){-c, s};
    }
}

/* a/b: the rounded quotient, and a correction by what is left of the division */
static double quotient_of(DoubleDouble a, DoubleDouble b) {
    const double quotient = a.hi / b.hi;
    const DoubleDouble back = exact_product(quotient, b.hi);
    return quotient + (((a.hi - back.hi) - back.lo) + (a.lo - quotient * b.lo)) / b.hi;
}

COMPACT double elementary_tan(double x) {
    if (!(fabs(x) <= DBL_MAX)) return x - x;
    if (fabs(x) < 0x1p-27) return x;
    const Reduced reduced = reduce(x);
    const DoubleDouble sine = ordered_sum(reduced.r.hi, sine_rest(reduced.r)), sum = cosine_sum(reduced.r);
    const double cut = exact_product(reduced.r.hi, reduced.r.hi).lo; /* the rounding of r^2 in the cosine */
    const DoubleDouble cosine = ordered_sum(sum.hi, sum.lo - 0.5 * cut);
    if ((reduced.quadrant & 1) == 0) return quotient_of(sine, cosine);
    return quotient_of((DoubleDouble){-cosine.hi, -cosine.lo}, sine);
}
