/* The controller of the car door's motor: PI on speed with feed-forward, off where the cam holds the door.
 *
 * The law is that of SpeedController in dualcam/systems/blocks/speed_controller.py. The door's angle is
 * offset + theta/ratio. The cam's torque about the hinge is ratio times its own (ratio < 0: closing loads the cam).
 * The edges of the stick band are straight lines over theta.
 */
#include <math.h>
#include <stddef.h>

#include "part.h"
#include "part_variables.h"
#include "reference.h"

static double torque(double v[], Point door, double planned, double then) {
    const double pull = v[LOAD_MOMENT] * v[LOAD_GRAVITY] * sin(v[LOAD_LEAN] + door.angle);
    const double theta = v[RATIO] * (door.angle - v[OFFSET]);
    const double closes = v[RATIO] * (v[BAND_LOAD] + v[BAND_LOAD_RISE] * theta);
    const double opens = v[RATIO] * (v[BAND_RELEASE] + v[BAND_RELEASE_RISE] * theta);
    if (planned == 0.0 && then == 0.0 && fabs(door.speed) < v[HOLD_SPEED] && opens > closes) {
        const double margin = v[HOLD_MARGIN] * (opens - closes);
        v[DISTANCE] = 0.0;
        return fmin(fmax(pull, closes + margin), opens - margin) - pull;
    }
    const double mean = 0.5 * (planned + then);
    const double acceleration =
        (then - planned) / v[TICK] + v[GAIN_SPEED] * (planned - door.speed) + v[GAIN_DISTANCE] * v[DISTANCE];
    const double cam = mean < 0.0 ? closes - v[DRAG] * mean * mean : mean > 0.0 ? opens : 0.0;
    const double wanted = v[INERTIA] * acceleration + cam - pull;
    const double limited = fmin(fmax(wanted, -v[LIMIT]), v[LIMIT]);
    if (limited == wanted) v[DISTANCE] += (mean - door.speed) * v[TICK]; /* else it would wind up */
    return limited;
}

/* The cycle begins with the first move. */
static Point profile(const double v[], double time) {
    const PickAndPlace cycle = {v[MOTION_START], v[MOTION_END], v[MOTION_MOVE], v[MOTION_DWELL]};
    return pick_and_place(cycle, cycle.dwell + time);
}

static Point at_end(const double v[]) { return profile(v, (v[NEWEST] + 1.0) * v[TICK]); }

static Point door_at(const double v[], double theta, double omega) {
    return (Point){v[OFFSET] + theta / v[RATIO], omega / v[RATIO]};
}

void part_initialize(double v[]) {
    const Point now = profile(v, 0.0);
    v[NEWEST] = v[DISTANCE] = 0.0;
    v[COMMAND] = torque(v, door_at(v, v[INITIAL_THETA], v[INITIAL_OMEGA]), now.speed, at_end(v).speed);
    v[REFERENCE] = now.angle;
}

const char *part_step(double v[], double time, double step) {
    if (step > 1.001 * v[TICK]) return TOO_LONG;
    Sample sample;
    if (tick_is_due(&v[NEWEST], v[TICK], time, step, &sample)) {
        const Point now = profile(v, sample.time), then = at_end(v);
        const Point door = door_at(v, v[THETA], v[OMEGA]);
        v[COMMAND] = torque(v, carried_on(door, sample.lead, now, then, v[TICK]), now.speed, then.speed);
    }
    v[REFERENCE] = profile(v, time + step).angle;
    return NULL;
}
