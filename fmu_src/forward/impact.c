#include "forward/impact.h"

#include "forward/decide.h"
#include "numerics/tolerances.h"

static void stand_still(Mechanism *m) {
    m->state.omega = sum_of(0.0);
}

/* ---- end stops ---- */

/* Is the bounce off the stop in `direction` too low to be seen in theta? The excursion at a speed omega against a
 * deceleration alpha is omega^2/(2 alpha). So a sequence of shrinking bounces ends after a finite number. */
static bool is_bounce_invisible(const Mechanism *m, int direction) {
    const double omega = m->state.omega.hi;
    const int slip = slip_after_impact(m, -direction);
    const double alpha = slip < 0 ? 0.0 : direction * candidate_of(m, slip).motion;
    return omega * omega < 2.0 * alpha * BOUNCE_INVISIBLE * largest_angle(&m->params);
}

void hit_stop(Mechanism *m, int direction) {
    State *state = &m->state;
    const double before = kinetic_energy(m);
    state->theta = sum_of(stop_ahead(&m->params.stop, direction));
    update_configuration(m);
    /* 0.0 - e omega, not -e omega: without restitution (e = 0) the speed at rest is then 0, not the negative zero. */
    state->omega = sum_of(0.0 - m->params.stop.restitution * state->omega.hi);
    state->energy_gained *= m->params.stop.restitution * m->params.stop.restitution;
    if (!has_inertia(&m->params)) stand_still(m);
    if (state->omega.hi != 0.0 && is_bounce_invisible(m, direction)) stand_still(m);
    if (m->params.ledger) sum_add(&state->ledger.heat_stop, before - kinetic_energy(m));
}

void handle_event(Mechanism *m, int direction, EventKind end) {
    if (end == EVENT_REST) stand_still(m);
    if (end == EVENT_STOP) hit_stop(m, direction);
}

/* ---- wedges ---- */

bool is_wedging(const Mechanism *m) {
    return has_inertia(&m->params) && m->state.omega.hi != 0.0 && !is_slip(m->state.mode);
}

void wedge_propose(const Mechanism *m, Segment *segment) {
    const Geometry *g = &m->configuration.geometry;
    const double energy = kinetic_energy(m);
    double share[2];
    for (int i = 0; i < 2; i++) share[i] = cam_heat(g, i) * g->dpsi_dtheta[i] / g->radius[i];
    const double sum = share[0] + share[1]; /* 0 where only a contact without friction slides */
    segment_begin(m, SEGMENT_WEDGE, segment);
    segment->books = energy != 0.0;
    segment->booking = (Booking){.work_in = 0.0};
    for (int i = 0; i < 2; i++) {
        const double heat = energy * (sum > 0.0 ? share[i] / sum : 0.5);
        segment->booking.heat_cam[i] = heat;
        if (g->friction[i] > 0.0) segment->booking.wear[i] = wear_per_sliding(&m->params, i) * heat / g->friction[i];
    }
}
