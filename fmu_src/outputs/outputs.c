#include "outputs/outputs.h"

#include <math.h>

#include "forward/configuration.h"
#include "forward/decide.h"
#include "forward/stick.h"
#include "model/friction_law.h"
#include "numerics/sign.h"
#include "platform/attributes.h"

/* ---- motion and loads ---- */

void mechanism_motion(const Mechanism *m, Motion *out) {
    out->z = m->configuration.z;
    out->v = m->configuration.geometry.dz_dtheta * m->state.omega.hi;
}

/* T_release/T_load; where F_0 = 0, and with it both torques, the ratio of their factors. 0 where no torque moves the
 * mechanism either way. */
static double efficiency(const Mechanism *m, const BandFactors *f, double F_0) {
    const double load = F_0 == 0.0 ? f->load : stick_edge(f->load, F_0);
    const double release = F_0 == 0.0 ? f->release : stick_edge(f->release, F_0);
    if (load == 0.0 && release == 0.0) return has_friction(&m->params) ? 0.0 : 1.0;
    return isinf(load) && isinf(release) ? 0.0 : release / load;
}

/* Acceleration and reactions while slipping, in grooves of any shape. */
static void general_slip_loads(const Mechanism *m, int index, LoadOutputs *out) {
    const SlipMode slip = slip_mode_from_here(m, index);
    const Balance now = balance_from_here(m, &slip);
    out->alpha = now.alpha;
    for (int i = 0; i < 2; i++) out->friction_coefficient[i] = slip.direction * slip.flank[i] * now.friction[i];
    if (slip.regime != REGIME_INERTIAL) {
        Taylor t;
        taylor_of_motion(m, &slip, KNOWN_COUNT, 1, &t);
        out->alpha = t.omega.c[1].value;
    }
    for (int i = 0; i < 2; i++) out->reaction[i] = now.x[i] * sqrt(now.length2[i]) / m->params.contacts;
}

/* Acceleration and reactions while slipping, in closed form. */
static void linear_slip_loads(const Mechanism *m, const LinearSlipMode *linear, LoadOutputs *out) {
    const SlipStart start = slip_start_of(m, linear);
    const LinearMotion now = linear_slip_motion_at_start(linear, &start);
    out->alpha = now.alpha;
    for (int i = 0; i < 2; i++) {
        const ContactLoad c = linear_slip_contact(linear, &m->params, &m->configuration.geometry, &start, &now, i);
        out->reaction[i] = c.value * linear->reaction[i];
    }
}

void mechanism_loads(const Mechanism *m, LoadOutputs *out) {
    const Geometry *g = &m->configuration.geometry;
    const double theta = m->state.theta.hi, omega = m->state.omega.hi, F_0 = stick_axial_load(m);
    const BandFactors f = stick_edges(m, F_0);
    const Decision now = decision_of(m);
    const Transmission *transmission = &m->model.transmission;
    *out = (LoadOutputs){
        .gamma = transmission->straight ? g->dpsi_dtheta[0] * theta : transmission_gamma(transmission, theta),
        .spring_force = spring_force(&m->params.spring, m->configuration.z),
        .damper_force = damper_force(&m->params.damper, sign_of(omega), g->dz_dtheta * omega),
        .torque_load = stick_edge(f.load, F_0),
        .torque_release = stick_edge(f.release, F_0),
        .efficiency = efficiency(m, &f, F_0),
        .mode = (int)now.mode,
        .friction_class = m->state.friction_class,
        .events = m->state.events,
    };
    for (int i = 0; i < 2; i++) {
        out->sliding_speed[i] = g->dpsi_dtheta[i] * fabs(omega) * cam_length(g, i);
        out->reaction[i] = stick_reaction(m, i);
        out->friction_coefficient[i] = friction_at_rest(&m->params.cam[i], out->reaction[i]);
    }
    if (!is_slip(now.mode)) return;
    LinearSlipMode storage;
    if (is_closed_form(m)) linear_slip_loads(m, linear_slip_of(m, now.slip_index, &storage), out);
    else general_slip_loads(m, now.slip_index, out);
    for (int i = 0; i < 2; i++)
        out->friction_power[i] =
            out->friction_coefficient[i] * fabs(out->reaction[i]) * m->params.contacts * out->sliding_speed[i];
    out->total_friction_power = out->friction_power[0] + out->friction_power[1];
}

/* ---- accounts ---- */

void mechanism_energy(const Mechanism *m, Energy *out) {
    const Ledger *l = &m->state.ledger;
    *out = (Energy){
        .work_in = l->work_in.hi,
        .work_ext = l->work_ext.hi,
        .work_tuning = l->work_tuning.hi,
        .spring = spring_energy(&m->params.spring, m->configuration.z),
        .kinetic = kinetic_energy(m),
        .heat_cam = {l->heat_cam[0].hi, l->heat_cam[1].hi},
        .heat_damper = l->heat_damper.hi,
        .heat_shaft = l->heat_shaft.hi,
        .heat_stop = l->heat_stop.hi,
    };
}

void mechanism_audit(const Mechanism *m, Audit *out) {
    const bool keeps = m->params.ledger && !m->continuous;
    out->residual = keeps ? ledger_residual(&m->state.ledger, stored_energy(m)) : 0.0;
}

/* ---- time derivatives ---- */

static void seed(Jet *jet, bool is_known) {
    jet->c[0].slope = is_known ? 1.0 : 0.0;
}

NOINLINE void taylor_of_motion(const Mechanism *m, const SlipMode *slip, Known known, int last, Taylor *out) {
    const Balance now = balance_from_here(m, slip);
    *out = (Taylor){
        .tau = jet_of_derivatives(m->inputs.tau), .F_ext = jet_of_derivatives(m->inputs.F_ext), .known = known};
    out->theta.c[0].value = now.theta;
    seed(&out->theta, known == KNOWN_THETA);
    seed(&out->tau, known == KNOWN_TAU);
    seed(&out->F_ext, known == KNOWN_F_EXT);
    taylor_follow(slip, &now, last, out);
}

static void linear_slip_derivatives(const Mechanism *m, const LinearSlipMode *linear, MotionDerivatives *out) {
    const SlipStart start = slip_start_of(m, linear);
    const LinearMotion now = linear_slip_motion_at_start(linear, &start);
    *out = (MotionDerivatives){.theta = {now.omega, now.alpha, now.jerk}};
    for (int k = 0; k < 3; k++) out->z[k] = m->configuration.geometry.dz_dtheta * out->theta[k];
}

void motion_derivatives(const Mechanism *m, MotionDerivatives *out) {
    const Decision now = decision_of(m);
    *out = (MotionDerivatives){.theta = {0.0}};
    if (!is_slip(now.mode)) return;
    if (is_closed_form(m)) {
        LinearSlipMode storage;
        linear_slip_derivatives(m, linear_slip_of(m, now.slip_index, &storage), out);
        return;
    }
    const SlipMode slip = slip_mode_from_here(m, now.slip_index);
    Taylor t;
    taylor_of_motion(m, &slip, KNOWN_COUNT, 2, &t);
    const double factorial[3] = {1.0, 1.0, 2.0};
    for (int k = 0; k < 3; k++) {
        out->theta[k] = factorial[k] * t.omega.c[k].value;
        out->z[k] = factorial[k] * t.v.c[k].value;
    }
    out->z[0] = m->configuration.geometry.dz_dtheta * out->theta[0]; /* bit for bit the output v */
}
