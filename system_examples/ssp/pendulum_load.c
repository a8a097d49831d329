/* The weight of a body that turns about an axis: GravityLoad of blocks.py.
 *
 * Its torque passes through the motor's part on its way to the cam, so it acts there two steps after theta and omega
 * were read, and is then held for a step: it is computed for the middle of that one, 2.5 steps on.
 */
#include <math.h>
#include <stddef.h>

#include "part.h"
#include "part_variables.h"

static double torque_at(const double v[], double theta) {
    return v[MOMENT] * v[GRAVITY] * sin(v[LEAN] + v[OFFSET] + theta / v[RATIO]);
}

void part_initialize(double v[]) { v[TORQUE] = torque_at(v, v[INITIAL_THETA]); }

const char *part_step(double v[], double time, double step) {
    (void)time;
    v[TORQUE] = torque_at(v, v[THETA] + 2.5 * step * v[OMEGA]);
    return NULL;
}
