/* Derivatives of the latest step by the torque: d theta(tc + h)/d tau and d omega(tc + h)/d tau, if the torque of the
 * whole step is shifted by a constant, tau(t) + d. A master that solves for the torque at a port needs them.
 *
 * The step is made once more, segment by segment, and the variations d theta, d omega are carried along. Inside a
 * segment the linearised equation of motion carries them, for motion in closed form (s and p1 of oscillator.h) by
 *     d theta = (1 - w2 p1) d theta_0 + s d omega_0 + p1/M      d omega = -w2 s d theta_0 + s' d omega_0 + s/M
 * else by the derivative of the Radau step. An event g(theta, omega, t) = 0 comes later by
 *     dt = -(grad g . d x + dg/d tau)/(dg/dt)
 * and the variation after the event is d x_after = R (d x_before + f_before dt) - f_after dt. R is the derivative of
 * the event's map of the state (the saltation matrix: M. di Bernardo et al., Piecewise-smooth Dynamical Systems,
 * Springer 2008, section 2.5).
 *
 * The derivatives are one-sided where the step has a kink: an event exactly at the end of the step counts as past, a
 * torque exactly on the edge of the stick band counts as inside. They are 0 where contacts jam after they have moved
 * for a while, unless a change of flank made them jam. */
#ifndef DUALCAM_STEP_SENSITIVITY_H
#define DUALCAM_STEP_SENSITIVITY_H

#include "forward/state.h"

/* The derivatives of the latest step with the inputs and parameters that it was made with, also if these have been set
 * since. 0 before the first step. */
void step_sensitivity(const Mechanism *m, StepSensitivity *out);

#endif
