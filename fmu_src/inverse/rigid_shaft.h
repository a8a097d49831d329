/* Inverse dynamics where the shaft of cam 2 is rigid: cam 2 turns as imposed. */
#ifndef DUALCAM_RIGID_SHAFT_H
#define DUALCAM_RIGID_SHAFT_H

#include "contact/contact_statics.h"
#include "inverse/inverse.h"

/* The motion of one instant. `direction` counts where omega = 0. */
typedef struct {
    double theta, omega, alpha; /* rad, rad/s, rad/s^2 */
    double F_ext;               /* N */
    int direction;
} Instant;

/* As the inputs have it now; at rest in the direction of the last motion. */
Instant rigid_shaft_present(const Inverse *m);

/* What it takes. */
typedef struct {
    ContactStatics statics;
    Load load;
    ContactForces forces;
    double tau;    /* N.m */
    double damper; /* N */
} Effort;

/* False if no torque brings this motion about: the contacts wedge. The station is filled in any case. */
bool rigid_shaft_effort(const Params *params, const TransmissionPiece *piece, const Instant *now, Effort *out);

/* 1/2 (J omega^2 + m v^2 + I gamma_dot^2), J */
double rigid_shaft_kinetic(const Params *params, const ContactStatics *statics, double omega);

/* How far beyond a stop an angle may be by rounding, rad. */
double rigid_shaft_slack(const StopParams *stop);

/* Carries `next`, the state at the start, along the motion, which ends at `omega`. Between two angles inside the stops the
 * cubic may overshoot: it is held there. False if the contacts wedge on the way. */
bool rigid_shaft_advance(const Inverse *m, const Imposed *motion, double omega, InverseState *next, Fault *fault);

/* The message for a wedge. */
void rigid_shaft_describe_wedge(Fault *fault, const Instant *now);

#endif
