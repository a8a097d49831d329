#include "sensitivity/sensitivity.h"

#include <stdio.h>

#include "contact/contact_statics.h"
#include "forward/decide.h"
#include "forward/outputs.h"
#include "platform/attributes.h"

/* z(theta) and v = z' omega. */
NOINLINE void mechanism_axial_partials(const Mechanism *m, int order, Partials *out) {
    const double dz_dtheta = m->configuration.geometry.dz_dtheta;
    *out = (Partials){.by = {0.0}};
    if (order == 0) {
        out->by[KNOWN_THETA] = dz_dtheta;
        return;
    }
    const double theta = m->state.theta.hi;
    const ContactStatics statics =
        contact_statics_at(&m->params, transmission_piece(&m->model.transmission, theta, 0), theta);
    out->by[KNOWN_THETA] = statics.d2z_dtheta2 * m->state.omega.hi;
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
    Partials residual;
    balance_partials(&slip, &balance, &residual);
    for (int k = 0; k < KNOWN_COUNT; k++)
        if (k != KNOWN_ALPHA) out->by[k] = -residual.by[k] / residual.by[KNOWN_ALPHA];
    return true;
}
