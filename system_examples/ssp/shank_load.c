/* The torque with which thigh and gravity swing the shank: HingedPendulum of dualcam/systems/blocks/pendulum.py along the
 * measured motion of thigh and knee, drive = I psi'' + m d [a_x cos chi + (a_y + g) sin chi], chi = psi - theta + lead.
 *
 * As in pendulum_load.c the torque is computed for the middle of the step in which it acts, 2.5 steps later.
 */
#include <math.h>
#include <stddef.h>

#include "part.h"
#include "part_variables.h"
#include "reference.h"

static double drive(const double v[], double since, double theta) {
    const double time = v[TOE_OFF] + since, stride = v[STRIDE];
    const double chi = fourier(&v[THIGH_MEAN], stride, time, 0) - (theta + v[EXTENSION]) + v[LEAD];
    const double forward = fourier(&v[FORWARD_MEAN], stride, time, 2);
    const double upward = fourier(&v[UPWARD_MEAN], stride, time, 2) + v[GRAVITY];
    return v[INERTIA] * fourier(&v[THIGH_MEAN], stride, time, 2) +
           v[MOMENT] * (forward * cos(chi) + upward * sin(chi));
}

void part_initialize(double v[]) { v[TORQUE] = drive(v, 0.0, v[INITIAL_THETA]); }

const char *part_step(double v[], double time, double step) {
    const double ahead = 2.5 * step;
    v[TORQUE] = drive(v, time + ahead, v[THETA] + ahead * v[OMEGA]);
    return NULL;
}
