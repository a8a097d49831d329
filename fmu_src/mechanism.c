#include "mechanism.h"

#include <float.h>
#include <math.h>
#include <stdio.h>

#include "event.h"

/* A step with more mode changes than this is refused. At about a microsecond each that bounds the time a step
 * takes. Only bounces of a restitution near 1, or vibrations of a tiny inertia, come so often in one step. */
enum { MAX_EVENTS_PER_STEP = 200000 };

/* Moving contacts can jam (see jam()), and let go again at once. Without inertia of the shaft a locked contact
 * can do so for ever, in ever shorter time: rigid bodies under Coulomb friction then have no motion at all
 * (P. Painleve, 1895). */
enum { MAX_JAMS_PER_STEP = 1000 };

/* Torque and load are known to a few roundings; a difference below this share of their size is none. */
static const double TIE = 8.0 * DBL_EPSILON;

/* A bounce whose excursion is below this share of the angles involved is lost in the rounding of theta. */
static const double NO_BOUNCE = 16.0 * DBL_EPSILON;

static int sign_of(double x) {
    return (x > 0.0) - (x < 0.0);
}

static bool is_slip(Mode mode) {
    return mode == MODE_LOADING || mode == MODE_RELEASING;
}

static int direction_of(Mode mode) {
    return mode == MODE_LOADING ? 1 : -1;
}

static double axial_position(const Mechanism *m) {
    return m->model.geometry.lift * m->state.theta.hi;
}

static bool has_inertia(const Params *p) {
    return p->inertia.shaft > 0.0 || p->inertia.follower_mass > 0.0 || p->inertia.follower > 0.0;
}

static bool has_friction(const Params *p) {
    return p->cam[0].friction > 0.0 || p->cam[1].friction > 0.0;
}

/* J + m z'^2 + I gamma'^2, kg.m^2 */
static double total_inertia(const Mechanism *m) {
    const InertiaParams *i = &m->params.inertia;
    const Geometry *g = &m->model.geometry;
    return i->shaft + i->follower_mass * g->lift * g->lift + i->follower * g->turn[0] * g->turn[0];
}

static double kinetic_energy(const Mechanism *m) {
    return 0.5 * total_inertia(m) * m->state.omega.hi * m->state.omega.hi;
}

static double stored_energy(const Mechanism *m) {
    return spring_energy(&m->params.spring, axial_position(m)) + kinetic_energy(m);
}

/* ---- model ---- */

static void build_model(Model *model, const Params *params) {
    model->geometry = cam_geometry(params->cam);
    model->band = contact_band(&model->geometry);
    for (int direction = -1; direction <= 1; direction += 2) {
        for (int k = 0; k < 4; k++) {
            const int flank[2] = {k & 2 ? -1 : 1, k & 1 ? -1 : 1};
            Slip *slip = &model->slip[slip_index(direction, flank)];
            slip_build(slip, params, &model->geometry, direction, flank);
        }
    }
}

static void forget(Cache *cache) {
    cache->hold.valid = false;
    for (int i = 0; i < SLIP_COUNT; i++) cache->kernel[i].t = NAN;
}

void mechanism_rebuild(Mechanism *m) {
    build_model(&m->model, &m->params);
    forget(&m->cache);
}

bool mechanism_check(const Params *p, Fault *fault) {
    if (p->cam[0].lead_angle == 0.0 && p->cam[1].lead_angle == 0.0) {
        snprintf(fault->text, sizeof fault->text,
                 "cam1.lead_angle = 0 and cam2.lead_angle = 0: at least one must be > 0, or nothing fixes the pin");
        return false;
    }
    if (!(p->stop.lower < p->stop.upper)) {
        snprintf(fault->text, sizeof fault->text, "stop.lower = %.17g must be < stop.upper = %.17g", p->stop.lower,
                 p->stop.upper);
        return false;
    }
    if (!(p->initial.theta >= p->stop.lower && p->initial.theta <= p->stop.upper)) {
        snprintf(fault->text, sizeof fault->text,
                 "initial.theta = %.17g must lie in [stop.lower, stop.upper] = [%.17g, %.17g]", p->initial.theta,
                 p->stop.lower, p->stop.upper);
        return false;
    }
    const Geometry g = cam_geometry(p->cam);
    if (isinf(contact_band(&g).load)) {
        snprintf(fault->text, sizeof fault->text,
                 "cam1.lead_angle = %.17g, cam2.lead_angle = %.17g jam when loading at cam1.friction = %.17g, "
                 "cam2.friction = %.17g: kappa_1 + kappa_2 must be > 0",
                 p->cam[0].lead_angle, p->cam[1].lead_angle, p->cam[0].friction, p->cam[1].friction);
        return false;
    }
    return true;
}

/* ---- the stick band ---- */

typedef struct {
    double release, load; /* multiply F_0, signed: edges of the band; may be infinite */
} EdgeFactors;

/* For F_0 < 0 the pins bear on the other flanks: what was loading is now releasing. */
static EdgeFactors edge_factors(const BandFactors *band, double side) {
    if (side >= 0.0) return (EdgeFactors){.release = band->release, .load = band->load};
    return (EdgeFactors){.release = band->load, .load = band->release};
}

static double edge(double factor, double F_0) {
    return F_0 == 0.0 ? 0.0 : factor * F_0; /* no load, no friction, however locked */
}

static double axial_load(const Mechanism *m) {
    return spring_force(&m->params.spring, axial_position(m)) + m->inputs.F_ext[0];
}

/* The sign that F_0 has, or is about to take. */
static double load_side(const Mechanism *m, double F_0) {
    return F_0 != 0.0 ? F_0 : m->inputs.F_ext[1];
}

/* The size of what axial_load adds up: its rounding error is a few eps of this. */
static double axial_size(const Mechanism *m) {
    return fabs(m->params.spring.preload) + fabs(m->params.spring.stiffness * axial_position(m)) +
           fabs(m->inputs.F_ext[0]);
}

/* The size of tau - factor F_0, likewise. */
static double torque_size(const Mechanism *m, double factor) {
    return fabs(m->inputs.tau[0]) + fabs(factor) * axial_size(m);
}

/* Does the torque press past an edge of the band? At the edge itself its rate decides. */
static bool presses(double excess, double size, double rate) {
    if (fabs(excess) <= TIE * size) return rate > 0.0;
    return excess > 0.0;
}

/* +1: the torque loads, -1: it releases, 0: it is inside the stick band. The inclusion of section 3. */
static int pressed_direction(const Mechanism *m, double F_0) {
    const double tau = m->inputs.tau[0], tau_rate = m->inputs.tau[1], F_rate = m->inputs.F_ext[1];
    const EdgeFactors f = edge_factors(&m->model.band, load_side(m, F_0));
    const double load = edge(f.load, F_0), release = edge(f.release, F_0);
    if (isfinite(f.load) && presses(tau - load, torque_size(m, f.load), tau_rate - edge(f.load, F_rate))) return 1;
    if (isfinite(f.release) && presses(release - tau, torque_size(m, f.release), edge(f.release, F_rate) - tau_rate))
        return -1;
    return 0;
}

/* At rest and inside the band. Where an edge is infinite, torque beyond the frictionless balance
 * z' F_0 pushes into the wedge. */
static Mode resting_mode(const Mechanism *m, double F_0) {
    const EdgeFactors f = edge_factors(&m->model.band, load_side(m, F_0));
    const bool wedge_below = isinf(f.release), wedge_above = isinf(f.load);
    if (!wedge_below && !wedge_above) return MODE_STICK;
    const double lift = m->model.geometry.lift, tau = m->inputs.tau[0];
    const double size = torque_size(m, lift), rate = m->inputs.tau[1] - lift * m->inputs.F_ext[1];
    if (wedge_below && presses(lift * F_0 - tau, size, -rate)) return MODE_WEDGED;
    if (wedge_above && presses(tau - lift * F_0, size, rate)) return MODE_WEDGED;
    return MODE_STICK;
}

/* ---- choosing a mode: the friction inclusion, from torque and never from a small velocity ---- */

typedef struct {
    Mode mode;
    int slip; /* index into Model.slip; used in the slip modes */
} Decision;

static Launch launch_of(const Mechanism *m, const Slip *slip) {
    return slip_launch(slip, &m->params, &m->model.geometry, m->state.theta.hi, m->state.omega.hi, &m->inputs);
}

/* From rest the net torque must point the way of the slip, or vanish (its rate then decides). */
static bool starts(const Mechanism *m, const Slip *slip, const Launch *l) {
    return slip->direction * slip_net_torque(slip, l) >= -TIE * torque_size(m, slip->transfer.rho);
}

/* Quasi-static slip begins with a jump unless the torque is on the edge already. */
static bool jumps(const Mechanism *m, const Slip *slip, const Launch *l) {
    const double net = slip->direction * slip_net_torque(slip, l);
    return slip->kind == FLOW_QUASISTATIC && net > TIE * torque_size(m, slip->transfer.rho);
}

/* Is x_i on the flank that the slip assumes, or about to be? Where it is zero, its rate tells, and then the
 * rate of that. Zero throughout (no load at all) suits either flank. */
static bool flank_agrees(const Mechanism *m, const Slip *slip, const Launch *l, int i) {
    const Arc start = {.omega = l->omega, .alpha = l->alpha, .jerk = l->curvature - slip->oscillator.decay2 * l->alpha};
    const Contact c = slip_contact(slip, &m->params, &m->model.geometry, l, &start, i);
    const Contact size = slip_contact_size(slip, &m->params, &m->model.geometry, l, i);
    const double flank = slip->flank[i];
    if (fabs(c.value) > NO_REACTION * size.value) return flank * c.value > 0.0;
    if (jumps(m, slip, l)) /* only the spring's force changes */
        return flank * slip->direction * slip->transfer.axial[i] * m->params.spring.stiffness >= 0.0;
    if (fabs(c.rate) > NO_REACTION * size.rate) return flank * c.rate > 0.0;
    return fabs(c.curvature) <= NO_REACTION * size.curvature || flank * c.curvature > 0.0;
}

static bool agrees(const Mechanism *m, const Slip *slip, bool at_rest) {
    if (!slip->possible) return false;
    const Launch l = launch_of(m, slip);
    if (at_rest && !starts(m, slip, &l)) return false;
    if (!has_friction(&m->params)) return true;
    return flank_agrees(m, slip, &l, 0) && flank_agrees(m, slip, &l, 1);
}

/* Sign of the axial load when motion in `direction` begins or goes on. */
static int load_sign(const Mechanism *m, int direction) {
    const double c = direction > 0 ? m->params.damper.c_load : m->params.damper.c_release;
    const double spring = spring_force(&m->params.spring, axial_position(m));
    const double damper = has_inertia(&m->params) ? c * m->model.geometry.lift * m->state.omega.hi : 0.0;
    const double force = spring + m->inputs.F_ext[0] + damper;
    if (fabs(force) > TIE * axial_size(m)) return sign_of(force);
    const int coming = sign_of(m->inputs.F_ext[1]);
    return coming != 0 ? coming : (m->params.spring.stiffness > 0.0 ? direction : 1);
}

/* The way to slip in `direction` whose flanks agree with their own reactions, or -1. Several can agree
 * where a contact locks; then both supporting flanks come first, as in section 3. */
static int choose_slip(const Mechanism *m, int direction, bool at_rest) {
    const int s = load_sign(m, direction);
    const int candidate[4][2] = {{s, s}, {s, -s}, {-s, s}, {-s, -s}};
    for (int k = 0; k < 4; k++) {
        const int index = slip_index(direction, candidate[k]);
        if (agrees(m, &m->model.slip[index], at_rest)) return index;
    }
    return -1;
}

static Mode slip_mode(int direction) {
    return direction > 0 ? MODE_LOADING : MODE_RELEASING;
}

static Decision decide_at_rest(const Mechanism *m) {
    const double F_0 = axial_load(m);
    const int direction = pressed_direction(m, F_0);
    if (direction == 0) return (Decision){.mode = resting_mode(m, F_0), .slip = -1};
    if (direction > 0 && m->state.theta.hi >= m->params.stop.upper)
        return (Decision){.mode = MODE_UPPER_STOP, .slip = -1};
    if (direction < 0 && m->state.theta.hi <= m->params.stop.lower)
        return (Decision){.mode = MODE_LOWER_STOP, .slip = -1};
    const int slip = choose_slip(m, direction, true);
    return (Decision){.mode = slip < 0 ? MODE_WEDGED : slip_mode(direction), .slip = slip};
}

/* While slipping the flanks stay as they are as long as they agree. */
static Decision decide_moving(const Mechanism *m) {
    const int direction = sign_of(m->state.omega.hi);
    const Mode mode = slip_mode(direction);
    const int present = slip_index(direction, m->state.flank);
    if (m->state.mode == mode && agrees(m, &m->model.slip[present], false))
        return (Decision){.mode = mode, .slip = present};
    const int slip = choose_slip(m, direction, false);
    return (Decision){.mode = slip < 0 ? MODE_WEDGED : mode, .slip = slip};
}

static Decision decide(const Mechanism *m) {
    return has_inertia(&m->params) && m->state.omega.hi != 0.0 ? decide_moving(m) : decide_at_rest(m);
}

static void enter(Mechanism *m, Decision d) {
    State *state = &m->state;
    if (state->mode != d.mode) {
        state->events++;
        state->mode = d.mode;
        m->cache.hold.valid = false;
    }
    if (is_slip(d.mode)) {
        const Slip *slip = &m->model.slip[d.slip];
        state->flank[0] = slip->flank[0];
        state->flank[1] = slip->flank[1];
    }
}

/* ---- holding ---- */

/* Frictionless sharing: in stick the two reactions are not unique (section 3). N per contact. */
static double resting_reaction(const Mechanism *m, double F_0, int i) {
    const Geometry *g = &m->model.geometry;
    return F_0 * g->turn[i] * g->length[i] / g->radius[i] / m->params.contacts;
}

static void stand_still(Mechanism *m) {
    m->state.omega = sum_of(0.0);
}

/* On which side of the frictionless balance is it wedged? At the balance itself, where the edge is infinite. */
static bool wedged_above(const Mechanism *m, const EdgeFactors *band, double F_0) {
    const double lift = m->model.geometry.lift, excess = m->inputs.tau[0] - lift * F_0;
    return fabs(excess) <= TIE * torque_size(m, lift) ? isinf(band->load) : excess > 0.0;
}

/* Torque interval, as factors of F_0, in which a resting mode stays while F_0 has the sign of `side`. */
static EdgeFactors hold_factors(const Mechanism *m, double F_0, double side) {
    const EdgeFactors band = edge_factors(&m->model.band, side);
    const double balance = m->model.geometry.lift;
    const double release = isfinite(band.release) ? band.release : balance;
    const double load = isfinite(band.load) ? band.load : balance;
    const double open = side < 0.0 ? -INFINITY : INFINITY;
    switch (m->state.mode) {
        case MODE_LOWER_STOP: return (EdgeFactors){.release = -open, .load = release};
        case MODE_UPPER_STOP: return (EdgeFactors){.release = load, .load = open};
        case MODE_WEDGED:
            return wedged_above(m, &band, F_0) ? (EdgeFactors){.release = load, .load = open}
                                               : (EdgeFactors){.release = -open, .load = release};
        default: return (EdgeFactors){.release = release, .load = load};
    }
}

/* First time in (0, t_end] at which value + rate t exceeds 0, or infinity. */
static double time_of_excess(double value, double rate, double t_end) {
    if (!(rate > 0.0)) return INFINITY;
    const double t = fmax(-value, 0.0) / rate;
    return t <= t_end ? t : INFINITY;
}

/* The torque leaves the hold while F_0 keeps its sign: both move linearly, so this is one division. */
static double time_of_release(const Mechanism *m, double F_0, double tau, double t_end) {
    const double F_rate = m->inputs.F_ext[1], tau_rate = m->inputs.tau[1];
    const EdgeFactors f = hold_factors(m, F_0, load_side(m, F_0));
    const double above = isinf(f.load) ? INFINITY : time_of_excess(tau - edge(f.load, F_0), tau_rate - edge(f.load, F_rate), t_end);
    const double below = isinf(f.release) ? INFINITY
                                          : time_of_excess(edge(f.release, F_0) - tau,
                                                           edge(f.release, F_rate) - tau_rate, t_end);
    return fmin(above, below);
}

/* Until when a resting mechanism surely stays at rest under ramps: release, or F_0 changing its sign
 * (the band is mirrored there, so the hold is looked at anew). */
static double hold_time(const Mechanism *m, double left) {
    const double F_0 = axial_load(m), F_rate = m->inputs.F_ext[1];
    const double mirror = F_0 * F_rate < 0.0 ? -F_0 / F_rate : INFINITY;
    return fmin(fmin(mirror, left), time_of_release(m, F_0, m->inputs.tau[0], fmin(mirror, left)));
}

static void advance_inputs(Inputs *inputs, double t) {
    inputs->tau[0] += inputs->tau[1] * t;
    inputs->F_ext[0] += inputs->F_ext[1] * t;
}

static void record_rest(Mechanism *m) {
    Peaks *peak = &m->state.ledger.peak;
    const double F_0 = axial_load(m);
    peak_raise(&peak->torque, m->inputs.tau[0]);
    for (int i = 0; i < 2; i++) peak_raise(&peak->reaction[i], resting_reaction(m, F_0, i));
}

static bool inputs_constant(const Inputs *inputs) {
    return inputs->tau[1] == 0.0 && inputs->F_ext[1] == 0.0;
}

/* A tie at the edge of the band is stick, so the other modes end short of it. N.m */
static double hold_margin(const Mechanism *m, double factor) {
    if (m->state.mode == MODE_STICK) return 0.0;
    return 4.0 * TIE * fabs(factor) * axial_size(m) + DBL_MIN;
}

/* Remembers the interval of torque in which nothing can happen, so that the next step at rest costs
 * one comparison. */
static void remember_hold(Mechanism *m) {
    const double F_0 = axial_load(m);
    const EdgeFactors f = hold_factors(m, F_0, F_0);
    m->cache.hold = (Hold){
        .lower = isinf(f.release) ? -INFINITY : edge(f.release, F_0) + hold_margin(m, f.release),
        .upper = isinf(f.load) ? INFINITY : edge(f.load, F_0) - hold_margin(m, f.load),
        .F_ext = m->inputs.F_ext[0],
        .valid = true,
    };
}

/* Stays at rest for up to `left` seconds; returns how long. */
static double hold(Mechanism *m, double left) {
    stand_still(m);
    if (m->params.ledger) record_rest(m);
    if (inputs_constant(&m->inputs)) {
        remember_hold(m);
        return left;
    }
    const double t = hold_time(m, left);
    advance_inputs(&m->inputs, t);
    if (m->params.ledger) record_rest(m);
    return t;
}

/* A step at rest, the hold known from before. */
static bool hold_again(Mechanism *m) {
    const Hold *hold = &m->cache.hold;
    const double tau = m->inputs.tau[0];
    if (!hold->valid || !(tau >= hold->lower && tau <= hold->upper)) return false;
    if (!inputs_constant(&m->inputs) || m->inputs.F_ext[0] != hold->F_ext) return false;
    if (m->params.ledger) peak_raise(&m->state.ledger.peak.torque, tau);
    return true;
}

/* ---- slipping ---- */

static double band_edge(const Mechanism *m, int direction) {
    const EdgeFactors edges = edge_factors(&m->model.band, axial_load(m));
    return direction > 0 ? edges.load : edges.release;
}

static Stretch stretch_of(const Mechanism *m, const Slip *slip) {
    const double stop = slip->direction > 0 ? m->params.stop.upper : m->params.stop.lower;
    return (Stretch){
        .slip = slip,
        .params = &m->params,
        .geometry = &m->model.geometry,
        .launch = launch_of(m, slip),
        .room = fmax(slip->direction * (stop - m->state.theta.hi - m->state.theta.lo), 0.0),
        .flanks = has_friction(&m->params),
        .edge = slip->kind == FLOW_VISCOUS ? band_edge(m, slip->direction) : slip->transfer.rho,
    };
}

static Slip *present_slip(Mechanism *m) {
    return &m->model.slip[slip_index(direction_of(m->state.mode), m->state.flank)];
}

static void record_slip(Mechanism *m, const Stretch *s, const Ends *ends) {
    Peaks *peak = &m->state.ledger.peak;
    double omega, reaction[2];
    event_peaks(s, ends, &omega, reaction);
    peak_raise(&peak->omega, omega);
    peak_raise(&peak->torque, s->launch.tau);
    peak_raise(&peak->torque, s->launch.tau + s->launch.tau_rate * ends->arc.t);
    for (int i = 0; i < 2; i++) peak_raise(&peak->reaction[i], reaction[i]);
}

/* Moves along the stretch to its end; false if a value would not be finite. */
static bool commit(Mechanism *m, const Stretch *s, const Ends *ends, Kernel *kernel) {
    const Arc *arc = &ends->arc;
    if (!isfinite(arc->dtheta + arc->omega)) return false;
    if (m->params.ledger) {
        const Booking booking = slip_booking(s->slip, s->params, s->geometry, &s->launch, arc, kernel);
        if (!isfinite(booking.work_in + booking.heat_cam[0] + booking.heat_cam[1] + booking.heat_damper)) return false;
        ledger_book(&m->state.ledger, &booking);
        record_slip(m, s, ends);
    }
    sum_add(&m->state.theta, arc->dtheta);
    if (s->slip->kind == FLOW_INERTIAL) {
        sum_add(&m->state.omega, arc->domega);
    } else {
        m->state.omega = sum_of(arc->omega);
    }
    advance_inputs(&m->inputs, arc->t);
    return true;
}

/* The kernel of a whole communication step is kept: an unchanged step needs no new transcendental. */
static Kernel *kernel_of_step(Mechanism *m, const Slip *slip, double h) {
    Kernel *kernel = &m->cache.kernel[slip_index(slip->direction, slip->flank)];
    if (kernel->t != h) oscillator_kernel(&slip->oscillator, h, kernel);
    return kernel;
}

/* A whole step of inertial slip in which nothing happens: the common case. */
static bool slip_on(Mechanism *m, double h) {
    if (!is_slip(m->state.mode) || m->state.omega.hi == 0.0) return false;
    const Slip *slip = present_slip(m);
    if (slip->kind != FLOW_INERTIAL || slip->direction != sign_of(m->state.omega.hi)) return false;
    const Stretch stretch = stretch_of(m, slip);
    Kernel *kernel = kernel_of_step(m, slip, h);
    Ends ends;
    event_ends(&stretch, kernel, stretch.flanks || m->params.ledger, &ends);
    return event_quiet(&stretch, &ends) && commit(m, &stretch, &ends, kernel);
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
    state->omega = sum_of(0.0 - m->params.stop.restitution * state->omega.hi);
    if (!has_inertia(&m->params)) stand_still(m);
    if (state->omega.hi != 0.0) {
        const int slip = choose_slip(m, -direction, false);
        const double size = fmax(fabs(m->params.stop.upper), fabs(m->params.stop.lower));
        const double back = slip < 0 ? 0.0 : direction * launch_of(m, &m->model.slip[slip]).alpha;
        if (state->omega.hi * state->omega.hi < 2.0 * back * NO_BOUNCE * size) stand_still(m);
    }
    stop_heat(m, before - kinetic_energy(m));
}

/* Velocity zero and stops are set to what they are by definition. A flank change moves nothing. */
static void land(Mechanism *m, const Slip *slip, EventKind kind) {
    if (kind == EVENT_REST) stand_still(m);
    if (kind == EVENT_STOP) hit_stop(m, slip->direction);
}

/* Slips for up to `left` seconds, to the first event; returns how long, or NAN if a value is not finite. */
static double slip_to_event(Mechanism *m, double left) {
    const Slip *slip = present_slip(m);
    const Stretch stretch = stretch_of(m, slip);
    const double horizon = fmin(left, slip->oscillator.horizon);
    const Event event = event_first(&stretch, horizon);
    const double t = event.kind == EVENT_NONE ? horizon : event.t;
    Kernel kernel;
    Ends ends;
    oscillator_kernel(&slip->oscillator, t, &kernel);
    event_ends(&stretch, &kernel, stretch.flanks || m->params.ledger, &ends);
    if (!commit(m, &stretch, &ends, &kernel)) return NAN;
    land(m, slip, event.kind);
    return t;
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
static bool jump(Mechanism *m, const Slip *slip) {
    const Stretch s = stretch_of(m, slip);
    const double sign = slip->direction, force = s.launch.force, net = sign * slip_net_torque(slip, &s.launch);
    const bool stable = slip->stiffness > 0.0; /* else the way on asks for less and less torque */
    if (stable && !jumps(m, slip, &s.launch)) return false;
    const double spring = sign * m->params.spring.stiffness * m->model.geometry.lift;
    const bool mirrors = force * spring < 0.0 && fabs(force) > TIE * axial_size(m);
    const double to_edge = stable ? net / slip->stiffness : INFINITY;
    const double to_mirror = mirrors ? -force / spring : INFINITY;
    const double way = fmin(to_edge, fmin(to_mirror, s.room));
    if (m->params.ledger) book_jump(m, &s, sign * way);
    sum_add(&m->state.theta, sign * way);
    stand_still(m);
    if (way == s.room) land(m, slip, EVENT_STOP);
    return true;
}

/* Moving, and in a mode in which it cannot. */
static bool is_jammed(const Mechanism *m) {
    return has_inertia(&m->params) && m->state.omega.hi != 0.0 && !is_slip(m->state.mode);
}

/* No flank agrees while it moves: the contacts jam it at once. Its kinetic energy becomes friction heat,
 * shared as frictionless loads would share the sliding. */
static void jam(Mechanism *m) {
    const Geometry *g = &m->model.geometry;
    const double energy = kinetic_energy(m);
    double share[2];
    for (int i = 0; i < 2; i++)
        share[i] = g->friction[i] * g->length[i] * g->length[i] * g->turn[i] * g->turn[i] / g->radius[i];
    stand_still(m);
    if (!m->params.ledger || energy == 0.0) return;
    for (int i = 0; i < 2; i++) sum_add(&m->state.ledger.heat_cam[i], energy * share[i] / (share[0] + share[1]));
}

/* ---- the step ---- */

/* Spends up to `left` seconds in the mode that the inclusion asks for now; returns how long. */
static double advance_in_mode(Mechanism *m, double left) {
    if (!is_slip(m->state.mode)) return hold(m, left);
    const Slip *slip = present_slip(m);
    if (slip->kind == FLOW_QUASISTATIC && jump(m, slip)) return 0.0;
    return slip_to_event(m, left);
}

static void undo(Mechanism *m, const State *state, const Inputs *inputs) {
    m->state = *state;
    m->inputs = *inputs;
    forget(&m->cache);
}

static void describe_failure(Fault *fault, const Mechanism *m, double h, double left, int jams) {
    const char *const what = !(left > 0.0)               ? "the motion leaves the range of numbers"
                             : jams >= MAX_JAMS_PER_STEP ? "the contacts jam and let go without end"
                                                         : "the mode changes too often";
    snprintf(fault->text, sizeof fault->text,
             "step of %.17g s at theta = %.17g, omega = %.17g, tau = %.17g: %s; allowed are finite values, %d mode "
             "changes and %d jams",
             h, m->state.theta.hi, m->state.omega.hi, m->inputs.tau[0], what, (int)MAX_EVENTS_PER_STEP,
             (int)MAX_JAMS_PER_STEP);
}

static bool advance_through_events(Mechanism *m, double h, Fault *fault) {
    const State state = m->state;
    const Inputs inputs = m->inputs;
    double left = h;
    int jams = 0;
    for (int n = 0; n < MAX_EVENTS_PER_STEP && jams < MAX_JAMS_PER_STEP && left > 0.0; n++) {
        enter(m, decide(m));
        if (is_jammed(m)) {
            jam(m);
            jams++;
        } else {
            left -= advance_in_mode(m, left);
        }
    }
    if (left == 0.0) {
        enter(m, decide(m)); /* the mode at the communication point itself */
        return true;
    }
    undo(m, &state, &inputs);
    describe_failure(fault, m, h, left, jams);
    return false;
}

bool mechanism_advance(Mechanism *m, double h, Fault *fault) {
    return hold_again(m) || slip_on(m, h) || advance_through_events(m, h, fault);
}

/* ---- start and tuning ---- */

void mechanism_start(Mechanism *m) {
    mechanism_rebuild(m);
    m->state = (State){
        .theta = sum_of(m->params.initial.theta),
        .omega = sum_of(has_inertia(&m->params) ? m->params.initial.omega : 0.0),
        .mode = MODE_STICK,
        .flank = {1, 1},
    };
    ledger_open(&m->state.ledger, stored_energy(m));
    enter(m, decide(m));
    m->state.events = 0;
}

void mechanism_retune(Mechanism *m, const Params *params) {
    const double z = axial_position(m);
    const double jump = spring_energy(&params->spring, z) - spring_energy(&m->params.spring, z);
    if (m->params.ledger && jump != 0.0) sum_add(&m->state.ledger.work_tuning, jump);
    m->params = *params;
    mechanism_rebuild(m);
}

/* ---- outputs ---- */

void mechanism_motion(const Mechanism *m, Motion *out) {
    out->z = axial_position(m);
    out->v = m->model.geometry.lift * m->state.omega.hi;
}

static double damper_force(const Mechanism *m, double v) {
    return v * (v > 0.0 ? m->params.damper.c_load : m->params.damper.c_release);
}

/* T_release/T_load; where both vanish with F_0, the ratio they had before. */
static double efficiency(const Mechanism *m, const EdgeFactors *f, double F_0) {
    const double load = F_0 == 0.0 ? f->load : edge(f->load, F_0);
    const double release = F_0 == 0.0 ? f->release : edge(f->release, F_0);
    if (load == 0.0 && release == 0.0) return has_friction(&m->params) ? 0.0 : 1.0;
    return release / load;
}

static void slip_loads(const Mechanism *m, const Slip *slip, Loads *out) {
    const Launch l = launch_of(m, slip);
    const Arc now = {.omega = l.omega, .alpha = l.alpha, .jerk = l.curvature - slip->oscillator.decay2 * l.alpha};
    out->alpha = now.alpha;
    out->jerk = now.jerk;
    for (int i = 0; i < 2; i++) {
        const Contact c = slip_contact(slip, &m->params, &m->model.geometry, &l, &now, i);
        out->reaction[i] = c.value * slip->reaction[i];
    }
}

void mechanism_loads(const Mechanism *m, Loads *out) {
    const Geometry *g = &m->model.geometry;
    const double F_0 = axial_load(m);
    const EdgeFactors f = edge_factors(&m->model.band, F_0);
    const Decision now = decide(m);
    *out = (Loads){
        .gamma = g->turn[0] * m->state.theta.hi,
        .spring_force = spring_force(&m->params.spring, axial_position(m)),
        .damper_force = damper_force(m, g->lift * m->state.omega.hi),
        .torque_load = edge(f.load, F_0),
        .torque_release = edge(f.release, F_0),
        .efficiency = efficiency(m, &f, F_0),
        .mode = (int)now.mode,
        .events = m->state.events,
    };
    for (int i = 0; i < 2; i++) {
        out->sliding_speed[i] = g->turn[i] * fabs(m->state.omega.hi) * g->length[i];
        out->reaction[i] = resting_reaction(m, F_0, i);
    }
    if (is_slip(now.mode)) slip_loads(m, &m->model.slip[now.slip], out);
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
        .residual = m->params.ledger ? ledger_residual(l, stored_energy(m)) : 0.0,
    };
}

double mechanism_axial_derivative(const Mechanism *m, int order) {
    if (order == 1) return m->model.geometry.lift * m->state.omega.hi;
    Loads loads;
    mechanism_loads(m, &loads);
    return m->model.geometry.lift * (order == 2 ? loads.alpha : loads.jerk);
}
