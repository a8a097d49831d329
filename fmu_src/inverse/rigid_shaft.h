/* Inverse dynamics with a rigid shaft, at one instant and over a step: cam 2 turns as imposed (docs/mechanism.md,
 * section 7). */
#ifndef DUALCAM_RIGID_SHAFT_H
#define DUALCAM_RIGID_SHAFT_H

#include "inverse/contact_statics.h"
#include "inverse/inverse_state.h"
#include "model/fault.h"

static inline Mode rigid_shaft_mode(double omega) {
    return omega > 0.0 ? MODE_LOADING : omega < 0.0 ? MODE_RELEASING : MODE_STICK;
}

/* Motion and axial force at one instant. */
typedef struct {
    double theta, omega, alpha; /* rad, rad/s, rad/s^2 */
    double F_ext;               /* N */
    int direction;              /* sigma, in which friction acts against motion; it counts also where omega = 0 */
} OperatingPoint;

/* As the inputs have it now; at rest in the direction of the last motion. */
OperatingPoint rigid_shaft_operating_point(const Inverse *m);

/* The torque that brings the motion about, and what it balances. */
typedef struct {
    ContactStatics statics;
    Load load;
    ContactForces forces;
    double tau;    /* N.m */
    double damper; /* N, D(v) */
} RequiredTorque;

/* False if no torque brings this motion about: the contacts wedge. The statics are filled in any case. */
bool rigid_shaft_required_torque(const Params *params, const TransmissionPiece *piece, const OperatingPoint *at,
                                 RequiredTorque *out);

/* 1/2 (J omega^2 + m v^2 + I gamma_dot^2), J */
double rigid_shaft_kinetic_energy(const Params *params, const ContactStatics *statics, double omega);

/* How far beyond a stop an angle may lie by rounding, rad. */
double rigid_shaft_stop_margin(const StopParams *stop);

/* The message for a wedge. */
void rigid_shaft_describe_wedge(Fault *fault, const OperatingPoint *at);

/* Carries `next`, the state at the start, along the motion, which ends at the speed `omega`. Between two angles inside
 * the stops a cubic may overshoot a stop: there cam 2 is held at the stop. False, with the reason, if the contacts
 * wedge during the motion, or if the motion swings too far beyond the stops to be known to the tolerance. */
bool rigid_shaft_advance(const Inverse *m, const ImposedMotion *motion, double omega, InverseState *next, Fault *fault);

#endif
