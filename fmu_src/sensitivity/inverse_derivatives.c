#include "sensitivity/inverse_derivatives.h"

#include <math.h>
#include <stdio.h>

#include "contact/balance.h"
#include "inverse/elastic_shaft.h"
#include "inverse/inverse_outputs.h"
#include "inverse/rigid_shaft.h"
#include "model/elements.h"
#include "outputs/taylor.h"

/* ---- the imposed motion at the present instant ---- */

static double first_nonzero(double a, double b, double c) {
    return a != 0.0 ? a : b != 0.0 ? b : c;
}

/* theta' = omega and omega' = alpha; the higher derivatives are those of alpha, or else of omega or theta. */
static Taylor imposed_taylor(const InverseInputs *u) {
    const double jerk = first_nonzero(u->alpha[1], u->omega[2], u->theta[3]);
    const double snap = first_nonzero(u->alpha[2], u->omega[3], 0.0);
    const double theta[JET_TERMS] = {u->theta[0], u->omega[0], u->alpha[0], jerk};
    const double omega[JET_TERMS] = {u->omega[0], u->alpha[0], jerk, snap};
    return (Taylor){.theta = jet_of_derivatives(theta),
                    .omega = jet_of_derivatives(omega),
                    .F_ext = jet_of_derivatives(u->F_ext),
                    .known = KNOWN_COUNT};
}

/* The sign of the first coefficient, from the given order on, that is not zero: the sign just after the present
 * instant. */
static int sign_ahead(const Jet *jet, int from) {
    for (int k = from; k < JET_TERMS; k++)
        if (jet->c[k].value != 0.0) return jet->c[k].value > 0.0 ? 1 : -1;
    return 0;
}

static SlipMode slip_mode_at(const Inverse *m, double theta, int direction, const int flank[2]) {
    static const Inputs none = {.tau = {0.0}};
    return slip_mode_of(&m->params, &m->transmission, NULL, &none, theta, direction, flank);
}

/* ---- rigid shaft ---- */

/* The torque in the direction of the motion that follows; where the contacts wedge in this direction, or where nothing
 * moves, in the present one. */
static void required_torque_ahead(const Inverse *m, const Taylor *t, OperatingPoint *at, RequiredTorque *required) {
    const int present = at->direction, ahead = sign_ahead(&t->omega, 0);
    if (ahead != 0) at->direction = ahead;
    if (rigid_shaft_required_torque(&m->params, inverse_piece(m, at->theta, at->direction), at, required)) return;
    at->direction = present;
    (void)rigid_shaft_required_torque(&m->params, inverse_piece(m, at->theta, present), at, required);
}

/* Does contact i, which carries nothing now, bear on this flank from now on? x_i Delta as in balance.h. */
static bool agrees_ahead(const Taylor *t, int i, int flank) {
    const int other = 1 - i;
    Jet x = jet_multiply(&t->factors.rn[other], &t->load);
    jet_add_product(&x, i == 0 ? -1.0 : 1.0, &t->factors.d[other], &t->moment);
    x = jet_divide(&x, &t->factors.delta);
    return flank * sign_ahead(&x, 1) >= 0;
}

static void balance_on_flanks(const Inverse *m, const OperatingPoint *at, const int flank[2], Taylor *t) {
    const SlipMode slip = slip_mode_at(m, at->theta, at->direction, flank);
    taylor_expand_grooves(&slip, t);
    taylor_balance(&slip, t);
}

/* The sign of the axial load, or of the load that follows where there is none now. */
static int load_side(const Load *load, const Taylor *t) {
    const int now = contact_statics_side(load);
    if (now != 0) return now;
    return sign_ahead(&t->load, 1) < 0 ? -1 : 1;
}

/* Balances on the present flanks. A contact that carries nothing now takes the flank that its reaction agrees with a
 * little later; of several pairs of flanks the first one in the order of contact_statics_forces(). False if no pair
 * agrees: the contacts wedge. */
static bool balance_ahead(const Inverse *m, const OperatingPoint *at, const RequiredTorque *required, Taylor *t) {
    const int *present = required->forces.flank;
    const bool idle[2] = {contact_statics_carries_nothing(&required->forces, &required->load, 0),
                          contact_statics_carries_nothing(&required->forces, &required->load, 1)};
    balance_on_flanks(m, at, present, t);
    if (!idle[0] && !idle[1]) return true;
    const int side = load_side(&required->load, t);
    for (int k = 0; k < FLANK_PAIR_COUNT; k++) {
        int flank[2];
        flank_pair(k, side, flank);
        if ((flank[0] != present[0] && !idle[0]) || (flank[1] != present[1] && !idle[1])) continue;
        balance_on_flanks(m, at, flank, t);
        if ((!idle[0] || agrees_ahead(t, 0, flank[0])) && (!idle[1] || agrees_ahead(t, 1, flank[1]))) return true;
    }
    return false;
}

static void rigid_shaft_taylor(const Inverse *m, Taylor *t, RequiredTorque *required) {
    OperatingPoint at = rigid_shaft_operating_point(m);
    required_torque_ahead(m, t, &at, required);
    /* z is rounded, and so the spring's force: a load of this size may be none */
    required->load.axial_size += fabs(spring_rate(&m->params.spring, required->statics.z)) * m->transmission.z_size;
    const bool moves_on = balance_ahead(m, &at, required, t);
    t->tau = jet_divide(&t->residual, &t->factors.delta);
    for (int k = 0; k < JET_TERMS; k++) t->tau.c[k].value = moves_on ? -t->tau.c[k].value : NAN;
}

/* ---- elastic shaft ---- */

/* Is the torque on the edge of the band in this direction, and does the shaft press beyond the edge from now on? Then
 * cam 2 follows. */
static bool follows_ahead(const Inverse *m, const ElasticShaftState *shaft, int direction, ContactForces *forces,
                          const Taylor *t) {
    if (!elastic_shaft_is_on_edge(m, shaft->x, direction, forces)) return false;
    Jet excess = jet_line((Dual){0.0, 0.0}, (Dual){t->stiffness, 0.0}, &t->far);
    jet_add_scaled(&excess, -forces->transfer.rho_rate, &t->F_ext);
    return direction * sign_ahead(&excess, 1) > 0;
}

static void elastic_shaft_taylor(const Inverse *m, Taylor *t) {
    ElasticShaftState shaft;
    ContactForces forces;
    elastic_shaft_present(m, &shaft);
    t->far = t->theta;
    t->stiffness = m->params.shaft.stiffness;
    t->theta = t->omega = (Jet){.c = {{0.0, 0.0}}};
    t->theta.c[0].value = shaft.x;
    t->tau = jet_line((Dual){0.0, 0.0}, (Dual){t->stiffness, 0.0}, &t->far); /* from order 1 on: cam 2 rests */
    for (int direction = -1; direction <= 1; direction += 2) {
        if (!follows_ahead(m, &shaft, direction, &forces, t)) continue;
        SlipMode slip = slip_mode_at(m, shaft.x, direction, forces.flank);
        slip.regime = REGIME_RATE_INDEPENDENT; /* neither inertia nor damping acts */
        const Balance now = {
            .theta = shaft.x,
            .tau = shaft.tau,
            .force = spring_force(&m->params.spring, shaft.statics.z) + m->inputs.F_ext[0],
        };
        taylor_follow(&slip, &now, 2, t);
        return;
    }
}

void inverse_derivatives(const Inverse *m, InverseDerivatives *out) {
    const bool is_elastic = has_elastic_shaft(m);
    Taylor t = imposed_taylor(&m->inputs);
    RequiredTorque required;
    if (is_elastic) elastic_shaft_taylor(m, &t);
    else rigid_shaft_taylor(m, &t, &required);
    *out = (InverseDerivatives){
        .tau = {t.tau.c[1].value, 2.0 * t.tau.c[2].value},
        .z = {t.v.c[0].value, t.v.c[1].value, 2.0 * t.v.c[2].value},
    };
    if (!is_elastic) out->z[0] = required.statics.geometry.dz_dtheta * m->inputs.omega[0];
}

/* ---- partial derivatives ---- */

/* The torque makes the equation of motion hold, residual(tau, k) = 0, so
 * d tau/dk = -(d residual/dk)/(d residual/d tau). */
static void solve_for_torque(const Inverse *m, double theta, int direction, const int flank[2], const Balance *now,
                             Partials *out) {
    const Inputs none = {.tau = {0.0}};
    const SlipMode slip = slip_mode_of(&m->params, &m->transmission, NULL, &none, theta, direction, flank);
    Partials residual;
    balance_partials(&slip, now, &residual);
    *out = (Partials){.by = {0.0}};
    for (int k = 0; k < KNOWN_COUNT; k++)
        if (k != KNOWN_TAU) out->by[k] = -residual.by[k] / residual.by[KNOWN_TAU];
}

static bool rigid_torque_partials(const Inverse *m, Partials *out, Fault *fault) {
    const OperatingPoint at = rigid_shaft_operating_point(m);
    RequiredTorque required;
    if (!rigid_shaft_required_torque(&m->params, inverse_piece(m, at.theta, at.direction), &at, &required)) {
        rigid_shaft_describe_wedge(fault, &at);
        return false;
    }
    const Balance now = {
        /* as far as balance_partials() reads it */
        .theta = at.theta,
        .omega = at.omega,
        .alpha = at.alpha,
        .tau = required.tau,
        .force = spring_force(&m->params.spring, required.statics.z) + at.F_ext,
        .damper = required.damper,
    };
    solve_for_torque(m, at.theta, at.direction, required.forces.flank, &now, out);
    return true;
}

/* The partial derivatives of the edge E of the stick band on which cam 2 slips. False where the contacts wedge. */
static bool edge_partials(const Inverse *m, const ElasticShaftState *shaft, Partials *edge) {
    const int direction = shaft->mode == MODE_LOADING ? 1 : -1;
    const double F_0 = spring_force(&m->params.spring, shaft->statics.z) + m->inputs.F_ext[0];
    ContactStatics statics = shaft->statics;
    ContactForces forces;
    if (!contact_statics_on_edge(&statics, direction, F_0, &forces)) return false;
    const Balance now = {.theta = shaft->x, .tau = shaft->tau, .force = F_0};
    solve_for_torque(m, shaft->x, direction, forces.flank, &now, edge);
    return true;
}

/* Of the angle x of cam 2 and of the torque of the elastic shaft, tau = K (theta - x). While cam 2 sticks, x is
 * constant. While it slips, tau is also the edge E(x, k) of the stick band, so dx = (K dtheta - E_k dk)/(K + E_x). */
static bool elastic_partials(const Inverse *m, const ElasticShaftState *shaft, Partials *x, Partials *tau) {
    const double K = m->params.shaft.stiffness;
    *x = *tau = (Partials){.by = {0.0}};
    tau->by[KNOWN_THETA] = K;
    if (shaft->mode != MODE_LOADING && shaft->mode != MODE_RELEASING) return true;
    Partials edge;
    if (!edge_partials(m, shaft, &edge)) return false;
    const double sum = K + edge.by[KNOWN_THETA];
    for (int k = 0; k < KNOWN_COUNT; k++) {
        const double by_input = k == KNOWN_THETA ? K : 0.0, by_edge = k == KNOWN_THETA ? 0.0 : edge.by[k];
        x->by[k] = k == KNOWN_OMEGA || k == KNOWN_ALPHA ? 0.0 : (by_input - by_edge) / sum;
        tau->by[k] = by_input - K * x->by[k];
    }
    return true;
}

bool inverse_torque_partials(const Inverse *m, Partials *out, Fault *fault) {
    if (!inverse_reaches(m, m->inputs.theta[0], fault)) return false;
    if (!has_elastic_shaft(m)) return rigid_torque_partials(m, out, fault);
    ElasticShaftState shaft;
    Partials x;
    elastic_shaft_present(m, &shaft);
    if (elastic_partials(m, &shaft, &x, out)) return true;
    snprintf(fault->text, sizeof fault->text,
             "tau has no partial derivatives where cam 2 is wedged: allowed is theta = %s, as at the latest "
             "communication point",
             shortest_decimal(m->state.theta).text);
    return false;
}

static bool elastic_axial_partials(const Inverse *m, int order, Partials *out, Fault *fault) {
    ElasticShaftState shaft;
    Partials tau;
    elastic_shaft_present(m, &shaft);
    if (order == 0 && elastic_partials(m, &shaft, out, &tau)) {
        for (int k = 0; k < KNOWN_COUNT; k++) out->by[k] *= shaft.statics.geometry.dz_dtheta;
        return true;
    }
    snprintf(fault->text, sizeof fault->text,
             "%s has no partial derivatives with shaft.stiffness = %s: allowed is shaft.stiffness = 0",
             order == 0 ? "z of a wedged cam 2" : "v", shortest_decimal(m->params.shaft.stiffness).text);
    return false;
}

/* z(theta) and v = z' omega. */
static void rigid_axial_partials(const Inverse *m, int order, Partials *out) {
    const OperatingPoint at = rigid_shaft_operating_point(m);
    const ContactStatics statics = contact_statics_at(&m->params, inverse_piece(m, at.theta, at.direction), at.theta);
    if (order == 0) {
        out->by[KNOWN_THETA] = statics.geometry.dz_dtheta;
        return;
    }
    out->by[KNOWN_THETA] = statics.d2z_dtheta2 * at.omega;
    out->by[KNOWN_OMEGA] = statics.geometry.dz_dtheta;
}

bool inverse_axial_partials(const Inverse *m, int order, Partials *out, Fault *fault) {
    if (!inverse_reaches(m, m->inputs.theta[0], fault)) return false;
    *out = (Partials){.by = {0.0}};
    if (has_elastic_shaft(m)) return elastic_axial_partials(m, order, out, fault);
    rigid_axial_partials(m, order, out);
    return true;
}
