/* The balance of forces along the motion, as Taylor polynomials in the time since one instant: the time derivatives of
 * torque, speed and position, and their derivatives by one known.
 *
 * With v = z' omega, so that dv/dt = z' alpha + z'' omega^2, and the factors of contact_factors.h, all of them
 * functions of time, the residual of the equation of motion times Delta vanishes at every order:
 *     R = Delta (tau - b omega - J domega/dt) - P A - Q W = 0
 *     A = F_s(z) + F_ext + v (c + q |v|) + m dv/dt      W = I d(gamma' omega)/dt
 * Where the motion is unknown, each coefficient of R is linear in one new coefficient of omega. The coefficients of
 * omega are found one after the other: omega_k from R_{k-1} with inertia, from R_k without inertia (viscous), from
 * R_{k+1} on the band's edge (rate-independent), where no force depends on speed. */
#ifndef DUALCAM_TAYLOR_H
#define DUALCAM_TAYLOR_H

#include "contact/balance.h"
#include "numerics/jet.h"

typedef struct {
    /* Set by the caller: */
    Jet theta, omega; /* rad, rad/s; omega is dtheta/dt */
    Jet tau, F_ext;   /* N.m, N */
    double stiffness; /* N.m/rad, K: if > 0, tau = K (far - theta) */
    Jet far;          /* rad, the port's angle */
    Known known;      /* the duals' slopes are derivatives by this known; KNOWN_COUNT: by nothing */
    /* Set by taylor_expand_grooves(): a_i and z as polynomials in theta - theta(0). */
    double slope[2][JET_TERMS], height[JET_TERMS];
    /* Set by taylor_balance(): */
    Jet z, v;                  /* m, m/s */
    Jet load, moment;          /* N, N.m: A and W */
    JetContactFactors factors; /* n_i, d_i, Delta, P, Q */
    Jet residual;              /* N.m m^3, R */
} Taylor;

/* Expands the grooves around theta(0), in the transmission's segment of the slip mode. */
void taylor_expand_grooves(const SlipMode *slip, Taylor *t);

/* Computes all that theta, omega, tau and F_ext imply. In the regime REGIME_RATE_INDEPENDENT no force depends on speed,
 * whatever the parameters are. R, A and W are one order shorter if there are masses. */
void taylor_balance(const SlipMode *slip, Taylor *t);

/* Finds the coefficients of omega up to `last` <= 2, and those of theta, from theta(0), the inputs and the balance at
 * the present instant; then calls taylor_balance(). Where theta does not follow the edge of the band stably, the motion
 * found is rest. */
void taylor_follow(const SlipMode *slip, const Balance *balance, int last, Taylor *t);

#endif
