/* Inverse dynamics where the shaft of cam 2 is rigid: cam 2 turns as imposed. */
#ifndef DUALCAM_RIGID_H
#define DUALCAM_RIGID_H

#include "inverse.h"
#include "station.h"

/* The motion of one instant. `direction` counts where omega = 0. */
typedef struct {
    double theta, omega, alpha; /* rad, rad/s, rad/s^2 */
    double F_ext;               /* N */
    int direction;
} Moment;

/* As the inputs have it now; at rest in the direction of the last motion. */
Moment rigid_present(const Inverse *m);

/* What it takes. */
typedef struct {
    Station station;
    Burden burden;
    Bearing bearing;
    double tau;    /* N.m */
    double damper; /* N */
} Effort;

/* False if no torque brings this motion about: the contacts wedge. The station is filled in any case. */
bool rigid_effort(const Params *params, const Piece *piece, const Moment *now, Effort *out);

/* 1/2 (J omega^2 + m v^2 + I gamma_dot^2), J */
double rigid_kinetic(const Params *params, const Station *station, double omega);

/* How far beyond a stop an angle may be by rounding, rad. */
double rigid_slack(const StopParams *stop);

/* Carries `next`, the state at the start, along the motion, which ends at `omega`. Between two angles inside the stops the
 * cubic may overshoot: it is held there. False if the contacts wedge on the way. */
bool rigid_advance(const Inverse *m, const Imposed *motion, double omega, InverseState *next, Fault *fault);

/* The message for a wedge. */
void rigid_describe_wedge(Fault *fault, const Moment *now);

#endif
