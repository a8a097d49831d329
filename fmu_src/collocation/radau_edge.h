/* The rate-independent regime: theta at the nodes of a step on the edge of the stick band.
 *
 * Without inertia and damping the torque equals the torque of the edge at any time, tau(t) = rho(theta) F_0(theta, t)
 * (docs/mechanism.md, section 6). Each theta_i solves this equation at t_i. */
#ifndef DUALCAM_RADAU_EDGE_H
#define DUALCAM_RADAU_EDGE_H

#include "collocation/radau_system.h"

/* Fills node[] with the balances at the nodes. False if the edge stops rising before the end of the step, or if the
 * motion leaves the transmission's piece. */
bool radau_edge_follow(const RadauSystem *system, Balance node[RADAU_MAX]);

/* How far the rounding of the torques moves theta along an edge that is nearly level, rad. */
double radau_edge_noise(const RadauSystem *system, const Balance node[RADAU_MAX]);

#endif
