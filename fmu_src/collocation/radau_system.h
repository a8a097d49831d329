/* The collocation equations of a Radau IIA step in one slip mode, and their solution by Newton's method.
 *
 * Inertial: the unknowns y_j are the accelerations at the nodes,
 *     alpha_i = alpha(theta_i, omega_i, t_i)    omega_i = omega_0 + h sum once_ij alpha_j
 *     theta_i = theta_0 + c_i h omega_0 + h^2 sum twice_ij alpha_j
 * Viscous: the unknowns y_j are the speeds,
 *     omega_i = omega(theta_i, t_i)             theta_i = theta_0 + h sum once_ij omega_j
 * The right-hand side alpha(theta, omega, t) or omega(theta, t) and its exact partial derivatives are those of
 * balance.h. So a stiff mode does not shorten the step. The equations are those of docs/mechanism.md, section 6. */
#ifndef DUALCAM_RADAU_SYSTEM_H
#define DUALCAM_RADAU_SYSTEM_H

#include "contact/balance.h"
#include "numerics/radau.h"

typedef struct {
    const SlipMode *slip;
    const Balance *start;
    const Radau *method;
    double h;                                   /* s */
    double lowest, highest;                     /* rad, where the polynomials of the transmission's piece may be used */
    double y[RADAU_MAX];                        /* alpha_j in rad/s^2, or without inertia omega_j in rad/s */
    double dtheta[RADAU_MAX], omega[RADAU_MAX]; /* rad, rad/s: theta_j - theta_0 and omega_j, which follow from y */
} RadauSystem;

RadauSystem radau_system_of(const SlipMode *slip, const Balance *start, double h, int stages);

/* Solves for y. Fills node[] with the balances at the nodes of the last iterate. False if Newton's method does not
 * converge, or if a node leaves the range in which the slip mode is possible. Not for the rate-independent regime. */
bool radau_system_solve(RadauSystem *system, Balance node[RADAU_MAX]);

/* The rate-independent regime: fills node[] with balances on the edge of the stick band, tau(t) = rho(theta) F_0(theta,
 * t), each theta_i solving this equation at t_i. False if the edge stops rising before the end of the step, or if the
 * motion leaves the transmission's piece. *noise: rad, how far the rounding of the torques moves theta where the edge
 * is nearly level. */
bool radau_system_follow_edge(const RadauSystem *system, Balance node[RADAU_MAX], double *noise);

/* dtheta and omega at the nodes from y. */
void radau_system_place_nodes(RadauSystem *system);

/* Row i of the Newton matrix: 1 less the derivative of the right-hand side at node i by each y_j. `rhs` holds the
 * partial derivatives at node i. */
void radau_system_newton_row(const RadauSystem *system, const RightHandSide *rhs, int i, double row[RADAU_MAX]);

/* How stiff the step is by the partial derivatives at one instant: h |by_omega| + h^2 |by_theta|, or without inertia
 * h |by_theta|. */
double radau_system_stiffness(const RadauSystem *system, const RightHandSide *rhs);

static inline bool radau_system_is_inside(const RadauSystem *system, double theta) {
    return theta >= system->lowest && theta <= system->highest;
}

#endif
