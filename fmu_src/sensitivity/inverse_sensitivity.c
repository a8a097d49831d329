#include <stdio.h>

#include "contact/balance.h"
#include "inverse/elastic_shaft.h"
#include "inverse/inverse.h"
#include "inverse/rigid_shaft.h"

/* Balance of the imposed motion: balance_partials() needs no more of it. */
static Balance balance_of(const Inverse *m, const Effort *effort, const Instant *at) {
    return (Balance){
        .theta = at->theta,
        .omega = at->omega,
        .alpha = at->alpha,
        .tau = effort->tau,
        .force = spring_force(&m->params.spring, effort->statics.z) + at->F_ext,
        .damper = effort->damper,
    };
}

/* tau makes the equation of motion hold: d tau/dk = -(d/dk)/(d/d tau) of it. */
static void solve_for_torque(const Inverse *m, double theta, int direction, const int flank[2], const Balance *now,
                             Partials *out) {
    const Inputs none = {.tau = {0.0}};
    const SlipMode slip = slip_mode_of(&m->params, &m->transmission, &none, theta, direction, flank);
    Partials residual;
    balance_partials(&slip, now, &residual);
    *out = (Partials){.by = {0.0}};
    for (int k = 0; k < KNOWN_COUNT; k++)
        if (k != KNOWN_TAU) out->by[k] = -residual.by[k] / residual.by[KNOWN_TAU];
}

static bool rigid_partials(const Inverse *m, Partials *out, Fault *fault) {
    const Instant at = rigid_shaft_present(m);
    Effort effort;
    if (!rigid_shaft_effort(&m->params, transmission_piece(&m->transmission, at.theta, at.direction), &at, &effort)) {
        rigid_shaft_describe_wedge(fault, &at);
        return false;
    }
    const Balance now = balance_of(m, &effort, &at);
    solve_for_torque(m, at.theta, at.direction, effort.forces.flank, &now, out);
    return true;
}

/* How cam 2's angle and the torque of the elastic shaft change: tau = K (theta - cam). While cam 2 sticks, that is all;
 * while it slips, tau is the edge E(cam, k) of the stick band as well, so d cam = (K d theta - E_k dk)/(K + E_theta). */
static bool elastic_partials(const Inverse *m, Partials *cam, Partials *tau) {
    const double K = m->params.shaft.stiffness;
    ElasticShaftState d;
    elastic_shaft_present(m, &d);
    *cam = *tau = (Partials){.by = {0.0}};
    tau->by[KNOWN_THETA] = K;
    if (d.mode != MODE_LOADING && d.mode != MODE_RELEASING) return true;
    const int direction = d.mode == MODE_LOADING ? 1 : -1;
    const double F_0 = spring_force(&m->params.spring, d.statics.z) + m->inputs.F_ext[0];
    ContactForces forces;
    if (!contact_statics_on_edge(&d.statics, direction, F_0, &forces)) return false;
    const Balance now = {.theta = d.cam, .tau = d.tau, .force = F_0};
    Partials edge;
    solve_for_torque(m, d.cam, direction, forces.flank, &now, &edge);
    const double sum = K + edge.by[KNOWN_THETA];
    for (int k = 0; k < KNOWN_COUNT; k++) {
        const double by_input = k == KNOWN_THETA ? K : 0.0, by_edge = k == KNOWN_THETA ? 0.0 : edge.by[k];
        cam->by[k] = k == KNOWN_OMEGA || k == KNOWN_ALPHA ? 0.0 : (by_input - by_edge) / sum;
        tau->by[k] = by_input - K * cam->by[k];
    }
    return true;
}

bool inverse_torque_partials(const Inverse *m, Partials *out, Fault *fault) {
    if (!inverse_reaches(m, m->inputs.theta[0], fault)) return false;
    if (!has_elastic_shaft(m)) return rigid_partials(m, out, fault);
    Partials cam;
    if (elastic_partials(m, &cam, out)) return true;
    snprintf(fault->text, sizeof fault->text,
             "tau has no partial derivatives where cam 2 is wedged: allowed is theta = %.17g only", m->state.theta);
    return false;
}

bool inverse_axial_partials(const Inverse *m, int order, Partials *out, Fault *fault) {
    if (!inverse_reaches(m, m->inputs.theta[0], fault)) return false;
    *out = (Partials){.by = {0.0}};
    if (has_elastic_shaft(m)) {
        ElasticShaftState d;
        Partials tau;
        elastic_shaft_present(m, &d);
        if (order == 0 && elastic_partials(m, out, &tau)) {
            for (int k = 0; k < KNOWN_COUNT; k++) out->by[k] *= d.statics.geometry.dz_dtheta;
            return true;
        }
        snprintf(fault->text, sizeof fault->text,
                 "%s with shaft.stiffness = %.17g has no partial derivatives: shaft.stiffness must be 0 for them",
                 order == 0 ? "z, wedged," : "v", m->params.shaft.stiffness);
        return false;
    }
    const Instant at = rigid_shaft_present(m);
    const ContactStatics statics =
        contact_statics_at(&m->params, transmission_piece(&m->transmission, at.theta, at.direction), at.theta);
    if (order == 0) {
        out->by[KNOWN_THETA] = statics.geometry.dz_dtheta;
        return true;
    }
    out->by[KNOWN_THETA] = statics.d2z_dtheta2 * at.omega;
    out->by[KNOWN_OMEGA] = statics.geometry.dz_dtheta;
    return true;
}
