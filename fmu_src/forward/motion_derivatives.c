#include "forward/motion_derivatives.h"

static void seed(Jet *jet, bool is_known) {
    jet->c[0].slope = is_known ? 1.0 : 0.0;
}

void taylor_of_motion(const Mechanism *m, const SlipMode *slip, Known known, int last, Taylor *out) {
    const Balance now = balance_from_here(m, slip);
    *out = (Taylor){
        .tau = jet_of_derivatives(m->inputs.tau), .F_ext = jet_of_derivatives(m->inputs.F_ext), .known = known};
    out->theta.c[0].value = now.theta;
    seed(&out->theta, known == KNOWN_THETA);
    seed(&out->tau, known == KNOWN_TAU);
    seed(&out->F_ext, known == KNOWN_F_EXT);
    taylor_follow(slip, &now, last, out);
}

static void slip_rates(const Mechanism *m, const LinearSlipMode *slip, MotionDerivatives *out) {
    const SlipStart start = slip_start_of(m, slip);
    const LinearMotion now = linear_slip_motion_at_start(slip, &start);
    *out = (MotionDerivatives){.theta = {now.omega, now.alpha, now.jerk}};
    for (int k = 0; k < 3; k++) out->z[k] = m->configuration.geometry.dz_dtheta * out->theta[k];
}

void motion_derivatives(const Mechanism *m, MotionDerivatives *out) {
    const Decision now = decision_of(m);
    *out = (MotionDerivatives){.theta = {0.0}};
    if (!is_slip(now.mode)) return;
    if (is_closed_form(m)) {
        LinearSlipMode room;
        slip_rates(m, linear_slip_of(m, now.slip_index, &room), out);
        return;
    }
    const SlipMode slip = present_slip_mode(m, now.slip_index);
    Taylor t;
    taylor_of_motion(m, &slip, KNOWN_COUNT, 2, &t);
    const double factorial[3] = {1.0, 1.0, 2.0};
    for (int k = 0; k < 3; k++) {
        out->theta[k] = factorial[k] * t.omega.c[k].value;
        out->z[k] = factorial[k] * t.v.c[k].value;
    }
    out->z[0] = m->configuration.geometry.dz_dtheta * out->theta[0]; /* to the last digit what v is */
}
