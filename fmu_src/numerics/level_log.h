/* A logarithm that levels off towards 0:
 *     l(q) = ln q                                q >= q_0 = LEVEL_LOG_FROM
 *     l(q) = ln q_0 - 3/4 + u - u^2/4            u = (q/q_0)^2 < 1
 * l is twice continuously differentiable, and, as a function of q^2, smooth at 0. */
#ifndef DUALCAM_LEVEL_LOG_H
#define DUALCAM_LEVEL_LOG_H

#include "numerics/jet.h"

/* Value and derivative. */
Dual level_log(double q);

Jet level_log_along(const Jet *q);

#endif
