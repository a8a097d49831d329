/* Golden section search: the maximum of a function on an interval that holds one maximum, and the first place at which a
 * sampled function exceeds 0.
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

/* f <= 0 at `before`, or no value of f there yet (-infinity), and f > 0 at `x`; x = infinity: none found. */
typedef struct {
    double before, f_before, x, value;
} FirstPositive;

/* The first of `samples` equal parts of (0, end] at whose end f exceeds 0. Where a sample exceeds its neighbours, the
 * maximum in between, after 2 + `steps` evaluations, counts too. `start`: f(0), which counts as 0 if more. */
FirstPositive golden_section_first_positive(ScalarFunction *f, const void *context, double start, double end,
                                            int samples, int steps);

#endif
