/* One step of the integrator: Radau IIA collocation along one way to slip.
 *
 * Inertial: the unknowns are the accelerations at the nodes,
 *     alpha_i = alpha(theta_i, omega_i, t_i)    omega_i = omega_0 + h sum once_ij alpha_j
 *     theta_i = theta_0 + c_i h omega_0 + h^2 sum twice_ij alpha_j
 * Viscous: the speeds, omega_i = omega(theta_i, t_i) and theta_i = theta_0 + h sum once_ij omega_j. Both are solved by
 * Newton's method with the exact partial derivatives at every node, so stiffness costs no step. Quasi-static: theta_i
 * solves the edge of the stick band at t_i. In each case the step is a polynomial in time, which serves to find
 * events, and its nodes are where the ledger's integrals are taken (order 2s - 1 as well).
 *
 * A one-step method: nothing of an earlier step is used. */
#ifndef DUALCAM_RADAU_STEP_H
#define DUALCAM_RADAU_STEP_H

#include "contact/balance.h"
#include "numerics/radau.h"

typedef struct {
    const Radau *method;
    double h; /* s */
    Balance start;
    Balance node[RADAU_MAX];  /* the last one is the end */
    double turned[RADAU_MAX]; /* rad, theta at the node since the start, not rounded to theta's digits */
    double dtheta, domega;    /* rad, rad/s: increments over the step; domega only if inertial */
    Booking booking;          /* J, work and heat over the step */
    double error;             /* estimate over what the tolerance allows: up to 1 is good */
    double energy_error;      /* what the energy balance misses, likewise */
    double stiffness;         /* of the step: large where a fast decay is stepped over */
    double noise;             /* rad, quasi-static only: how far the rounding of the torques moves theta */
} RadauStep;

/* What to try: a length, s, which may be infinite, and the least number of stages. */
typedef struct {
    double h;
    int stages;
} StepProposal;

/* Solves the step of length h from `start`, the balance at the time of the way's inputs. False if Newton's method
 * does not converge or a node leaves where the way is possible: then a shorter step is to be tried. */
bool radau_step_solve(const SlipMode *slip, const Balance *start, double h, int stages, RadauStep *radau);

/* The ends of a step, as far as its energy balance needs them. */
typedef struct {
    double z[2], kinetic[2]; /* m, J: at the start and at the end; without inertia no kinetic energy counts */
    double spring_force;     /* N, at the start */
    double tau;              /* N.m, at the end */
    double angle_noise;      /* rad, how far rounding moves theta */
} EnergyEnds;

/* What the balance of the step misses, over what the tolerance allows of the energies that pass: up to 1 is good. It
 * checks the integrals of the ledger, which the defect of the motion does not see, and the motion once more. */
double radau_step_energy_error(const SlipMode *slip, const Booking *booking, const EnergyEnds *ends);

/* A small change of angle and speed, and what it becomes. Without inertia the angle alone is a state. */
typedef struct {
    double theta, omega; /* rad, rad/s */
} Variation;

/* The derivative of the step, not quasi-static: carries a variation at its start, and a constant shift of the torque
 * by `torque`, N.m, to its end. False if that has no solution. */
bool radau_step_vary(const SlipMode *slip, const RadauStep *radau, double torque, Variation *v);

/* Time scale of the motion, s: h over this is small where few stages do. */
double radau_step_time_scale(const SlipMode *slip, const Balance *start);

#endif
