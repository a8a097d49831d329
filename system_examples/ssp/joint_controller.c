/* The position controller of robot_joint.py's elbow: LQI with feed-forward, and rest inside the stick band.
 *
 * As JointController there, which explains it: at each tick it looks at the joint and at the planned motion (angle,
 * speed) at the tick's beginning and end. The stick band's edges are straight lines over theta.
 */
#include <math.h>
#include <stddef.h>

#include "part.h"
#include "part_variables.h"
#include "reference.h"

static double release_edge(const double v[], double theta) { return v[BAND_RELEASE] + v[BAND_RELEASE_RISE] * theta; }
static double load_edge(const double v[], double theta) { return v[BAND_LOAD] + v[BAND_LOAD_RISE] * theta; }
static double weight(const double v[], double theta) {
    return v[LOAD_MOMENT] * v[LOAD_GRAVITY] * sin(v[LOAD_LEAN] + theta);
}

static bool may_rest(const double v[], double error, double advance) {
    const double tolerance = v[RESTING] != 0.0 ? 2.0 * v[HOLD_TOLERANCE] : v[HOLD_TOLERANCE];
    return advance == 0.0 && load_edge(v, v[THETA]) > release_edge(v, v[THETA]) && fabs(error) < tolerance &&
           fabs(v[OMEGA]) < v[HOLD_SPEED];
}

/* The smallest torque that keeps gravity inside the band, with a margin. */
static double rest_torque(const double v[]) {
    const double release = release_edge(v, v[THETA]), load = load_edge(v, v[THETA]), pull = weight(v, v[THETA]);
    const double margin = v[HOLD_MARGIN] * 0.5 * (load - release);
    return fmin(fmax(pull, release + margin), load - margin) - pull;
}

static double command(double v[], Point now, Point then) {
    const double error = v[THETA] - now.angle, rate = v[OMEGA] - now.speed, advance = then.angle - now.angle;
    const bool resting = may_rest(v, error, advance);
    v[RESTING] = resting;
    if (resting) {
        v[INTEGRAL] = 0.0;
        return rest_torque(v);
    }
    const double feedback = v[GAIN_ANGLE] * error + v[GAIN_SPEED] * rate + v[GAIN_INTEGRAL] * v[INTEGRAL];
    const double acceleration = (then.speed - now.speed) / v[TICK] - feedback;
    const double middle = now.angle + 0.5 * advance;
    const double direction = advance != 0.0 ? advance : -error; /* at rest but off target: the way back */
    const double cam = direction > 0.0 ? load_edge(v, middle) : release_edge(v, middle);
    const double wanted = v[INERTIA] * acceleration + cam - weight(v, middle);
    const double torque = fmin(fmax(wanted, -v[LIMIT]), v[LIMIT]);
    if (torque == wanted) v[INTEGRAL] += error * v[TICK]; /* else it would wind up */
    return torque;
}

static Point planned(const double v[], double samples) {
    const PickAndPlace cycle = {v[MOTION_START], v[MOTION_END], v[MOTION_MOVE], v[MOTION_DWELL]};
    return pick_and_place(cycle, samples * v[TICK]);
}

void part_initialize(double v[]) { v[REFERENCE] = planned(v, 0.0).angle; }

const char *part_step(double v[], double time, double step) {
    if (step > 1.001 * v[TICK]) return TOO_LONG;
    if (sample_is_due(&v[SAMPLES], v[TICK], time, step)) {
        const Point now = planned(v, v[SAMPLES] - 1.0), then = planned(v, v[SAMPLES]);
        v[COMMAND] = command(v, now, then);
        v[REFERENCE] = then.angle;
    }
    return NULL;
}
