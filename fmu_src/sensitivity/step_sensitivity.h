/* How the latest step depends on the torque: d theta(tc + h)/d tau and d omega(tc + h)/d tau, where the torque of the
 * whole step is shifted by a constant, tau(t) + d. A master that solves for the torque at a port needs it.
 *
 * The step is gone through again, leg by leg, and the variations d theta, d omega are carried along: inside a leg by
 * the linearised equation of motion, in closed form where the motion is (with s and p1 of oscillator.h),
 *     d theta = (1 - w2 p1) d theta_0 + s d omega_0 + p1/M      d omega = -w2 s d theta_0 + s' d omega_0 + s/M
 * else by the derivative of the leap. At an event g(theta, omega, t) = 0, which comes later by
 *     dt = -(grad g . d x + dg/d tau)/(dg/dt)
 * it is d x_after = R (d x_before + f_before dt) - f_after dt, R being what the event does to the state (the saltation
 * matrix: M. di Bernardo et al., Piecewise-smooth Dynamical Systems, Springer 2008, section 2.5).
 *
 * One-sided where the step itself has a kink: an event exactly at its end counts as past, a torque exactly on the edge
 * of the stick band as inside. Where contacts jam that had moved for a while it is 0, unless a change of flank made them. */
#ifndef DUALCAM_STEP_SENSITIVITY_H
#define DUALCAM_STEP_SENSITIVITY_H

#include "forward/state.h"

/* Of the latest step as it was made, also if parameters were tuned or inputs set since. 0 before the first step. */
void step_sensitivity(const Mechanism *m, StepSensitivity *out);

#endif
