/* Golden section search: the maximum of a function on an interval that holds one maximum.
 *
 * Each evaluation shrinks the interval by the factor (sqrt(5) - 1)/2 = 0.618 (J. Kiefer, Proceedings of the American
 * Mathematical Society 4, 1953). The maximum of -f is the minimum of f. */
#ifndef DUALCAM_GOLDEN_SECTION_H
#define DUALCAM_GOLDEN_SECTION_H

#include "numerics/root.h"

typedef struct {
    double x;     /* where the larger of the last two values is */
    double value; /* that value */
} GoldenSectionMaximum;

/* The maximum of f between a and b, which may be in either order, after 2 + `steps` evaluations. */
GoldenSectionMaximum golden_section_maximum(ScalarFunction *f, const void *context, double a, double b, int steps);

#endif
