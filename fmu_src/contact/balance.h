/* The balance of forces at one instant, in grooves of any shape: acceleration, contact loads and how they change.
 *
 * On one way to slip (direction sigma, flanks e_i), with mu_i meaning sigma e_i mu_i,
 *     n_i = a_i + mu_i r_i   d_i = r_i - mu_i a_i   rn_i = r_i n_i
 *     Delta = rn2 d1 + rn1 d2   P = rn1 rn2   Q = d1 rn2
 * the equation of motion of the mechanism page, section 6, times Delta, reads
 *     [J Delta + P m z' + Q I gamma'] alpha = Delta (tau - b omega) - P (F_s + F_ext + D) - [P m z'' + Q I gamma''] omega^2
 * so that no division but the last is needed, and only then the contacts x_i = R_i/hypot(r_i, a_i):
 *     A = F_s + F_ext + D + m (z' alpha + z'' omega^2)    W = I (gamma' alpha + gamma'' omega^2)
 *     x_1 = (rn2 A - d2 W)/Delta    x_2 = (rn1 A + d1 W)/Delta
 * Without inertia the same balance gives omega: Delta tau - P F_0 = Delta b omega + P D(z' omega); and without
 * damping either, theta stays on the band's edge: Delta tau = P F_0. */
#ifndef DUALCAM_BALANCE_H
#define DUALCAM_BALANCE_H

#include "geometry/transmission.h"
#include "model/elements.h"
#include "model/known.h"
#include "model/ledger.h"
#include "model/params.h"
#include "model/regime.h"
#include "numerics/dual.h"

/* Grooves and friction at one theta, with derivatives by theta. */
typedef struct {
    Dual dz_dtheta;                    /* z' */
    Dual slope[2], dpsi_dtheta[2];     /* a_i; gamma', phi' */
    Dual d2z_dtheta2, d2gamma_dtheta2; /* z'', gamma''; their slopes only where the follower has mass or inertia */
    Dual rn[2], d[2], delta, p, q;     /* see above; p, q: P, Q */
} ContactFactors;

/* One way to slip through one piece of the course, under inputs that are polynomials of the time since `inputs`
 * were written. */
typedef struct {
    const Params *params;
    const Transmission *transmission;
    const TransmissionPiece *piece;
    const Inputs *inputs;
    Regime regime;
    int direction;          /* sigma */
    int flank[2];           /* e_i */
    double mu[2];           /* sigma e_i mu_i */
    double c, q;            /* N.s/m, N.s^2/m^2: of the damper in this direction */
    bool heavy;             /* the follower has mass or inertia */
    bool steady;            /* the inputs are constant */
    ContactFactors factors; /* in straight grooves, where it is the same at every theta */
    bool
        to_rounding; /* its leaps are solved to rounding, not to a share of the tolerance: where one ends on an event */
} SlipMode;

SlipMode slip_mode_of(const Params *params, const Transmission *transmission, const Inputs *inputs, double theta,
                      int direction, const int flank[2]);

typedef struct {
    double value;              /* rad/s^2: alpha if inertial; else rad/s: omega */
    double size;               /* of the terms that add up to it: its rounding is some eps of that */
    double by_theta, by_omega; /* its partial derivatives; by_omega only if inertial */
    double by_time;
    double net;        /* N.m, quasi-static only: tau - rho F_0, torque beyond the edge */
    double resistance; /* inertial: |Delta| times the inertia felt; quasi-static: dE/dtheta, N.m/rad */
    bool possible;     /* Delta != 0 and, if inertial, a positive inertia felt: else friction jams it */
    bool stable;       /* what resists the motion is positive */
} RightHandSide;

/* All that is known at one instant. */
typedef struct {
    double theta, omega, alpha; /* rad, rad/s, rad/s^2; alpha is 0 without inertia */
    RightHandSide rhs;
    double tau, F_ext;     /* N.m, N */
    double force;          /* N, F_0 = F_s + F_ext */
    double damper;         /* N, D */
    double z;              /* m */
    double dz_dtheta;      /* m/rad, z' */
    double dpsi_dtheta[2]; /* gamma', phi' */
    double length2[2];     /* m^2, r_i^2 + a_i^2 */
    double axial[2];       /* 1/m, x_i per A */
    double x[2];           /* contacts: see above */
} Balance;

/* The instant t after `inputs`. omega is used if the way is inertial; else the balance finds it. */
void balance_at(const SlipMode *slip, double theta, double omega, double t, Balance *out);

/* The same, without contact loads: what a Newton iteration needs. */
RightHandSide balance_rhs(const SlipMode *slip, double theta, double omega, double t);

/* How alpha (or omega) and the contacts change along the motion, one-sided, and the sizes of the terms that
 * add up to each: a sum of less than a few eps of its size is zero. */
typedef struct {
    double rhs;                   /* 1/s times the unit of RightHandSide.value */
    double rhs_size;              /* size of the terms of RightHandSide.value itself */
    double net, net_size;         /* N.m: torque beyond what holds the loads, tau - b omega - rho F; its terms */
    double contact[2];            /* d x_i/dt */
    double size[2], rate_size[2]; /* sizes of x_i and of d x_i/dt */
} BalanceRates;

void balance_rates(const SlipMode *slip, const Balance *now, double t, BalanceRates *out);

/* The equation of motion times Delta, with all terms on one side: zero at `now`, whatever brings that about. Its partial
 * derivatives, N.m m^2 per unit: alpha changes with a knob k by -by[k]/by[KNOWN_ALPHA], tau by -by[k]/by[KNOWN_TAU]. */
void balance_partials(const SlipMode *slip, const Balance *now, Partials *out);

/* How alpha, or without inertia omega, grows with the torque, per N.m. */
double balance_mobility(const SlipMode *slip, const Balance *now);

/* How x_i changes with theta, omega and alpha, if these change by so much. */
double balance_contact_change(const SlipMode *slip, const Balance *now, int i, double dtheta, double domega,
                              double dalpha);

/* Rates of the accounts at this instant, W. */
Booking balance_power(const SlipMode *slip, const Balance *now);

/* The size of what adds up to the axial load A, N; `swing`: z' alpha, m/s^2. */
static inline double balance_load_size(const Params *p, double force, double damper, double swing) {
    return fabs(force) + fabs(damper) + p->inertia.follower_mass * fabs(swing);
}

/* Is contact i on its flank by more than rounding? `axial`: x_i per A; `load`: the size of what adds up to A. */
static inline bool balance_is_firm(const SlipMode *slip, int i, double x, double axial, double load) {
    const double CLEAR = 1e-9;
    return slip->flank[i] * x > CLEAR * fabs(axial) * load;
}

/* Polynomial input and its rate at time t. */
double input_value(const double u[INPUT_ORDER + 1], double t);
double input_rate(const double u[INPUT_ORDER + 1], double t);

/* The same polynomials, written for an origin t later. */
void inputs_advance(Inputs *inputs, double t);

#endif
