/* Two doubles that share one vector register: one instruction computes both. */
#ifndef DUALCAM_VECTOR2_H
#define DUALCAM_VECTOR2_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#include "elementary/of_two_table.h"

typedef double Vector2 __attribute__((vector_size(2 * sizeof(double))));

/* Of each half; where a number is NaN, the y of that half. */
static inline Vector2 vector2_min(Vector2 x, Vector2 y) {
    return (Vector2){x[0] < y[0] ? x[0] : y[0], x[1] < y[1] ? x[1] : y[1]};
}

static inline Vector2 vector2_max(Vector2 x, Vector2 y) {
    return (Vector2){x[0] > y[0] ? x[0] : y[0], x[1] > y[1] ? x[1] : y[1]};
}

static inline Vector2 vector2_abs(Vector2 x) {
    return (Vector2){fabs(x[0]), fabs(x[1])};
}

/* False for NaN. */
static inline bool vector2_is_within(Vector2 x, double limit) {
    const Vector2 size = vector2_abs(x);
    return size[0] <= limit && size[1] <= limit;
}

/* exp(u) for |u| <= OF_TWO_EXP_SMALL, to one unit in the last place: 1 + 2 u/(u coth(u/2) - u). */
static inline Vector2 vector2_exp_small(Vector2 u) {
    const double *k = OF_TWO_EXP_SMALL_SERIES;
    const Vector2 z = u * u;
    return 1.0 + (u + u) / ((2.0 - u) + z * (k[0] + z * (k[1] + z * k[2])));
}

/* exp(u) for u < 700, to one unit in the last place; below exp(-700) the value is exp(-700). With u = n log 2 + x and
 * |x| <= log(2)/2: exp(x) times 2^n, and exp(x) = 1 + x + x c/(2 - c) with c = 2 - (x coth(x/2) - x). */
static inline Vector2 vector2_exp(Vector2 u) {
    u = (Vector2){u[0] < -700.0 ? -700.0 : u[0], u[1] < -700.0 ? -700.0 : u[1]};
    const Vector2 shifted = u * 0x1.71547652b82fep+0 + 0x1.8p52, n = shifted - 0x1.8p52; /* n to the nearest integer */
    typedef uint64_t Bits __attribute__((vector_size(2 * sizeof(uint64_t))));
    Bits bits;
    memcpy(&bits, &shifted, sizeof bits);
    bits = (bits + 1023) << 52; /* 2^n: the last bits of `shifted` are those of n */
    Vector2 power;
    memcpy(&power, &bits, sizeof power);
    const Vector2 high = u - n * OF_TWO_LOG_2_HIGH, low = n * OF_TWO_LOG_2_LOW, x = high - low, z = x * x;
    const double *k = OF_TWO_EXP_SERIES;
    const Vector2 c = x - z * (k[0] + z * (k[1] + z * (k[2] + z * (k[3] + z * k[4]))));
    return (1.0 - ((low - x * c / (2.0 - c)) - high)) * power;
}

/* log(x), x > 0 and normal, to one unit in the last place. With x = 2^n (1 + f), 1 + f from sqrt(1/2) to sqrt(2), and
 * s = f/(2 + f): log(1 + f) = 2 artanh(s), where 2 s = f - f^2/2 + s f^2/2 without the rounding of s. */
static inline Vector2 vector2_log(Vector2 x) {
    typedef int64_t Bits __attribute__((vector_size(2 * sizeof(int64_t))));
    Bits bits;
    memcpy(&bits, &x, sizeof bits);
    const Bits whole = (bits - 0x3fe6a09e667f3bcd) >> 52;
    bits -= whole << 52;
    Vector2 m;
    memcpy(&m, &bits, sizeof m);
    const Vector2 n = {(double)whole[0], (double)whole[1]}, f = m - 1.0, s = f / (2.0 + f), z = s * s, w = z * z;
    const double *k = OF_TWO_LOG_SERIES;
    const Vector2 even = k[0] + w * (k[2] + w * (k[4] + w * k[6])), odd = k[1] + w * (k[3] + w * k[5]);
    const Vector2 half = 0.5 * f * f, rest = s * (half + z * (even + z * odd)) + n * OF_TWO_LOG_2_LOW;
    return n * OF_TWO_LOG_2_HIGH - ((half - rest) - f);
}

#endif
