#include "forward/candidate.h"

#include <math.h>

#include "elementary/elementary.h"
#include "forward/stick.h"
#include "platform/attributes.h"

/* ---- slip modes from the present state ---- */

bool is_closed_form(const Mechanism *m) {
    return m->model.closed_form && inputs_within(&m->inputs, 1);
}

SlipStart slip_start_of(const Mechanism *m, const LinearSlipMode *linear) {
    return linear_slip_start(linear, &m->params, &m->configuration.geometry, m->state.theta.hi, m->state.omega.hi,
                             &m->inputs);
}

const LinearSlipMode *linear_slip_of(const Mechanism *m, int index, LinearSlipMode *storage) {
    if (m->model.linear_slips >> index & 1u) return &m->model.linear_slip[index];
    int flank[2];
    slip_flanks(index, flank);
    linear_slip_build(storage, &m->params, &m->configuration.geometry, slip_direction(index), flank);
    return storage;
}

void keep_linear_slip(Mechanism *m, int index) {
    (void)linear_slip_of(m, index, &m->model.linear_slip[index]);
    m->model.linear_slips |= 1u << index;
}

SlipMode slip_mode_from_here(const Mechanism *m, int index) {
    int flank[2];
    slip_flanks(index, flank);
    SlipMode slip = slip_mode_of(&m->params, &m->model.transmission, m->model.law, &m->inputs, m->state.theta.hi,
                                 slip_direction(index), flank);
    slip.work = m->work;
    return slip;
}

NOINLINE Balance balance_from_here(const Mechanism *m, const SlipMode *slip) {
    Balance now;
    balance_at(slip, m->state.theta.hi, m->state.omega.hi, 0.0, &now);
    const bool starts = slip->regime == REGIME_INERTIAL && m->state.omega.hi == 0.0;
    if (starts && slip->direction * now.alpha < 0.0) now.alpha = now.rhs.value = 0.0;
    if (slip->regime == REGIME_VISCOUS && slip->direction * now.omega < 0.0) now.omega = now.rhs.value = 0.0;
    return now;
}

/* ---- candidates ---- */

/* The rounding of theta changes x_i however small its terms are: through the spring, and through the acceleration of
 * the follower. The change, as a size of x_i. In closed form: */
static double linear_size_by_angle(const Mechanism *m, const LinearSlipMode *linear, int i) {
    const double spring = linear->transfer.axial[i] * m->params.spring.stiffness * m->configuration.geometry.dz_dtheta;
    const double by_alpha =
        linear->regime == REGIME_INERTIAL ? linear->acceleration[i] * linear->stiffness / linear->mass : 0.0;
    return CANDIDATE_ANGLE_ROUNDING * largest_angle(&m->params) * (fabs(spring) + fabs(by_alpha));
}

/* In grooves of any shape: */
static void sizes_by_angle(const Mechanism *m, const SlipMode *slip, const Balance *now, double size[2]) {
    BalanceChange by_angle = {.theta = 1.0};
    if (slip->regime == REGIME_INERTIAL) by_angle.alpha = now->rhs.by_theta;
    else if (slip->regime == REGIME_VISCOUS) by_angle.omega = now->rhs.by_theta;
    balance_contact_changes(slip, now, &by_angle, size);
    for (int i = 0; i < 2; i++) size[i] = CANDIDATE_ANGLE_ROUNDING * largest_angle(&m->params) * fabs(size[i]);
}

static Candidate closed_form_candidate(const Mechanism *m, const LinearSlipMode *linear) {
    if (!linear->possible) return (Candidate){.possible = false};
    const SlipStart start = slip_start_of(m, linear);
    const LinearMotion now = linear_slip_motion_at_start(linear, &start);
    const double tie = stick_tie(m) * stick_torque_size(m, linear->transfer.rho);
    const bool inertial = linear->regime == REGIME_INERTIAL,
               rate_independent = linear->regime == REGIME_RATE_INDEPENDENT;
    const double net = linear_slip_net_torque(linear, &start);
    const double resistance = inertial ? linear->mass : linear->damping;
    const double free = inertial ? net - linear->damping * start.omega : net; /* start.alpha keeps to the direction */
    Candidate c = {
        .possible = true,
        .regime = linear->regime,
        .motion = rate_independent ? start.omega : free / resistance,
        .net = net,
        .rounding = rate_independent ? tie : tie / resistance,
        .stiffness = linear->stiffness,
        .axial = {linear->transfer.axial[0], linear->transfer.axial[1]},
    };
    for (int i = 0; has_friction(&m->params) && i < 2; i++) {
        c.x[i] = linear_slip_contact(linear, &m->params, &m->configuration.geometry, &start, &now, i).value;
        c.size[i] = linear_slip_contact_size(linear, &m->params, &m->configuration.geometry, &start, i) +
                    linear_size_by_angle(m, linear, i);
    }
    return c;
}

/* N.m: what the stick band calls a tie, and the two differences' own rounding. */
static double edge_rounding(const Mechanism *m, int direction) {
    const double F_0 = stick_axial_load(m);
    const BandFactors edges = stick_edges(m, F_0);
    const double factor = direction > 0 ? edges.load : edges.release;
    const double tie =
        stick_tie(m) * stick_torque_size(m, isfinite(factor) ? factor : m->configuration.geometry.dz_dtheta);
    return CANDIDATE_TIES * tie;
}

static Candidate general_candidate(const Mechanism *m, int index) {
    const SlipMode slip = slip_mode_from_here(m, index);
    Balance now;
    balance_at(&slip, m->state.theta.hi, m->state.omega.hi, 0.0, &now);
    if (!now.rhs.possible || !isfinite(now.rhs.value)) return (Candidate){.possible = false};
    const bool rate_independent = slip.regime == REGIME_RATE_INDEPENDENT;
    Candidate c = {
        .possible = true,
        .regime = slip.regime,
        .motion = now.rhs.value,
        .net = now.rhs.net,
        .rounding = rate_independent ? edge_rounding(m, slip.direction) : CANDIDATE_ROUNDING * now.rhs.size,
        .stiffness = now.rhs.by_theta,
        .axial = {now.axial[0], now.axial[1]},
    };
    if (!has_friction(&m->params)) return c;
    double by_angle[2];
    balance_contact_sizes(&slip, &now, c.size);
    sizes_by_angle(m, &slip, &now, by_angle);
    for (int i = 0; i < 2; i++) {
        c.x[i] = now.x[i];
        c.size[i] = CANDIDATE_COARSE * c.size[i] + by_angle[i];
    }
    c.possible = isfinite(c.x[0]) && isfinite(c.x[1]);
    return c;
}

Candidate candidate_of(const Mechanism *m, int index) {
    LinearSlipMode storage;
    return is_closed_form(m) ? closed_form_candidate(m, linear_slip_of(m, index, &storage))
                             : general_candidate(m, index);
}
