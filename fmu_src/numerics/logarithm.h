/* The natural logarithm of a number > 0, from log1p(), which the closed form needs as well: log() would add kilobytes of
 * tables. */
#ifndef DUALCAM_LOGARITHM_H
#define DUALCAM_LOGARITHM_H

#include <math.h>

static inline double logarithm(double x) {
    return x >= 1.0 ? log1p(x - 1.0) : -log1p(1.0 / x - 1.0);
}

#endif
