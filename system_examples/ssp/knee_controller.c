/* The knee's controller: a spring and a damper between the joint and the measured motion.
 *
 * The law is that of ImpedanceController in dualcam/systems/blocks/impedance.py.
 */
#include <math.h>
#include <stddef.h>

#include "part.h"
#include "part_variables.h"
#include "reference.h"

static Point measured(const double v[], double time) {
    const double since = v[TOE_OFF] + time; /* heel strike */
    return (Point){fourier(&v[KNEE_MEAN], v[STRIDE], since, 0) - v[EXTENSION],
                   fourier(&v[KNEE_MEAN], v[STRIDE], since, 1)};
}

static double command(const double v[], Point knee, Point now) {
    const double wanted = -v[STIFFNESS] * (knee.angle - now.angle) - v[DAMPING] * (knee.speed - now.speed);
    return knee.angle <= 0.0 ? fmax(wanted, 0.0) : wanted; /* to push into the stop only costs current */
}

void part_initialize(double v[]) {
    const Point now = measured(v, 0.0);
    v[NEWEST] = 0.0;
    v[COMMAND] = command(v, (Point){v[INITIAL_THETA], v[INITIAL_OMEGA]}, now);
    v[REFERENCE] = now.angle;
}

const char *part_step(double v[], double time, double step) {
    if (step > 1.001 * v[TICK]) return TOO_LONG;
    Sample sample;
    if (tick_is_due(&v[NEWEST], v[TICK], time, step, &sample)) {
        const Point now = measured(v, sample.time), then = measured(v, sample.time + v[TICK]);
        v[COMMAND] = command(v, carried_on((Point){v[THETA], v[OMEGA]}, sample.lead, now, then, v[TICK]), now);
    }
    v[REFERENCE] = measured(v, time + step).angle;
    return NULL;
}
