#include "forward/collocation_slip.h"

#include <float.h>
#include <math.h>

#include "collocation/lobatto_step.h"
#include "collocation/radau_step.h"
#include "elementary/elementary.h"
#include "forward/candidate.h"
#include "forward/jump.h"
#include "forward/rest.h"
#include "forward/stick.h"
#include "numerics/sign.h"

/* Does the mechanism move, in the direction of its mode? */
static bool slips_on(const Mechanism *m) {
    return is_slip(m->state.mode) && direction_of(m->state.mode) == sign_of(m->state.omega.hi);
}

/* ---- Radau steps ---- */

static void raise_radau_peaks(const Mechanism *m, const SlipMode *slip, const RadauStep *step, Segment *segment) {
    radau_step_raise_peaks(slip, step, &segment->peak);
    segment_raise_input_peaks(m, step->h, segment);
}

/* Without inertia: the speed by the equation of motion at the angle `theta` after t seconds. The last iterate of the
 * step has another angle, and its piece of the transmission may end before `theta`. */
static double speed_at_end(const Mechanism *m, const SlipMode *slip, double theta, double t) {
    const SlipMode here =
        slip_mode_of(&m->params, &m->model.transmission, m->model.law, &m->inputs, theta, slip->direction, slip->flank);
    return balance_rhs(&here, theta, 0.0, t).value;
}

/* The segment along a Radau step to its end, with `left` seconds left. A segment below the rounding of the time raises
 * no peak: it has the reactions of the next one. */
static void radau_segment(Mechanism *m, const SlipMode *slip, double left, EventLocation *location, Segment *segment) {
    const RadauStep *step = &location->step;
    segment_begin(m, SEGMENT_RADAU, segment);
    segment->books = true;
    segment->booking = step->booking;
    segment->energy_gained = step->energy_gained;
    if (m->params.ledger && step->h > DBL_EPSILON * left) raise_radau_peaks(m, slip, step, segment);
    segment->end = location->kind;
    for (int i = 0; location->kind == EVENT_FLANK && i < 2; i++) segment->crossed[i] = location->crossed[i];
    segment->duration = step->h;
    segment->dtheta = step->dtheta;
    segment->varies = true;
    segment->omega_is_increment = slip->regime == REGIME_INERTIAL;
    segment->omega =
        segment->omega_is_increment ? step->domega : speed_at_end(m, slip, theta_after(m, step->dtheta).hi, step->h);
    segment->ends_at_breakpoint = location->aimed_at_breakpoint;
    segment->location = location;
    m->cache.proposal = location->next;
}

/* At breakaway under inputs that are polynomials the torque is on the edge of the band, or short of the edge by
 * rounding, and its excess grows like its first time derivative that is not zero. Until the excess exceeds the rounding
 * of the torques, the motion is rest to all digits, and no step can resolve the motion. Returns the duration of this
 * rest, at least a rounding of `left` seconds; 0 where the torque exceeds the edge or the mechanism moves. */
static double unseen_time(const Mechanism *m, const SlipMode *slip, const Balance *start, double left) {
    if (slip->regime == REGIME_INERTIAL && start->omega != 0.0) return 0.0;
    Partials by;
    balance_partials(slip, start, &by);
    const double lever = by.by[KNOWN_F_EXT] / by.by[KNOWN_TAU]; /* minus the torque per load that holds the load */
    const double excess = slip->direction * start->rhs.value / by.by[KNOWN_TAU]; /* N.m; the motion begins at rest */
    const double rounding = BREAKAWAY_TIES * stick_tie(m) * stick_torque_size(m, lever);
    if (!(excess <= rounding)) return 0.0;
    const double missing = rounding + max_of(-excess, 0.0);
    const Inputs *in = slip->inputs;
    double t[INPUT_ORDER], factorial = 1.0; /* s, until the k-th derivative alone has made what is missing */
    for (int k = 1; k <= INPUT_ORDER; k++) {
        factorial *= k;
        t[k - 1] = factorial * missing / fabs(in->tau[k] + lever * in->F_ext[k]);
    }
    const double unseen = min_of(t[0], min_of(sqrt(t[1]), elementary_cbrt(t[2])));
    return unseen < INFINITY ? max_of(unseen, DBL_EPSILON * left) : 0.0;
}

/* Slip along `slip` for up to `left` seconds, to the first event; along the band's edge also jumps past its folds. */
static SlipProposal propose_along(Mechanism *m, const SlipMode *slip, const Balance *start, double left,
                                  EventLocation *location, Segment *segment) {
    const StopAhead stop = {angle_to_stop(m, slip->direction), m->state.energy_gained};
    if (stop.angle <= 0.0) {
        segment_begin(m, SEGMENT_AT_EVENT, segment);
        segment->omega_is_increment = true; /* the impact needs the speed */
        segment->end = EVENT_STOP;
        return SLIP_PROPOSED;
    }
    const bool found = event_location_find(slip, start, &stop, left, &m->cache.proposal, location);
    if (slip->regime == REGIME_RATE_INDEPENDENT && (!found || jump_is_at_fold(slip, location, left))) {
        if (jump_past_fold(m, slip, start, left, segment)) return SLIP_PROPOSED;
        if (!found) rest_propose(m, left, segment);
    } else if (!found) {
        const double unseen = unseen_time(m, slip, start, left);
        if (!(unseen > 0.0)) return SLIP_LOST;
        rest_propose_for(m, min_of(left, unseen), segment);
    }
    if (found) radau_segment(m, slip, left, location, segment);
    return SLIP_PROPOSED;
}

SlipProposal collocation_slip_propose(Mechanism *m, double left, EventLocation *location, Segment *segment) {
    const SlipMode slip = slip_mode_from_here(m, present_slip_index(m));
    const Balance start = balance_from_here(m, &slip);
    return propose_along(m, &slip, &start, left, location, segment);
}

/* ---- Lobatto steps ---- */

/* Without inertia: is the torque still beyond the band, and do the contacts bear on the flanks of the spring's load?
 * The damper's load is then on the same flanks. */
static bool is_driven(const Mechanism *m, const SlipMode *slip) {
    const double load = stick_axial_load(m);
    const bool on_spring_flanks = slip->flank[0] * load > 0.0 && slip->flank[1] * load > 0.0;
    return (on_spring_flanks || !has_friction(&m->params)) && stick_direction_beyond_band(m) == slip->direction;
}

static bool find_lobatto_step(const Mechanism *m, const SlipMode *slip, double left, LobattoStep *lobatto) {
    const State *s = &m->state;
    if (slip->regime == REGIME_RATE_INDEPENDENT) return false;
    if (slip->regime == REGIME_VISCOUS && (slip->friction_varies || !is_driven(m, slip))) return false;
    const LobattoStart from = {
        s->theta.hi,    s->omega.hi, m->configuration.z, &m->configuration.geometry, angle_to_stop(m, slip->direction),
        &s->ledger.peak};
    return lobatto_step_along(slip, &from, left, lobatto);
}

/* Raises the peaks to the largest values inside a Lobatto step, by a Radau step over the same time. */
static void raise_peaks_inside(const Mechanism *m, const SlipMode *slip, double h, Segment *segment) {
    const Balance start = balance_from_here(m, slip);
    RadauStep step;
    if (radau_step_solve(slip, &start, h, RADAU_MAX, &step)) raise_radau_peaks(m, slip, &step, segment);
}

static void raise_lobatto_peaks(const Mechanism *m, const SlipMode *slip, const LobattoStep *lobatto,
                                Segment *segment) {
    Peaks *peak = &segment->peak;
    peak_raise(&peak->omega, lobatto->peak.omega);
    peak_raise(&peak->torque, lobatto->peak.torque);
    segment_raise_input_peaks(m, lobatto->h, segment);
    for (int i = 0; i < 2; i++) peak_raise(&peak->reaction[i], lobatto->peak.reaction[i]);
    if (lobatto->peaks_inside) raise_peaks_inside(m, slip, lobatto->h, segment);
}

static void lobatto_segment(const Mechanism *m, const SlipMode *slip, const LobattoStep *lobatto, Segment *segment) {
    segment_begin(m, SEGMENT_LOBATTO, segment);
    segment->books = true;
    segment->booking = lobatto->booking;
    segment->energy_gained = lobatto->energy_gained;
    if (m->params.ledger) raise_lobatto_peaks(m, slip, lobatto, segment);
    segment->duration = lobatto->h;
    segment->dtheta = lobatto->dtheta;
    segment->varies = !slip->inputs_are_constant;
    segment->omega_is_increment = slip->regime == REGIME_INERTIAL;
    segment->omega = segment->omega_is_increment ? lobatto->domega : lobatto->omega;
}

static bool lobatto_propose(const Mechanism *m, const SlipMode *slip, double left, LobattoHint *hint,
                            Segment *segment) {
    LobattoStep lobatto;
    lobatto.accurate = false;
    const bool found = find_lobatto_step(m, slip, left, &lobatto);
    *hint = (LobattoHint){.refused = !found, .accurate = lobatto.accurate};
    if (found) lobatto_segment(m, slip, &lobatto, segment);
    return found;
}

bool collocation_slip_quiet(const Mechanism *m, double h, LobattoHint *hint, Segment *segment) {
    *hint = (LobattoHint){.refused = true};
    if (!slips_on(m)) return false;
    const SlipMode slip = slip_mode_from_here(m, present_slip_index(m));
    return lobatto_propose(m, &slip, h, hint, segment);
}

/* ---- the next segment in the same mode ---- */

/* Would a decision find this slip mode again? The test is sufficient, not necessary. Where a contact is on its flank by
 * no more than rounding, the rate of its reaction decides, which needs a decision. */
static bool goes_on(const Mechanism *m, const SlipMode *slip, const Balance *start) {
    if (!start->rhs.possible || !(slip->direction * start->omega > 0.0)) return false;
    if (has_friction(&m->params) && !balance_are_firm(slip, start)) return false;
    if (slip->regime == REGIME_INERTIAL) return true;
    return slip->regime == REGIME_VISCOUS && is_driven(m, slip);
}

SlipProposal collocation_slip_continue(Mechanism *m, double left, const LobattoHint *hint, EventLocation *location,
                                       Segment *segment) {
    if (!slips_on(m)) return SLIP_UNDECIDED;
    const SlipMode slip = slip_mode_from_here(m, present_slip_index(m));
    StepProposal *proposal = &m->cache.proposal;
    LobattoHint latest = *hint;
    const bool suits = !hint->refused && left <= proposal->h; /* a longer step needs more than the four Lobatto nodes */
    if (suits && lobatto_propose(m, &slip, left, &latest, segment)) return SLIP_PROPOSED;
    const Balance start = balance_from_here(m, &slip);
    if (!goes_on(m, &slip, &start)) return SLIP_UNDECIDED;
    if (!latest.accurate && proposal->stages <= RADAU_MIN) proposal->stages = RADAU_MIN + 2;
    return propose_along(m, &slip, &start, left, location, segment);
}
