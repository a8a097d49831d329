#include "forward/decide.h"

#include <float.h>
#include <math.h>

#include "closed_form/linear_event.h"
#include "collocation/radau_step.h"
#include "forward/stick.h"

SlipStart slip_start_of(const Mechanism *m, const LinearSlipMode *slip) {
    return linear_slip_start(slip, &m->params, &m->configuration.geometry, m->state.theta.hi, m->state.omega.hi,
                             &m->inputs);
}

bool is_closed_form(const Mechanism *m) {
    return m->model.closed_form && inputs_within(&m->inputs, 1);
}

/* ---- looking along a way to slip ---- */

SlipMode present_slip_mode(const Mechanism *m, int index) {
    int flank[2];
    slip_flanks(index, flank);
    return slip_mode_of(&m->params, &m->model.transmission, &m->inputs, m->state.theta.hi, slip_direction(index),
                        flank);
}

Balance balance_from_here(const Mechanism *m, const SlipMode *slip) {
    Balance now;
    balance_at(slip, m->state.theta.hi, m->state.omega.hi, 0.0, &now);
    const bool starts = slip->regime == REGIME_INERTIAL && m->state.omega.hi == 0.0;
    if (starts && slip->direction * now.alpha < 0.0) now.alpha = now.rhs.value = 0.0;
    if (slip->regime == REGIME_VISCOUS && slip->direction * now.omega < 0.0) now.omega = now.rhs.value = 0.0;
    return now;
}

/* Without inertia a locked contact can turn the damper's resistance round: then less torque drives it faster. */
static bool is_backward(const LinearSlipMode *slip) {
    return slip->regime == REGIME_VISCOUS && slip->damping < 0.0;
}

/* Without inertia and damping, on the edge of the band: unstable if the way on asks for less and less torque. */
static bool is_stable(const LinearSlipMode *slip) {
    return slip->regime == REGIME_RATE_INDEPENDENT ? slip->stiffness > 0.0 : !is_backward(slip);
}

const LinearSlipMode *linear_slip_of(const Mechanism *m, int index, LinearSlipMode *room) {
    if (m->model.linear_slips >> index & 1u) return &m->model.linear_slip[index];
    int flank[2];
    slip_flanks(index, flank);
    linear_slip_build(room, &m->params, &m->configuration.geometry, slip_direction(index), flank);
    return room;
}

static Candidate closed_form_candidate(const Mechanism *m, const LinearSlipMode *slip) {
    if (!slip->possible) return (Candidate){.possible = false};
    const SlipStart l = slip_start_of(m, slip);
    const LinearMotion start = linear_slip_motion_at_start(slip, &l);
    Candidate candidate = {
        .possible = true,
        .regime = slip->regime,
        .stable = is_stable(slip),
        .net = is_backward(slip) ? -linear_slip_net_torque(slip, &l) : linear_slip_net_torque(slip, &l),
        .net_size = stick_torque_size(m, slip->transfer.rho),
        .tie = stick_tie(m),
        .omega = l.omega,
        .alpha = l.alpha,
        .jerk = start.jerk,
        .stiffness = slip->stiffness,
    };
    for (int i = 0; has_friction(&m->params) && i < 2; i++) {
        candidate.axial[i] = slip->transfer.axial[i] * m->params.spring.stiffness;
        candidate.contact[i] = linear_slip_contact(slip, &m->params, &m->configuration.geometry, &l, &start, i);
        candidate.size[i] = linear_slip_contact_size(slip, &m->params, &m->configuration.geometry, &l, i);
    }
    return candidate;
}

/* Where neither x_i nor its rate tells a flank, x_i a little later does: inputs can begin as slowly as t^3. Kept in
 * place of the second derivative. */
static void extrapolate_contacts(const SlipMode *slip, const Balance *now, Candidate *candidate) {
    const double SHARE = 1e-3; /* of the motion's time scale, and at most as many seconds */
    const double dt = SHARE * fmin(1.0, radau_step_time_scale(slip, now));
    const double omega = candidate->omega + dt * (candidate->alpha + dt / 2.0 * candidate->jerk);
    const double theta =
        now->theta + dt * (candidate->omega + dt / 2.0 * (candidate->alpha + dt / 3.0 * candidate->jerk));
    Balance later;
    balance_at(slip, theta, omega, dt, &later);
    for (int i = 0; i < 2; i++) {
        candidate->contact[i].curvature = later.x[i];
        candidate->size[i].curvature = candidate->size[i].value;
    }
}

static bool is_undecided(const Candidate *candidate, int i) {
    return fabs(candidate->contact[i].value) <= NO_REACTION * candidate->size[i].value &&
           fabs(candidate->contact[i].rate) <= NO_REACTION * candidate->size[i].rate;
}

/* A leap ends on a flank change to its own rounding, which is some times that of one balance. */
static const double COARSE = 10.0;

/* However small a load is, theta is known to its rounding only: what that makes of x_i, as a size. */
static double noise_of_angle(const Mechanism *m, double by_angle) {
    static const double ROUNDING = 4.0 * DBL_EPSILON / NO_REACTION;
    return ROUNDING * largest_angle(&m->params) * fabs(by_angle);
}

static Candidate general_candidate(const Mechanism *m, int index) {
    const SlipMode slip = present_slip_mode(m, index);
    const Balance now = balance_from_here(m, &slip);
    if (!now.rhs.possible || !isfinite(now.rhs.value)) return (Candidate){.possible = false};
    BalanceRates rates;
    balance_rates(&slip, &now, 0.0, &rates);
    const bool inertial = slip.regime == REGIME_INERTIAL;
    Candidate candidate = {
        .possible = true,
        .regime = slip.regime,
        .stable = now.rhs.stable,
        .net = slip.regime == REGIME_VISCOUS && !now.rhs.stable ? -rates.net : rates.net,
        .net_size = rates.net_size,
        .tie = stick_tie(m),
        .omega = now.omega,
        .alpha = inertial ? now.alpha : rates.rhs,
        .jerk = inertial ? rates.rhs : 0.0,
        .stiffness = now.rhs.by_theta,
    };
    const double spring = spring_rate(&m->params.spring, m->configuration.z);
    for (int i = 0; i < 2; i++) {
        candidate.axial[i] = now.axial[i] * spring;
        candidate.contact[i] = (ContactLoad){.value = now.x[i], .rate = rates.contact[i]};
        candidate.size[i] = (ContactLoad){.value = COARSE * rates.size[i], .rate = COARSE * rates.rate_size[i]};
        if (slip.regime != REGIME_RATE_INDEPENDENT)
            candidate.size[i].value += noise_of_angle(m, candidate.axial[i] * now.dz_dtheta);
    }
    if (is_undecided(&candidate, 0) || is_undecided(&candidate, 1)) extrapolate_contacts(&slip, &now, &candidate);
    return candidate;
}

/* See decide() for `built`. */
static Candidate candidate_with(const Mechanism *m, int index, LinearSlipMode *built) {
    return is_closed_form(m) ? closed_form_candidate(m, linear_slip_of(m, index, built)) : general_candidate(m, index);
}

Candidate candidate_of(const Mechanism *m, int index) {
    LinearSlipMode room;
    return candidate_with(m, index, &room);
}

/* ---- does a way to slip agree with itself? ---- */

/* From rest the net torque must point the way of the slip, or vanish (its rate then decides). */
static bool starts(const Candidate *candidate, int direction) {
    return direction * candidate->net >= -candidate->tie * candidate->net_size;
}

bool decide_jump(const Candidate *candidate, int direction) {
    return candidate->regime == REGIME_RATE_INDEPENDENT &&
           direction * candidate->net > candidate->tie * candidate->net_size;
}

/* Is x_i on the flank that the slip assumes, or about to be? Where it is zero, its rate tells, and then the
 * rate of that. Zero throughout (no load at all) suits either flank. */
static bool flank_agrees(const Candidate *candidate, int direction, int flank, int i) {
    const ContactLoad *c = &candidate->contact[i], *size = &candidate->size[i];
    if (fabs(c->value) > NO_REACTION * size->value) return flank * c->value > 0.0;
    if (decide_jump(candidate, direction)) /* only the spring's force changes, by direction times its stiffness */
        return flank * direction * candidate->axial[i] >= 0.0;
    if (fabs(c->rate) > NO_REACTION * size->rate) return flank * c->rate > 0.0;
    return fabs(c->curvature) <= NO_REACTION * size->curvature || flank * c->curvature > 0.0;
}

/* Quasi-static slip that does not begin with a jump follows the moving edge of the band, in its own direction. */
static bool follows(const Candidate *candidate, int direction) {
    if (candidate->regime != REGIME_RATE_INDEPENDENT || !(candidate->stiffness > 0.0) ||
        decide_jump(candidate, direction))
        return true;
    return direction * candidate->omega > 0.0;
}

static bool agrees(const Mechanism *m, int index, const Candidate *candidate, bool at_rest) {
    const int direction = slip_direction(index);
    int flank[2];
    slip_flanks(index, flank);
    if (!candidate->possible) return false;
    if (at_rest && !starts(candidate, direction)) return false;
    if (!follows(candidate, direction)) return false;
    if (!has_friction(&m->params)) return true;
    return flank_agrees(candidate, direction, flank[0], 0) && flank_agrees(candidate, direction, flank[1], 1);
}

/* Sign of the axial load when motion in `direction` begins or goes on. */
static int load_sign(const Mechanism *m, int direction) {
    const double v = has_inertia(&m->params) ? m->configuration.geometry.dz_dtheta * m->state.omega.hi : 0.0;
    const double force = stick_axial_load(m) + damper_force(&m->params.damper, direction, v);
    if (fabs(force) > stick_tie(m) * stick_axial_size(m)) return sign_of(force);
    const int coming = sign_of(m->inputs.F_ext[1]);
    return coming != 0 ? coming : (m->params.spring.stiffness != 0.0 ? direction : 1);
}

int decide_slip(const Mechanism *m, int direction, bool at_rest, LinearSlipMode *built) {
    const int s = load_sign(m, direction);
    const int flanks[4][2] = {{s, s}, {s, -s}, {-s, s}, {-s, -s}};
    int unstable = -1;
    for (int k = 0; k < 4; k++) {
        const int index = slip_index(direction, flanks[k]);
        const Candidate candidate = candidate_with(m, index, built);
        if (!agrees(m, index, &candidate, at_rest)) continue;
        if (candidate.stable) return index;
        if (unstable < 0) unstable = index;
    }
    return unstable;
}

static Mode slip_mode(int direction) {
    return direction > 0 ? MODE_LOADING : MODE_RELEASING;
}

static Decision decide_at_rest(const Mechanism *m, LinearSlipMode *built) {
    const int direction = stick_pressed(m);
    if (direction == 0) return (Decision){.mode = stick_mode(m), .slip_index = -1};
    if (direction > 0 && m->state.theta.hi >= m->params.stop.upper)
        return (Decision){.mode = MODE_UPPER_STOP, .slip_index = -1};
    if (direction < 0 && m->state.theta.hi <= m->params.stop.lower)
        return (Decision){.mode = MODE_LOWER_STOP, .slip_index = -1};
    const int slip = decide_slip(m, direction, true, built);
    if (slip < 0 && stick_is_on_edge(m, direction)) return (Decision){.mode = MODE_STICK, .slip_index = -1};
    return (Decision){.mode = slip < 0 ? MODE_WEDGED : slip_mode(direction), .slip_index = slip};
}

/* While slipping the flanks stay as they are as long as they agree. */
static Decision decide_moving(const Mechanism *m, LinearSlipMode *built) {
    const int direction = sign_of(m->state.omega.hi);
    const Mode mode = slip_mode(direction);
    const int present = slip_index(direction, m->state.flank);
    const Candidate candidate = candidate_with(m, present, built);
    if (m->state.mode == mode && agrees(m, present, &candidate, false))
        return (Decision){.mode = mode, .slip_index = present};
    const int slip = decide_slip(m, direction, false, built);
    return (Decision){.mode = slip < 0 ? MODE_WEDGED : mode, .slip_index = slip};
}

Decision decide(const Mechanism *m, LinearSlipMode *built) {
    return has_inertia(&m->params) && m->state.omega.hi != 0.0 ? decide_moving(m, built) : decide_at_rest(m, built);
}

Decision decision_of(const Mechanism *m) {
    LinearSlipMode room;
    if (!m->continuous) return decide(m, &room);
    const Mode mode = m->state.mode;
    const int direction = mode == MODE_LOADING ? 1 : -1;
    return (Decision){.mode = mode, .slip_index = is_slip(mode) ? slip_index(direction, m->state.flank) : -1};
}
