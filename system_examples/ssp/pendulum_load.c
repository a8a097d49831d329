/* The weight of a body that turns about an axis: GravityLoad of dualcam/systems/blocks/gravity.py.
 *
 * The torque passes through the motor's part to the cam. It acts on the cam two steps after theta and omega were
 * read, and is held for one step. So the torque is computed for the middle of that step, 2.5 steps later.
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
