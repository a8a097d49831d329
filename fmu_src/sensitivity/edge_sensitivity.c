#include "sensitivity/edge_sensitivity.h"

#include <math.h>
#include <stddef.h>

#include "contact/contact.h"
#include "elementary/elementary.h"
#include "forward/candidate.h"
#include "forward/stick.h"
#include "numerics/tolerances.h"
#include "platform/attributes.h"

bool edge_slip(const Mechanism *m, int direction, SlipMode *slip) {
    const int side = stick_axial_load(m) < 0.0 ? -1 : 1; /* the band is mirrored */
    int flank[2];
    Transfer transfer;
    Geometry g = m->configuration.geometry;
    cam_set_load(&m->params, stick_axial_load(m), &g);
    if (!contact_edge(&g, side * direction, flank, &transfer)) return false;
    for (int i = 0; i < 2; i++) flank[i] *= side;
    *slip = slip_mode_from_here(m, slip_index(direction, flank));
    slip->regime = REGIME_RATE_INDEPENDENT;
    return true;
}

/* The residual Delta tau - P F_0 of the edge gives the derivatives: tau - E is the residual over Delta. */
Excess edge_excess(const SlipMode *slip, double theta) {
    Balance on_edge;
    Excess excess;
    balance_at(slip, theta, 0.0, 0.0, &on_edge);
    excess.rhs = on_edge.rhs;
    on_edge.tau -= on_edge.rhs.net;
    on_edge.omega = on_edge.damper = 0.0; /* no force depends on the speed */
    balance_partials(slip, &on_edge, &excess.by);
    const double delta = excess.by.by[KNOWN_TAU];
    for (int known = 0; known < KNOWN_COUNT; known++)
        excess.by.by[known] = known < KNOWN_TAU ? 0.0 : excess.by.by[known] / delta;
    return excess;
}

/* The change of theta along the edge, per unit of the known. */
static double give(const Excess *excess, int known) {
    return excess->by.by[known] / excess->rhs.by_theta;
}

void edge_give(const Mechanism *m, const Excess *excess, Variation *x) {
    const double slope = excess->rhs.by_theta;
    const bool held =
        fabs(excess->rhs.net) <= SENSITIVITY_ROUNDING * stick_torque_size(m, m->configuration.geometry.dz_dtheta);
    for (int known = x->first; known < x->end; known++)
        x->theta[known] = held && slope > 0.0 ? give(excess, known) : 0.0;
}

/* g = tau - E(theta) = 0 comes later by -dg/(dg/dt). */
void edge_delays(const Mechanism *m, int direction, double omega, const Variation *x, double delay[KNOWN_COUNT]) {
    SlipMode slip;
    const bool exists = edge_slip(m, direction, &slip);
    Excess excess = {.by = {.by = {0.0}}};
    if (exists) excess = edge_excess(&slip, m->state.theta.hi);
    const double *by = excess.by.by, slope = excess.rhs.by_theta;
    const double rate = m->inputs.tau[1] + by[KNOWN_F_EXT] * m->inputs.F_ext[1] - slope * omega;
    for (int known = x->first; known < x->end; known++)
        delay[known] = finite_or_zero(exists ? (slope * x->theta[known] - by[known]) / rate : 0.0);
}

/* Of a central difference of order 4, times 12. */
static const double offset[4] = {-2.0, -1.0, 1.0, 2.0}, weight[4] = {1.0, -8.0, 8.0, -1.0};

/* The change of the speed is the time derivative of the change of theta, by a central difference of order 4 along the
 * motion. F_ext varies at most by a small share of F_0. */
void edge_speed_give(const SlipMode *slip, double theta, double omega, Variation *x) {
    const Inputs *in = slip->inputs;
    const Excess now = edge_excess(slip, theta);
    Balance here;
    balance_at(slip, theta, 0.0, 0.0, &here);
    const double width = slip->piece->upper - slip->piece->lower;
    const double t = SENSITIVITY_DIFFERENCE * min_of(width / fabs(omega), fabs(here.force) / fabs(in->F_ext[1]));
    for (int known = x->first; known < x->end; known++) x->omega[known] = 0.0;
    for (int k = 0; k < 4; k++) {
        const Inputs there = {.tau = {in->tau[0]}, .F_ext = {in->F_ext[0] + in->F_ext[1] * offset[k] * t}};
        SlipMode moved = *slip;
        moved.inputs = &there;
        const Excess excess = edge_excess(&moved, theta + omega * offset[k] * t);
        for (int known = x->first; known < x->end; known++)
            x->omega[known] += weight[k] * (give(&excess, known) - give(&now, known)) / (12.0 * t);
    }
}
