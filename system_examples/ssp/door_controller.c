/* The motor's controller of car_door.py: PI on speed with feed-forward, off where the cam holds.
 *
 * As SpeedController there, which explains it. The door's angle is offset + theta/ratio, and what the cam does about
 * the hinge is ratio times its torque (ratio < 0: closing loads it). The band's edges are straight lines over theta.
 */
#include <math.h>
#include <stddef.h>

#include "part.h"
#include "part_variables.h"
#include "reference.h"

static double torque(double v[], double planned, double then) {
    const double angle = v[OFFSET] + v[THETA] / v[RATIO], speed = v[OMEGA] / v[RATIO];
    const double pull = v[LOAD_MOMENT] * v[LOAD_GRAVITY] * sin(v[LOAD_LEAN] + angle);
    const double closes = v[RATIO] * (v[BAND_LOAD] + v[BAND_LOAD_RISE] * v[THETA]);
    const double opens = v[RATIO] * (v[BAND_RELEASE] + v[BAND_RELEASE_RISE] * v[THETA]);
    if (planned == 0.0 && then == 0.0 && fabs(speed) < v[HOLD_SPEED] && opens > closes) {
        const double margin = v[HOLD_MARGIN] * (opens - closes);
        v[DISTANCE] = 0.0;
        return fmin(fmax(pull, closes + margin), opens - margin) - pull;
    }
    const double mean = 0.5 * (planned + then);
    const double acceleration =
        (then - planned) / v[TICK] + v[GAIN_SPEED] * (planned - speed) + v[GAIN_DISTANCE] * v[DISTANCE];
    const double cam = mean < 0.0 ? closes - v[DRAG] * mean * mean : mean > 0.0 ? opens : 0.0;
    const double wanted = v[INERTIA] * acceleration + cam - pull;
    const double limited = fmin(fmax(wanted, -v[LIMIT]), v[LIMIT]);
    if (limited == wanted) v[DISTANCE] += (mean - speed) * v[TICK]; /* else it would wind up */
    return limited;
}

/* The cycle begins with the first move. */
static Point profile(const double v[], double samples) {
    const PickAndPlace cycle = {v[MOTION_START], v[MOTION_END], v[MOTION_MOVE], v[MOTION_DWELL]};
    return pick_and_place(cycle, cycle.dwell + samples * v[TICK]);
}

void part_initialize(double v[]) { v[REFERENCE] = profile(v, 0.0).angle; }

const char *part_step(double v[], double time, double step) {
    if (step > 1.001 * v[TICK]) return TOO_LONG;
    if (sample_is_due(&v[SAMPLES], v[TICK], time, step)) {
        const Point now = profile(v, v[SAMPLES] - 1.0), then = profile(v, v[SAMPLES]);
        v[COMMAND] = torque(v, now.speed, then.speed);
        v[REFERENCE] = then.angle;
    }
    return NULL;
}
