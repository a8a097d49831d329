/* The collocation equations of a Lobatto IIIA step in one slip mode, and their solution by functional iteration.
 *
 * With alpha_i = alpha(theta_i, omega_i, t_i) at the four nodes, of which the first is the start:
 *     omega_i = omega_0 + h sum once_ij alpha_j    theta_i = theta_0 + c_i h omega_0 + h^2 sum twice_ij alpha_j
 * or, without inertia, with omega_i = omega(theta_i, t_i):
 *     theta_i = theta_0 + h sum once_ij omega_j
 * The right-hand sides are those of balance.h. A sweep evaluates them at all nodes, two nodes per vector register, and
 * needs values only, no derivatives. */
#ifndef DUALCAM_LOBATTO_SYSTEM_H
#define DUALCAM_LOBATTO_SYSTEM_H

#include "collocation/lobatto_nodes.h"

/* An angle at which the step must end, likewise. */
typedef struct {
    bool given;
    double distance, slack; /* rad, from the start on; the step may miss the distance by the slack */
} EndAngle;

static inline bool lobatto_system_is_inertial(const LobattoSystem *system) {
    return system->slip->regime == REGIME_INERTIAL;
}

/* Sets what all sweeps have in common: slip mode, forces that are there, friction law. */
void lobatto_system_begin(LobattoSystem *system, const SlipMode *slip);

/* A first iterate under constant acceleration. `rhs`: alpha, or without inertia omega, at the start. */
void lobatto_system_guess(LobattoSystem *system, double rhs);

/* Sweeps from the first iterate until the equations hold to a share of the tolerance. False if the iteration converges
 * too slowly, or if the slip mode is not possible at a node. */
bool lobatto_system_solve(LobattoSystem *system, const EndAngle *end);

/* The same where friction varies. */
bool lobatto_system_solve_varying(LobattoSystem *system, const EndAngle *end);

/* Without inertia: omega by the balance at the end of the step, rad/s. */
double lobatto_system_speed_at_end(LobattoSystem *system);

#endif
