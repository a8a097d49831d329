#include "forward/jump.h"

#include <math.h>

#include "contact/loaded_contacts.h"
#include "elementary/elementary.h"
#include "forward/closed_form_slip.h"
#include "forward/decide.h"
#include "forward/play.h"
#include "forward/rest.h"
#include "forward/stick.h"
#include "numerics/bernstein.h"
#include "numerics/radau.h"
#include "numerics/root.h"
#include "platform/attributes.h"

COMPACT_BEGIN

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

JumpProposal jump_of_helices(const Mechanism *m, const LinearSlipMode *linear, Segment *segment) {
    const LinearSegment s = linear_segment_from_here(m, linear);
    const double sign = linear->direction, force = s.start.force;
    const double net = sign * linear_slip_net_torque(linear, &s.start);
    const bool stable = linear->stiffness > 0.0; /* else the holding torque falls along the motion */
    const Candidate candidate = candidate_of(m, present_slip_index(m));
    if (stable && !begins_with_jump(&candidate, linear->direction)) return JUMP_NONE;
    const double spring = sign * m->params.spring.stiffness * m->configuration.geometry.dz_dtheta;
    const bool mirrors = force * spring < 0.0 && stick_force_counts(m, force);
    const double to_edge = stable ? net / linear->stiffness : INFINITY;
    const double to_mirror = mirrors ? -force / spring : INFINITY;
    const double distance = min_of(to_edge, min_of(to_mirror, s.to_stop));
    segment_begin(m, SEGMENT_JUMP, segment);
    if (m->params.ledger) book_helices(&s, sign * distance, segment);
    segment->dtheta = sign * distance;
    if (distance == s.to_stop) segment->end = EVENT_STOP;
    return JUMP_PROPOSED;
}

/* ---- grooves of any shape ---- */

bool jump_is_due(const Mechanism *m) {
    const int index = present_slip_index(m);
    if (slip_mode_from_here(m, index).regime != REGIME_RATE_INDEPENDENT) return false;
    const Candidate candidate = candidate_of(m, index);
    return !(candidate.stiffness > 0.0) || begins_with_jump(&candidate, direction_of(m->state.mode));
}

/* Proposes the segment of a jump. */
static JumpProposal propose_jump(const Mechanism *m, const Jump *jump, Segment *segment) {
    const Booking *b = &jump->booking;
    if (!isfinite(jump->dtheta + b->work_in + b->work_ext + b->heat_cam[0] + b->heat_cam[1])) return JUMP_NOT_FINITE;
    segment_begin(m, SEGMENT_JUMP, segment);
    segment->books = true;
    segment->booking = *b;
    peak_raise(&segment->peak.torque, m->inputs.tau[0]);
    for (int i = 0; i < 2; i++) peak_raise(&segment->peak.reaction[i], jump->reaction[i] / m->params.contacts);
    segment->dtheta = jump->dtheta;
    if (jump->stopped) segment->end = EVENT_STOP;
    return JUMP_PROPOSED;
}

/* ---- along F_0 = 0 ---- */

/* The way along which F_0 stays zero while F_ext varies: the torque moves the mechanism on where F_0 has the sign of the
 * direction, and a contact locks where F_0 has the other sign. */
typedef struct {
    const Mechanism *m;
    const TransmissionPiece *piece;
    int direction;
    double F_ext; /* N */
} UnloadedWay;

/* F_0 in the direction of the way. */
static double load_along(const void *context, double theta) {
    const UnloadedWay *way = context;
    return way->direction * (spring_force(&way->m->params.spring, piece_at(way->piece, theta).z) + way->F_ext);
}

/* At theta: does F_0 fall along the way, and does a contact lock where it has fallen below zero? */
static bool ends_unloaded(const UnloadedWay *way, double theta) {
    const Params *p = &way->m->params;
    const TransmissionPoint point = piece_at(way->piece, theta);
    Geometry g = cam_geometry(p->cam, point.slope);
    int flank[2];
    Transfer t;
    work_add(way->m->work, 1);
    return spring_rate(&p->spring, point.z) * g.dz_dtheta < 0.0 &&
           !contact_edge_under(p, &g, 0.0, -1, flank, &t, way->m->work);
}

/* The angle, rad, up to which this is so at all samples; 0 where it is not so here. */
static double unloaded_range(const UnloadedWay *way) {
    const Radau *r = radau_of(RADAU_MAX);
    const double width = way->piece->upper - way->piece->lower, theta = way->m->state.theta.hi;
    const double to_end = way->direction > 0 ? way->piece->upper - theta : theta - way->piece->lower;
    double range = min_of(min_of(to_end, angle_to_stop(way->m, way->direction)), width / (int)PLAY_SAMPLES);
    for (int n = 0; n < PLAY_HALVINGS_TO_LOCK; n++, range *= 0.5) {
        bool unloaded = ends_unloaded(way, theta);
        for (int j = 0; j < r->stages; j++) unloaded &= ends_unloaded(way, theta + way->direction * r->node[j] * range);
        if (unloaded) return range;
    }
    return 0.0;
}

/* The first time up to t, s, at which sign u falls below zero; else t. */
static double time_of_descent(const double u[INPUT_ORDER + 1], double sign, double t) {
    const double signed_u[INPUT_ORDER + 1] = {sign * u[0], sign * u[1], sign * u[2], sign * u[3]};
    const Bernstein p = bernstein_of_taylor(signed_u, t);
    return t * min_of(bernstein_descent(&p), 1.0);
}

/* The time up to t, s, for which u grows in the direction of `sign`. */
static double time_of_growth(const double u[INPUT_ORDER + 1], double sign, double t) {
    const double rate[INPUT_ORDER + 1] = {u[1], u[2], u[3]};
    return time_of_descent(rate, sign, t);
}

/* Where F_0 = 0 is after *t seconds, while F_ext lifts F_0, or at the latest at `end`, up to which the way leads: *t is then
 * the time at the end. */
static double unloaded_angle(UnloadedWay *way, double end, double *t) {
    const double *F_ext = way->m->inputs.F_ext, theta = way->m->state.theta.hi, past = load_along(way, end);
    way->F_ext = input_value(F_ext, *t);
    const double before = load_along(way, theta), after = load_along(way, end);
    if (!(before > 0.0)) return theta; /* to rounding */
    if (after < 0.0) return root_between(load_along, way, theta, before, end, after);
    const int sign = -way->direction;
    const double missing[INPUT_ORDER + 1] = {sign * F_ext[0] - past, sign * F_ext[1], sign * F_ext[2], sign * F_ext[3]};
    *t = time_of_descent(missing, 1.0, min_of(*t, 2.0 * time_of_descent(missing, 1.0, *t))); /* twice: all digits */
    return end;
}

/* Proposes the motion along F_0 = 0 for up to `left` seconds: while F_ext lifts F_0 and the torque points along the way.
 * NONE where there is no such motion. As in a jump the torque counts as that of the edge, which is zero. */
static JumpProposal follow_unloaded(const Mechanism *m, double left, Segment *segment) {
    const Inputs *in = &m->inputs;
    const SpringParams *spring = &m->params.spring;
    const int direction = direction_of(m->state.mode);
    const double theta = m->state.theta.hi;
    UnloadedWay way = {m, transmission_piece(&m->model.transmission, theta, direction), direction, 0.0};
    if (inputs_load_constant(in) || !stick_is_unloaded(m)) return JUMP_NONE;
    double t = time_of_descent(in->tau, direction, time_of_growth(in->F_ext, direction, left));
    const double range = t > 0.0 ? unloaded_range(&way) : 0.0;
    if (!(range > 0.0)) return JUMP_NONE;
    const double last = theta + direction * range, end = unloaded_angle(&way, last, &t);
    const TransmissionPoint point = piece_at(way.piece, end);
    const Geometry g = cam_geometry(m->params.cam, point.slope);
    const Jump jump = {.dtheta = end - theta,
                       .stopped = end == last && range >= angle_to_stop(m, direction),
                       .booking.work_ext = spring_energy(spring, m->configuration.z) - spring_energy(spring, point.z)};
    if (propose_jump(m, &jump, segment) != JUMP_PROPOSED) return JUMP_NOT_FINITE;
    segment->duration = t;
    segment->varies = true;
    if (end != theta) segment->omega = -input_rate(in->F_ext, t) / (spring_rate(spring, point.z) * g.dz_dtheta);
    segment_raise_input_peaks(m, t, segment);
    peak_raise(&segment->peak.torque, input_value(in->tau, t));
    peak_raise(&segment->peak.omega, segment->omega);
    return JUMP_PROPOSED;
}

bool jump_propose(Mechanism *m, double left, Segment *segment) {
    Jump jump;
    play_jump(m, direction_of(m->state.mode), m->inputs.tau[0], 0.0, &jump);
    if (jump.stopped || jump.dtheta != 0.0) return propose_jump(m, &jump, segment) == JUMP_PROPOSED;
    const JumpProposal unloaded = follow_unloaded(m, left, segment);
    if (unloaded != JUMP_NONE) return unloaded == JUMP_PROPOSED;
    rest_propose(m, left, segment);
    return true;
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
    return time_of_growth(in->tau, direction, left);
}

/* Where the edge of the band is level, time does not follow from theta, but theta follows from the torque. As long as
 * the torque grows, theta ends where a jump of the torque would end. */
static JumpProposal follow_torque(const Mechanism *m, int direction, double t, Segment *segment) {
    Inputs after = m->inputs;
    inputs_advance(&after, t);
    Jump jump;
    play_jump(m, direction, after.tau[0], 0.0, &jump);
    if (propose_jump(m, &jump, segment) != JUMP_PROPOSED) return JUMP_NOT_FINITE;
    peak_raise(&segment->peak.torque, after.tau[0]);
    segment->duration = t;
    segment->varies = segment->finds_speed = true;
    return JUMP_PROPOSED;
}

JumpProposal jump_past_fold(const Mechanism *m, const SlipMode *slip, const Balance *start, double left,
                            Segment *segment) {
    const double grows = growing_time(&m->inputs, slip->direction, left);
    if (grows > 0.0) return follow_torque(m, slip->direction, grows, segment);
    Jump jump;
    play_jump(m, slip->direction, m->inputs.tau[0], fold_height(slip, start), &jump);
    return jump.stopped || jump.dtheta != 0.0 ? propose_jump(m, &jump, segment) : JUMP_NONE;
}

void jump_find_speed(Mechanism *m) {
    (void)enter_decided_mode(m);
    if (is_slip(m->state.mode)) {
        const SlipMode slip = slip_mode_from_here(m, present_slip_index(m));
        m->state.omega = sum_of(balance_from_here(m, &slip).omega);
    }
    if (m->params.ledger) peak_raise(&m->state.ledger.peak.omega, m->state.omega.hi);
}

COMPACT_END
