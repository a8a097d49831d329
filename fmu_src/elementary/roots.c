#include <math.h>

#include "elementary/double_double.h"
#include "elementary/elementary.h"
#include "elementary/roots_table.h"

/* x = m 2^(3n), 1 <= m < 8, x normal. A polynomial gives the root of m to two digits. Two steps of Halley's method
 * follow, y + y (m - y^3)/(2 y^3 + m), which has order three. The second step takes y with 26 bits, so that y^2 is
 * exact; a third of the rounding of m/y^2 is all that counts besides the last sum. */
static double root_of_normal(double x) {
    const uint64_t bits = bits_of(x);
    const int exponent = (int)(bits >> 52) - 1023 + 3 * 400, n = exponent / 3 - 400, above = exponent % 3;
    const double m = double_of((bits & 0xfffffffffffff) | (uint64_t)(1023 + above) << 52), *c = CBRT_START;
    double y = (c[0] + m * c[1]) + m * m * (c[2] + m * c[3]);
    const double cube = y * y * y;
    y += y * (m - cube) / (2.0 * cube + m);
    y = double_of(bits_of(y) & 0xfffffffff8000000);
    const double r = m / (y * y);
    return (y + y * (r - y) / (2.0 * y + r)) * power_of_two(n);
}

double elementary_cbrt(double x) {
    const double size = fabs(x);
    if (size == 0.0 || !(size <= DBL_MAX)) return x;
    const double root = size < DBL_MIN ? root_of_normal(size * 0x1p54) * 0x1p-18 : root_of_normal(size);
    return copysign(root, x);
}
