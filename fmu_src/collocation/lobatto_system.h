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

#include <float.h>
#include <math.h>

#include "contact/balance.h"
#include "contact/contact_factors.h"
#include "elementary/elementary.h"
#include "numerics/lobatto.h"
#include "numerics/tolerances.h"

/* The balance of forces at two nodes, see balance.h. */
typedef struct {
    Vector2 slope[2], dpsi_dtheta[2], dz_dtheta;
    Vector2 d2z_dtheta2, d2gamma_dtheta2; /* only if the follower has mass or inertia */
    VectorContactFactors factors;         /* r_i n_i, d_i, Delta, P, Q */
    Vector2 z, force, damper;             /* m, N, N: z, F_0, D */
    Vector2 mass;                         /* J Delta + P m z' + Q I gamma', or without inertia Delta b + P c z' */
    Vector2 damping_rate;                 /* 1/s, -d alpha/d omega; only if a force depends on the speed */
    /* Only where friction varies: */
    Vector2 omega, sliding[2];                /* rad/s, m: at which the balance was taken last; v_i per omega */
    Vector2 friction[2], dfriction_domega[2]; /* f_i, s/rad */
    Vector2 friction_damping;                 /* 1/s, its part of the damping rate, as the first sweep found it */
} NodePair;

/* z'' and gamma''; 0 where the follower has neither mass nor inertia. */
typedef struct {
    double d2z_dtheta2, d2gamma_dtheta2;
} GrooveBend;

/* A sliding speed at which the step is to end, a sample of a friction table. Its length is then an unknown too. */
typedef struct {
    bool given;
    int contact;
    double start, speed, slack; /* m/s: at the start; the aim, and by how much the step may miss it */
    double longest;             /* s, the length that the step may have */
} EndSpeed;

typedef struct {
    const SlipMode *slip;
    bool has_damper, is_resisted; /* is_resisted: alpha depends on the speed */
    double theta, omega, h;       /* rad, rad/s at the start; s */
    /* Only where friction varies: */
    const FrictionNearby *law[2]; /* times sigma e_i */
    FrictionLoadStart load[2];    /* only where friction depends on the load */
    bool by_speed, has_loads;     /* friction depends on the speed; on the load */
    bool has_tables;              /* at a contact */
    /* Only where there is such a table; of a contact without one, the same as of the other contact: */
    const FrictionPiece *piece[2];
    const FrictionPatch *patch[2]; /* of a contact whose table has loads, else NULL */
    Vector2 lowest, highest;       /* m/s, the sliding speeds up to which the step may use the pieces */
    EndSpeed end_speed;
    LobattoValues tau, F_ext;
    LobattoValues dtheta, speed; /* rad, rad/s: theta_i - theta_0, omega_i */
    LobattoValues y;             /* alpha_i in rad/s^2, or without inertia omega_i in rad/s */
    double end_shift;            /* rad, dtheta at the end less the dtheta at which the balance was taken last */
    NodePair pair[LOBATTO_HALVES];
} LobattoSystem;

/* N, N.m; 1/m^3: A and W at two nodes of a solution; 1/Delta. */
typedef struct {
    Vector2 axial, moment, inverse;
} NodeForces;

static inline NodeForces lobatto_node_forces(const LobattoSystem *system, int k) {
    const SlipMode *slip = system->slip;
    const InertiaParams *in = &slip->params->inertia;
    const NodePair *n = &system->pair[k];
    NodeForces out = {n->force + n->damper, {0.0, 0.0}, 1.0 / n->factors.delta};
    if (slip->follower_has_inertia) {
        const Vector2 omega = system->speed.half[k], alpha = system->y.half[k], omega2 = omega * omega;
        out.axial += in->follower_mass * (n->dz_dtheta * alpha + n->d2z_dtheta2 * omega2);
        out.moment = in->follower * (n->dpsi_dtheta[0] * alpha + n->d2gamma_dtheta2 * omega2);
    }
    return out;
}

/* N/m: x_i = R_i/hypot(r_i, a_i), R_i total. */
static inline Vector2 lobatto_node_contact(const NodePair *n, const NodeForces *forces, int i) {
    const Vector2 arm = i == 0 ? -n->factors.d[1] : n->factors.d[0];
    return (n->factors.rn[1 - i] * forces->axial + arm * forces->moment) * forces->inverse;
}

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

/* Times the sign of contact i: its friction at two sliding speeds, m/s; load2: the square of the nominal loads over
 * N_ref, or over 1 N where there is a table. */
VectorFriction lobatto_friction(const LobattoSystem *system, int i, Vector2 v, Vector2 load2);

/* Without inertia: omega by the balance at the end of the step, rad/s. */
double lobatto_system_speed_at_end(LobattoSystem *system);

/* ---- the error of a step ---- */

/* The coefficient of c^3 of the cubic through the values. Where it happens to be small, the decay of the lower
 * coefficients stands for it. */
static inline double lobatto_cubic_term(const LobattoValues *y) {
    const LobattoValues c = lobatto_combine(LOBATTO.bernstein, y);
    const double *b = c.at;
    const double linear = 3.0 * fabs(b[1] - b[0]), square = 3.0 * fabs(b[0] - 2.0 * b[1] + b[2]);
    return max_of(fabs(b[3] - b[0] + 3.0 * (b[1] - b[2])),
                  LOBATTO_DECAY * square * square / (linear + square + DBL_MIN));
}

/* The parabola through the last three nodes misses the value at the start by the cubic term times LOBATTO.missed. In
 * between, its integrals are those of prod(1 - c/c_i) times that. The cubic itself misses far less. x is the error of
 * the parabola relative to speed and distance. The limit x^(11/8) <= tolerance is set so that of 5000 random steps that
 * just pass, all are within the tolerance, and 99 of 100 within half of it. `margin`: factor on tolerance^8. */
static inline bool lobatto_is_accurate(const LobattoSystem *s, double margin) {
    const double tolerance = s->slip->params->tolerance;
    const double missed = s->h * LOBATTO.missed * lobatto_cubic_term(&s->y);
    const double distance = fabs(s->dtheta.at[LOBATTO_END]), rounding = ANGLE_ROUNDING * fabs(s->theta);
    double by_speed = 0.0, by_angle = missed * LOBATTO.missed_once;
    if (lobatto_system_is_inertial(s)) {
        by_speed = missed * LOBATTO.missed_once / lobatto_largest(lobatto_range(&s->speed));
        by_angle = missed * LOBATTO.missed_twice * s->h;
    }
    const double x = max_of(by_speed, max_of(by_angle - rounding, 0.0) / (distance + DBL_MIN));
    const double x2 = x * x, x8 = (x2 * x2) * (x2 * x2), t2 = tolerance * tolerance;
    return x < 1.0 && x8 * x2 * x <= margin * (t2 * t2) * (t2 * t2);
}

#endif
