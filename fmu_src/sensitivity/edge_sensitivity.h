/* The edge E of the stick band, E = rho F_0, and how inputs and parameters shift it. */
#ifndef DUALCAM_EDGE_SENSITIVITY_H
#define DUALCAM_EDGE_SENSITIVITY_H

#include <math.h>

#include "collocation/radau_variation.h"
#include "forward/state.h"

/* A derivative that does not exist counts as 0. */
static inline double finite_or_zero(double x) {
    return isfinite(x) ? x : 0.0;
}

/* The torque beyond the edge, tau - E, at one angle, with derivatives. */
typedef struct {
    RightHandSide rhs; /* rate-independent: by_theta is dE/dtheta, `value` the speed along the edge */
    Partials by;       /* of tau - E by inputs and parameters, N.m per unit; 0 by the state */
} Excess;

Excess edge_excess(const SlipMode *slip, double theta);

/* Is there a torque that moves cam 2 in `direction`? Then *slip is the slip mode along the edge. */
bool edge_slip(const Mechanism *m, int direction, SlipMode *slip);

/* The changes of theta on the edge, at constant time, from `first` to `end` - 1. 0 where cam 2 rests inside
 * the band. */
void edge_give(const Mechanism *m, const Excess *excess, Variation *x);

/* The times, s per unit, by which the torque passes the edge later, if theta varies as in x. `omega`: rad/s, of
 * cam 2. */
void edge_delays(const Mechanism *m, int direction, double omega, const Variation *x, double delay[KNOWN_COUNT]);

/* While theta follows the edge: the changes of the speed. */
void edge_speed_give(const SlipMode *slip, double theta, double omega, Variation *x);

#endif
