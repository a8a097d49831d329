/* The servo of the spring clamp: position control with feed-forward, Servo of dualcam/systems/clamp.py.
 *
 * The torque of a sample is computed from the measurement one sample earlier. After a move and some settling the servo
 * keeps its torque, and the stick band of the cam holds the clamp.
 */
#include <math.h>
#include <stddef.h>

#include "part.h"
#include "part_variables.h"
#include "reference.h"

/* The cycle begins with the first move. */
static Point planned(const double v[], double time) {
    const PickAndPlace cycle = {v[MOTION_START], v[MOTION_END], v[MOTION_MOVE], v[MOTION_DWELL]};
    return pick_and_place(cycle, cycle.dwell + time);
}

static double feed_forward(const double v[], double begin) {
    const double h = v[SAMPLE];
    const Point middle = planned(v, begin + 0.5 * h);
    const double release = v[BAND_RELEASE] + v[BAND_RELEASE_RISE] * middle.angle;
    const double load = v[BAND_LOAD] + v[BAND_LOAD_RISE] * middle.angle;
    const double friction = middle.speed > 0.0 ? load : middle.speed < 0.0 ? release : 0.5 * (release + load);
    return v[INERTIA] * (planned(v, begin + h).speed - planned(v, begin).speed) / h + friction;
}

/* The torque of the sample that begins at `begin`; theta and omega are those one sample earlier. */
static double torque(const double v[], double begin) {
    const double h = v[SAMPLE];
    const double since_move = fmod(begin + 0.5 * h, v[MOTION_MOVE] + v[MOTION_DWELL]);
    if (since_move > v[MOTION_MOVE] + v[SETTLING]) return v[TAU];
    const Point measured = planned(v, begin - h);
    return feed_forward(v, begin) + v[INERTIA] * v[BANDWIDTH] *
                                        (2.0 * (measured.speed - v[OMEGA]) + v[BANDWIDTH] * (measured.angle - v[THETA]));
}

void part_initialize(double v[]) {
    v[THETA] = v[INITIAL_THETA];
    v[OMEGA] = v[INITIAL_OMEGA];
    v[TAU] = torque(v, 0.0);
}

const char *part_step(double v[], double time, double step) {
    if (fabs(step - v[SAMPLE]) > 1e-6 * v[SAMPLE]) return "allowed are steps of one sample of the servo";
    v[TAU] = torque(v, (round(time / step) + 1.0) * step);
    return NULL;
}
