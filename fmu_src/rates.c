#include "rates.h"

static void seed(Jet *jet, bool is_knob) {
    jet->c[0].slope = is_knob ? 1.0 : 0.0;
}

void rates_along(const Mechanism *m, const Way *way, Knob knob, int last, Taylor *out) {
    const Balance now = balance_from_here(m, way);
    *out = (Taylor){
        .tau = jet_of_derivatives(m->inputs.tau), .F_ext = jet_of_derivatives(m->inputs.F_ext), .knob = knob};
    out->theta.c[0].value = now.theta;
    seed(&out->theta, knob == KNOB_THETA);
    seed(&out->tau, knob == KNOB_TAU);
    seed(&out->F_ext, knob == KNOB_F_EXT);
    taylor_follow(way, &now, last, out);
}

static void slip_rates(const Mechanism *m, const Slip *slip, Rates *out) {
    const Launch launch = launch_of(m, slip);
    const Arc now = slip_arc_start(slip, &launch);
    *out = (Rates){.theta = {now.omega, now.alpha, now.jerk}};
    for (int k = 0; k < 3; k++) out->z[k] = m->place.geometry.lift * out->theta[k];
}

void rates_of_motion(const Mechanism *m, Rates *out) {
    const Decision now = decision_of(m);
    *out = (Rates){.theta = {0.0}};
    if (!is_slip(now.mode)) return;
    if (is_closed_form(m)) {
        Slip room;
        slip_rates(m, slip_of(m, now.slip, &room), out);
        return;
    }
    const Way way = way_from_here(m, now.slip);
    Taylor t;
    rates_along(m, &way, KNOB_COUNT, 2, &t);
    const double factorial[3] = {1.0, 1.0, 2.0};
    for (int k = 0; k < 3; k++) {
        out->theta[k] = factorial[k] * t.omega.c[k].value;
        out->z[k] = factorial[k] * t.v.c[k].value;
    }
    out->z[0] = m->place.geometry.lift * out->theta[0]; /* to the last digit what v is */
}
