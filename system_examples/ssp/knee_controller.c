/* The knee's controller of prosthetic_knee.py: a spring and a damper between the joint and the measured motion. */
#include <math.h>
#include <stddef.h>

#include "part.h"
#include "part_variables.h"
#include "reference.h"

static Point measured(const double v[], double samples) {
    const double time = v[TOE_OFF] + samples * v[TICK]; /* from heel strike */
    return (Point){fourier(&v[KNEE_MEAN], v[STRIDE], time, 0) - v[EXTENSION],
                   fourier(&v[KNEE_MEAN], v[STRIDE], time, 1)};
}

void part_initialize(double v[]) { v[REFERENCE] = measured(v, 0.0).angle; }

const char *part_step(double v[], double time, double step) {
    if (step > 1.001 * v[TICK]) return TOO_LONG;
    if (sample_is_due(&v[SAMPLES], v[TICK], time, step)) {
        const Point now = measured(v, v[SAMPLES] - 1.0);
        const double wanted = -v[STIFFNESS] * (v[THETA] - now.angle) - v[DAMPING] * (v[OMEGA] - now.speed);
        v[COMMAND] = v[THETA] <= 0.0 ? fmax(wanted, 0.0) : wanted; /* pushing into the stop only costs current */
        v[REFERENCE] = measured(v, v[SAMPLES]).angle;
    }
    return NULL;
}
