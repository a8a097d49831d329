#include <math.h>

#include "contact/taylor.h"
#include "inverse/elastic_shaft.h"
#include "inverse/inverse.h"
#include "inverse/rigid_shaft.h"

/* ---- the imposed motion at the present instant ---- */

static double first_given(double a, double b, double c) {
    return a != 0.0 ? a : b != 0.0 ? b : c;
}

/* theta' = omega, omega' = alpha; higher derivatives are alpha's, or those that omega or theta have instead. */
static Taylor imposed_now(const InverseInputs *u) {
    const double jerk = first_given(u->alpha[1], u->omega[2], u->theta[3]);
    const double snap = first_given(u->alpha[2], u->omega[3], 0.0);
    const double theta[JET_TERMS] = {u->theta[0], u->omega[0], u->alpha[0], jerk};
    const double omega[JET_TERMS] = {u->omega[0], u->alpha[0], jerk, snap};
    return (Taylor){.theta = jet_of_derivatives(theta),
                    .omega = jet_of_derivatives(omega),
                    .F_ext = jet_of_derivatives(u->F_ext),
                    .known = KNOWN_COUNT};
}

/* The sign of the first coefficient that is not zero: how it goes on from zero. */
static int sign_ahead(const Jet *jet, int from) {
    for (int k = from; k < JET_TERMS; k++)
        if (jet->c[k].value != 0.0) return jet->c[k].value > 0.0 ? 1 : -1;
    return 0;
}

static SlipMode way_there(const Inverse *m, double theta, int direction, const int flank[2]) {
    static const Inputs none = {.tau = {0.0}};
    return slip_mode_of(&m->params, &m->transmission, &none, theta, direction, flank);
}

/* ---- rigid shaft ---- */

/* The direction of what comes next; where that is wedged or unknown, the one that tau has now. */
static void effort_ahead(const Inverse *m, const Taylor *t, Instant *at, Effort *effort) {
    const int kept = at->direction, ahead = sign_ahead(&t->omega, 0);
    if (ahead != 0) at->direction = ahead;
    if (rigid_shaft_effort(&m->params, transmission_piece(&m->transmission, at->theta, at->direction), at, effort))
        return;
    at->direction = kept;
    (void)rigid_shaft_effort(&m->params, transmission_piece(&m->transmission, at->theta, kept), at, effort);
}

/* Does contact i, which carries nothing now, go on to bear on that flank? x_i Delta as in balance.h. */
static bool agrees_ahead(const Taylor *t, int i, int flank) {
    const int other = 1 - i;
    Jet x = jet_multiply(&t->factors.rn[other], &t->load);
    jet_add_product(&x, i == 0 ? -1.0 : 1.0, &t->factors.d[other], &t->moment);
    x = jet_divide(&x, &t->factors.delta);
    return flank * sign_ahead(&x, 1) >= 0;
}

static void balance_on(const Inverse *m, const Instant *at, const int flank[2], Taylor *t) {
    const SlipMode slip = way_there(m, at->theta, at->direction, flank);
    taylor_place(&slip, t);
    taylor_balance(&slip, t);
}

/* On the flanks of now; where a contact carries nothing now, on the first that it agrees with a little later. */
static void rigid_ahead(const Inverse *m, Taylor *t, Effort *effort) {
    Instant at = rigid_shaft_present(m);
    effort_ahead(m, t, &at, effort);
    /* the load may be no more than what rounding of z makes of the spring's force */
    effort->load.axial_size += fabs(spring_rate(&m->params.spring, effort->statics.z)) * m->transmission.z_size;
    const int *now = effort->forces.flank;
    const bool idle[2] = {contact_statics_is_idle(&effort->forces, &effort->load, 0),
                          contact_statics_is_idle(&effort->forces, &effort->load, 1)};
    for (int k = 0; k < 4; k++) {
        const bool turns[2] = {(k & 2) != 0, (k & 1) != 0};
        const int flank[2] = {turns[0] ? -now[0] : now[0], turns[1] ? -now[1] : now[1]};
        if ((turns[0] && !idle[0]) || (turns[1] && !idle[1])) continue;
        balance_on(m, &at, flank, t);
        if ((!idle[0] || agrees_ahead(t, 0, flank[0])) && (!idle[1] || agrees_ahead(t, 1, flank[1]))) break;
        if (k == 3) balance_on(m, &at, now, t);
    }
    t->tau = jet_divide(&t->residual, &t->factors.delta);
    for (int k = 0; k < JET_TERMS; k++) t->tau.c[k].value = -t->tau.c[k].value;
}

/* ---- elastic shaft ---- */

/* Where the torque is on the edge of the band in that direction: will it press beyond? Cam 2 then follows. */
static bool follows_ahead(const Inverse *m, const ElasticShaftState *d, int direction, ContactForces *forces,
                          const Taylor *t) {
    if (!elastic_shaft_is_on_edge(m, d->cam, direction, forces)) return false;
    Jet excess = jet_line((Dual){0.0, 0.0}, (Dual){t->stiffness, 0.0}, &t->far);
    jet_add_scaled(&excess, -forces->transfer.rho, &t->F_ext);
    return direction * sign_ahead(&excess, 1) > 0;
}

static void elastic_ahead(const Inverse *m, Taylor *t) {
    ElasticShaftState d;
    ContactForces forces;
    elastic_shaft_present(m, &d);
    t->far = t->theta;
    t->stiffness = m->params.shaft.stiffness;
    t->theta = t->omega = (Jet){.c = {{0.0, 0.0}}};
    t->theta.c[0].value = d.cam;
    t->tau = jet_line((Dual){0.0, 0.0}, (Dual){t->stiffness, 0.0}, &t->far); /* rates only: cam 2 stays */
    for (int direction = -1; direction <= 1; direction += 2) {
        if (!follows_ahead(m, &d, direction, &forces, t)) continue;
        SlipMode slip = way_there(m, d.cam, direction, forces.flank);
        slip.regime = REGIME_RATE_INDEPENDENT; /* neither inertia nor damper acts */
        const Balance now = {
            .theta = d.cam,
            .tau = d.tau,
            .force = spring_force(&m->params.spring, d.statics.z) + m->inputs.F_ext[0],
        };
        taylor_follow(&slip, &now, 2, t);
        return;
    }
}

void inverse_derivatives(const Inverse *m, InverseDerivatives *out) {
    Taylor t = imposed_now(&m->inputs);
    Effort effort;
    if (has_elastic_shaft(m)) elastic_ahead(m, &t);
    else rigid_ahead(m, &t, &effort);
    *out = (InverseDerivatives){.tau = {t.tau.c[1].value, 2.0 * t.tau.c[2].value},
                                .z = {t.v.c[0].value, t.v.c[1].value, 2.0 * t.v.c[2].value}};
    if (!has_elastic_shaft(m)) out->z[0] = effort.statics.geometry.dz_dtheta * m->inputs.omega[0];
}
