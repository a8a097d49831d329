/* The Jacobian of the latest step: derivatives of theta and omega at its end by theta and omega at its start, by tau
 * and F_ext, which shift by a constant over the whole step, and by the tunable parameters. The chain rule makes of the
 * Jacobians the gradient of a whole run. A master that solves for the torque at a port needs the derivatives by tau.
 *
 * The step is made once more, segment by segment, and the variations d theta, d omega are carried along. Inside a
 * segment the linearised equation of motion carries them, for motion in closed form (s and p1 of oscillator.h) by
 *     d theta = (1 - w2 p1) d theta_0 + s d omega_0 + p1/M      d omega = -w2 s d theta_0 + s' d omega_0 + s/M
 * (the last terms: by tau; by F_ext times -rho; by the state they are absent), else by the derivative of the Radau
 * step. An event g(theta, omega, k, t) = 0, k the known, comes later by
 *     dt = -(grad g . d x + dg/dk)/(dg/dt)
 * and the variation after the event is d x_after = R (d x_before + f_before dt) - f_after dt. R is the derivative of
 * the event's map of the state (the saltation matrix: M. di Bernardo et al., Piecewise-smooth Dynamical Systems,
 * Springer 2008, section 2.5).
 *
 * The derivatives are one-sided where the step has a kink: an event exactly at the end of the step counts as past, a
 * torque exactly on the edge of the stick band counts as inside. By the state they are 0 at a stop, and by omega at
 * rest. They are 0 where contacts jam after they have moved for a while, unless a change of flank made them jam.
 * Without inertia omega is no state: the derivatives by omega are 0. Without inertia and damping they are 0 also by
 * parameters of damping, which would begin to act. */
#ifndef DUALCAM_STEP_SENSITIVITY_H
#define DUALCAM_STEP_SENSITIVITY_H

#include "outputs/outputs.h"

/* The derivatives of the latest step with the inputs and parameters that it was made with, also if these have been set
 * since. 0 before the first step. Sets the members by state and inputs, or those `by_parameters`, which take longer. */
void step_sensitivity(const Mechanism *m, bool by_parameters, StepSensitivity *out);

#endif
