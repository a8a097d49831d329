#include "numerics/golden_section.h"

#include <math.h>

#include "elementary/elementary.h"
#include "platform/attributes.h"

/* Left and right divide [a, b] so that one of the two is in the right place after the interval has shrunk. */
GoldenSectionMaximum golden_section_maximum(ScalarFunction *f, const void *context, double a, double b, int steps) {
    static const double RATIO = 0.61803398874989485; /* (sqrt(5) - 1)/2 */
    double left = b - RATIO * (b - a), right = a + RATIO * (b - a);
    double f_left = f(context, left), f_right = f(context, right);
    for (int i = 0; i < steps; i++) {
        if (f_left > f_right) {
            b = right;
            right = left;
            f_right = f_left;
            left = b - RATIO * (b - a);
            f_left = f(context, left);
        } else {
            a = left;
            left = right;
            f_left = f_right;
            right = a + RATIO * (b - a);
            f_right = f(context, right);
        }
    }
    return (GoldenSectionMaximum){.x = f_left > f_right ? left : right, .value = max_of(f_left, f_right)};
}

COLD FirstPositive golden_section_first_positive(ScalarFunction *f, const void *context, double start, double end,
                                                 int samples, int steps) {
    double x[3] = {0.0, 0.0, 0.0}, y[3] = {-INFINITY, -INFINITY, min_of(start, 0.0)};
    for (int k = 1; k <= samples; k++) {
        for (int j = 0; j < 2; j++) { /* the latest three samples */
            x[j] = x[j + 1];
            y[j] = y[j + 1];
        }
        x[2] = end * k / samples;
        y[2] = f(context, x[2]);
        if (y[2] > 0.0) return (FirstPositive){x[1], y[1], x[2], y[2]};
        if (!(y[1] < 0.0 && y[1] > y[0] && y[1] > y[2])) continue;
        const GoldenSectionMaximum top = golden_section_maximum(f, context, x[0], x[2], steps);
        if (top.value > 0.0) return (FirstPositive){x[0], y[0], top.x, top.value};
    }
    return (FirstPositive){.x = INFINITY};
}
