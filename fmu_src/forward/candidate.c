#include "forward/candidate.h"

#include <float.h>
#include <math.h>

#include "collocation/radau_step.h"
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

SlipMode slip_mode_from_here(const Mechanism *m, int index) {
    int flank[2];
    slip_flanks(index, flank);
    SlipMode slip = slip_mode_of(&m->params, &m->model.transmission, m->model.law, &m->inputs, m->state.theta.hi,
                                 slip_direction(index), flank);
    slip.searches = index >= SLIP_SEARCHES;
    slip.work = m->work;
    return slip;
}

NOINLINE Balance balance_from_here(const Mechanism *m, const SlipMode *slip) {
    Balance now;
    balance_at(slip, m->state.theta.hi, m->state.omega.hi, 0.0, &now);
    const bool starts = slip->regime == REGIME_INERTIAL && m->state.omega.hi == 0.0;
    /* Reactions at which more torque gives less acceleration can balance a motion that begins backwards. */
    if (starts && slip->friction_is_loaded && !now.rhs.stable)
        now.rhs.possible &= slip->direction * now.alpha >= -CANDIDATE_BACKWARD * now.rhs.size;
    if (starts && slip->direction * now.alpha < 0.0) now.alpha = now.rhs.value = 0.0;
    /* Where friction grows with the speed, no speed in this direction may balance the forces. */
    if (slip->friction_varies && slip->regime == REGIME_VISCOUS)
        now.rhs.possible &= slip->direction * now.omega >= -REACTION_ZERO_SHARE * now.rhs.size;
    if (slip->regime == REGIME_VISCOUS && slip->direction * now.omega < 0.0) now.omega = now.rhs.value = 0.0;
    return now;
}

/* ---- in closed form ---- */

/* Without inertia a locked contact can reverse the damper's resistance, B < 0: then less torque means more speed. */
static bool is_backward(const LinearSlipMode *linear) {
    return linear->regime == REGIME_VISCOUS && linear->damping < 0.0;
}

/* Without inertia and damping, on the edge of the stick band: unstable if the edge falls along the motion. With inertia:
 * unstable if the reactions do not settle between slightly elastic flanks. */
static bool is_stable(const LinearSlipMode *linear) {
    if (linear->regime == REGIME_INERTIAL) return linear->transfer.settles;
    return linear->regime == REGIME_RATE_INDEPENDENT ? linear->stiffness > 0.0 : !is_backward(linear);
}

static Candidate closed_form_candidate(const Mechanism *m, const LinearSlipMode *linear) {
    if (!linear->possible) return (Candidate){.possible = false};
    const SlipStart l = slip_start_of(m, linear);
    const LinearMotion start = linear_slip_motion_at_start(linear, &l);
    Candidate candidate = {
        .possible = true,
        .regime = linear->regime,
        .stable = is_stable(linear),
        .single = true,
        .net = is_backward(linear) ? -linear_slip_net_torque(linear, &l) : linear_slip_net_torque(linear, &l),
        .net_size = stick_torque_size(m, linear->transfer.rho),
        .tie = stick_tie(m),
        .omega = l.omega,
        .alpha = l.alpha,
        .jerk = start.jerk,
        .stiffness = linear->stiffness,
    };
    const Geometry *g = &m->configuration.geometry;
    for (int i = 0; has_friction(&m->params) && i < 2; i++) {
        candidate.axial[i] = linear->transfer.axial[i] * m->params.spring.stiffness;
        candidate.contact[i] = linear_slip_contact(linear, &m->params, g, &l, &start, i);
        candidate.size[i] = linear_slip_contact_size(linear, &m->params, g, &l, i);
        candidate.rounding[i] = candidate.size[i].value;
    }
    return candidate;
}

/* ---- in grooves of any shape ---- */

/* rad, a share of the width of the piece of the grooves. */
static double angle_ahead(const SlipMode *slip) {
    return 2.0 * CANDIDATE_LOOK_AHEAD / slip->piece->scale;
}

/* s, in which neither the motion nor the grooves change much. At rest on a dwell without load nothing but the torque sets
 * the motion: the time scale is infinite, and the angle alone limits the look ahead. */
static double look_ahead(const SlipMode *slip, const Balance *now, const Candidate *candidate) {
    const double angle = angle_ahead(slip);
    const double by_alpha = sqrt(2.0 * angle / fabs(candidate->alpha));
    const double by_jerk = elementary_cbrt(6.0 * angle / fabs(candidate->jerk));
    const double by_time = CANDIDATE_LOOK_AHEAD * min_of(1.0, radau_step_time_scale(slip, now));
    return min_of(min_of(by_time, angle / fabs(candidate->omega)), min_of(by_alpha, by_jerk));
}

/* The balance after dt at the angle theta. False beyond the piece of the transmission, whose polynomials end there. */
static bool balance_after(const SlipMode *slip, double theta, double omega, double dt, Balance *later) {
    if (!(theta >= slip->piece->lower && theta <= slip->piece->upper)) return false;
    balance_at(slip, theta, omega, dt, later);
    return true;
}

bool search_goes_on(const Mechanism *m, int index) {
    if (m->state.omega.hi == 0.0) return false;
    const SlipMode slip = slip_mode_from_here(m, index);
    const Balance now = balance_from_here(m, &slip);
    const double dt = LOST_AHEAD * min_of(1.0, radau_step_time_scale(&slip, &now));
    Balance later;
    if (!balance_after(&slip, now.theta + dt * now.omega, now.omega + dt * now.alpha, dt, &later)) return false;
    bool goes_on = later.rhs.possible;
    for (int i = 0; i < 2; i++) goes_on &= fabs(later.x[i] - now.x[i]) <= LOST_CHANGE * fabs(now.x[i]);
    return goes_on;
}

/* Under friction that varies with the speed a contact can lock before: behind that place the flanks are others. */
COMPACT static bool has_locked(const SlipMode *slip, const Balance *now, const Balance *later) {
    return slip->friction_varies && (now->axial[0] * later->axial[0] < 0.0 || now->axial[1] * later->axial[1] < 0.0);
}

/* x_i after dt, as far as the present alpha and jerk tell; `steady`: alpha alone, under the present inputs. What the acceleration
 * then has beyond them has grown at least like t^2: the speed gains a third of it, which a damper's load follows, and the
 * angle a twelfth. */
COMPACT static bool contacts_after(const SlipMode *slip, const Balance *now, const Candidate *candidate, double dt,
                                   bool steady, double x[2]) {
    const double jerk = steady ? 0.0 : candidate->jerk, t = steady ? 0.0 : dt;
    const double omega = candidate->omega + dt * (candidate->alpha + dt / 2.0 * jerk);
    const double theta = now->theta + dt * (candidate->omega + dt / 2.0 * (candidate->alpha + dt / 3.0 * jerk));
    Balance later;
    if (!balance_after(slip, theta, omega, t, &later)) return false;
    if (slip->regime == REGIME_INERTIAL) {
        const double gained = dt * (later.alpha - (candidate->alpha + dt * jerk));
        if (!balance_after(slip, theta + dt / 12.0 * gained, omega + gained / 3.0, t, &later)) return false;
    }
    for (int i = 0; i < 2; i++) x[i] = later.x[i];
    return isfinite(x[0]) && isfinite(x[1]) && !has_locked(slip, now, &later);
}

static bool is_visible(double x, double size) {
    return fabs(x) > REACTION_ZERO_SHARE * size;
}

static bool is_undecided(const Candidate *candidate, int i) {
    return !is_visible(candidate->contact[i].value, candidate->size[i].value);
}

/* A rate that cannot lift x_i out of its rounding within dt does not tell the flank, if x_i has left on the other side
 * by then. */
COMPACT static void drop_faint_rate(Candidate *candidate, int i, double dt) {
    ContactLoad *c = &candidate->contact[i];
    const bool against = c->rate * c->second < 0.0;
    if (against && !is_visible(c->rate * dt, candidate->size[i].value)) c->rate = 0.0;
}

typedef enum { LOOK_BEYOND, LOOK_DARK, LOOK_VISIBLE } Look; /* beyond: of the piece of the grooves, or of a lock */

/* Each x_i that exceeds its rounding after dt takes the place of the second derivative, and dt that of visible_at[i]. A
 * steady look leaves what a shorter look has seen. */
COMPACT static Look look_after(const SlipMode *slip, const Balance *now, double dt, bool steady, Candidate *candidate,
                               double visible_at[2]) {
    double x[2];
    if (!contacts_after(slip, now, candidate, dt, steady, x)) return LOOK_BEYOND;
    Look look = LOOK_DARK;
    for (int i = 0; i < 2; i++) {
        /* The terms of x_i grow as well, and their rounding with them. */
        const double size = candidate->size[i].value + dt * candidate->size[i].rate;
        if ((steady && visible_at[i] != 0.0) || !is_visible(x[i], CANDIDATE_COARSE * size)) continue;
        look = LOOK_VISIBLE;
        candidate->contact[i].second = x[i];
        visible_at[i] = dt;
    }
    return look;
}

/* On a groove that is nearly level, a motion from rest shows no x_i within the look ahead. Then the motion under the present
 * inputs decides: x_i at the first of some longer times at which one exceeds its rounding, as long as neither the inputs nor
 * the damping change the acceleration. */
COMPACT static void look_farther(const SlipMode *slip, const Balance *now, double dt, Candidate *candidate,
                                 double visible_at[2]) {
    const double alpha = candidate->alpha;
    if (alpha == 0.0) return;
    const double by_alpha = sqrt(2.0 * angle_ahead(slip) / fabs(alpha));
    const double by_time = CANDIDATE_LOOK_FARTHER * radau_step_time_scale(slip, now);
    const double farthest = min_of(min_of(by_alpha, by_time), fabs(alpha / candidate->jerk));
    for (int n = 0; n < CANDIDATE_LOOKS && dt < farthest; n++) {
        bool hides = false;
        for (int i = 0; i < 2; i++) hides |= visible_at[i] == 0.0 && is_undecided(candidate, i);
        dt = min_of(dt / CANDIDATE_LOOK_SHORTER, farthest);
        if (!hides || look_after(slip, now, dt, true, candidate, visible_at) == LOOK_BEYOND) return;
    }
}

/* Inputs can begin as slowly as t^3, and loads change their sign soon after. Where neither x_i nor its rate tells the
 * flank, the value of x_i a little later decides, at the shortest of some times at which x_i exceeds its rounding. This
 * value takes the place of the second derivative. */
COMPACT static void extrapolate_contacts(const SlipMode *slip, const Balance *now, Candidate *candidate) {
    const double first = look_ahead(slip, now, candidate);
    double dt = first, visible_at[2] = {0.0, 0.0};
    Look look = LOOK_VISIBLE;
    for (int n = 0; n < CANDIDATE_LOOKS && look != LOOK_DARK; n++, dt *= CANDIDATE_LOOK_SHORTER)
        look = look_after(slip, now, dt, false, candidate, visible_at);
    if (slip->regime == REGIME_INERTIAL && candidate->omega == 0.0)
        look_farther(slip, now, first, candidate, visible_at);
    for (int i = 0; i < 2; i++) {
        drop_faint_rate(candidate, i, visible_at[i]);
        candidate->unseen[i] &= visible_at[i] == 0.0;
        candidate->size[i].second = candidate->size[i].value;
    }
}

/* The rounding of theta changes x_i however small the load is: through the spring, and where the grooves bend sharply
 * through the follower's acceleration. The change, as a size of x_i. */
static double noise_of_angle(const Mechanism *m, const SlipMode *slip, const Balance *now, int i) {
    BalanceChange by_angle = {.theta = 1.0};
    if (slip->regime == REGIME_INERTIAL) by_angle.alpha = now->rhs.by_theta;
    else by_angle.omega = now->rhs.by_theta;
    const double change = balance_contact_change(slip, now, i, &by_angle);
    return CANDIDATE_ANGLE_ROUNDING * largest_angle(&m->params) * fabs(change);
}

/* s, in which a rate must change a reaction by more than its rounding to count. Beyond the present piece of the grooves
 * another rate holds: where a groove becomes level, a locked contact loses its load without changing its flank. */
static double steady_time(const SlipMode *slip, const Balance *now) {
    const double left = slip->direction > 0 ? slip->piece->upper - now->theta : now->theta - slip->piece->lower;
    return min_of(CANDIDATE_STEADY, max_of(left, DBL_MIN) / fabs(now->omega));
}

/* Both x_i are rounding, while each is large per axial load, since Delta is zero to rounding. */
COMPACT static bool reactions_are_quotients_of_zeros(const SlipMode *slip, const Balance *now) {
    BalanceRates rates;
    balance_rates(slip, now, 0.0, &rates);
    for (int i = 0; i < 2; i++) {
        if (is_visible(now->x[i], CANDIDATE_COARSE_VARYING * rates.size[i])) return false;
        if (!(fabs(now->axial[i]) * sqrt(now->length2[i]) > CANDIDATE_AT_JAM)) return false;
    }
    return now->rhs.possible;
}

COMPACT bool is_quotient_of_zeros(const Mechanism *m, int index) {
    const SlipMode slip = slip_mode_from_here(m, index);
    if (slip.regime != REGIME_INERTIAL || !slip.friction_varies || slip.friction_is_loaded) return false;
    const Balance now = balance_from_here(m, &slip);
    return fabs(now.rhs.value) <= REACTION_ZERO_SHARE * CANDIDATE_COARSE_VARYING * now.rhs.size ||
           reactions_are_quotients_of_zeros(&slip, &now);
}

/* Is the effective inertia D of the pair of flanks zero within the rounding of theta? No motion begins from rest there: the
 * kinetic energy, the integral of N/D over theta, would be infinite beside D = 0. */
COMPACT static bool rests_at_pole(const Mechanism *m, const SlipMode *slip) {
    if (slip->regime != REGIME_INERTIAL || slip->friction_is_loaded || m->state.omega.hi != 0.0) return false;
    const double rounding = REACTION_ZERO_SHARE * CANDIDATE_ANGLE_ROUNDING * largest_angle(&m->params);
    for (int side = -1; side <= 1; side += 2)
        if (!balance_rhs(slip, m->state.theta.hi + side * rounding, 0.0, 0.0).possible) return true;
    return false;
}

/* Under friction that depends on the load the reactions are those of the acceleration, and so are the coefficients of
 * friction. The edge for these coefficients is not that of rest: beyond its tie, the torque has the sign of the acceleration.
 * balance_from_here() has set an acceleration against the direction to zero. */
static double net_along_motion(const SlipMode *slip, const Balance *now, const Candidate *candidate) {
    const double size = fabs(candidate->net);
    if (size <= candidate->tie * candidate->net_size) return candidate->net;
    return (now->alpha == 0.0 ? -slip->direction : slip->direction) * size;
}

static Candidate general_candidate(const Mechanism *m, int index) {
    const SlipMode slip = slip_mode_from_here(m, index);
    const Balance now = balance_from_here(m, &slip);
    if (!now.rhs.possible || !isfinite(now.rhs.value)) return (Candidate){.possible = false};
    BalanceRates rates;
    balance_rates(&slip, &now, 0.0, &rates);
    const bool inertial = slip.regime == REGIME_INERTIAL;
    Candidate candidate = {
        .possible = true,
        .regime = slip.regime,
        .stable = inertial ? now.rhs.settles : now.rhs.stable,
        .single = !inertial || now.rhs.single,
        .recedes = inertial && !now.rhs.stable,
        .net = slip.regime == REGIME_VISCOUS && !now.rhs.stable ? -rates.net : rates.net,
        .net_size = rates.net_size,
        .tie = stick_tie(m),
        .omega = now.omega,
        .alpha = inertial ? now.alpha : rates.rhs,
        .jerk = inertial ? rates.rhs : 0.0,
        .stiffness = now.rhs.by_theta,
    };
    if (inertial && slip.friction_is_loaded) candidate.net = net_along_motion(&slip, &now, &candidate);
    const double spring = spring_rate(&m->params.spring, m->configuration.z);
    const double steady = steady_time(&slip, &now);
    const bool may_let_go = slip.friction_varies && m->state.omega.hi != 0.0; /* at a jam, see tolerances.h */
    const double coarse = may_let_go ? CANDIDATE_COARSE_VARYING : CANDIDATE_COARSE;
    const double load = fabs(now.force) + fabs(now.F_ext) + fabs(now.damper); /* N */
    for (int i = 0; i < 2; i++) {
        candidate.axial[i] = now.axial[i] * spring;
        candidate.contact[i] = (ContactLoad){.value = now.x[i], .rate = rates.contact[i]};
        candidate.size[i] =
            (ContactLoad){.value = coarse * rates.size[i], .rate = CANDIDATE_COARSE * rates.rate_size[i]};
        const double noise = slip.regime != REGIME_RATE_INDEPENDENT ? noise_of_angle(m, &slip, &now, i) : 0.0;
        candidate.size[i].value += noise;
        /* The balance sets a reaction below a rounding of the load to zero (loaded_contacts.c). */
        if (slip.friction_is_loaded)
            candidate.size[i].value = max_of(candidate.size[i].value, coarse * load / slip.params->cam[i].radius);
        candidate.size[i].rate += candidate.size[i].value / steady;
        candidate.rounding[i] = CANDIDATE_COARSE * rates.size[i] + noise;
        candidate.unseen[i] =
            m->load_ahead == 0 && !slip.friction_is_loaded && !is_visible(now.x[i], coarse * rates.size[i]);
        candidate.ahead[i] = m->load_ahead != 0 ? m->load_ahead * now.axial[i] : m->crossed[i];
    }
    if (is_undecided(&candidate, 0) || is_undecided(&candidate, 1)) {
        if (rests_at_pole(m, &slip)) return (Candidate){.possible = false};
        extrapolate_contacts(&slip, &now, &candidate);
    }
    return candidate;
}

Candidate candidate_building(const Mechanism *m, int index, LinearSlipMode *built) {
    return is_closed_form(m) ? closed_form_candidate(m, linear_slip_of(m, index, built)) : general_candidate(m, index);
}

Candidate candidate_of(const Mechanism *m, int index) {
    LinearSlipMode storage;
    return candidate_building(m, index, &storage);
}
