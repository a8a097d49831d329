#include "decide.h"

#include <float.h>
#include <math.h>

#include "event.h"
#include "leap.h"
#include "stick.h"

Launch launch_of(const Mechanism *m, const Slip *slip) {
    return slip_launch(slip, &m->params, &m->place.geometry, m->state.theta.hi, m->state.omega.hi, &m->inputs);
}

bool is_closed_form(const Mechanism *m) {
    return m->model.closed_form && inputs_within(&m->inputs, 1);
}

/* ---- looking along a way to slip ---- */

Way way_from_here(const Mechanism *m, int index) {
    int flank[2];
    slip_flanks(index, flank);
    return way_of(&m->params, &m->model.course, &m->inputs, m->state.theta.hi, slip_direction(index), flank);
}

Balance balance_from_here(const Mechanism *m, const Way *way) {
    Balance now;
    balance_at(way, m->state.theta.hi, m->state.omega.hi, 0.0, &now);
    const bool starts = way->kind == FLOW_INERTIAL && m->state.omega.hi == 0.0;
    if (starts && way->direction * now.alpha < 0.0) now.alpha = now.pace.value = 0.0;
    if (way->kind == FLOW_VISCOUS && way->direction * now.omega < 0.0) now.omega = now.pace.value = 0.0;
    return now;
}

/* Without inertia a locked contact can turn the damper's resistance round: then less torque drives it faster. */
static bool is_backward(const Slip *slip) {
    return slip->kind == FLOW_VISCOUS && slip->damping < 0.0;
}

/* Without inertia and damping, on the edge of the band: unstable if the way on asks for less and less torque. */
static bool is_stable(const Slip *slip) {
    return slip->kind == FLOW_QUASISTATIC ? slip->stiffness > 0.0 : !is_backward(slip);
}

const Slip *slip_of(const Mechanism *m, int index, Slip *room) {
    if (m->model.slips >> index & 1u) return &m->model.slip[index];
    int flank[2];
    slip_flanks(index, flank);
    slip_build(room, &m->params, &m->place.geometry, slip_direction(index), flank);
    return room;
}

static Look look_at_closed_form(const Mechanism *m, const Slip *slip) {
    if (!slip->possible) return (Look){.possible = false};
    const Launch l = launch_of(m, slip);
    const Arc start = slip_arc_start(slip, &l);
    Look look = {
        .possible = true,
        .kind = slip->kind,
        .stable = is_stable(slip),
        .net = is_backward(slip) ? -slip_net_torque(slip, &l) : slip_net_torque(slip, &l),
        .net_size = stick_torque_size(m, slip->transfer.rho),
        .tie = stick_tie(m),
        .omega = l.omega,
        .alpha = l.alpha,
        .jerk = start.jerk,
        .stiffness = slip->stiffness,
    };
    for (int i = 0; has_friction(&m->params) && i < 2; i++) {
        look.axial[i] = slip->transfer.axial[i] * m->params.spring.stiffness;
        look.contact[i] = slip_contact(slip, &m->params, &m->place.geometry, &l, &start, i);
        look.size[i] = slip_contact_size(slip, &m->params, &m->place.geometry, &l, i);
    }
    return look;
}

/* Where neither x_i nor its rate tells a flank, x_i a little later does: inputs can begin as slowly as t^3. Kept in
 * place of the second derivative. */
static void look_ahead(const Way *way, const Balance *now, Look *look) {
    const double SHARE = 1e-3; /* of the motion's time scale, and at most as many seconds */
    const double dt = SHARE * fmin(1.0, leap_time_scale(way, now));
    const double omega = look->omega + dt * (look->alpha + dt / 2.0 * look->jerk);
    const double theta = now->theta + dt * (look->omega + dt / 2.0 * (look->alpha + dt / 3.0 * look->jerk));
    Balance later;
    balance_at(way, theta, omega, dt, &later);
    for (int i = 0; i < 2; i++) {
        look->contact[i].curvature = later.x[i];
        look->size[i].curvature = look->size[i].value;
    }
}

static bool is_undecided(const Look *look, int i) {
    return fabs(look->contact[i].value) <= NO_REACTION * look->size[i].value &&
           fabs(look->contact[i].rate) <= NO_REACTION * look->size[i].rate;
}

/* A leap ends on a flank change to its own rounding, which is some times that of one balance. */
static const double COARSE = 10.0;

/* However small a load is, theta is known to its rounding only: what that makes of x_i, as a size. */
static double noise_of_angle(const Mechanism *m, double by_angle) {
    static const double ROUNDING = 4.0 * DBL_EPSILON / NO_REACTION;
    return ROUNDING * largest_angle(&m->params) * fabs(by_angle);
}

static Look look_at_any_form(const Mechanism *m, int index) {
    const Way way = way_from_here(m, index);
    const Balance now = balance_from_here(m, &way);
    if (!now.pace.possible || !isfinite(now.pace.value)) return (Look){.possible = false};
    Trend trend;
    balance_trend(&way, &now, 0.0, &trend);
    const bool inertial = way.kind == FLOW_INERTIAL;
    Look look = {
        .possible = true,
        .kind = way.kind,
        .stable = now.pace.stable,
        .net = way.kind == FLOW_VISCOUS && !now.pace.stable ? -trend.net : trend.net,
        .net_size = trend.net_size,
        .tie = stick_tie(m),
        .omega = now.omega,
        .alpha = inertial ? now.alpha : trend.pace,
        .jerk = inertial ? trend.pace : 0.0,
        .stiffness = now.pace.by_theta,
    };
    const double spring = spring_rate(&m->params.spring, m->place.z);
    for (int i = 0; i < 2; i++) {
        look.axial[i] = now.axial[i] * spring;
        look.contact[i] = (Contact){.value = now.x[i], .rate = trend.contact[i]};
        look.size[i] = (Contact){.value = COARSE * trend.size[i], .rate = COARSE * trend.rate_size[i]};
        if (way.kind != FLOW_QUASISTATIC) look.size[i].value += noise_of_angle(m, look.axial[i] * now.lift);
    }
    if (is_undecided(&look, 0) || is_undecided(&look, 1)) look_ahead(&way, &now, &look);
    return look;
}

/* See decide() for `built`. */
static Look look_into(const Mechanism *m, int index, Slip *built) {
    return is_closed_form(m) ? look_at_closed_form(m, slip_of(m, index, built)) : look_at_any_form(m, index);
}

Look look_at(const Mechanism *m, int index) {
    Slip room;
    return look_into(m, index, &room);
}

/* ---- does a way to slip agree with itself? ---- */

/* From rest the net torque must point the way of the slip, or vanish (its rate then decides). */
static bool starts(const Look *look, int direction) {
    return direction * look->net >= -look->tie * look->net_size;
}

bool decide_jump(const Look *look, int direction) {
    return look->kind == FLOW_QUASISTATIC && direction * look->net > look->tie * look->net_size;
}

/* Is x_i on the flank that the slip assumes, or about to be? Where it is zero, its rate tells, and then the
 * rate of that. Zero throughout (no load at all) suits either flank. */
static bool flank_agrees(const Look *look, int direction, int flank, int i) {
    const Contact *c = &look->contact[i], *size = &look->size[i];
    if (fabs(c->value) > NO_REACTION * size->value) return flank * c->value > 0.0;
    if (decide_jump(look, direction)) /* only the spring's force changes, by direction times its stiffness */
        return flank * direction * look->axial[i] >= 0.0;
    if (fabs(c->rate) > NO_REACTION * size->rate) return flank * c->rate > 0.0;
    return fabs(c->curvature) <= NO_REACTION * size->curvature || flank * c->curvature > 0.0;
}

/* Quasi-static slip that does not begin with a jump follows the moving edge of the band, in its own direction. */
static bool follows(const Look *look, int direction) {
    if (look->kind != FLOW_QUASISTATIC || !(look->stiffness > 0.0) || decide_jump(look, direction)) return true;
    return direction * look->omega > 0.0;
}

static bool agrees(const Mechanism *m, int index, const Look *look, bool at_rest) {
    const int direction = slip_direction(index);
    int flank[2];
    slip_flanks(index, flank);
    if (!look->possible) return false;
    if (at_rest && !starts(look, direction)) return false;
    if (!follows(look, direction)) return false;
    if (!has_friction(&m->params)) return true;
    return flank_agrees(look, direction, flank[0], 0) && flank_agrees(look, direction, flank[1], 1);
}

/* Sign of the axial load when motion in `direction` begins or goes on. */
static int load_sign(const Mechanism *m, int direction) {
    const double v = has_inertia(&m->params) ? m->place.geometry.lift * m->state.omega.hi : 0.0;
    const double force = stick_axial_load(m) + damper_force(&m->params.damper, direction, v);
    if (fabs(force) > stick_tie(m) * stick_axial_size(m)) return sign_of(force);
    const int coming = sign_of(m->inputs.F_ext[1]);
    return coming != 0 ? coming : (m->params.spring.stiffness != 0.0 ? direction : 1);
}

int decide_slip(const Mechanism *m, int direction, bool at_rest, Slip *built) {
    const int s = load_sign(m, direction);
    const int candidate[4][2] = {{s, s}, {s, -s}, {-s, s}, {-s, -s}};
    int unstable = -1;
    for (int k = 0; k < 4; k++) {
        const int index = slip_index(direction, candidate[k]);
        const Look look = look_into(m, index, built);
        if (!agrees(m, index, &look, at_rest)) continue;
        if (look.stable) return index;
        if (unstable < 0) unstable = index;
    }
    return unstable;
}

static Mode slip_mode(int direction) {
    return direction > 0 ? MODE_LOADING : MODE_RELEASING;
}

static Decision decide_at_rest(const Mechanism *m, Slip *built) {
    const int direction = stick_pressed(m);
    if (direction == 0) return (Decision){.mode = stick_mode(m), .slip = -1};
    if (direction > 0 && m->state.theta.hi >= m->params.stop.upper)
        return (Decision){.mode = MODE_UPPER_STOP, .slip = -1};
    if (direction < 0 && m->state.theta.hi <= m->params.stop.lower)
        return (Decision){.mode = MODE_LOWER_STOP, .slip = -1};
    const int slip = decide_slip(m, direction, true, built);
    if (slip < 0 && stick_is_on_edge(m, direction)) return (Decision){.mode = MODE_STICK, .slip = -1};
    return (Decision){.mode = slip < 0 ? MODE_WEDGED : slip_mode(direction), .slip = slip};
}

/* While slipping the flanks stay as they are as long as they agree. */
static Decision decide_moving(const Mechanism *m, Slip *built) {
    const int direction = sign_of(m->state.omega.hi);
    const Mode mode = slip_mode(direction);
    const int present = slip_index(direction, m->state.flank);
    const Look look = look_into(m, present, built);
    if (m->state.mode == mode && agrees(m, present, &look, false)) return (Decision){.mode = mode, .slip = present};
    const int slip = decide_slip(m, direction, false, built);
    return (Decision){.mode = slip < 0 ? MODE_WEDGED : mode, .slip = slip};
}

Decision decide(const Mechanism *m, Slip *built) {
    return has_inertia(&m->params) && m->state.omega.hi != 0.0 ? decide_moving(m, built) : decide_at_rest(m, built);
}

Decision decision_of(const Mechanism *m) {
    Slip room;
    if (!m->continuous) return decide(m, &room);
    const Mode mode = m->state.mode;
    const int direction = mode == MODE_LOADING ? 1 : -1;
    return (Decision){.mode = mode, .slip = is_slip(mode) ? slip_index(direction, m->state.flank) : -1};
}
