#include "numerics/level_log.h"

#include "numerics/tolerances.h"
#include "platform/attributes.h"

/* Of u = (q/q_0)^2: (w - w^2/2 + w^3/3 - w^4/4)/2 with w = u - 1, in powers of u. */
enum { DEGREE = 4 };
static const double POLYNOMIAL[] = {-25.0 / 24.0, 2.0, -1.5, 2.0 / 3.0, -0.125};

COMPACT Dual level_log(double q) {
    if (q >= LEVEL_LOG_FROM) return (Dual){logarithm(q), 1.0 / q};
    const double per_square = 1.0 / (LEVEL_LOG_FROM * LEVEL_LOG_FROM), u = q * q * per_square;
    Dual sum = {POLYNOMIAL[DEGREE], 0.0};
    for (int k = DEGREE - 1; k >= 0; k--) sum = (Dual){POLYNOMIAL[k] + u * sum.value, sum.value + u * sum.slope};
    return (Dual){logarithm(LEVEL_LOG_FROM) + sum.value, sum.slope * 2.0 * q * per_square};
}

COMPACT Jet level_log_along(const Jet *q) {
    if (q->c[0].value >= LEVEL_LOG_FROM) return jet_log(q);
    const Dual none = {0.0, 0.0};
    const Jet square = jet_multiply(q, q), u = jet_line(none, (Dual){1.0 / (LEVEL_LOG_FROM * LEVEL_LOG_FROM), 0.0}, &square);
    Jet sum = jet_polynomial(POLYNOMIAL, DEGREE, &u);
    sum.c[0].value += logarithm(LEVEL_LOG_FROM);
    return sum;
}
