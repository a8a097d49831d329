/* Errors of computed elementary functions, in units of the last place of the exact value.
 *
 * exp, sin and cos are summed in double-double arithmetic, whose relative error is some 2^-104, from Taylor's series after
 * a reduction of the argument. They have no table and no fitted polynomial in common with the core. The error of an inverse
 * function follows from what is left of its equation: log(x) - y = log(x exp(-y)), atan2(y, x) - a = asin((y cos a - x sin
 * a)/hypot(x, y)). __main__.py compares these errors with those from 60 digits. */
#include "elementary/double_double.h"

#include <math.h>
#include <stddef.h>

typedef DoubleDouble Real;
enum { TERMS = 31, WORDS = 22 };

/* Filled from 60 digits by __main__.py */
typedef struct {
    double inverse_factorial[TERMS][2];
    double log_2[3]; /* the first two parts have 40 bits */
    double half_pi[2];
    uint64_t two_by_pi[WORDS]; /* binary digits, after 64 zeros */
} Constants;

static Real real(const double pair[2]) { return (Real){pair[0], pair[1]}; }

static Real add(Real a, Real b) {
    const Real high = exact_sum(a.hi, b.hi), low = exact_sum(a.lo, b.lo), sum = ordered_sum(high.hi, high.lo + low.hi);
    return ordered_sum(sum.hi, sum.lo + low.lo);
}

static Real plus(Real a, double b) { return add(a, (Real){b, 0.0}); }
static Real negative(Real a) { return (Real){-a.hi, -a.lo}; }

static Real times(Real a, Real b) {
    const Real product = exact_product(a.hi, b.hi);
    return ordered_sum(product.hi, product.lo + (a.hi * b.lo + a.lo * b.hi));
}

static Real by(Real a, double b) { return times(a, (Real){b, 0.0}); }
static Real scaled(Real a, int n) { return (Real){ldexp(a.hi, n), ldexp(a.lo, n)}; }

static Real over(Real a, Real b) {
    const double quotient = a.hi / b.hi;
    const Real rest = add(a, negative(by(b, quotient)));
    return ordered_sum(quotient, rest.hi / b.hi);
}

/* The sum of sign^k x^k/(first + stride k)! up to (TERMS - 1)! */
static Real series(const Constants *c, Real x, int first, int stride, double sign) {
    Real sum = {0.0, 0.0};
    const Real signed_x = by(x, sign);
    for (int n = first + (TERMS - 1 - first) / stride * stride; n >= first; n -= stride)
        sum = add(times(sum, signed_x), real(c->inverse_factorial[n]));
    return sum;
}

/* exp(x) = (1 + rest) 2^n */
typedef struct {
    Real rest;
    int n;
} Exponential;

static Exponential exponential(const Constants *c, double x) {
    const double n = rint(x / c->log_2[0]);
    const Real r = plus(plus(exact_sum(x, -n * c->log_2[0]), -n * c->log_2[1]), -n * c->log_2[2]);
    return (Exponential){times(r, series(c, r, 1, 1, 1.0)), (int)n};
}

/* x less its multiple of pi/2, by 256 bits of 2/pi; the quadrant is counted modulo 4. */
static Real reduced(const Constants *c, double x, unsigned *quadrant) {
    *quadrant = 0;
    if (fabs(x) < 0.78) return (Real){x, 0.0};
    int exponent;
    const uint64_t m = (uint64_t)ldexp(frexp(fabs(x), &exponent), 53);
    const int first = exponent - 53 - 2 + 64, word = first / 64, above = first % 64; /* the bit of weight 2 */
    uint64_t product[4];
    unsigned __int128 carry = 0;
    for (int j = 3; j >= 0; j--) {
        const uint64_t *w = &c->two_by_pi[word + j];
        carry += (unsigned __int128)m * (above == 0 ? w[0] : w[0] << above | w[1] >> (64 - above));
        product[j] = (uint64_t)carry;
        carry >>= 64;
    }
    const int up = (int)(product[0] >> 61 & 1);
    *quadrant = (unsigned)(product[0] >> 62) + (unsigned)up;
    const uint64_t flip = up ? UINT64_MAX : 0; /* the complement of the digits, but for 2^-254 */
    product[0] = (product[0] ^ flip) & 0x3fffffffffffffff;
    Real sum = {0.0, 0.0};
    for (int j = 0; j < 4; j++) {
        const uint64_t digits = j == 0 ? product[0] : product[j] ^ flip;
        sum = plus(sum, ldexp((double)(digits >> 32), 2 - 64 * j - 32));
        sum = plus(sum, ldexp((double)(digits & 0xffffffff), 2 - 64 * j - 64));
    }
    if ((x < 0.0) != (up == 1)) sum = negative(sum);
    if (x < 0.0) *quadrant = -*quadrant;
    return times(sum, real(c->half_pi));
}

typedef struct {
    Real sin, cos;
} Circle;

static Circle circle(const Constants *c, double x) {
    unsigned quadrant;
    const Real r = reduced(c, x, &quadrant), z = times(r, r);
    const Real s = times(r, series(c, z, 1, 2, -1.0)), k = series(c, z, 0, 2, -1.0);
    switch (quadrant % 4) {
        case 0: return (Circle){s, k};
        case 1: return (Circle){k, negative(s)};
        case 2: return (Circle){negative(s), negative(k)};
        default: return (Circle){negative(k), s};
    }
}

/* exact 2^n less y, in units of the last place of the exact value */
static double error_of(Real exact, int n, double y) {
    int exponent;
    frexp(exact.hi, &exponent);
    const int last = exponent + n - 53 < -1074 ? -1074 - n : exponent - 53;
    return ldexp(add(exact, (Real){-ldexp(y, -n), 0.0}).hi, -last);
}

static double error_of_correction(double correction, double y) { return error_of(exact_sum(y, correction), 0, y); }

static double of_exp(const Constants *c, double x, double unused, double y) {
    (void)unused;
    const Exponential e = exponential(c, x);
    return error_of(plus(e.rest, 1.0), e.n, y);
}

static double of_expm1(const Constants *c, double x, double unused, double y) {
    const Exponential e = exponential(c, x);
    if (e.n > 200) return of_exp(c, x, unused, y);
    if (e.n == 0) return error_of(e.rest, 0, y);
    return error_of(plus(scaled(plus(e.rest, 1.0), e.n), -1.0), 0, y);
}

/* log(1 + x) - y, 1 + x = whole */
static double log_error(const Constants *c, Real x, Real whole, double y) {
    const Exponential e = exponential(c, -y);
    const Real left = e.n == 0 ? add(times(x, plus(e.rest, 1.0)), e.rest)
                               : plus(times(scaled(whole, e.n), plus(e.rest, 1.0)), -1.0);
    return error_of_correction(left.hi - 0.5 * left.hi * left.hi, y);
}

static double of_log(const Constants *c, double x, double unused, double y) {
    (void)unused;
    return log_error(c, exact_sum(x, -1.0), (Real){x, 0.0}, y);
}

static double of_log1p(const Constants *c, double x, double unused, double y) {
    (void)unused;
    return log_error(c, (Real){x, 0.0}, exact_sum(1.0, x), y);
}

static double of_sin(const Constants *c, double x, double unused, double y) {
    (void)unused;
    return error_of(circle(c, x).sin, 0, y);
}

static double of_cos(const Constants *c, double x, double unused, double y) {
    (void)unused;
    return error_of(circle(c, x).cos, 0, y);
}

static double of_tan(const Constants *c, double x, double unused, double y) {
    (void)unused;
    const Circle f = circle(c, x);
    return error_of(over(f.sin, f.cos), 0, y);
}

/* Of the angle of the point (across, up) */
static double of_atan2(const Constants *c, double up, double across, double y) {
    const Circle f = circle(c, y);
    int exponent;
    frexp(fmax(fabs(up), fabs(across)), &exponent);
    const double v = ldexp(up, -exponent), h = ldexp(across, -exponent);
    return error_of_correction(add(by(f.cos, v), by(f.sin, -h)).hi / hypot(v, h), y);
}

static double of_atan(const Constants *c, double x, double unused, double y) {
    (void)unused;
    return of_atan2(c, x, 1.0, y);
}

static double of_cbrt(const Constants *c, double x, double unused, double y) {
    (void)c, (void)unused;
    int n;
    frexp(y, &n);
    const double root = ldexp(y, -n), m = ldexp(x, -3 * n);
    const double left = plus(negative(by(exact_product(root, root), root)), m).hi;
    return error_of_correction(ldexp(left / (3.0 * root * root), n), y);
}

typedef double ErrorOf(const Constants *c, double x, double second, double y);

static ErrorOf *const ERROR_OF[] = {of_exp, of_expm1, of_log,  of_log1p, of_sin,
                                    of_cos, of_tan,   of_atan, of_cbrt,  of_atan2};
enum { EXP, LAST_OF_ONE = 8 };

/* Errors of the computed y[i] = f(x[i]), or f(x[i], second[i]); `f` counts the functions above. Below 2^-100 those that are
 * x + ... are x up to 2^-100 of themselves. */
__attribute__((visibility("default"))) void errors(const Constants *c, int f, int is_odd_like_x, size_t count,
                                                   const double *x, const double *second, const double *y,
                                                   double *error) {
    for (size_t i = 0; i < count; i++) {
        const int tiny = is_odd_like_x && fabs(x[i]) < 0x1p-100;
        error[i] = tiny ? error_of((Real){x[i], 0.0}, 0, y[i]) : ERROR_OF[f](c, x[i], second[i], y[i]);
    }
}
