#include "forward/jump.h"

#include <math.h>

#include "elementary/elementary.h"
#include "forward/closed_form_slip.h"
#include "forward/decide.h"
#include "forward/play.h"
#include "forward/rest.h"
#include "forward/stick.h"
#include "numerics/bernstein.h"

/* ---- two helices ---- */

static void book_helices(const LinearSegment *s, double dtheta, Segment *segment) {
    const double dF = s->params->spring.stiffness * s->geometry->dz_dtheta * dtheta;
    segment->booking = linear_slip_jump_booking(s->linear, s->params, s->geometry, &s->start, dtheta);
    segment->books = true;
    peak_raise(&segment->peak.torque, s->start.tau);
    for (int i = 0; i < 2; i++) {
        const double reaction = s->linear->transfer.axial[i] * s->linear->reaction[i]; /* per force */
        peak_raise(&segment->peak.reaction[i], reaction * s->start.force);
        peak_raise(&segment->peak.reaction[i], reaction * (s->start.force + dF));
    }
}

bool jump_of_helices(const Mechanism *m, const LinearSlipMode *linear, Segment *segment) {
    const LinearSegment s = linear_segment_from_here(m, linear);
    const double sign = linear->direction, force = s.start.force;
    const double net = sign * linear_slip_net_torque(linear, &s.start);
    const bool stable = linear->stiffness > 0.0; /* else the holding torque falls along the motion */
    const Candidate candidate = candidate_of(m, present_slip_index(m));
    if (stable && !begins_with_jump(&candidate, linear->direction)) return false;
    const double spring = sign * m->params.spring.stiffness * m->configuration.geometry.dz_dtheta;
    const double carried = linear->flank[0] * linear->transfer.axial[0] + linear->flank[1] * linear->transfer.axial[1];
    /* Beyond the place where the load turns, a load that is rounding does not turn once more. */
    const bool mirrors = force * spring < 0.0 && carried * force > 0.0 && stick_force_counts(m, force);
    const double to_edge = stable ? net / linear->stiffness : INFINITY;
    const double to_mirror = mirrors ? -force / spring : INFINITY;
    const double distance = min_of(to_edge, min_of(to_mirror, s.to_stop));
    segment_begin(m, SEGMENT_JUMP, segment);
    if (m->params.ledger) book_helices(&s, sign * distance, segment);
    segment->dtheta = sign * distance;
    if (distance == to_mirror) {
        segment->end = EVENT_FLANK;
        segment->crossed[0] = segment->crossed[1] = true;
    }
    if (distance == s.to_stop) segment->end = EVENT_STOP;
    return true;
}

/* ---- grooves of any shape ---- */

bool jump_is_due(const Mechanism *m) {
    const int index = present_slip_index(m);
    if (slip_mode_from_here(m, index).regime != REGIME_RATE_INDEPENDENT) return false;
    const Candidate candidate = candidate_of(m, index);
    return begins_with_jump(&candidate, direction_of(m->state.mode));
}

/* Proposes the segment of the jump to where `torque` is held, see play_jump(). False if there is none: the jump is
 * zero. */
static bool propose_jump(const Mechanism *m, int direction, double torque, double bump, Segment *segment) {
    Jump jump;
    play_jump(m, direction, torque, bump, &jump);
    segment_begin(m, SEGMENT_JUMP, segment);
    segment->books = true;
    segment->booking = jump.booking;
    peak_raise(&segment->peak.torque, m->inputs.tau[0]);
    for (int i = 0; i < 2; i++) peak_raise(&segment->peak.reaction[i], jump.reaction[i] / m->params.contacts);
    segment->dtheta = jump.dtheta;
    if (jump.stopped) segment->end = EVENT_STOP;
    return jump.stopped || jump.dtheta != 0.0;
}

void jump_propose(Mechanism *m, double left, Segment *segment) {
    if (propose_jump(m, direction_of(m->state.mode), m->inputs.tau[0], 0.0, segment)) return;
    m->state.mode = MODE_WEDGED; /* beyond this angle the contacts lock */
    rest_propose(m, left, segment);
}

/* ---- folds ---- */

bool jump_is_at_fold(const SlipMode *slip, const EventLocation *location, double left) {
    const RadauStep *step = &location->step;
    if (location->kind != EVENT_NONE || location->at_breakpoint || step->h >= left) return false;
    const bool slower = fabs(radau_step_end(step)->omega) < fabs(step->start.omega);
    const bool noisy = step->angle_noise > slip->params->tolerance * fabs(step->dtheta);
    const bool near = fabs(step->dtheta) <= FOLD_SHARE * (slip->piece->upper - slip->piece->lower);
    return !slower && ((noisy && inputs_load_constant(slip->inputs)) || near);
}

/* Upper bound of the edge's rise from here to the fold, N.m. */
static double fold_height(const SlipMode *slip, const Balance *start) {
    return FOLD_SHARE * (slip->piece->upper - slip->piece->lower) * fabs(start->rhs.by_theta);
}

/* The time, s, at most `left`, for which the torque grows in `direction`; 0 if F_ext is not constant. */
static double growing_time(const Inputs *in, int direction, double left) {
    if (!inputs_load_constant(in)) return 0.0;
    const double rate[INPUT_ORDER + 1] = {direction * in->tau[1], direction * in->tau[2], direction * in->tau[3]};
    const Bernstein p = bernstein_of_taylor(rate, left);
    return left * min_of(bernstein_descent(&p), 1.0);
}

/* Where the edge of the band is level, time does not follow from theta, but theta follows from the torque. As long as
 * the torque grows, theta ends where a jump of the torque would end. */
static void follow_torque(const Mechanism *m, int direction, double t, Segment *segment) {
    const double torque = input_value(m->inputs.tau, t);
    (void)propose_jump(m, direction, torque, 0.0, segment);
    peak_raise(&segment->peak.torque, torque);
    segment->duration = t;
    segment->varies = segment->finds_speed = true;
}

bool jump_past_fold(const Mechanism *m, const SlipMode *slip, const Balance *start, double left, Segment *segment) {
    const double grows = growing_time(&m->inputs, slip->direction, left);
    if (!(grows > 0.0)) return propose_jump(m, slip->direction, m->inputs.tau[0], fold_height(slip, start), segment);
    follow_torque(m, slip->direction, grows, segment);
    return true;
}

void jump_find_speed(Mechanism *m) {
    enter_decided_mode(m);
    if (is_slip(m->state.mode)) {
        const SlipMode slip = slip_mode_from_here(m, present_slip_index(m));
        m->state.omega = sum_of(balance_from_here(m, &slip).omega);
    }
    if (m->params.ledger) peak_raise(&m->state.ledger.peak.omega, m->state.omega.hi);
}
