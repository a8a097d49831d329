#include "sensitivity/inverse_sensitivity.h"

#include <stdio.h>

#include "contact/balance.h"
#include "inverse/elastic_shaft.h"
#include "inverse/inverse_outputs.h"
#include "inverse/rigid_shaft.h"
#include "model/elements.h"
#include "platform/attributes.h"

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
