#include "forward/mechanism.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "closed_form/linear_event.h"
#include "collocation/lobatto_step.h"
#include "contact/check.h"
#include "forward/decide.h"
#include "forward/motion_derivatives.h"
#include "forward/play.h"
#include "forward/segment.h"
#include "forward/stick.h"
#include "numerics/bernstein.h"
#include "platform/attributes.h"

/* A step with more mode changes than this is refused. At about a microsecond each that bounds the time a step
 * takes. Only bounces of a restitution near 1, or vibrations of a tiny inertia, come so often in one step. */
enum { MAX_EVENTS_PER_STEP = 200000 };

/* So many of them are to take at least this share of the step: speeds that are nothing but rounding, because next to
 * nothing resists the motion, would keep it from getting on for minutes. Bounces fade out before. */
enum { WATCHED_EVENTS = 2000 };
static const double LEAST_PROGRESS = 1e-9;

/* Moving contacts can jam (see jam()), and let go again at once. Without inertia of the shaft a locked contact
 * can do so for ever, in ever shorter time: rigid bodies under Coulomb friction then have no motion at all
 * (P. Painleve, 1895). */
enum { MAX_JAMS_PER_STEP = 1000 };

/* A bounce whose excursion is below this share of the angles involved is lost in the rounding of theta. */
static const double NO_BOUNCE = 16.0 * DBL_EPSILON;

static double kinetic_energy(const Mechanism *m) {
    const Geometry *g = &m->configuration.geometry;
    return kinetic_energy_of(&m->params.inertia, g->dz_dtheta, g->dpsi_dtheta[0], m->state.omega.hi);
}

static double stored_energy(const Mechanism *m) {
    return spring_energy(&m->params.spring, axial_position(m)) + kinetic_energy(m);
}

/* ---- model ---- */

/* Switched off, every scene takes the way of general grooves: a test compares the two. */
#ifdef DUALCAM_NO_CLOSED_FORM
enum { USE_CLOSED_FORM = 0 };
#else
enum { USE_CLOSED_FORM = 1 };
#endif

/* A way to slip that has been built; none if its direction is 0. */
static void keep_slip(Mechanism *m, const LinearSlipMode *built) {
    if (built->direction == 0) return;
    const int index = slip_index(built->direction, built->flank);
    m->model.linear_slip[index] = *built;
    m->model.linear_slips |= 1u << index;
}

/* That way to slip, built if it has not been yet. */
static inline const LinearSlipMode *kept_slip(Mechanism *m, int index) {
    LinearSlipMode built;
    if ((m->model.linear_slips >> index & 1u) == 0) keep_slip(m, linear_slip_of(m, index, &built));
    return &m->model.linear_slip[index];
}

/* To be called whenever theta changes. */
static void update_configuration(Mechanism *m) {
    const Transmission *transmission = &m->model.transmission;
    Configuration *configuration = &m->configuration;
    if (transmission->straight) {
        configuration->z = configuration->geometry.dz_dtheta * m->state.theta.hi;
        return;
    }
    const TransmissionPoint point =
        piece_point(transmission_piece(transmission, m->state.theta.hi, 0), m->state.theta.hi, TRANSMISSION_SLOPES);
    configuration->geometry = cam_geometry(m->params.cam, point.slope);
    configuration->z = point.z;
}

static void forget(Cache *cache) {
    cache->hold.valid = false;
    cache->radau = (StepProposal){INFINITY, 0};
    for (int i = 0; i < SLIP_MODE_COUNT; i++) cache->kernel[i].t = NAN;
}

/* All that follows from params and course. */
static void build_model(Mechanism *m) {
    const Transmission *transmission = &m->model.transmission;
    m->model.closed_form = USE_CLOSED_FORM && transmission->straight && is_linear(&m->params);
    if (transmission->straight) {
        const double slope[2] = {transmission->piece->slope[0][0], transmission->piece->slope[0][1]};
        m->configuration = (Configuration){.geometry = cam_geometry(m->params.cam, slope)};
        m->configuration.band = contact_band(&m->configuration.geometry);
    }
    m->model.linear_slips = 0;
    update_configuration(m);
    forget(&m->cache);
}

bool mechanism_rebuild(Mechanism *m, Fault *fault) {
    if (!check_params(&m->params, fault) ||
        !check_transmission(&m->params, m->resources, &m->model.transmission, fault))
        return false;
    build_model(m);
    return true;
}

void mechanism_free(Mechanism *m) {
    transmission_free(&m->model.transmission);
    m->model.transmission = (Transmission){.count = 0};
}

static void enter(Mechanism *m, Decision d) {
    State *state = &m->state;
    if (state->mode != d.mode) {
        state->events++;
        state->mode = d.mode;
        m->cache.hold.valid = false;
    }
    if (is_slip(d.mode)) slip_flanks(d.slip_index, state->flank);
}

/* What has been built for it is kept. */
static void enter_anew(Mechanism *m) {
    LinearSlipMode built;
    built.direction = 0;
    const Decision d = decide(m, &built);
    keep_slip(m, &built);
    enter(m, d);
}

/* ---- holding ---- */

static void stand_still(Mechanism *m) {
    m->state.omega = sum_of(0.0);
}

static void record_rest(Mechanism *m) {
    Peaks *peak = &m->state.ledger.peak;
    peak_raise(&peak->torque, m->inputs.tau[0]);
    for (int i = 0; i < 2; i++) peak_raise(&peak->reaction[i], stick_reaction(m, i));
}

/* Torque and load of a curved input may be largest in between. */
static void record_input_peaks(Mechanism *m, double t) {
    if (inputs_within(&m->inputs, 1)) return;
    Peaks *peak = &m->state.ledger.peak;
    const Bernstein tau = bernstein_of_taylor(m->inputs.tau, t), F_ext = bernstein_of_taylor(m->inputs.F_ext, t);
    peak_raise(&peak->torque, bernstein_value(&tau, bernstein_peak(&tau)));
    if (is_slip(m->state.mode)) return;
    Bernstein load = F_ext;
    for (int i = 0; i <= load.degree; i++) load.c[i] += spring_force(&m->params.spring, m->configuration.z);
    const double F_0 = bernstein_value(&load, bernstein_peak(&load));
    for (int i = 0; i < 2; i++) peak_raise(&peak->reaction[i], stick_sharing(m, i) * F_0);
}

/* Stays at rest for up to `left` seconds; returns how long. */
static double hold(Mechanism *m, double left, Segment *segment) {
    segment->kind = SEGMENT_REST;
    stand_still(m);
    if (m->params.ledger) record_rest(m);
    if (inputs_constant(&m->inputs)) {
        m->cache.hold = stick_rest_interval(m); /* the next step at rest costs one comparison */
        return left;
    }
    /* on the very edge of the band, where no slip agrees, rounding could hold it for no time at all */
    const double t = fmax(stick_rest_time(m, left), DBL_EPSILON * left);
    if (m->params.ledger) record_input_peaks(m, t);
    inputs_advance(&m->inputs, t);
    if (m->params.ledger) record_rest(m);
    return t;
}

/* A step at rest under constant inputs, the hold known from before. */
static bool hold_again(Mechanism *m) {
    const RestInterval *hold = &m->cache.hold;
    const double tau = m->inputs.tau[0];
    if (!hold->valid || !(tau >= hold->lower && tau <= hold->upper)) return false;
    if (m->inputs.F_ext[0] != hold->F_ext) return false;
    if (m->params.ledger) peak_raise(&m->state.ledger.peak.torque, tau);
    return true;
}

/* ---- the start of the step ---- */

/* A step of h seconds starts here. Member by member: a copy of the whole would go by way of the stack. */
static inline void begin_step(const Mechanism *m, double h, Step *step) {
    const State *s = &m->state;
    step->theta = s->theta;
    step->omega = s->omega;
    step->inputs = m->inputs;
    step->h = h;
    step->mode = s->mode;
    memcpy(step->flank, s->flank, sizeof step->flank);
    step->retuned = 0;
}

static void forget_tunables(State *s) {
    if (s->step.retuned) s->tunables = (Tunables){.friction = {0.0}};
}

/* Before a step, of which nothing can fail any more, moves anything. */
static void remember_step(Mechanism *m, double h) {
    forget_tunables(&m->state);
    begin_step(m, h, &m->state.step);
}

/* ---- slipping ---- */

static int direction_of(Mode mode) {
    return mode == MODE_LOADING ? 1 : -1;
}

/* T per F_0 at the edge of the stick band that was passed. */
static double band_edge(const Mechanism *m, int direction) {
    const EdgeFactors edges = stick_edges(m, stick_axial_load(m));
    return direction > 0 ? edges.load : edges.release;
}

static LinearSegment stretch_of(const Mechanism *m, const LinearSlipMode *slip) {
    LinearSegment stretch = {
        .linear = slip,
        .params = &m->params,
        .geometry = &m->configuration.geometry,
        .start = slip_start_of(m, slip),
        .flanks = has_friction(&m->params),
    };
    const double stop = slip->direction > 0 ? m->params.stop.upper : m->params.stop.lower;
    stretch.room = fmax(slip->direction * (stop - m->state.theta.hi - m->state.theta.lo), 0.0);
    stretch.edge = slip->regime == REGIME_VISCOUS ? band_edge(m, slip->direction) : slip->transfer.rho;
    return stretch;
}

static int present_index(const Mechanism *m) {
    return slip_index(direction_of(m->state.mode), m->state.flank);
}

static void record_slip(Mechanism *m, const LinearSegment *s, const SegmentEnds *ends) {
    Peaks *peak = &m->state.ledger.peak;
    event_peaks(s, ends, peak);
    peak_raise(&peak->torque, s->start.tau);
    peak_raise(&peak->torque, s->start.tau + s->start.tau_rate * ends->motion.t);
}

/* theta is known to rounding, which must not carry it past a stop. */
static void rotate(Mechanism *m, double dtheta) {
    Sum *theta = &m->state.theta;
    sum_add(theta, dtheta);
    if (theta->hi > m->params.stop.upper) *theta = sum_of(m->params.stop.upper);
    if (theta->hi < m->params.stop.lower) *theta = sum_of(m->params.stop.lower);
    update_configuration(m);
}

/* Moves along the stretch to its end, and remembers the start of a communication step of `step` seconds that this is,
 * unless it is 0. False, with nothing changed, if a value would not be finite. */
static bool commit(Mechanism *m, const LinearSegment *s, const SegmentEnds *ends, Kernel *kernel, double step) {
    const LinearMotion *motion = &ends->motion;
    const bool keeps = m->params.ledger;
    Booking booking;
    double all = motion->dtheta + motion->omega;
    if (keeps) {
        booking = linear_slip_booking(s->linear, s->params, s->geometry, &s->start, motion, kernel);
        all += booking.work_in + booking.heat_cam[0] + booking.heat_cam[1] + booking.heat_damper;
    }
    if (!(fabs(all) <= DBL_MAX)) return false;
    if (step > 0.0) remember_step(m, step);
    if (keeps) {
        ledger_book(&m->state.ledger, &booking);
        record_slip(m, s, ends);
    }
    rotate(m, motion->dtheta);
    if (s->linear->regime == REGIME_INERTIAL && !motion->settled) {
        sum_add(&m->state.omega, motion->domega);
    } else {
        m->state.omega = sum_of(motion->omega);
    }
    if (s->start.tau_rate != 0.0 || s->start.F_ext_rate != 0.0) inputs_advance(&m->inputs, motion->t);
    return true;
}

/* Slips for `horizon` seconds, or to the first event before; but if this is a whole communication step of `step` seconds,
 * only if there is no event. False, with nothing changed, if there is, or a value would not be finite. */
static bool slip_along(Mechanism *m, const LinearSlipMode *slip, Kernel *kernel, double horizon, double step,
                       EventKind *end) {
    const LinearSegment stretch = stretch_of(m, slip);
    const Event last = step > 0.0 ? (Event){EVENT_NONE, horizon} : event_last(&stretch, horizon);
    if (kernel->t != last.t) oscillator_kernel(&slip->oscillator, last.t, kernel);
    SegmentEnds ends;
    event_ends(&stretch, kernel, &ends);
    const bool quiet = last.kind == EVENT_NONE && event_quiet(&stretch, &ends);
    if (!quiet && step > 0.0) return false;
    *end = quiet ? EVENT_NONE : event_first(&stretch, last, kernel, &ends).kind;
    return commit(m, &stretch, &ends, kernel, step);
}

/* A whole step of inertial slip in which nothing happens: the common case. The kernel of the step is kept: an
 * unchanged step needs no new transcendental. */
static bool slip_on(Mechanism *m, double h) {
    if (!is_slip(m->state.mode)) return false;
    const int index = present_index(m);
    const LinearSlipMode *slip = kept_slip(m, index);
    if (slip->regime != REGIME_INERTIAL || !(slip->direction * m->state.omega.hi > 0.0)) return false;
    EventKind none;
    return slip_along(m, slip, &m->cache.kernel[index], h, h, &none);
}

static void stop_heat(Mechanism *m, double joule) {
    if (m->params.ledger) sum_add(&m->state.ledger.heat_stop, joule);
}

/* Arrival at an end stop: omega -> -e omega. A bounce too low to be seen in theta ends the bouncing, so
 * that a shrinking sequence of bounces ends after finitely many. */
static void hit_stop(Mechanism *m, int direction) {
    State *state = &m->state;
    const double before = kinetic_energy(m);
    state->theta = sum_of(direction > 0 ? m->params.stop.upper : m->params.stop.lower);
    update_configuration(m);
    state->omega = sum_of(0.0 - m->params.stop.restitution * state->omega.hi);
    if (!has_inertia(&m->params)) stand_still(m);
    if (state->omega.hi != 0.0) {
        LinearSlipMode built;
        built.direction = 0;
        const int slip = decide_slip(m, -direction, false, &built);
        keep_slip(m, &built);
        const double size = largest_angle(&m->params);
        const double back = slip < 0 ? 0.0 : direction * candidate_of(m, slip).alpha;
        if (state->omega.hi * state->omega.hi < 2.0 * back * NO_BOUNCE * size) stand_still(m);
    }
    stop_heat(m, before - kinetic_energy(m));
}

/* Velocity zero and stops are set to what they are by definition. A flank change moves nothing. */
static void land(Mechanism *m, int direction, EventKind kind, Segment *segment) {
    segment->end = kind;
    segment->omega = m->state.omega.hi;
    if (kind == EVENT_REST) stand_still(m);
    if (kind == EVENT_STOP) hit_stop(m, direction);
}

/* Slips for up to `left` seconds, to the first event; returns how long, or NAN if a value is not finite. */
static double slip_to_event(Mechanism *m, double left, Segment *segment) {
    const int index = present_index(m);
    const LinearSlipMode *slip = kept_slip(m, index);
    const double horizon = fmin(left, slip->oscillator.horizon);
    Kernel kernel = m->cache.kernel[index];
    EventKind end;
    if (!slip_along(m, slip, &kernel, horizon, 0.0, &end)) return NAN;
    segment->kind = SEGMENT_CLOSED_FORM;
    land(m, slip->direction, end, segment);
    return kernel.t;
}

/* ---- jams ---- */

/* Moving, and in a mode in which it cannot. */
static bool is_jammed(const Mechanism *m) {
    return has_inertia(&m->params) && m->state.omega.hi != 0.0 && !is_slip(m->state.mode);
}

/* No flank agrees while it moves: the contacts jam it at once. Its kinetic energy becomes friction heat,
 * shared as frictionless loads would share the sliding. */
static void jam(Mechanism *m) {
    const Geometry *g = &m->configuration.geometry;
    const double energy = kinetic_energy(m);
    double share[2];
    for (int i = 0; i < 2; i++) share[i] = cam_heat(g, i) * g->dpsi_dtheta[i] / g->radius[i];
    stand_still(m);
    if (!m->params.ledger || energy == 0.0) return;
    const double sum = share[0] + share[1]; /* 0 where only a contact without friction slides */
    for (int i = 0; i < 2; i++) sum_add(&m->state.ledger.heat_cam[i], energy * (sum > 0.0 ? share[i] / sum : 0.5));
}

/* ---- slipping in grooves of any shape ---- */

static void record_passage(Mechanism *m, const SlipMode *slip, EventLocation *location) {
    Peaks *peak = &m->state.ledger.peak;
    const RadauStep *radau = &location->radau;
    const double known[2] = {peak->reaction[0] * m->params.contacts, peak->reaction[1] * m->params.contacts};
    event_location_peaks(slip, location, peak->omega, known);
    peak_raise(&peak->omega, location->omega);
    peak_raise(&peak->torque, radau->start.tau);
    peak_raise(&peak->torque, radau->node[radau->method->stages - 1].tau);
    record_input_peaks(m, radau->h);
    for (int i = 0; i < 2; i++) peak_raise(&peak->reaction[i], location->reaction[i] / m->params.contacts);
}

/* Moves along the leap to its end; false if a value would not be finite. */
static bool commit_leap(Mechanism *m, const SlipMode *slip, EventLocation *location) {
    const RadauStep *radau = &location->radau;
    const Balance *end = &radau->node[radau->method->stages - 1];
    const Booking *b = &radau->booking;
    if (!isfinite(radau->dtheta + end->omega + b->work_in + b->heat_cam[0] + b->heat_cam[1] + b->heat_damper))
        return false;
    if (m->params.ledger) {
        ledger_book(&m->state.ledger, &radau->booking);
        record_passage(m, slip, location);
    }
    rotate(m, radau->dtheta);
    if (slip->regime == REGIME_INERTIAL) {
        sum_add(&m->state.omega, radau->domega);
    } else {
        /* the law's own speed where it has got to, not where the last iteration was, or beyond a border of its piece */
        const SlipMode here = slip_mode_of(&m->params, &m->model.transmission, &m->inputs, m->state.theta.hi,
                                           slip->direction, slip->flank);
        m->state.omega = sum_of(balance_rhs(&here, m->state.theta.hi, 0.0, radau->h).value);
    }
    inputs_advance(&m->inputs, radau->h);
    return true;
}

static double room_ahead(const Mechanism *m, int direction) {
    const double stop = direction > 0 ? m->params.stop.upper : m->params.stop.lower;
    return fmax(direction * (stop - m->state.theta.hi - m->state.theta.lo), 0.0);
}

/* Where the edge of the band stops rising, following it ends, ever faster, in a jump: a fold. Nearer to it than this
 * share of a piece's width the rounding of the torques is all that moves theta; what a jump from there leaves out of the
 * energies is of the third power of it. */
static const double FOLD = 3e-6;

/* False if a value would not be finite. */
static bool take_jump(Mechanism *m, int direction, const Jump *jump, Segment *segment) {
    const Booking *b = &jump->booking;
    if (!isfinite(jump->dtheta + b->work_in + b->work_ext + b->heat_cam[0] + b->heat_cam[1])) return false;
    if (m->params.ledger) {
        Peaks *peak = &m->state.ledger.peak;
        ledger_book(&m->state.ledger, &jump->booking);
        peak_raise(&peak->torque, m->inputs.tau[0]);
        for (int i = 0; i < 2; i++) peak_raise(&peak->reaction[i], jump->reaction[i] / m->params.contacts);
    }
    rotate(m, jump->dtheta);
    stand_still(m);
    segment->kind = SEGMENT_JUMP;
    if (jump->stopped) land(m, direction, EVENT_STOP, segment);
    return true;
}

static bool must_jump(const Mechanism *m) {
    if (present_slip_mode(m, present_index(m)).regime != REGIME_RATE_INDEPENDENT) return false;
    const Candidate candidate = candidate_of(m, present_index(m));
    return !(candidate.stiffness > 0.0) || decide_jump(&candidate, direction_of(m->state.mode));
}

/* A jump that leads nowhere, on an edge that holds the torque to rounding, is rest. */
static double jump_or_hold(Mechanism *m, double left, Segment *segment) {
    const int direction = direction_of(m->state.mode);
    Jump jump;
    play_jump(m, direction, m->inputs.tau[0], 0.0, &jump);
    if (!take_jump(m, direction, &jump, segment)) return NAN;
    return jump.stopped || jump.dtheta != 0.0 ? 0.0 : hold(m, left, segment);
}

static bool is_at_fold(const SlipMode *slip, const EventLocation *location, double left) {
    const RadauStep *radau = &location->radau;
    if (slip->regime != REGIME_RATE_INDEPENDENT || location->kind != EVENT_NONE || location->at_breakpoint ||
        radau->h >= left)
        return false;
    const bool slower = fabs(radau->node[radau->method->stages - 1].omega) < fabs(radau->start.omega);
    const bool noisy = radau->noise > slip->params->tolerance * fabs(radau->dtheta);
    return !slower && ((noisy && inputs_load_constant(slip->inputs)) ||
                       fabs(radau->dtheta) <= FOLD * (slip->piece->upper - slip->piece->lower));
}

/* How much higher the edge still is at the fold, at most, N.m. */
static double fold_height(const SlipMode *slip, const Balance *start) {
    return FOLD * (slip->piece->upper - slip->piece->lower) * fabs(start->rhs.by_theta);
}

/* For how long, up to `left` seconds, the torque grows in `direction` while F_ext stays; 0 if F_ext does not. */
static double growing_time(const Inputs *in, int direction, double left) {
    if (!inputs_load_constant(in)) return 0.0;
    const double rate[INPUT_ORDER + 1] = {direction * in->tau[1], direction * in->tau[2], direction * in->tau[3]};
    const Bernstein p = bernstein_of_taylor(rate, left);
    return left * fmin(bernstein_descent(&p), 1.0);
}

/* Where the edge of the band is level, theta says nothing of the time, but the torque says all of theta: as long as it
 * grows, theta goes where a jump of the torque would take it. Returns how long that is. */
static double follow_by_torque(Mechanism *m, int direction, double t, Segment *segment) {
    Inputs after = m->inputs;
    inputs_advance(&after, t);
    Jump jump;
    play_jump(m, direction, after.tau[0], 0.0, &jump);
    if (!take_jump(m, direction, &jump, segment)) return NAN;
    m->inputs = after;
    enter_anew(m);
    if (is_slip(m->state.mode)) {
        const SlipMode slip = present_slip_mode(m, present_index(m));
        m->state.omega = sum_of(balance_from_here(m, &slip).omega);
    }
    if (m->params.ledger) {
        peak_raise(&m->state.ledger.peak.torque, after.tau[0]);
        peak_raise(&m->state.ledger.peak.omega, m->state.omega.hi);
    }
    return t;
}

/* At a fold, or where the edge is level: *took is how long it took to pass, or NAN if a value is not finite. False if there
 * is nothing to pass. */
static bool pass_fold(Mechanism *m, const SlipMode *slip, const Balance *start, double left, double *took,
                      Segment *segment) {
    const double grows = growing_time(&m->inputs, slip->direction, left);
    if (grows > 0.0) {
        *took = follow_by_torque(m, slip->direction, grows, segment);
        return true;
    }
    Jump jump;
    play_jump(m, slip->direction, m->inputs.tau[0], fold_height(slip, start), &jump);
    if (!jump.stopped && jump.dtheta == 0.0) return false;
    *took = take_jump(m, slip->direction, &jump, segment) ? 0.0 : NAN;
    return true;
}

/* Slips along `way` for up to `left` seconds, to the first event; returns how long, or NAN if a value is not finite. */
static double leap_along(Mechanism *m, const SlipMode *slip, const Balance *start, double left, Segment *segment) {
    const double room = room_ahead(m, slip->direction);
    EventLocation *location = &segment->location;
    if (room <= 0.0) {
        land(m, slip->direction, EVENT_STOP, segment);
        return 0.0;
    }
    const bool found = event_location_find(slip, start, room, left, &m->cache.radau, location);
    const bool folds = slip->regime == REGIME_RATE_INDEPENDENT && (!found || is_at_fold(slip, location, left));
    double took = 0.0;
    if (folds && pass_fold(m, slip, start, left, &took, segment)) return took;
    if (folds && !found) return hold(m, left, segment);
    if (!found) {
        jam(m);
        return 0.0;
    }
    if (!commit_leap(m, slip, location)) return NAN;
    m->cache.radau = location->next;
    segment->kind = SEGMENT_RADAU;
    land(m, slip->direction, location->kind, segment);
    return location->radau.h;
}

static double leap_to_event(Mechanism *m, double left, Segment *segment) {
    const SlipMode slip = present_slip_mode(m, present_index(m));
    const Balance start = balance_from_here(m, &slip);
    return leap_along(m, &slip, &start, left, segment);
}

/* Is each contact on its flank by more than rounding? Else its rate tells, which decide() asks for. */
static bool is_firm(const Mechanism *m, const SlipMode *slip, const Balance *b) {
    const double load = balance_load_size(&m->params, b->force, b->damper, b->dz_dtheta * b->alpha);
    return balance_is_firm(slip, 0, b->x[0], b->axial[0], load) && balance_is_firm(slip, 1, b->x[1], b->axial[1], load);
}

/* Without inertia it starts from rest at any time: is it still driven, and on the spring's flanks, which are then the
 * damper's too? */
static bool is_driven(const Mechanism *m, const SlipMode *slip) {
    const double load = stick_axial_load(m);
    const bool springs = slip->flank[0] * load > 0.0 && slip->flank[1] * load > 0.0;
    return (springs || !has_friction(&m->params)) && stick_pressed(m) == slip->direction;
}

/* Would decide() find the motion along `way` again? A short answer, for the common case. */
static bool goes_on(const Mechanism *m, const SlipMode *slip, const Balance *start) {
    if (!start->rhs.possible || !(slip->direction * start->omega > 0.0)) return false;
    if (has_friction(&m->params) && !is_firm(m, slip, start)) return false;
    if (slip->regime == REGIME_INERTIAL) return true;
    return slip->regime == REGIME_VISCOUS && start->rhs.stable && is_driven(m, slip);
}

/* The largest values in between, by way of a leap. */
static void record_inside(Mechanism *m, const SlipMode *slip, double h) {
    const Balance start = balance_from_here(m, slip);
    EventLocation location;
    if (radau_step_solve(slip, &start, h, RADAU_MAX, &location.radau)) record_passage(m, slip, &location);
}

static void record_glide(Mechanism *m, const SlipMode *slip, const LobattoStep *lobatto) {
    Peaks *peak = &m->state.ledger.peak;
    ledger_book(&m->state.ledger, &lobatto->booking);
    peak_raise(&peak->omega, lobatto->peak_omega);
    peak_raise(&peak->torque, m->inputs.tau[0]);
    peak_raise(&peak->torque, lobatto->tau);
    record_input_peaks(m, lobatto->h);
    for (int i = 0; i < 2; i++) peak_raise(&peak->reaction[i], lobatto->peak_reaction[i]);
    if (lobatto->peaks_inside) record_inside(m, slip, lobatto->h);
}

static void commit_glide(Mechanism *m, const SlipMode *slip, const LobattoStep *lobatto) {
    if (m->params.ledger) record_glide(m, slip, lobatto);
    rotate(m, lobatto->dtheta);
    if (slip->regime == REGIME_INERTIAL) {
        sum_add(&m->state.omega, lobatto->domega);
    } else {
        m->state.omega = sum_of(lobatto->omega);
    }
    if (!slip->steady) inputs_advance(&m->inputs, lobatto->h);
}

/* Is it moving, in a mode in which it should? */
static bool slips_on(const Mechanism *m) {
    return is_slip(m->state.mode) && direction_of(m->state.mode) == sign_of(m->state.omega.hi);
}

/* An easy step of at most `left` seconds in which nothing happens, see lobatto_step_along(). */
static bool find_glide(const Mechanism *m, const SlipMode *slip, double left, LobattoStep *lobatto) {
    const State *s = &m->state;
    if (slip->regime == REGIME_RATE_INDEPENDENT || (slip->regime == REGIME_VISCOUS && !is_driven(m, slip)))
        return false;
    const LobattoStart from = {
        s->theta.hi,    s->omega.hi, m->configuration.z, &m->configuration.geometry, room_ahead(m, slip->direction),
        &s->ledger.peak};
    return lobatto_step_along(slip, &from, left, lobatto);
}

/* Slips on through grooves of any shape until something happens, or *legs are `most`: it counts on, but for those that
 * lead to a border of a piece, of which there are so many and no more. Returns how much of h seconds is left, or NAN if
 * a value is not finite. `refused`, unless NULL: the glide that was sought for the first stretch, and is none. */
static double leap_on(Mechanism *m, double h, const LobattoStep *refused, int *legs, int most) {
    double left = h;
    for (; left > 0.0 && *legs < most && slips_on(m); refused = NULL) {
        const SlipMode slip = present_slip_mode(m, present_index(m));
        LobattoStep lobatto;
        lobatto.accurate = false;
        const bool may_do = refused == NULL && left <= m->cache.radau.h; /* else more stages than it has are needed */
        if (may_do && find_glide(m, &slip, left, &lobatto)) {
            commit_glide(m, &slip, &lobatto);
            if (lobatto.h == left) return 0.0;
            left -= lobatto.h;
            continue;
        }
        const Balance start = balance_from_here(m, &slip);
        if (!goes_on(m, &slip, &start)) break;
        const LobattoStep *sought = refused != NULL ? refused : &lobatto;
        if (!sought->accurate && m->cache.radau.stages <= RADAU_MIN) m->cache.radau.stages = RADAU_MIN + 2;
        Segment segment;
        segment.kind = SEGMENT_NONE;
        segment.end = EVENT_NONE;
        left -= leap_along(m, &slip, &start, left, &segment);
        if (segment.kind != SEGMENT_RADAU || segment.end != EVENT_NONE) break;
        *legs += !segment.location.for_breakpoint;
    }
    return left;
}

static void book_jump(Mechanism *m, const LinearSegment *s, double dtheta) {
    const Booking booking = linear_slip_jump_booking(s->linear, s->params, s->geometry, &s->start, dtheta);
    ledger_book(&m->state.ledger, &booking);
    peak_raise(&m->state.ledger.peak.torque, s->start.tau);
    for (int i = 0; i < 2; i++) {
        const double x = s->linear->transfer.axial[i] * s->linear->reaction[i];
        peak_raise(&m->state.ledger.peak.reaction[i], x * s->start.force);
        peak_raise(&m->state.ledger.peak.reaction[i],
                   x * (s->start.force + s->params->spring.stiffness * s->geometry->dz_dtheta * dtheta));
    }
}

/* Without inertia and damping theta is the play operator of tau: it moves at once, just far enough
 * that tau is on the edge of the band, or to the stop, or to where F changes its sign and with it the
 * flanks. Returns false if tau is on the edge already. */
static bool jump(Mechanism *m, const LinearSlipMode *slip, Segment *segment) {
    const LinearSegment s = stretch_of(m, slip);
    const double sign = slip->direction, force = s.start.force, net = sign * linear_slip_net_torque(slip, &s.start);
    const bool stable = slip->stiffness > 0.0; /* else the way on asks for less and less torque */
    const Candidate candidate = candidate_of(m, present_index(m));
    if (stable && !decide_jump(&candidate, slip->direction)) return false;
    const double spring = sign * m->params.spring.stiffness * m->configuration.geometry.dz_dtheta;
    const bool mirrors = force * spring < 0.0 && fabs(force) > stick_tie(m) * stick_axial_size(m);
    const double to_edge = stable ? net / slip->stiffness : INFINITY;
    const double to_mirror = mirrors ? -force / spring : INFINITY;
    const double distance = fmin(to_edge, fmin(to_mirror, s.room));
    if (m->params.ledger) book_jump(m, &s, sign * distance);
    rotate(m, sign * distance);
    stand_still(m);
    segment->kind = SEGMENT_JUMP;
    if (distance == s.room) land(m, slip->direction, EVENT_STOP, segment);
    return true;
}

/* ---- the step ---- */

/* On a dwell, where z' = 0, the follower's mass and damper resist no motion. With a follower that has mass the shaft's
 * damping alone does not help: speed is a state then. */
static bool nothing_resists(const Mechanism *m) {
    const double LEVEL = 1e-3; /* of the steepest slope: near enough to a dwell to run away */
    const bool damped = m->params.shaft.damping > 0.0 && !has_inertia(&m->params);
    const bool follower_only = m->params.inertia.shaft == 0.0 && !damped;
    return follower_only && m->configuration.geometry.dz_dtheta <= LEVEL * m->model.transmission.slope_size;
}

void segment_enter(Mechanism *m) {
    enter_anew(m);
}

double segment_run(Mechanism *m, double left, Segment *segment) {
    segment->kind = SEGMENT_NONE;
    segment->end = EVENT_NONE;
    if (is_jammed(m)) {
        jam(m);
        return 0.0;
    }
    /* pressed beyond a finite edge, and yet there is no motion that agrees: it would be infinitely fast */
    if (m->state.mode == MODE_WEDGED && nothing_resists(m) && stick_pressed(m) != 0) return NAN;
    if (!is_slip(m->state.mode)) return hold(m, left, segment);
    if (!is_closed_form(m)) return must_jump(m) ? jump_or_hold(m, left, segment) : leap_to_event(m, left, segment);
    const LinearSlipMode *slip = kept_slip(m, present_index(m));
    if (slip->regime == REGIME_RATE_INDEPENDENT && jump(m, slip, segment)) return 0.0;
    return slip_to_event(m, left, segment);
}

static void undo(Mechanism *m, const State *state, const Inputs *inputs) {
    m->state = *state;
    m->inputs = *inputs;
    update_configuration(m);
    forget(&m->cache);
}

static const char *failure_of(const Mechanism *m, double left, int jams) {
    if (nothing_resists(m))
        return "nothing resists the motion on a dwell, where inertia.shaft, or without any inertia shaft.damping, must "
               "be > 0";
    if (!(left > 0.0)) return "the motion leaves the range of numbers";
    if (jams >= MAX_JAMS_PER_STEP) return "the contacts jam and let go without end";
    return "the mode changes too often";
}

/* After undo(), of a step in which `what` was found to go wrong. */
static void describe_failure(Fault *fault, const Mechanism *m, double h, const char *what) {
    snprintf(fault->text, sizeof fault->text,
             "step of %.17g s at theta = %.17g, omega = %.17g, tau = %.17g: %s; allowed are finite values, %d mode "
             "changes, of which %d take at least %g of the step, and %d jams",
             h, m->state.theta.hi, m->state.omega.hi, m->inputs.tau[0], what, (int)MAX_EVENTS_PER_STEP,
             (int)WATCHED_EVENTS, LEAST_PROGRESS, (int)MAX_JAMS_PER_STEP);
}

/* Tells the watcher, if there is one, of another mode. Returns for how long to go on. */
static double report(const Mechanism *m, Watcher *watcher, double left) {
    const int mode = (int)m->state.mode;
    if (watcher == NULL || watcher->mode == 0 || watcher->mode == mode || is_jammed(m)) return left;
    watcher->mode = mode;
    const double on = watcher->changed(watcher, left);
    watcher->cut += left - on;
    return on;
}

/* At rest under constant inputs nothing has changed since the mode was decided. */
static bool rests_on(const Mechanism *m, const Segment *latest) {
    return latest->kind == SEGMENT_REST && !is_slip(m->state.mode) && inputs_constant(&m->inputs);
}

/* Returns how much of `left` seconds is left: 0, or more if there is no end of events, or NAN. */
static double advance_through_events(Mechanism *m, double left, Watcher *watcher, int *jams) {
    const double least = LEAST_PROGRESS * left;
    double before = INFINITY;
    int legs = 0, check = 0; /* `check`: when to look whether it gets on */
    Segment segment;
    while (legs < MAX_EVENTS_PER_STEP && *jams < MAX_JAMS_PER_STEP && left > 0.0) {
        if (legs >= check) {
            if (before - left < least) break;
            before = left;
            check = legs + WATCHED_EVENTS;
        }
        segment_enter(m);
        left = report(m, watcher, left);
        if (left == 0.0) return 0.0;
        *jams += is_jammed(m);
        const int mode = (int)m->state.mode;
        const double took = segment_run(m, left, &segment);
        left -= took;
        legs++;
        if (watcher != NULL && took > 0.0) watcher->mode = mode;
        if (segment.kind == SEGMENT_RADAU && segment.end == EVENT_NONE) left = leap_on(m, left, NULL, &legs, check);
    }
    if (left != 0.0) return left;
    if (!rests_on(m, &segment)) segment_enter(m); /* the mode at the communication point itself */
    return report(m, watcher, 0.0);
}

/* A glide at the start of a step of h seconds, if it slips then, and the way of it. */
static bool glides_first(const Mechanism *m, double h, SlipMode *slip, LobattoStep *lobatto) {
    if (!slips_on(m)) return false;
    *slip = present_slip_mode(m, present_index(m));
    return find_glide(m, slip, h, lobatto);
}

bool mechanism_advance_watched(Mechanism *m, double h, Watcher *watcher, Fault *fault) {
    const bool constant = inputs_constant(&m->inputs);
    if (constant && hold_again(m)) {
        remember_step(m, h);
        return true;
    }
    const bool closed = constant ? m->model.closed_form : is_closed_form(m);
    if (closed && slip_on(m, h)) return true;
    SlipMode slip;
    LobattoStep lobatto;
    lobatto.accurate = false;
    const bool glides = !closed && glides_first(m, h, &slip, &lobatto);
    if (glides && lobatto.h == h) {
        remember_step(m, h);
        commit_glide(m, &slip, &lobatto);
        return true;
    }
    const State state = m->state;
    const Inputs inputs = m->inputs;
    m->cache.radau = (StepProposal){INFINITY, 0}; /* a step depends on nothing but state and inputs */
    Step step;
    begin_step(m, h, &step);
    double left = h;
    if (glides) {
        commit_glide(m, &slip, &lobatto);
        left -= lobatto.h;
    }
    int legs = 0;
    if (!closed) left = leap_on(m, left, glides ? NULL : &lobatto, &legs, WATCHED_EVENTS);
    int jams = 0;
    if (watcher != NULL && left < h) watcher->mode = (int)m->state.mode;
    if (left > 0.0) left = advance_through_events(m, left, watcher, &jams);
    if (left == 0.0) {
        if (watcher != NULL) step.h -= watcher->cut;
        forget_tunables(&m->state);
        m->state.step = step;
        return true;
    }
    const char *const what = failure_of(m, left, jams);
    undo(m, &state, &inputs);
    describe_failure(fault, m, h, what);
    return false;
}

bool mechanism_advance(Mechanism *m, double h, Fault *fault) {
    return mechanism_advance_watched(m, h, NULL, fault);
}

/* ---- events without time ---- */

void mechanism_set_motion(Mechanism *m, double theta, double omega) {
    m->state.theta = sum_of(theta);
    m->state.omega = sum_of(omega);
    update_configuration(m);
}

/* A solver finds the instant at which it is at a stop to its own rounding, on either side. */
static void land_where_it_is(Mechanism *m) {
    static const double AT_STOP = 1e-13; /* of the largest angle */
    if (!is_slip(m->state.mode)) return;
    const int direction = direction_of(m->state.mode);
    if (direction * m->state.omega.hi <= 0.0) stand_still(m);
    if (room_ahead(m, direction) <= AT_STOP * largest_angle(&m->params)) hit_stop(m, direction);
}

bool mechanism_settle(Mechanism *m, Fault *fault) {
    const State before = m->state;
    if (m->continuous) land_where_it_is(m); /* a step has done so */
    int jams = 0;
    for (; jams < MAX_JAMS_PER_STEP; jams++) {
        enter_anew(m);
        if (!is_jammed(m)) break;
        jam(m);
    }
    if (m->continuous) m->state.ledger = before.ledger;
    if (jams < MAX_JAMS_PER_STEP) return true;
    undo(m, &before, &m->inputs);
    describe_failure(fault, m, 0.0, failure_of(m, 1.0, jams));
    return false;
}

/* ---- the latest step ---- */

static Tunables tunables_of(const Params *p) {
    return (Tunables){{p->cam[0].friction, p->cam[1].friction}, p->spring, p->damper};
}

static void remember_tunables(Mechanism *m, const Params *next) {
    const Tunables before = tunables_of(&m->params), after = tunables_of(next);
    State *s = &m->state;
    if (!(s->step.h > 0.0) || s->step.retuned || memcmp(&before, &after, sizeof before) == 0) return;
    s->tunables = before;
    s->step.retuned = 1;
}

COLD void mechanism_rewind(Mechanism *m) {
    State *s = &m->state;
    const Step *step = &s->step;
    s->theta = step->theta;
    s->omega = step->omega;
    s->mode = step->mode;
    memcpy(s->flank, step->flank, sizeof s->flank);
    m->inputs = step->inputs;
    if (!step->retuned) {
        update_configuration(m);
        forget(&m->cache);
        return;
    }
    const Tunables *t = &s->tunables;
    for (int i = 0; i < 2; i++) m->params.cam[i].friction = t->friction[i];
    m->params.spring = t->spring;
    m->params.damper = t->damper;
    build_model(m);
}

/* ---- start and tuning ---- */

bool mechanism_start(Mechanism *m, Fault *fault) {
    if (!check_initial(&m->params, fault) || !mechanism_rebuild(m, fault)) return false;
    m->state = (State){
        .theta = sum_of(m->params.initial.theta),
        .omega = sum_of(has_inertia(&m->params) ? m->params.initial.omega : 0.0),
        .mode = MODE_STICK,
        .flank = {1, 1},
    };
    update_configuration(m);
    ledger_open(&m->state.ledger, stored_energy(m));
    enter_anew(m);
    m->state.events = 0;
    return true;
}

bool mechanism_retune(Mechanism *m, const Params *params, Fault *fault) {
    if (!check_params(params, fault) || !check_jam(params, &m->model.transmission, fault)) return false;
    const double z = axial_position(m);
    const double jump = spring_energy(&params->spring, z) - spring_energy(&m->params.spring, z);
    if (m->params.ledger && jump != 0.0) sum_add(&m->state.ledger.work_tuning, jump);
    remember_tunables(m, params);
    m->params = *params;
    build_model(m);
    return true;
}

/* ---- outputs ---- */

void mechanism_motion(const Mechanism *m, Motion *out) {
    out->z = axial_position(m);
    out->v = m->configuration.geometry.dz_dtheta * m->state.omega.hi;
}

/* T_release/T_load; where both vanish with F_0, the ratio they had before. */
static double efficiency(const Mechanism *m, const EdgeFactors *f, double F_0) {
    const double load = F_0 == 0.0 ? f->load : stick_edge(f->load, F_0);
    const double release = F_0 == 0.0 ? f->release : stick_edge(f->release, F_0);
    if (load == 0.0 && release == 0.0) return has_friction(&m->params) ? 0.0 : 1.0;
    return release / load;
}

static void leap_loads(const Mechanism *m, int index, LoadOutputs *out) {
    const SlipMode slip = present_slip_mode(m, index);
    const Balance now = balance_from_here(m, &slip);
    out->alpha = now.alpha;
    if (slip.regime != REGIME_INERTIAL) {
        Taylor t;
        taylor_of_motion(m, &slip, KNOWN_COUNT, 1, &t);
        out->alpha = t.omega.c[1].value;
    }
    for (int i = 0; i < 2; i++) out->reaction[i] = now.x[i] * sqrt(now.length2[i]) / m->params.contacts;
}

static void slip_loads(const Mechanism *m, const LinearSlipMode *slip, LoadOutputs *out) {
    const SlipStart l = slip_start_of(m, slip);
    const LinearMotion now = linear_slip_motion_at_start(slip, &l);
    out->alpha = now.alpha;
    for (int i = 0; i < 2; i++) {
        const ContactLoad c = linear_slip_contact(slip, &m->params, &m->configuration.geometry, &l, &now, i);
        out->reaction[i] = c.value * slip->reaction[i];
    }
}

void mechanism_loads(const Mechanism *m, LoadOutputs *out) {
    const Geometry *g = &m->configuration.geometry;
    const double F_0 = stick_axial_load(m);
    const EdgeFactors f = stick_edges(m, F_0);
    const Decision now = decision_of(m);
    *out = (LoadOutputs){
        .gamma = m->model.transmission.straight ? g->dpsi_dtheta[0] * m->state.theta.hi
                                                : transmission_gamma(&m->model.transmission, m->state.theta.hi),
        .spring_force = spring_force(&m->params.spring, axial_position(m)),
        .damper_force = damper_force(&m->params.damper, sign_of(m->state.omega.hi), g->dz_dtheta * m->state.omega.hi),
        .torque_load = stick_edge(f.load, F_0),
        .torque_release = stick_edge(f.release, F_0),
        .efficiency = efficiency(m, &f, F_0),
        .mode = (int)now.mode,
        .events = m->state.events,
    };
    for (int i = 0; i < 2; i++) {
        out->sliding_speed[i] = g->dpsi_dtheta[i] * fabs(m->state.omega.hi) * cam_length(g, i);
        out->reaction[i] = stick_reaction(m, i);
    }
    if (!is_slip(now.mode)) return;
    LinearSlipMode room;
    if (is_closed_form(m)) slip_loads(m, linear_slip_of(m, now.slip_index, &room), out);
    else leap_loads(m, now.slip_index, out);
}

void mechanism_energy(const Mechanism *m, Energy *out) {
    const Ledger *l = &m->state.ledger;
    *out = (Energy){
        .work_in = l->work_in.hi,
        .work_ext = l->work_ext.hi,
        .work_tuning = l->work_tuning.hi,
        .spring = spring_energy(&m->params.spring, axial_position(m)),
        .kinetic = kinetic_energy(m),
        .heat_cam = {l->heat_cam[0].hi, l->heat_cam[1].hi},
        .heat_damper = l->heat_damper.hi,
        .heat_shaft = l->heat_shaft.hi,
        .heat_stop = l->heat_stop.hi,
    };
}

void mechanism_audit(const Mechanism *m, Audit *out) {
    const bool keeps = m->params.ledger && !m->continuous;
    out->residual = keeps ? ledger_residual(&m->state.ledger, stored_energy(m)) : 0.0;
}
