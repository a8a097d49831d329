/* The balance of forces at one instant, in grooves of any shape: acceleration, contact loads and their rates.
 *
 * slip_mode.h gives the equation of motion. The contact loads x_i = R_i/hypot(r_i, a_i) follow from its solution
 * (contact_factors.h):
 *     A = F_s + F_ext + D + m (z' alpha + z'' omega^2)    W = I (gamma' alpha + gamma'' omega^2)
 *     x_1 = (r_2 n_2 A - d_2 W)/Delta    x_2 = (r_1 n_1 A + d_1 W)/Delta
 * Without inertia the balance gives omega: Delta tau - P F_0 = Delta b omega + P D(z' omega). Without damping either,
 * theta stays on the edge of the stick band: Delta tau = P F_0. */
#ifndef DUALCAM_BALANCE_H
#define DUALCAM_BALANCE_H

#include "contact/contact.h"
#include "contact/slip_mode.h"
#include "model/elements.h"
#include "model/known.h"
#include "model/ledger.h"
#include "numerics/tolerances.h"

/* The right-hand side: alpha, or without inertia omega, as a function of theta, omega and time. */
typedef struct {
    double value;              /* rad/s^2: alpha if inertial; else rad/s: omega */
    double size;               /* sum of the magnitudes of its terms: its rounding is some eps of that */
    double by_theta, by_omega; /* its partial derivatives; by_omega only if inertial */
    double by_time;
    double net;    /* N.m, rate-independent only: tau - rho F_0, torque beyond the edge */
    bool possible; /* D/Delta > 0 (docs/mechanism.md, section 3); rate-independent: Delta > 0 */
} RightHandSide;

/* The balance and all that enters it. */
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
    double friction[2];    /* f_i = sigma e_i mu_i */
    double axial[2];       /* 1/m, dx_i/dA */
    double x[2];           /* N/m */
} Balance;

/* The balance at time t after `inputs`. Without inertia `omega` is not used: the balance finds the speed. */
void balance_at(const SlipMode *slip, double theta, double omega, double t, Balance *out);

/* Where friction varies: the share, above 0 and at most 1, of the way between two balances at which a step is
 * to end. */
double balance_friction_share(const SlipMode *slip, const Balance *from, const Balance *to);

/* The right-hand side alone, as a Newton iteration needs it. */
RightHandSide balance_rhs(const SlipMode *slip, double theta, double omega, double t);

/* N/m: the sums of the magnitudes of the terms of x_i, which rounds by a few eps of them. */
void balance_contact_sizes(const SlipMode *slip, const Balance *balance, double size[2]);

/* Partial derivatives, N.m m^3 per unit, of the residual of the equation of motion times Delta,
 *     Delta (tau - b omega) - P (F_0 + D) - [P m z'' + Q I gamma''] omega^2 - [J Delta + P m z' + Q I gamma'] alpha,
 * which is zero at `balance`: alpha changes with a known k by -by[k]/by[KNOWN_ALPHA], tau by -by[k]/by[KNOWN_TAU]. */
void balance_partials(const SlipMode *slip, const Balance *balance, Partials *out);

/* The partial derivatives of alpha, or without inertia of omega, by the other knowns. */
void balance_response(const SlipMode *slip, const Balance *balance, Partials *out);

/* N per unit of the known, times `factor`: how F_0 + D grows with the known, at the height z, m, and the axial speed v,
 * m/s. */
double balance_force_by(const SlipMode *slip, Known known, double factor, double z, double v);

/* A change of the state and, besides, of the axial force and of f_i. */
typedef struct {
    double theta, omega, alpha; /* rad, rad/s, rad/s^2 */
    double axial;               /* N */
    double friction[2];
} BalanceChange;

/* The change of axial force and f_i at constant state, if an input or a tunable parameter grows by 1 of its unit. */
BalanceChange balance_change_by(const SlipMode *slip, const Balance *balance, Known known);

/* N/m: the first-order changes of x_i. */
void balance_contact_changes(const SlipMode *slip, const Balance *balance, const BalanceChange *by, double change[2]);

/* One-sided time derivatives of alpha (or omega) and of the contact loads along the motion. */
typedef struct {
    double rhs;        /* 1/s times the unit of RightHandSide.value */
    double contact[2]; /* N/(m.s), d x_i/dt */
} BalanceRates;

/* `balance` is that at time t. */
void balance_rates(const SlipMode *slip, const Balance *balance, double t, BalanceRates *out);

/* The rates of the accounts, watt. */
Booking balance_power(const SlipMode *slip, const Balance *balance);

/* N: the sum of the magnitudes of the terms of the axial load A; `follower_acceleration` z' alpha, m/s^2. */
static inline double balance_load_size(const Params *p, double force, double damper, double follower_acceleration) {
    return fabs(force) + fabs(damper) + p->inertia.follower_mass * fabs(follower_acceleration);
}

/* Is contact i on its flank by more than rounding? `axial`: x_i per A; `load`: balance_load_size(). */
static inline bool balance_is_firm(const SlipMode *slip, int i, double x, double axial, double load) {
    return slip->flank[i] * x > FLANK_CLEARANCE * fabs(axial) * load;
}

/* Are both contacts on their flanks by more than rounding? */
static inline bool balance_are_firm(const SlipMode *slip, const Balance *b) {
    const double load = balance_load_size(slip->params, b->force, b->damper, b->dz_dtheta * b->alpha);
    return balance_is_firm(slip, 0, b->x[0], b->axial[0], load) && balance_is_firm(slip, 1, b->x[1], b->axial[1], load);
}

#endif
