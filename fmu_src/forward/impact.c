#include "forward/impact.h"

#include <float.h>
#include <math.h>

#include "forward/decide.h"
#include "numerics/tolerances.h"
#include "platform/attributes.h"

static void stand_still(Mechanism *m) {
    m->state.omega = sum_of(0.0);
}

/* ---- end stops ---- */

/* Is the bounce off the stop in `direction` too low to be seen in theta? The excursion at a speed omega against a
 * deceleration alpha is omega^2/(2 alpha). So a sequence of shrinking bounces ends after a finite number. */
static bool is_bounce_invisible(Mechanism *m, int direction) {
    const double omega = m->state.omega.hi;
    const int slip = slip_mode_of_moving(m, -direction);
    const double alpha = slip < 0 ? 0.0 : direction * candidate_of(m, slip).alpha;
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
    if (end == EVENT_LOST) m->state.searches = 1;
    if (end == EVENT_LET_GO) let_go(m, direction);
}

/* ---- jams ---- */

bool is_jammed(const Mechanism *m) {
    return has_inertia(&m->params) && m->state.omega.hi != 0.0 && !is_slip(m->state.mode);
}

/* dD/dt along the motion; D: the factor of alpha in the equation of motion. */
static double inertia_rate(const SlipMode *slip, const Balance *now, double *inertia) {
    SlipCoefficients storage;
    double z;
    const SlipCoefficients *k = slip_coefficients_at(slip, now->theta, now->omega, &storage, &z);
    const Dual d = slip_inertia(slip, k);
    const double by_omega = slip->friction_varies ? slip_inertia_with(slip, k, &k->dfactors_domega) : 0.0;
    *inertia = d.value;
    return d.slope * now->omega + by_omega * now->alpha;
}

/* The time to the zero of D is |D/(dD/dt)| to first order. In this time theta changes by less than its rounding, and the
 * speed by more than its rounding, since alpha grows without bound, but not to rest. Where D reaches zero with finite
 * reactions the speed does not change: the loads vanish there. */
COMPACT bool runs_into_jam(const Mechanism *m, const SlipMode *slip, const Balance *now) {
    if (slip->regime != REGIME_INERTIAL || slip->friction_is_loaded || !has_friction(&m->params)) return false;
    const double angle = JAM_ANGLE * largest_angle(&m->params), speed = slip->direction * now->omega;
    const double braking = -slip->direction * now->alpha;
    if (!(speed > 0.0 && braking * angle > JAM_SPEED * speed * speed)) return false;
    double inertia;
    const double rate = inertia_rate(slip, now, &inertia);
    const double left = inertia * rate < 0.0 ? fabs(inertia / rate) : INFINITY; /* s */
    return speed * left <= angle && braking * left > JAM_SPEED * speed && braking * left < speed;
}

COMPACT void jam_propose(const Mechanism *m, Segment *segment) {
    const Geometry *g = &m->configuration.geometry;
    const double energy = kinetic_energy(m);
    double share[2];
    for (int i = 0; i < 2; i++) share[i] = cam_heat(g, i) * g->dpsi_dtheta[i] / g->radius[i];
    const double sum = share[0] + share[1]; /* 0 where only a contact without friction slides */
    segment_begin(m, SEGMENT_JAM, segment);
    segment->books = energy != 0.0;
    segment->booking = (Booking){.work_in = 0.0};
    for (int i = 0; i < 2; i++) {
        const double heat = energy * (sum > 0.0 ? share[i] / sum : 0.5);
        segment->booking.heat_cam[i] = heat;
        if (g->friction[i] > 0.0) segment->booking.wear[i] = wear_per_sliding(&m->params, i) * heat / g->friction[i];
    }
}
