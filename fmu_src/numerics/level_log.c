#include "numerics/level_log.h"

#include "numerics/tolerances.h"
#include "platform/attributes.h"

COMPACT Dual level_log(double q) {
    if (q >= LEVEL_LOG_FROM) return (Dual){logarithm(q), 1.0 / q};
    const double per_square = 1.0 / (LEVEL_LOG_FROM * LEVEL_LOG_FROM), u = q * q * per_square;
    return (Dual){logarithm(LEVEL_LOG_FROM) - 0.75 + u - 0.25 * u * u, (2.0 - u) * q * per_square};
}

COMPACT Jet level_log_along(const Jet *q) {
    if (q->c[0].value >= LEVEL_LOG_FROM) return jet_log(q);
    const double per_square = 1.0 / (LEVEL_LOG_FROM * LEVEL_LOG_FROM);
    const double c[] = {logarithm(LEVEL_LOG_FROM) - 0.75, per_square, -0.25 * per_square * per_square};
    const Jet square = jet_multiply(q, q);
    return jet_polynomial(c, 2, &square);
}
