/* Sums and products of two doubles without rounding: the rounded result and what rounding cuts off.
 * (T. J. Dekker, A floating-point technique for extending the available precision, Numer. Math. 18, 1971) */
#ifndef DUALCAM_DOUBLE_DOUBLE_H
#define DUALCAM_DOUBLE_DOUBLE_H

#include <stdint.h>
#include <string.h>

typedef struct {
    double hi, lo; /* the value is hi + lo */
} DoubleDouble;

/* x + y for |x| >= |y| or x = 0 */
static inline DoubleDouble ordered_sum(double x, double y) {
    const double sum = x + y;
    return (DoubleDouble){sum, (x - sum) + y};
}

/* x + y in any order */
static inline DoubleDouble exact_sum(double x, double y) {
    const double sum = x + y, added = sum - x;
    return (DoubleDouble){sum, (x - (sum - added)) + (y - added)};
}

/* The upper 26 bits of x, |x| < 2^990. The rest has 26 bits too. */
static inline double upper_half(double x) {
    const double large = x * 134217729.0; /* 2^27 + 1 */
    return large - (large - x);
}

static inline DoubleDouble exact_product(double x, double y) {
    const double product = x * y, a = upper_half(x), b = x - a, c = upper_half(y), d = y - c;
    return (DoubleDouble){product, ((a * c - product) + a * d + b * c) + b * d};
}

static inline uint64_t bits_of(double x) {
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}

static inline double double_of(uint64_t bits) {
    double x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

/* 2^n for -1022 <= n <= 1023 */
static inline double power_of_two(int n) {
    return double_of((uint64_t)(n + 1023) << 52);
}

#endif
