#include "sensitivity.h"

#include <stdio.h>

#include "decide.h"

/* z(theta), v = z' omega */
void mechanism_axial_partials(const Mechanism *m, int order, Partials *out) {
    const double lift = m->place.geometry.lift;
    *out = (Partials){.by = {0.0}};
    if (order == 0) {
        out->by[KNOB_THETA] = lift;
        return;
    }
    out->by[KNOB_THETA] = m->place.lift_rate * m->state.omega.hi;
    out->by[KNOB_OMEGA] = lift;
}

bool mechanism_alpha_partials(const Mechanism *m, Partials *out, Fault *fault) {
    *out = (Partials){.by = {0.0}};
    if (!has_inertia(&m->params)) {
        snprintf(fault->text, sizeof fault->text,
                 "alpha has partial derivatives with inertia only: inertia.shaft, inertia.follower_mass or "
                 "inertia.follower must be > 0");
        return false;
    }
    const Decision now = decision_of(m);
    if (!is_slip(now.mode)) return true;
    const Way way = way_from_here(m, now.slip);
    const Balance balance = balance_from_here(m, &way);
    Partials residual;
    balance_partials(&way, &balance, &residual);
    for (int k = 0; k < KNOB_COUNT; k++)
        if (k != KNOB_ALPHA) out->by[k] = -residual.by[k] / residual.by[KNOB_ALPHA];
    return true;
}
