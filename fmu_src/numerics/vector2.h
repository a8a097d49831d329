/* Two doubles that share one vector register: one instruction computes both. */
#ifndef DUALCAM_VECTOR2_H
#define DUALCAM_VECTOR2_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

typedef double Vector2 __attribute__((vector_size(2 * sizeof(double))));

/* The largest |u| of vector2_exp_small(), the largest |s| of vector2_log_ratio() */
static const double VECTOR2_SMALL = 0.125, VECTOR2_NEAR = 0.0625;

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

/* exp(u) for |u| <= 1/8, to 1e-14: (s + u)/(s - u) with s = u coth(u/2), an even function, by its series. */
static inline Vector2 vector2_exp_small(Vector2 u) {
    const Vector2 u2 = u * u, s = 2.0 + u2 * (1.0 / 6.0 + u2 * (-1.0 / 360.0 + u2 * (1.0 / 15120.0)));
    return (s + u) / (s - u);
}

/* exp(u) for |u| <= log(2)/2, to 1e-14: the Taylor polynomial at u/16, to the 16th power. */
static inline Vector2 vector2_exp_near_0(Vector2 u) {
    const Vector2 w = 0.0625 * u, w2 = w * w;
    const Vector2 high = (1.0 / 24.0 + w * (1.0 / 120.0)) + w2 * (1.0 / 720.0);
    const Vector2 root = (1.0 + w) + w2 * ((0.5 + w * (1.0 / 6.0)) + w2 * high);
    const Vector2 square = root * root, fourth = square * square, eighth = fourth * fourth;
    return eighth * eighth;
}

/* exp(u) for u < 700, to 1e-14; below exp(-700) the value is exp(-700). With u = n log 2 + r and |r| <= log(2)/2: exp(r)
 * times 2^n. */
static inline Vector2 vector2_exp(Vector2 u) {
    u = (Vector2){u[0] < -700.0 ? -700.0 : u[0], u[1] < -700.0 ? -700.0 : u[1]};
    const double log2_high = 0x1.62e42fee00000p-1, log2_low = 0x1.a39ef35793c76p-33;     /* their sum is log 2 */
    const Vector2 shifted = u * 0x1.71547652b82fep+0 + 0x1.8p52, n = shifted - 0x1.8p52; /* n to the nearest integer */
    typedef uint64_t Bits __attribute__((vector_size(2 * sizeof(uint64_t))));
    Bits bits;
    memcpy(&bits, &shifted, sizeof bits);
    bits = (bits + 1023) << 52; /* 2^n: the last bits of `shifted` are those of n */
    Vector2 power;
    memcpy(&power, &bits, sizeof power);
    return vector2_exp_near_0((u - n * log2_high) - n * log2_low) * power;
}

/* log((1 + s)/(1 - s)) = 2 artanh(s) for |s| <= 1/16, to some roundings, by its series. */
static inline Vector2 vector2_log_ratio(Vector2 s) {
    const Vector2 z = s * s;
    const Vector2 low = 2.0 / 3.0 + z * (2.0 / 5.0 + z * (2.0 / 7.0 + z * (2.0 / 9.0 + z * (2.0 / 11.0))));
    return (s + s) + s * z * low;
}

/* log(x), x > 0 and normal, to some roundings: x = 2^n m with m from sqrt(1/2) to sqrt(2), and the series of
 * log m = 2 artanh((m - 1)/(m + 1)). */
static inline Vector2 vector2_log(Vector2 x) {
    typedef int64_t Bits __attribute__((vector_size(2 * sizeof(int64_t))));
    Bits bits;
    memcpy(&bits, &x, sizeof bits);
    const Bits n = (bits - 0x3fe6a09e667f3bcd) >> 52;
    bits -= n << 52;
    Vector2 m;
    memcpy(&m, &bits, sizeof m);
    const Vector2 s = (m - 1.0) / (m + 1.0), z = s * s, z2 = z * z, z4 = z2 * z2;
    const Vector2 low = (1.0 / 3.0 + z * (1.0 / 5.0)) + z2 * (1.0 / 7.0 + z * (1.0 / 9.0));
    const Vector2 high = (1.0 / 11.0 + z * (1.0 / 13.0)) + z2 * (1.0 / 15.0 + z * (1.0 / 17.0));
    return (Vector2){(double)n[0], (double)n[1]} * 0x1.62e42fefa39efp-1 + (2.0 * s + 2.0 * s * z * (low + z4 * high));
}

#endif
