/* The nodes of a Lobatto step, two in each vector, and all that a sweep finds at them (lobatto_system.h). */
#ifndef DUALCAM_LOBATTO_NODES_H
#define DUALCAM_LOBATTO_NODES_H

#include "contact/balance.h"
#include "contact/contact_factors.h"
#include "numerics/lobatto.h"

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

#endif
