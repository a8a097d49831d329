/* A geared brushless motor under a PI current loop, and the sum of the motor's torque and the load's.
 *
 * The loop is that of CurrentLoop in dualcam/systems/blocks/current_loop.py, where its design is derived. Between two of its
 * samples the voltage is constant and the current an exponential in time, so the integrals of i, i^2 and v i are
 * closed forms. A step of any length has a whole number of samples, at least one.
 */
#include <math.h>
#include <stddef.h>

#include "part.h"
#include "part_variables.h"

static double clamp(double value, double limit) { return fmin(fmax(value, -limit), limit); }

void part_initialize(double v[]) { v[TAU] = v[INITIAL_LOAD] / v[RATIO]; }

const char *part_step(double v[], double time, double step) {
    (void)time;
    const double samples = fmax(1.0, round(step * v[CURRENT_RATE]));
    const double period = step / samples;
    const double resistance = v[RESISTANCE], constant = v[TORQUE_CONSTANT] * v[GEAR];
    const double pole = exp(-period * resistance / v[INDUCTANCE]); /* of the sampled winding */
    const double gain = (1.0 - exp(-2.0 * PI * v[CURRENT_BANDWIDTH] * period)) * resistance / (1.0 - pole);
    const double decay = v[INDUCTANCE] / resistance * (1.0 - pole); /* integral of its response from 1 to 0 */
    const double reference = clamp(v[COMMAND], v[PEAK_TORQUE]) / constant;
    const double back_emf = constant * v[OMEGA] / v[RATIO];
    double charge = 0.0; /* integral of i */
    for (double k = 0.0; k < samples; k += 1.0) {
        const double error = reference - v[CURRENT];
        const double wanted = gain * error + v[CURRENT_INTEGRAL] + back_emf;
        const double voltage = clamp(wanted, v[VOLTAGE]);
        if (voltage == wanted) v[CURRENT_INTEGRAL] += gain * (1.0 - pole) * error; /* else it would wind up */
        const double final = (voltage - back_emf) / resistance, start = v[CURRENT] - final;
        const double area = final * period + start * decay;
        charge += area;
        v[HEAT] += resistance * (final * (area + start * decay) + 0.5 * start * start * decay * (1.0 + pole));
        v[ENERGY] += voltage * area;
        v[CURRENT] = final + start * pole;
    }
    v[TORQUE] = constant * charge / step;
    v[TAU] = (v[TORQUE] + v[LOAD]) / v[RATIO];
    return NULL;
}
