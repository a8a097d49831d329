/* A logarithm that levels off towards 0:
 *     l(q) = ln q                                q >= q_0 = LEVEL_LOG_FROM
 *     l(q) = ln q_0 + (w - w^2/2 + w^3/3 - w^4/4)/2        w = (q/q_0)^2 - 1 < 0
 * the first terms of the series of ln q = ln q_0 + ln(1 + w)/2. l is four times continuously differentiable, and, as a
 * function of q^2, smooth at 0. */
#ifndef DUALCAM_LEVEL_LOG_H
#define DUALCAM_LEVEL_LOG_H

#include "numerics/jet.h"

/* Value and derivative. */
Dual level_log(double q);

Jet level_log_along(const Jet *q);

#endif
