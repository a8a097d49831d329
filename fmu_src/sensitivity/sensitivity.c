#include "sensitivity/sensitivity.h"

#include <stdio.h>

#include "forward/decide.h"
#include "outputs/outputs.h"
#include "platform/attributes.h"

/* z(theta) and v = z' omega. */
NOINLINE void mechanism_axial_partials(const Mechanism *m, int order, Partials *out) {
    const double dz_dtheta = m->configuration.geometry.dz_dtheta;
    *out = (Partials){.by = {0.0}};
    if (order == 0) {
        out->by[KNOWN_THETA] = dz_dtheta;
        return;
    }
    const double theta = m->state.theta.hi, *share = m->configuration.geometry.dpsi_dtheta;
    const TransmissionPoint at =
        piece_point(transmission_piece(&m->model.transmission, theta, 0), theta, TRANSMISSION_FIRST_DERIVATIVES);
    const double d2z_dtheta2 = share[0] * share[0] * at.dslope_dtheta[0] + share[1] * share[1] * at.dslope_dtheta[1];
    out->by[KNOWN_THETA] = d2z_dtheta2 * m->state.omega.hi;
    out->by[KNOWN_OMEGA] = dz_dtheta;
}

/* Without inertia the balance of forces gives omega, and alpha is the time derivative of this omega along the
 * motion. */
static void viscous_partials(const Mechanism *m, const SlipMode *slip, Partials *out) {
    for (int k = 0; k < KNOWN_COUNT; k++) {
        Taylor along;
        taylor_of_motion(m, slip, (Known)k, 1, &along);
        out->by[k] = along.omega.c[1].slope;
    }
}

bool mechanism_alpha_partials(const Mechanism *m, Partials *out, Fault *fault) {
    *out = (Partials){.by = {0.0}};
    const Decision now = decision_of(m);
    if (!is_slip(now.mode)) return true;
    const SlipMode slip = slip_mode_from_here(m, now.slip_index);
    if (slip.regime == REGIME_RATE_INDEPENDENT) {
        snprintf(fault->text, sizeof fault->text,
                 "alpha has no partial derivatives where angle follows torque: inertia.shaft, inertia.follower_mass, "
                 "inertia.follower, shaft.damping or a damper that acts in this direction must be > 0");
        return false;
    }
    if (slip.regime == REGIME_VISCOUS) {
        viscous_partials(m, &slip, out);
        return true;
    }
    const Balance balance = balance_from_here(m, &slip);
    balance_response(&slip, &balance, out);
    return true;
}
