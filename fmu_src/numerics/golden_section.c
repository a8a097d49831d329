#include "numerics/golden_section.h"

#include <math.h>

#include "elementary/elementary.h"

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
