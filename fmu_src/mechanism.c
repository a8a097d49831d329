#include "mechanism.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "bernstein.h"
#include "check.h"
#include "decide.h"
#include "event.h"
#include "glide.h"
#include "leg.h"
#include "play.h"
#include "rare.h"
#include "rates.h"
#include "stick.h"

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
    const Geometry *g = &m->place.geometry;
    return kinetic_energy_of(&m->params.inertia, g->lift, g->turn[0], m->state.omega.hi);
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
static void keep_slip(Mechanism *m, const Slip *built) {
    if (built->direction == 0) return;
    const int index = slip_index(built->direction, built->flank);
    m->model.slip[index] = *built;
    m->model.slips |= 1u << index;
}

/* That way to slip, built if it has not been yet. */
static inline const Slip *kept_slip(Mechanism *m, int index) {
    Slip built;
    if ((m->model.slips >> index & 1u) == 0) keep_slip(m, slip_of(m, index, &built));
    return &m->model.slip[index];
}

/* To be called whenever theta changes. */
static void arrive(Mechanism *m) {
    const Course *course = &m->model.course;
    Place *place = &m->place;
    if (course->straight) {
        place->z = place->geometry.lift * m->state.theta.hi;
        return;
    }
    const Spot spot = piece_spot(course_piece(course, m->state.theta.hi, 0), m->state.theta.hi, SPOT_SLOPES);
    place->geometry = cam_geometry(m->params.cam, spot.slope);
    place->z = spot.z;
}

static void forget(Cache *cache) {
    cache->hold.valid = false;
    cache->leap = (Stride){INFINITY, 0};
    for (int i = 0; i < SLIP_COUNT; i++) cache->kernel[i].t = NAN;
}

/* All that follows from params and course. */
static void build_model(Mechanism *m) {
    const Course *course = &m->model.course;
    m->model.closed_form = USE_CLOSED_FORM && course->straight && is_linear(&m->params);
    if (course->straight) {
        const double slope[2] = {course->piece->slope[0][0], course->piece->slope[0][1]};
        m->place = (Place){.geometry = cam_geometry(m->params.cam, slope)};
        m->place.band = contact_band(&m->place.geometry);
    }
    m->model.slips = 0;
    arrive(m);
    forget(&m->cache);
}

bool mechanism_rebuild(Mechanism *m, Fault *fault) {
    if (!check_params(&m->params, fault) || !check_course(&m->params, m->resources, &m->model.course, fault)) return false;
    build_model(m);
    return true;
}

void mechanism_free(Mechanism *m) {
    course_free(&m->model.course);
    m->model.course = (Course){.count = 0};
}

static void enter(Mechanism *m, Decision d) {
    State *state = &m->state;
    if (state->mode != d.mode) {
        state->events++;
        state->mode = d.mode;
        m->cache.hold.valid = false;
    }
    if (is_slip(d.mode)) slip_flanks(d.slip, state->flank);
}

/* What has been built for it is kept. */
static void enter_anew(Mechanism *m) {
    Slip built;
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
    for (int i = 0; i <= load.degree; i++) load.c[i] += spring_force(&m->params.spring, m->place.z);
    const double F_0 = bernstein_value(&load, bernstein_peak(&load));
    for (int i = 0; i < 2; i++) peak_raise(&peak->reaction[i], stick_sharing(m, i) * F_0);
}

/* Stays at rest for up to `left` seconds; returns how long. */
static double hold(Mechanism *m, double left, Leg *leg) {
    leg->kind = LEG_REST;
    stand_still(m);
    if (m->params.ledger) record_rest(m);
    if (inputs_constant(&m->inputs)) {
        m->cache.hold = stick_hold(m); /* the next step at rest costs one comparison */
        return left;
    }
    /* on the very edge of the band, where no slip agrees, rounding could hold it for no time at all */
    const double t = fmax(stick_hold_time(m, left), DBL_EPSILON * left);
    if (m->params.ledger) record_input_peaks(m, t);
    inputs_advance(&m->inputs, t);
    if (m->params.ledger) record_rest(m);
    return t;
}

/* A step at rest under constant inputs, the hold known from before. */
static bool hold_again(Mechanism *m) {
    const Hold *hold = &m->cache.hold;
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

static Stretch stretch_of(const Mechanism *m, const Slip *slip) {
    Stretch stretch = {
        .slip = slip,
        .params = &m->params,
        .geometry = &m->place.geometry,
        .launch = launch_of(m, slip),
        .flanks = has_friction(&m->params),
    };
    const double stop = slip->direction > 0 ? m->params.stop.upper : m->params.stop.lower;
    stretch.room = fmax(slip->direction * (stop - m->state.theta.hi - m->state.theta.lo), 0.0);
    stretch.edge = slip->kind == FLOW_VISCOUS ? band_edge(m, slip->direction) : slip->transfer.rho;
    return stretch;
}

static int present_index(const Mechanism *m) {
    return slip_index(direction_of(m->state.mode), m->state.flank);
}

static void record_slip(Mechanism *m, const Stretch *s, const Ends *ends) {
    Peaks *peak = &m->state.ledger.peak;
    event_peaks(s, ends, peak);
    peak_raise(&peak->torque, s->launch.tau);
    peak_raise(&peak->torque, s->launch.tau + s->launch.tau_rate * ends->arc.t);
}

/* theta is known to rounding, which must not carry it past a stop. */
static void turn(Mechanism *m, double dtheta) {
    Sum *theta = &m->state.theta;
    sum_add(theta, dtheta);
    if (theta->hi > m->params.stop.upper) *theta = sum_of(m->params.stop.upper);
    if (theta->hi < m->params.stop.lower) *theta = sum_of(m->params.stop.lower);
    arrive(m);
}

/* Moves along the stretch to its end, and remembers the start of a communication step of `step` seconds that this is,
 * unless it is 0. False, with nothing changed, if a value would not be finite. */
static bool commit(Mechanism *m, const Stretch *s, const Ends *ends, Kernel *kernel, double step) {
    const Arc *arc = &ends->arc;
    const bool keeps = m->params.ledger;
    Booking booking;
    double all = arc->dtheta + arc->omega;
    if (keeps) {
        booking = slip_booking(s->slip, s->params, s->geometry, &s->launch, arc, kernel);
        all += booking.work_in + booking.heat_cam[0] + booking.heat_cam[1] + booking.heat_damper;
    }
    if (!(fabs(all) <= DBL_MAX)) return false;
    if (step > 0.0) remember_step(m, step);
    if (keeps) {
        ledger_book(&m->state.ledger, &booking);
        record_slip(m, s, ends);
    }
    turn(m, arc->dtheta);
    if (s->slip->kind == FLOW_INERTIAL && !arc->settled) {
        sum_add(&m->state.omega, arc->domega);
    } else {
        m->state.omega = sum_of(arc->omega);
    }
    if (s->launch.tau_rate != 0.0 || s->launch.F_ext_rate != 0.0) inputs_advance(&m->inputs, arc->t);
    return true;
}

/* Slips for `horizon` seconds, or to the first event before; but if this is a whole communication step of `step` seconds,
 * only if there is no event. False, with nothing changed, if there is, or a value would not be finite. */
static bool slip_along(Mechanism *m, const Slip *slip, Kernel *kernel, double horizon, double step, EventKind *end) {
    const Stretch stretch = stretch_of(m, slip);
    const Event last = step > 0.0 ? (Event){EVENT_NONE, horizon} : event_last(&stretch, horizon);
    if (kernel->t != last.t) oscillator_kernel(&slip->oscillator, last.t, kernel);
    Ends ends;
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
    const Slip *slip = kept_slip(m, index);
    if (slip->kind != FLOW_INERTIAL || !(slip->direction * m->state.omega.hi > 0.0)) return false;
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
    arrive(m);
    state->omega = sum_of(0.0 - m->params.stop.restitution * state->omega.hi);
    if (!has_inertia(&m->params)) stand_still(m);
    if (state->omega.hi != 0.0) {
        Slip built;
        built.direction = 0;
        const int slip = decide_slip(m, -direction, false, &built);
        keep_slip(m, &built);
        const double size = largest_angle(&m->params);
        const double back = slip < 0 ? 0.0 : direction * look_at(m, slip).alpha;
        if (state->omega.hi * state->omega.hi < 2.0 * back * NO_BOUNCE * size) stand_still(m);
    }
    stop_heat(m, before - kinetic_energy(m));
}

/* Velocity zero and stops are set to what they are by definition. A flank change moves nothing. */
static void land(Mechanism *m, int direction, EventKind kind, Leg *leg) {
    leg->end = kind;
    leg->omega = m->state.omega.hi;
    if (kind == EVENT_REST) stand_still(m);
    if (kind == EVENT_STOP) hit_stop(m, direction);
}

/* Slips for up to `left` seconds, to the first event; returns how long, or NAN if a value is not finite. */
static double slip_to_event(Mechanism *m, double left, Leg *leg) {
    const int index = present_index(m);
    const Slip *slip = kept_slip(m, index);
    const double horizon = fmin(left, slip->oscillator.horizon);
    Kernel kernel = m->cache.kernel[index];
    EventKind end;
    if (!slip_along(m, slip, &kernel, horizon, 0.0, &end)) return NAN;
    leg->kind = LEG_ARC;
    land(m, slip->direction, end, leg);
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
    const Geometry *g = &m->place.geometry;
    const double energy = kinetic_energy(m);
    double share[2];
    for (int i = 0; i < 2; i++)
        share[i] = cam_heat(g, i) * g->turn[i] / g->radius[i];
    stand_still(m);
    if (!m->params.ledger || energy == 0.0) return;
    const double sum = share[0] + share[1]; /* 0 where only a contact without friction slides */
    for (int i = 0; i < 2; i++) sum_add(&m->state.ledger.heat_cam[i], energy * (sum > 0.0 ? share[i] / sum : 0.5));
}

/* ---- slipping in grooves of any shape ---- */

static void record_passage(Mechanism *m, const Way *way, Passage *passage) {
    Peaks *peak = &m->state.ledger.peak;
    const Leap *leap = &passage->leap;
    const double known[2] = {peak->reaction[0] * m->params.contacts, peak->reaction[1] * m->params.contacts};
    passage_peaks(way, passage, peak->omega, known);
    peak_raise(&peak->omega, passage->omega);
    peak_raise(&peak->torque, leap->start.tau);
    peak_raise(&peak->torque, leap->node[leap->method->stages - 1].tau);
    record_input_peaks(m, leap->h);
    for (int i = 0; i < 2; i++) peak_raise(&peak->reaction[i], passage->reaction[i] / m->params.contacts);
}

/* Moves along the leap to its end; false if a value would not be finite. */
static bool commit_leap(Mechanism *m, const Way *way, Passage *passage) {
    const Leap *leap = &passage->leap;
    const Balance *end = &leap->node[leap->method->stages - 1];
    const Booking *b = &leap->booking;
    if (!isfinite(leap->dtheta + end->omega + b->work_in + b->heat_cam[0] + b->heat_cam[1] + b->heat_damper)) return false;
    if (m->params.ledger) {
        ledger_book(&m->state.ledger, &leap->booking);
        record_passage(m, way, passage);
    }
    turn(m, leap->dtheta);
    if (way->kind == FLOW_INERTIAL) {
        sum_add(&m->state.omega, leap->domega);
    } else {
        /* the law's own speed where it has got to, not where the last iteration was, or beyond a border of its piece */
        const Way here = way_of(&m->params, &m->model.course, &m->inputs, m->state.theta.hi, way->direction, way->flank);
        m->state.omega = sum_of(balance_pace(&here, m->state.theta.hi, 0.0, leap->h).value);
    }
    inputs_advance(&m->inputs, leap->h);
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
static bool take_jump(Mechanism *m, int direction, const Jump *jump, Leg *leg) {
    const Booking *b = &jump->booking;
    if (!isfinite(jump->dtheta + b->work_in + b->work_ext + b->heat_cam[0] + b->heat_cam[1])) return false;
    if (m->params.ledger) {
        Peaks *peak = &m->state.ledger.peak;
        ledger_book(&m->state.ledger, &jump->booking);
        peak_raise(&peak->torque, m->inputs.tau[0]);
        for (int i = 0; i < 2; i++) peak_raise(&peak->reaction[i], jump->reaction[i] / m->params.contacts);
    }
    turn(m, jump->dtheta);
    stand_still(m);
    leg->kind = LEG_JUMP;
    if (jump->stopped) land(m, direction, EVENT_STOP, leg);
    return true;
}

static bool must_jump(const Mechanism *m) {
    if (way_from_here(m, present_index(m)).kind != FLOW_QUASISTATIC) return false;
    const Look look = look_at(m, present_index(m));
    return !(look.stiffness > 0.0) || decide_jump(&look, direction_of(m->state.mode));
}

/* A jump that leads nowhere, on an edge that holds the torque to rounding, is rest. */
static double jump_or_hold(Mechanism *m, double left, Leg *leg) {
    const int direction = direction_of(m->state.mode);
    Jump jump;
    play_jump(m, direction, m->inputs.tau[0], 0.0, &jump);
    if (!take_jump(m, direction, &jump, leg)) return NAN;
    return jump.stopped || jump.dtheta != 0.0 ? 0.0 : hold(m, left, leg);
}


static bool is_at_fold(const Way *way, const Passage *passage, double left) {
    const Leap *leap = &passage->leap;
    if (way->kind != FLOW_QUASISTATIC || passage->kind != EVENT_NONE || passage->at_border || leap->h >= left)
        return false;
    const bool slower = fabs(leap->node[leap->method->stages - 1].omega) < fabs(leap->start.omega);
    const bool noisy = leap->noise > way->params->tolerance * fabs(leap->dtheta);
    return !slower && ((noisy && inputs_load_constant(way->inputs)) || fabs(leap->dtheta) <= FOLD * (way->piece->upper - way->piece->lower));
}

/* How much higher the edge still is at the fold, at most, N.m. */
static double fold_height(const Way *way, const Balance *start) {
    return FOLD * (way->piece->upper - way->piece->lower) * fabs(start->pace.by_theta);
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
static double follow_by_torque(Mechanism *m, int direction, double t, Leg *leg) {
    Inputs after = m->inputs;
    inputs_advance(&after, t);
    Jump jump;
    play_jump(m, direction, after.tau[0], 0.0, &jump);
    if (!take_jump(m, direction, &jump, leg)) return NAN;
    m->inputs = after;
    enter_anew(m);
    if (is_slip(m->state.mode)) {
        const Way way = way_from_here(m, present_index(m));
        m->state.omega = sum_of(balance_from_here(m, &way).omega);
    }
    if (m->params.ledger) {
        peak_raise(&m->state.ledger.peak.torque, after.tau[0]);
        peak_raise(&m->state.ledger.peak.omega, m->state.omega.hi);
    }
    return t;
}

/* At a fold, or where the edge is level: *took is how long it took to pass, or NAN if a value is not finite. False if there
 * is nothing to pass. */
static bool pass_fold(Mechanism *m, const Way *way, const Balance *start, double left, double *took, Leg *leg) {
    const double grows = growing_time(&m->inputs, way->direction, left);
    if (grows > 0.0) {
        *took = follow_by_torque(m, way->direction, grows, leg);
        return true;
    }
    Jump jump;
    play_jump(m, way->direction, m->inputs.tau[0], fold_height(way, start), &jump);
    if (!jump.stopped && jump.dtheta == 0.0) return false;
    *took = take_jump(m, way->direction, &jump, leg) ? 0.0 : NAN;
    return true;
}

/* Slips along `way` for up to `left` seconds, to the first event; returns how long, or NAN if a value is not finite. */
static double leap_along(Mechanism *m, const Way *way, const Balance *start, double left, Leg *leg) {
    const double room = room_ahead(m, way->direction);
    Passage *passage = &leg->passage;
    if (room <= 0.0) {
        land(m, way->direction, EVENT_STOP, leg);
        return 0.0;
    }
    const bool found = passage_find(way, start, room, left, &m->cache.leap, passage);
    const bool folds = way->kind == FLOW_QUASISTATIC && (!found || is_at_fold(way, passage, left));
    double took = 0.0;
    if (folds && pass_fold(m, way, start, left, &took, leg)) return took;
    if (folds && !found) return hold(m, left, leg);
    if (!found) {
        jam(m);
        return 0.0;
    }
    if (!commit_leap(m, way, passage)) return NAN;
    m->cache.leap = passage->next;
    leg->kind = LEG_LEAP;
    land(m, way->direction, passage->kind, leg);
    return passage->leap.h;
}

static double leap_to_event(Mechanism *m, double left, Leg *leg) {
    const Way way = way_from_here(m, present_index(m));
    const Balance start = balance_from_here(m, &way);
    return leap_along(m, &way, &start, left, leg);
}

/* Is each contact on its flank by more than rounding? Else its rate tells, which decide() asks for. */
static bool is_firm(const Mechanism *m, const Way *way, const Balance *b) {
    const double load = balance_load_size(&m->params, b->force, b->damper, b->lift * b->alpha);
    return balance_is_firm(way, 0, b->x[0], b->axial[0], load) && balance_is_firm(way, 1, b->x[1], b->axial[1], load);
}

/* Without inertia it starts from rest at any time: is it still driven, and on the spring's flanks, which are then the
 * damper's too? */
static bool is_driven(const Mechanism *m, const Way *way) {
    const double load = stick_axial_load(m);
    const bool springs = way->flank[0] * load > 0.0 && way->flank[1] * load > 0.0;
    return (springs || !has_friction(&m->params)) && stick_pressed(m) == way->direction;
}

/* Would decide() find the motion along `way` again? A short answer, for the common case. */
static bool goes_on(const Mechanism *m, const Way *way, const Balance *start) {
    if (!start->pace.possible || !(way->direction * start->omega > 0.0)) return false;
    if (has_friction(&m->params) && !is_firm(m, way, start)) return false;
    if (way->kind == FLOW_INERTIAL) return true;
    return way->kind == FLOW_VISCOUS && start->pace.stable && is_driven(m, way);
}

/* The largest values in between, by way of a leap. */
static void record_inside(Mechanism *m, const Way *way, double h) {
    const Balance start = balance_from_here(m, way);
    Passage passage;
    if (leap_solve(way, &start, h, RADAU_MAX, &passage.leap)) record_passage(m, way, &passage);
}

static void record_glide(Mechanism *m, const Way *way, const Glide *glide) {
    Peaks *peak = &m->state.ledger.peak;
    ledger_book(&m->state.ledger, &glide->booking);
    peak_raise(&peak->omega, glide->peak_omega);
    peak_raise(&peak->torque, m->inputs.tau[0]);
    peak_raise(&peak->torque, glide->tau);
    record_input_peaks(m, glide->h);
    for (int i = 0; i < 2; i++) peak_raise(&peak->reaction[i], glide->peak_reaction[i]);
    if (glide->peaks_inside) record_inside(m, way, glide->h);
}

static void commit_glide(Mechanism *m, const Way *way, const Glide *glide) {
    if (m->params.ledger) record_glide(m, way, glide);
    turn(m, glide->dtheta);
    if (way->kind == FLOW_INERTIAL) {
        sum_add(&m->state.omega, glide->domega);
    } else {
        m->state.omega = sum_of(glide->omega);
    }
    if (!way->steady) inputs_advance(&m->inputs, glide->h);
}

/* Is it moving, in a mode in which it should? */
static bool slips_on(const Mechanism *m) {
    return is_slip(m->state.mode) && direction_of(m->state.mode) == sign_of(m->state.omega.hi);
}

/* An easy step of at most `left` seconds in which nothing happens, see glide_along(). */
static bool find_glide(const Mechanism *m, const Way *way, double left, Glide *glide) {
    const State *s = &m->state;
    if (way->kind == FLOW_QUASISTATIC || (way->kind == FLOW_VISCOUS && !is_driven(m, way))) return false;
    const Launchpad from = {s->theta.hi, s->omega.hi, m->place.z, &m->place.geometry, room_ahead(m, way->direction),
                            &s->ledger.peak};
    return glide_along(way, &from, left, glide);
}

/* Slips on through grooves of any shape until something happens, or *legs are `most`: it counts on, but for those that
 * lead to a border of a piece, of which there are so many and no more. Returns how much of h seconds is left, or NAN if
 * a value is not finite. `refused`, unless NULL: the glide that was sought for the first stretch, and is none. */
static double leap_on(Mechanism *m, double h, const Glide *refused, int *legs, int most) {
    double left = h;
    for (; left > 0.0 && *legs < most && slips_on(m); refused = NULL) {
        const Way way = way_from_here(m, present_index(m));
        Glide glide;
        glide.accurate = false;
        const bool may_do = refused == NULL && left <= m->cache.leap.h; /* else more stages than it has are needed */
        if (may_do && find_glide(m, &way, left, &glide)) {
            commit_glide(m, &way, &glide);
            if (glide.h == left) return 0.0;
            left -= glide.h;
            continue;
        }
        const Balance start = balance_from_here(m, &way);
        if (!goes_on(m, &way, &start)) break;
        const Glide *sought = refused != NULL ? refused : &glide;
        if (!sought->accurate && m->cache.leap.stages <= RADAU_MIN) m->cache.leap.stages = RADAU_MIN + 2;
        Leg leg;
        leg.kind = LEG_NONE;
        leg.end = EVENT_NONE;
        left -= leap_along(m, &way, &start, left, &leg);
        if (leg.kind != LEG_LEAP || leg.end != EVENT_NONE) break;
        *legs += !leg.passage.for_border;
    }
    return left;
}

static void book_jump(Mechanism *m, const Stretch *s, double dtheta) {
    const Booking booking = slip_jump_booking(s->slip, s->params, s->geometry, &s->launch, dtheta);
    ledger_book(&m->state.ledger, &booking);
    peak_raise(&m->state.ledger.peak.torque, s->launch.tau);
    for (int i = 0; i < 2; i++) {
        const double x = s->slip->transfer.axial[i] * s->slip->reaction[i];
        peak_raise(&m->state.ledger.peak.reaction[i], x * s->launch.force);
        peak_raise(&m->state.ledger.peak.reaction[i],
                   x * (s->launch.force + s->params->spring.stiffness * s->geometry->lift * dtheta));
    }
}

/* Without inertia and damping theta is the play operator of tau: it moves at once, just far enough
 * that tau is on the edge of the band, or to the stop, or to where F changes its sign and with it the
 * flanks. Returns false if tau is on the edge already. */
static bool jump(Mechanism *m, const Slip *slip, Leg *leg) {
    const Stretch s = stretch_of(m, slip);
    const double sign = slip->direction, force = s.launch.force, net = sign * slip_net_torque(slip, &s.launch);
    const bool stable = slip->stiffness > 0.0; /* else the way on asks for less and less torque */
    const Look look = look_at(m, present_index(m));
    if (stable && !decide_jump(&look, slip->direction)) return false;
    const double spring = sign * m->params.spring.stiffness * m->place.geometry.lift;
    const bool mirrors = force * spring < 0.0 && fabs(force) > stick_tie(m) * stick_axial_size(m);
    const double to_edge = stable ? net / slip->stiffness : INFINITY;
    const double to_mirror = mirrors ? -force / spring : INFINITY;
    const double way = fmin(to_edge, fmin(to_mirror, s.room));
    if (m->params.ledger) book_jump(m, &s, sign * way);
    turn(m, sign * way);
    stand_still(m);
    leg->kind = LEG_JUMP;
    if (way == s.room) land(m, slip->direction, EVENT_STOP, leg);
    return true;
}

/* ---- the step ---- */

/* On a dwell, where z' = 0, the follower's mass and damper resist no motion. With a follower that has mass the shaft's
 * damping alone does not help: speed is a state then. */
static bool nothing_resists(const Mechanism *m) {
    const double LEVEL = 1e-3; /* of the steepest slope: near enough to a dwell to run away */
    const bool damped = m->params.shaft.damping > 0.0 && !has_inertia(&m->params);
    const bool follower_only = m->params.inertia.shaft == 0.0 && !damped;
    return follower_only && m->place.geometry.lift <= LEVEL * m->model.course.slope_size;
}

void leg_enter(Mechanism *m) {
    enter_anew(m);
}

double leg_run(Mechanism *m, double left, Leg *leg) {
    leg->kind = LEG_NONE;
    leg->end = EVENT_NONE;
    if (is_jammed(m)) {
        jam(m);
        return 0.0;
    }
    /* pressed beyond a finite edge, and yet there is no motion that agrees: it would be infinitely fast */
    if (m->state.mode == MODE_WEDGED && nothing_resists(m) && stick_pressed(m) != 0) return NAN;
    if (!is_slip(m->state.mode)) return hold(m, left, leg);
    if (!is_closed_form(m)) return must_jump(m) ? jump_or_hold(m, left, leg) : leap_to_event(m, left, leg);
    const Slip *slip = kept_slip(m, present_index(m));
    if (slip->kind == FLOW_QUASISTATIC && jump(m, slip, leg)) return 0.0;
    return slip_to_event(m, left, leg);
}

static void undo(Mechanism *m, const State *state, const Inputs *inputs) {
    m->state = *state;
    m->inputs = *inputs;
    arrive(m);
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
static bool rests_on(const Mechanism *m, const Leg *latest) {
    return latest->kind == LEG_REST && !is_slip(m->state.mode) && inputs_constant(&m->inputs);
}

/* Returns how much of `left` seconds is left: 0, or more if there is no end of events, or NAN. */
static double advance_through_events(Mechanism *m, double left, Watcher *watcher, int *jams) {
    const double least = LEAST_PROGRESS * left;
    double before = INFINITY;
    int legs = 0, check = 0; /* `check`: when to look whether it gets on */
    Leg leg;
    while (legs < MAX_EVENTS_PER_STEP && *jams < MAX_JAMS_PER_STEP && left > 0.0) {
        if (legs >= check) {
            if (before - left < least) break;
            before = left;
            check = legs + WATCHED_EVENTS;
        }
        leg_enter(m);
        left = report(m, watcher, left);
        if (left == 0.0) return 0.0;
        *jams += is_jammed(m);
        const int mode = (int)m->state.mode;
        const double took = leg_run(m, left, &leg);
        left -= took;
        legs++;
        if (watcher != NULL && took > 0.0) watcher->mode = mode;
        if (leg.kind == LEG_LEAP && leg.end == EVENT_NONE) left = leap_on(m, left, NULL, &legs, check);
    }
    if (left != 0.0) return left;
    if (!rests_on(m, &leg)) leg_enter(m); /* the mode at the communication point itself */
    return report(m, watcher, 0.0);
}

/* A glide at the start of a step of h seconds, if it slips then, and the way of it. */
static bool glides_first(const Mechanism *m, double h, Way *way, Glide *glide) {
    if (!slips_on(m)) return false;
    *way = way_from_here(m, present_index(m));
    return find_glide(m, way, h, glide);
}

bool mechanism_advance_watched(Mechanism *m, double h, Watcher *watcher, Fault *fault) {
    const bool constant = inputs_constant(&m->inputs);
    if (constant && hold_again(m)) {
        remember_step(m, h);
        return true;
    }
    const bool closed = constant ? m->model.closed_form : is_closed_form(m);
    if (closed && slip_on(m, h)) return true;
    Way way;
    Glide glide;
    glide.accurate = false;
    const bool glides = !closed && glides_first(m, h, &way, &glide);
    if (glides && glide.h == h) {
        remember_step(m, h);
        commit_glide(m, &way, &glide);
        return true;
    }
    const State state = m->state;
    const Inputs inputs = m->inputs;
    m->cache.leap = (Stride){INFINITY, 0}; /* a step depends on nothing but state and inputs */
    Step step;
    begin_step(m, h, &step);
    double left = h;
    if (glides) {
        commit_glide(m, &way, &glide);
        left -= glide.h;
    }
    int legs = 0;
    if (!closed) left = leap_on(m, left, glides ? NULL : &glide, &legs, WATCHED_EVENTS);
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

void mechanism_place(Mechanism *m, double theta, double omega) {
    m->state.theta = sum_of(theta);
    m->state.omega = sum_of(omega);
    arrive(m);
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

RARE void mechanism_rewind(Mechanism *m) {
    State *s = &m->state;
    const Step *step = &s->step;
    s->theta = step->theta;
    s->omega = step->omega;
    s->mode = step->mode;
    memcpy(s->flank, step->flank, sizeof s->flank);
    m->inputs = step->inputs;
    if (!step->retuned) {
        arrive(m);
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
    arrive(m);
    ledger_open(&m->state.ledger, stored_energy(m));
    enter_anew(m);
    m->state.events = 0;
    return true;
}

bool mechanism_retune(Mechanism *m, const Params *params, Fault *fault) {
    if (!check_params(params, fault) || !check_jam(params, &m->model.course, fault)) return false;
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
    out->v = m->place.geometry.lift * m->state.omega.hi;
}

/* T_release/T_load; where both vanish with F_0, the ratio they had before. */
static double efficiency(const Mechanism *m, const EdgeFactors *f, double F_0) {
    const double load = F_0 == 0.0 ? f->load : stick_edge(f->load, F_0);
    const double release = F_0 == 0.0 ? f->release : stick_edge(f->release, F_0);
    if (load == 0.0 && release == 0.0) return has_friction(&m->params) ? 0.0 : 1.0;
    return release / load;
}

static void leap_loads(const Mechanism *m, int index, Loads *out) {
    const Way way = way_from_here(m, index);
    const Balance now = balance_from_here(m, &way);
    out->alpha = now.alpha;
    if (way.kind != FLOW_INERTIAL) {
        Taylor t;
        rates_along(m, &way, KNOB_COUNT, 1, &t);
        out->alpha = t.omega.c[1].value;
    }
    for (int i = 0; i < 2; i++) out->reaction[i] = now.x[i] * sqrt(now.length2[i]) / m->params.contacts;
}

static void slip_loads(const Mechanism *m, const Slip *slip, Loads *out) {
    const Launch l = launch_of(m, slip);
    const Arc now = slip_arc_start(slip, &l);
    out->alpha = now.alpha;
    for (int i = 0; i < 2; i++) {
        const Contact c = slip_contact(slip, &m->params, &m->place.geometry, &l, &now, i);
        out->reaction[i] = c.value * slip->reaction[i];
    }
}

void mechanism_loads(const Mechanism *m, Loads *out) {
    const Geometry *g = &m->place.geometry;
    const double F_0 = stick_axial_load(m);
    const EdgeFactors f = stick_edges(m, F_0);
    const Decision now = decision_of(m);
    *out = (Loads){
        .gamma = m->model.course.straight ? g->turn[0] * m->state.theta.hi
                                          : course_gamma(&m->model.course, m->state.theta.hi),
        .spring_force = spring_force(&m->params.spring, axial_position(m)),
        .damper_force = damper_force(&m->params.damper, sign_of(m->state.omega.hi), g->lift * m->state.omega.hi),
        .torque_load = stick_edge(f.load, F_0),
        .torque_release = stick_edge(f.release, F_0),
        .efficiency = efficiency(m, &f, F_0),
        .mode = (int)now.mode,
        .events = m->state.events,
    };
    for (int i = 0; i < 2; i++) {
        out->sliding_speed[i] = g->turn[i] * fabs(m->state.omega.hi) * cam_length(g, i);
        out->reaction[i] = stick_reaction(m, i);
    }
    if (!is_slip(now.mode)) return;
    Slip room;
    if (is_closed_form(m)) slip_loads(m, slip_of(m, now.slip, &room), out);
    else leap_loads(m, now.slip, out);
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
