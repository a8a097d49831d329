/* The servo of the spring clamp: position control with feed-forward, Servo of dualcam/systems/machines/clamp.py.
 *
 * After a move and some settling the servo keeps its torque, and the stick band of the cam holds the clamp.
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
    const Point middle = planned(v, begin + 0.5 * v[TICK]);
    const double release = v[BAND_RELEASE] + v[BAND_RELEASE_RISE] * middle.angle;
    const double load = v[BAND_LOAD] + v[BAND_LOAD_RISE] * middle.angle;
    const double friction = middle.speed > 0.0 ? load : middle.speed < 0.0 ? release : 0.5 * (release + load);
    return v[INERTIA] * (planned(v, begin + v[TICK]).speed - planned(v, begin).speed) / v[TICK] + friction;
}

/* The torque of the tick that begins at `begin`; theta and omega were measured at `time`. */
static double torque(const double v[], double begin, double time) {
    const double since_move = fmod(begin + 0.5 * v[TICK], v[MOTION_MOVE] + v[MOTION_DWELL]);
    if (since_move > v[MOTION_MOVE] + v[SETTLING]) return v[COMMAND];
    const Point then = planned(v, time);
    const double damping = 2.0 * v[BANDWIDTH] * v[INERTIA], stiffness = v[BANDWIDTH] * v[BANDWIDTH] * v[INERTIA];
    return feed_forward(v, begin) + damping * (then.speed - v[OMEGA]) + stiffness * (then.angle - v[THETA]);
}

void part_initialize(double v[]) {
    v[THETA] = v[INITIAL_THETA];
    v[OMEGA] = v[INITIAL_OMEGA];
    v[NEWEST] = 0.0;
    v[COMMAND] = torque(v, 0.0, 0.0);
    v[REFERENCE] = planned(v, 0.0).angle;
}

/* A command acts on the cam one step after its measurement, so the measurement is taken one step before the tick. */
const char *part_step(double v[], double time, double step) {
    if (step > 1.001 * v[TICK]) return TOO_LONG;
    const double due = floor((time + 1.5 * step) / v[TICK]);
    if (due > v[NEWEST]) {
        v[NEWEST] = due;
        const double exact = due * v[TICK] - step; /* masters add up their steps: their clocks carry rounding */
        v[COMMAND] = torque(v, due * v[TICK], fabs(time - exact) < 1e-3 * step ? exact : time);
    }
    v[REFERENCE] = planned(v, time + step).angle;
    return NULL;
}
