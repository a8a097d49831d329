#include <math.h>
#include <stdbool.h>

#include "elementary/double_double.h"
#include "elementary/elementary.h"
#include "elementary/logarithm_table.h"
#include "platform/attributes.h"

static const uint64_t FIRST = 0x3fe6a00000000000; /* 0.707: where a binade of m begins; 1 is the middle of a step */

enum { BITS_OF_FRACTION = 52, STEPS = 1 << LOG_BITS };

/* The steps of normal numbers from 0.707 2^-1021 to 0.707 2^1023, counted from FIRST on */
enum { LEAST_STEP = -1021 * STEPS, COUNT_OF_STEPS = (1021 + 1023) * STEPS };

/* The step of a number of these bits. Zeros, subnormal and negative numbers, infinity and NaN are out of range. */
static inline int64_t step_of(uint64_t bits) {
    return (int64_t)(bits - FIRST) >> (BITS_OF_FRACTION - LOG_BITS);
}

static inline bool in_range(int64_t step) {
    return (uint64_t)(step - LEAST_STEP) < COUNT_OF_STEPS;
}

/* A logarithm as a sum. |r| is below 1/4 of the logarithm, so that roundings of r and of the inner sums count little.
 * (P. T. P. Tang, Table-driven implementation of the logarithm function, ACM Trans. Math. Softw. 16, 1990) */
typedef struct {
    double high, low, r; /* high + low + log(1 + r) */
} LogParts;

/* log(x 2^shift), x in this step, outside of the steps around 1. With x = 2^n m and c from the table:
 * log(x) = n log 2 + log c + log(1 + r), r = (m - c)/c. The difference m - c is exact. */
static inline LogParts parts_of(double x, int64_t step, int shift) {
    const int64_t n = step >> LOG_BITS, j = step & (STEPS - 1);
    const double m = double_of(bits_of(x) - ((uint64_t)n << BITS_OF_FRACTION)), binades = (double)((int)n + shift);
    return (LogParts){
        .high = binades * LOG_2_HIGH + LOG_STEPS.log[j],
        .low = binades * LOG_2_LOW,
        .r = (m - LOG_STEPS.centre[j]) * LOG_STEPS.inverse[j],
    };
}

static inline double sum_of(LogParts p) {
    const double r = p.r, r2 = r * r, *c = LOG_SERIES;
    const double series = (c[0] + r * c[1]) + r2 * ((c[2] + r * c[3]) + r2 * (c[4] + r * c[5]));
    return p.high + (r + (p.low + r2 * series));
}

/* log(1 + r), LOG_NEAR_LOW <= r <= LOG_NEAR_HIGH */
NOINLINE static double log_near_one(double r) {
    const double r2 = r * r, *c = LOG_NEAR_SERIES;
    const double low = (c[0] + r * c[1]) + r2 * (c[2] + r * c[3]);
    const double high = (c[4] + r * c[5]) + r2 * ((c[6] + r * c[7]) + r2 * c[8]);
    return r + r2 * (low + r2 * r2 * high);
}

NOINLINE double elementary_log(double x) {
    int64_t step = step_of(bits_of(x));
    int shift = 0;
    if (!in_range(step)) {
        if (x == 0.0) return -INFINITY;
        if (!(x > 0.0)) return x != x ? x : NAN;
        if (x > DBL_MAX) return x;
        shift = x < 1.0 ? -54 : 54;
        x *= power_of_two(-shift);
        step = step_of(bits_of(x));
    }
    if ((uint64_t)(step - LOG_NEAR) < LOG_NEAR_STEPS) return log_near_one(x - 1.0);
    return sum_of(parts_of(x, step, shift));
}

/* With the rounded sum 1 + x, log(1 + x) = log(sum) + rest/sum. The rest is exact, but for x so large that it does not
 * count. */
NOINLINE double elementary_log1p(double x) {
    if (x >= LOG_NEAR_LOW && x <= LOG_NEAR_HIGH) return log_near_one(x);
    const double sum = 1.0 + x;
    const int64_t step = step_of(bits_of(sum));
    if (!in_range(step)) return elementary_log(sum);
    LogParts parts = parts_of(sum, step, 0);
    parts.low += (x - (sum - 1.0)) / sum;
    return sum_of(parts);
}
