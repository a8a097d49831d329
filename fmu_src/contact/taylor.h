/* The balance of forces along the motion, as Taylor polynomials in the time since one instant: how torque, speed and
 * position go on (derivatives of outputs), and how that depends on a knob.
 *
 * With v = z' omega, so that dv/dt = z' alpha + z'' omega^2, and balance.h's names, all of them functions of time,
 *     R = Delta (tau - b omega - J domega/dt) - P A - Q W = 0
 *     A = F_s(z) + F_ext + v (c + q |v|) + m dv/dt      W = I d(gamma' omega)/dt
 * at every order. Where the motion is unknown, each coefficient of R is linear in one new coefficient of omega: one
 * is found after the other, from R_{k-1} with inertia, from R_k without (viscous), from R_{k+1} where no force
 * depends on speed either and the band's edge is followed. */
#ifndef DUALCAM_TAYLOR_H
#define DUALCAM_TAYLOR_H

#include "contact/balance.h"
#include "numerics/jet.h"

typedef struct {
    /* To be set: */
    Jet theta, omega; /* rad, rad/s; omega is dtheta/dt */
    Jet tau, F_ext;   /* N.m, N */
    double stiffness; /* N.m/rad, K: if > 0, tau = K (far - theta) */
    Jet far;          /* rad */
    Known known;      /* what the duals' slopes are derivatives by, or KNOWN_COUNT: nothing */
    /* By taylor_place(): polynomials in theta - theta(0), as far as they matter. */
    double slope[2][JET_TERMS], height[JET_TERMS];
    /* By taylor_balance(): */
    Jet z, v;         /* m, m/s */
    Jet load, moment; /* N, N.m: A and W of balance.h */
    Jet rn[2], d[2], delta;
    Jet residual; /* N.m m^2, R */
} Taylor;

/* The grooves around theta.c[0], in the way's piece. */
void taylor_place(const SlipMode *slip, Taylor *t);

/* All that theta, omega, tau and F_ext imply. A way of kind REGIME_RATE_INDEPENDENT has no forces that depend on speed,
 * whatever its parameters say. R, A and W are one order short if there are masses. */
void taylor_balance(const SlipMode *slip, Taylor *t);

/* Finds omega's coefficients up to `last` <= 2, with theta's, from theta(0), the inputs and `now`; then balances.
 * Where following the edge of the band is not stable, it finds rest. */
void taylor_follow(const SlipMode *slip, const Balance *now, int last, Taylor *t);

#endif
