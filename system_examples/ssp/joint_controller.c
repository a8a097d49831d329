/* The position controller of the robot's elbow: LQI with feed-forward, and rest inside the stick band.
 *
 * The law is that of PositionController in dualcam/systems/blocks/position_controller.py. For each tick it takes the state
 * of the joint, and the planned angle and speed at the beginning and at the end of the tick. The edges of the stick
 * band are straight lines over theta.
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

static bool may_rest(const double v[], Point joint, double error, double advance) {
    const double tolerance = v[RESTING] != 0.0 ? 2.0 * v[HOLD_TOLERANCE] : v[HOLD_TOLERANCE];
    return advance == 0.0 && load_edge(v, joint.angle) > release_edge(v, joint.angle) && fabs(error) < tolerance &&
           fabs(joint.speed) < v[HOLD_SPEED];
}

/* The smallest torque that keeps gravity inside the band, with a margin. */
static double rest_torque(const double v[], double theta) {
    const double release = release_edge(v, theta), load = load_edge(v, theta), pull = weight(v, theta);
    const double margin = v[HOLD_MARGIN] * 0.5 * (load - release);
    return fmin(fmax(pull, release + margin), load - margin) - pull;
}

static double command(double v[], Point joint, Point now, Point then) {
    const double error = joint.angle - now.angle, rate = joint.speed - now.speed;
    const double advance = then.angle - now.angle;
    const bool resting = may_rest(v, joint, error, advance);
    v[RESTING] = resting;
    if (resting) {
        v[INTEGRAL] = 0.0;
        return rest_torque(v, joint.angle);
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

static Point planned(const double v[], double time) {
    const PickAndPlace cycle = {v[MOTION_START], v[MOTION_END], v[MOTION_MOVE], v[MOTION_DWELL]};
    return pick_and_place(cycle, time);
}

static Point at_end(const double v[]) { return planned(v, (v[NEWEST] + 1.0) * v[TICK]); }

void part_initialize(double v[]) {
    const Point now = planned(v, 0.0);
    v[NEWEST] = v[INTEGRAL] = v[RESTING] = 0.0;
    v[COMMAND] = command(v, (Point){v[INITIAL_THETA], v[INITIAL_OMEGA]}, now, at_end(v));
    v[REFERENCE] = now.angle;
}

const char *part_step(double v[], double time, double step) {
    if (step > 1.001 * v[TICK]) return TOO_LONG;
    Sample sample;
    if (tick_is_due(&v[NEWEST], v[TICK], time, step, &sample)) {
        const Point now = planned(v, sample.time), then = at_end(v);
        const Point joint = carried_on((Point){v[THETA], v[OMEGA]}, sample.lead, now, then, v[TICK]);
        v[COMMAND] = command(v, joint, now, then);
    }
    v[REFERENCE] = planned(v, time + step).angle;
    return NULL;
}
