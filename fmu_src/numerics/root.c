#include "numerics/root.h"

#include <math.h>
#include <stdbool.h>

#include "elementary/elementary.h"
#include "numerics/tolerances.h"

static bool same_sign(double a, double b) {
    return (a > 0.0) == (b > 0.0);
}

/* The next point, as a share of the interval from a towards b: by inverse quadratic interpolation where the three
 * latest points make the interpolant monotone, else by bisection (T. R. Chandrupatla, Advances in Engineering Software
 * 28, 1997). */
static double share(double a, double f_a, double b, double f_b, double c, double f_c) {
    const double x = (a - b) / (c - b), f = (f_a - f_b) / (f_c - f_b);
    if (!(f * f < x && (1.0 - f) * (1.0 - f) < 1.0 - x)) return 0.5;
    /* 0 < x < 1 and 0 < f < 1: no difference below is zero */
    return f_a / (f_b - f_a) * f_c / (f_b - f_c) + (c - a) / (b - a) * f_a / (f_c - f_a) * f_b / (f_c - f_b);
}

/* Invariant: the zero lies between a and b. a is the latest point, b the latest point on the other side of the zero,
 * and c the point that a or b replaced. */
double root_between(ScalarFunction *f, const void *context, double a, double f_a, double b, double f_b) {
    if (f_a == 0.0) return a;
    if (f_b == 0.0) return b;
    double t = isfinite(f_a) && isfinite(f_b) ? f_a / (f_a - f_b) : 0.5; /* the secant's zero */
    for (int i = 0; i < ROOT_MAX_ITERATIONS; i++) {
        const double width = fabs(b - a), near = ROOT_WIDTH * max_of(fabs(a), fabs(b));
        if (width <= near) break;
        const double least = 0.5 * near / width;
        const double x = a + min_of(max_of(t, least), 1.0 - least) * (b - a);
        const double f_x = f(context, x);
        if (f_x == 0.0) return x;
        const bool on_side_of_a = same_sign(f_x, f_a);
        const double c = on_side_of_a ? a : b, f_c = on_side_of_a ? f_a : f_b;
        if (!on_side_of_a) {
            b = a;
            f_b = f_a;
        }
        a = x;
        f_a = f_x;
        t = share(a, f_a, b, f_b, c, f_c);
    }
    return fabs(f_a) < fabs(f_b) ? a : b;
}
