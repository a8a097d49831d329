#include "numerics/root.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>

enum { MAX_ITERATIONS = 200 };

static bool same_sign(double a, double b) {
    return (a > 0.0) == (b > 0.0);
}

/* Inverse quadratic interpolation where the three latest points promise that it is monotone between them, else
 * bisection (T. R. Chandrupatla, Advances in Engineering Software 28, 1997). Share of the way from b to a. */
static double share(double a, double f_a, double b, double f_b, double c, double f_c) {
    const double x = (a - b) / (c - b), f = (f_a - f_b) / (f_c - f_b);
    if (!(f * f < x && (1.0 - f) * (1.0 - f) < 1.0 - x)) return 0.5;
    const double t = f_a / (f_b - f_a) * f_c / (f_b - f_c) + (c - a) / (b - a) * f_a / (f_c - f_a) * f_b / (f_c - f_b);
    return isfinite(t) ? t : 0.5;
}

/* b is the latest point, a the one before on the other side, c the one that a or b replaced. */
double root_between(ScalarFunction *f, const void *context, double a, double f_a, double b, double f_b) {
    if (f_a == 0.0) return a;
    if (f_b == 0.0) return b;
    double t = isfinite(f_a) && isfinite(f_b) ? f_a / (f_a - f_b) : 0.5; /* the secant's, from a */
    for (int i = 0; i < MAX_ITERATIONS; i++) {
        const double width = fabs(b - a), near = 2.0 * DBL_EPSILON * fmax(fabs(a), fabs(b));
        if (width <= near) break;
        const double least = 0.5 * near / width;
        const double x = a + fmin(fmax(t, least), 1.0 - least) * (b - a);
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
