#include "sensitivity.h"

#include <stdio.h>

#include "decide.h"
#include "rates.h"
#include "station.h"

/* z(theta), v = z' omega */
void mechanism_axial_partials(const Mechanism *m, int order, Partials *out) {
    const double lift = m->place.geometry.lift;
    *out = (Partials){.by = {0.0}};
    if (order == 0) {
        out->by[KNOB_THETA] = lift;
        return;
    }
    const double theta = m->state.theta.hi;
    const Station station = station_at(&m->params, course_piece(&m->model.course, theta, 0), theta);
    out->by[KNOB_THETA] = station.lift_rate * m->state.omega.hi;
    out->by[KNOB_OMEGA] = lift;
}

/* Without inertia alpha is how the speed, that the balance of forces gives, changes along the motion. */
static void viscous_partials(const Mechanism *m, const Way *way, Partials *out) {
    for (int k = 0; k < KNOB_COUNT; k++) {
        Taylor along;
        rates_along(m, way, (Knob)k, 1, &along);
        out->by[k] = along.omega.c[1].slope;
    }
}

bool mechanism_alpha_partials(const Mechanism *m, Partials *out, Fault *fault) {
    *out = (Partials){.by = {0.0}};
    const Decision now = decision_of(m);
    if (!is_slip(now.mode)) return true;
    const Way way = way_from_here(m, now.slip);
    if (way.kind == FLOW_QUASISTATIC) {
        snprintf(fault->text, sizeof fault->text,
                 "alpha has no partial derivatives where angle follows torque: inertia.shaft, inertia.follower_mass, "
                 "inertia.follower, shaft.damping or a damper that acts in this direction must be > 0");
        return false;
    }
    if (way.kind == FLOW_VISCOUS) {
        viscous_partials(m, &way, out);
        return true;
    }
    const Balance balance = balance_from_here(m, &way);
    Partials residual;
    balance_partials(&way, &balance, &residual);
    for (int k = 0; k < KNOB_COUNT; k++)
        if (k != KNOB_ALPHA) out->by[k] = -residual.by[k] / residual.by[KNOB_ALPHA];
    return true;
}
