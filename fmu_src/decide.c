#include "decide.h"

#include <math.h>

#include "event.h"
#include "stick.h"

Launch launch_of(const Mechanism *m, const Slip *slip) {
    return slip_launch(slip, &m->params, &m->model.geometry, m->state.theta.hi, m->state.omega.hi, &m->inputs);
}

/* From rest the net torque must point the way of the slip, or vanish (its rate then decides). */
static bool starts(const Mechanism *m, const Slip *slip, const Launch *l) {
    return slip->direction * slip_net_torque(slip, l) >= -TIE * stick_torque_size(m, slip->transfer.rho);
}

bool decide_jump(const Mechanism *m, const Slip *slip, const Launch *l) {
    const double net = slip->direction * slip_net_torque(slip, l);
    return slip->kind == FLOW_QUASISTATIC && net > TIE * stick_torque_size(m, slip->transfer.rho);
}

/* Is x_i on the flank that the slip assumes, or about to be? Where it is zero, its rate tells, and then the
 * rate of that. Zero throughout (no load at all) suits either flank. */
static bool flank_agrees(const Mechanism *m, const Slip *slip, const Launch *l, int i) {
    const Arc start = slip_arc_start(slip, l);
    const Contact c = slip_contact(slip, &m->params, &m->model.geometry, l, &start, i);
    const Contact size = slip_contact_size(slip, &m->params, &m->model.geometry, l, i);
    const double flank = slip->flank[i];
    if (fabs(c.value) > NO_REACTION * size.value) return flank * c.value > 0.0;
    if (decide_jump(m, slip, l)) /* only the spring's force changes */
        return flank * slip->direction * slip->transfer.axial[i] * m->params.spring.stiffness >= 0.0;
    if (fabs(c.rate) > NO_REACTION * size.rate) return flank * c.rate > 0.0;
    return fabs(c.curvature) <= NO_REACTION * size.curvature || flank * c.curvature > 0.0;
}

/* Quasi-static slip that does not begin with a jump follows the moving edge of the band, in its own direction. */
static bool follows(const Mechanism *m, const Slip *slip, const Launch *l) {
    if (slip->kind != FLOW_QUASISTATIC || !(slip->stiffness > 0.0) || decide_jump(m, slip, l)) return true;
    return slip->direction * l->omega > 0.0;
}

static bool agrees(const Mechanism *m, const Slip *slip, bool at_rest) {
    if (!slip->possible) return false;
    const Launch l = launch_of(m, slip);
    if (at_rest && !starts(m, slip, &l)) return false;
    if (!follows(m, slip, &l)) return false;
    if (!has_friction(&m->params)) return true;
    return flank_agrees(m, slip, &l, 0) && flank_agrees(m, slip, &l, 1);
}

/* Sign of the axial load when motion in `direction` begins or goes on. */
static int load_sign(const Mechanism *m, int direction) {
    const double c = direction > 0 ? m->params.damper.c_load : m->params.damper.c_release;
    const double damper = has_inertia(&m->params) ? c * m->model.geometry.lift * m->state.omega.hi : 0.0;
    const double force = stick_axial_load(m) + damper;
    if (fabs(force) > TIE * stick_axial_size(m)) return sign_of(force);
    const int coming = sign_of(m->inputs.F_ext[1]);
    return coming != 0 ? coming : (m->params.spring.stiffness > 0.0 ? direction : 1);
}

/* Without inertia and damping, on the edge of the band: unstable, since the way on asks for less and less torque. */
static bool is_snap(const Slip *slip) {
    return slip->kind == FLOW_QUASISTATIC && !(slip->stiffness > 0.0);
}

int decide_slip(const Mechanism *m, int direction, bool at_rest) {
    const int s = load_sign(m, direction);
    const int candidate[4][2] = {{s, s}, {s, -s}, {-s, s}, {-s, -s}};
    int snap = -1; /* only where nothing else agrees */
    for (int k = 0; k < 4; k++) {
        const int index = slip_index(direction, candidate[k]);
        const Slip *slip = &m->model.slip[index];
        if (!agrees(m, slip, at_rest)) continue;
        if (!is_snap(slip)) return index;
        if (snap < 0) snap = index;
    }
    return snap;
}

static Mode slip_mode(int direction) {
    return direction > 0 ? MODE_LOADING : MODE_RELEASING;
}

static Decision decide_at_rest(const Mechanism *m) {
    const int direction = stick_pressed(m);
    if (direction == 0) return (Decision){.mode = stick_mode(m), .slip = -1};
    if (direction > 0 && m->state.theta.hi >= m->params.stop.upper)
        return (Decision){.mode = MODE_UPPER_STOP, .slip = -1};
    if (direction < 0 && m->state.theta.hi <= m->params.stop.lower)
        return (Decision){.mode = MODE_LOWER_STOP, .slip = -1};
    const int slip = decide_slip(m, direction, true);
    return (Decision){.mode = slip < 0 ? MODE_WEDGED : slip_mode(direction), .slip = slip};
}

/* While slipping the flanks stay as they are as long as they agree. */
static Decision decide_moving(const Mechanism *m) {
    const int direction = sign_of(m->state.omega.hi);
    const Mode mode = slip_mode(direction);
    const int present = slip_index(direction, m->state.flank);
    if (m->state.mode == mode && agrees(m, &m->model.slip[present], false))
        return (Decision){.mode = mode, .slip = present};
    const int slip = decide_slip(m, direction, false);
    return (Decision){.mode = slip < 0 ? MODE_WEDGED : mode, .slip = slip};
}

Decision decide(const Mechanism *m) {
    return has_inertia(&m->params) && m->state.omega.hi != 0.0 ? decide_moving(m) : decide_at_rest(m);
}
