#include "sensitivity/step_sensitivity.h"

#include <math.h>

#include "forward/decide.h"
#include "forward/segment.h"
#include "forward/stick.h"

/* Per N.m of the torque's shift. */
typedef struct {
    Variation x;
    double delay; /* s: the event just passed comes later by that, and x is taken at the event's own time; else 0 */
    bool slipped, rested; /* in the leg before; rested: what comes next begins where the torque leaves the band */
} Carried;

static double finite_or_zero(double x) {
    return isfinite(x) ? x : 0.0;
}

static int present_direction(const Mechanism *m) {
    return m->state.mode == MODE_LOADING ? 1 : -1;
}

static SlipMode present_slip(const Mechanism *m) {
    return present_slip_mode(m, slip_index(present_direction(m), m->state.flank));
}

static bool is_viscous(const Mechanism *m) {
    return present_slip(m).regime == REGIME_VISCOUS;
}

/* ---- the edge of the stick band ---- */

/* Is there a torque that moves it in `direction`? Then *way is along the band's edge, rho F_0 with *rho. */
static bool slip_along_edge(const Mechanism *m, int direction, SlipMode *slip, double *rho) {
    const int side = stick_axial_load(m) < 0.0 ? -1 : 1; /* the band is mirrored */
    int flank[2];
    Transfer transfer;
    if (!contact_edge(&m->configuration.geometry, side * direction, flank, &transfer)) return false;
    for (int i = 0; i < 2; i++) flank[i] *= side;
    *slip = present_slip_mode(m, slip_index(direction, flank));
    slip->regime = REGIME_RATE_INDEPENDENT;
    *rho = transfer.rho;
    return true;
}

/* By how much later the torque passes the edge, theta being larger by its variation. */
static double delay_at_edge(const Mechanism *m, int direction, double theta, double omega) {
    const double *tau = m->inputs.tau;
    SlipMode slip;
    double rho;
    if (!slip_along_edge(m, direction, &slip, &rho)) return 0.0;
    const double slope = balance_rhs(&slip, m->state.theta.hi, 0.0, 0.0).by_theta;
    return finite_or_zero((slope * theta - 1.0) / (tau[1] - rho * m->inputs.F_ext[1] - slope * omega));
}

/* d theta/d tau on the edge; 0 where it is not the edge that holds the torque, but that nothing moves it on. */
static double give_of_edge(const Mechanism *m, const RightHandSide *rhs) {
    static const double HELD = 1e-9; /* of the torques involved: what is left of them on the edge */
    const bool held = fabs(rhs->net) <= HELD * stick_torque_size(m, m->configuration.geometry.dz_dtheta);
    return held && rhs->by_theta > 0.0 ? 1.0 / rhs->by_theta : 0.0;
}

/* d omega/d theta on the edge E(theta), where E' omega is the rate of the load: (d rate/d theta - omega E'')/E'.
 * Both are smooth inside a piece, so that a central difference of order 4 has ten digits. */
static double speed_on_edge(const SlipMode *slip, double theta) {
    static const double offset[4] = {-2.0, -1.0, 1.0, 2.0}, weight[4] = {1.0, -8.0, 8.0, -1.0};
    const double step = 1e-3 * (slip->piece->upper - slip->piece->lower);
    const RightHandSide now = balance_rhs(slip, theta, 0.0, 0.0);
    double change = 0.0;
    for (int k = 0; k < 4; k++) {
        const RightHandSide p = balance_rhs(slip, theta + offset[k] * step, 0.0, 0.0);
        change += weight[k] * (p.value - now.value) * p.by_theta;
    }
    return change / (12.0 * step * now.by_theta);
}

/* ---- inside a leg ---- */

static void carry_along_arc(const LinearSlipMode *slip, double t, Variation *x) {
    Kernel k;
    oscillator_kernel(&slip->oscillator, t, &k);
    if (slip->regime == REGIME_VISCOUS) {
        x->omega = k.ds * (1.0 - slip->stiffness * x->theta) / slip->damping;
        x->theta = k.ds * x->theta + k.s / slip->damping;
        return;
    }
    const double w2 = slip->oscillator.stiffness, theta = x->theta, omega = x->omega;
    x->theta = (1.0 - w2 * k.p1) * theta + k.s * omega + k.p1 / slip->mass;
    x->omega = -w2 * k.s * theta + k.ds * omega + k.s / slip->mass;
}

/* Without inertia and damping theta is where the edge is the torque, whatever it was before: d theta = d tau/E'; at
 * the end of a jump that comes later by dt it is (d tau + rate dt)/E', with the rate of the torque beyond the edge.
 * Following the edge ends at a fold, E' = 0, when the torque gets to the fold's. */
static void carry_along_edge(const Mechanism *m, const Segment *segment, double t, Carried *v) {
    SlipMode slip = present_slip(m);
    double rho;
    const bool jumps = segment->kind == SEGMENT_JUMP;
    const bool there = !jumps || slip_along_edge(m, present_direction(m), &slip, &rho);
    const RightHandSide rhs = balance_rhs(&slip, m->state.theta.hi, 0.0, 0.0);
    if (jumps && t > 0.0) v->delay = 0.0;
    v->x.theta = there ? give_of_edge(m, &rhs) + (jumps ? rhs.value * v->delay : 0.0) : 0.0;
    if (!jumps) v->delay = finite_or_zero(-1.0 / (rhs.value * rhs.by_theta));
}

/* `inputs`: those at the start of the leg. */
static bool carry(const Mechanism *m, const Segment *segment, const Inputs *inputs, double t, Carried *v) {
    if (segment->kind == SEGMENT_NONE && segment->end == EVENT_STOP) return true;
    if (segment->kind ==
        SEGMENT_NONE) { /* a jam: at an event, or before anything has varied, or for an unknown reason */
        const bool known = v->delay != 0.0 || (v->x.theta == 0.0 && v->x.omega == 0.0);
        v->x.omega = 0.0;
        return known;
    }
    if (segment->kind == SEGMENT_REST) {
        *v = (Carried){.x = {.theta = v->x.theta}};
        return true;
    }
    const int index = slip_index(present_direction(m), m->state.flank);
    SlipMode slip = present_slip_mode(m, index);
    if (slip.regime == REGIME_RATE_INDEPENDENT) {
        carry_along_edge(m, segment, t, v);
    } else if (segment->kind == SEGMENT_CLOSED_FORM) {
        LinearSlipMode room;
        carry_along_arc(linear_slip_of(m, index, &room), t, &v->x);
    } else {
        const RadauStep *radau = &segment->location.radau;
        slip = slip_mode_of(&m->params, &m->model.transmission, inputs, radau->start.theta, slip.direction, slip.flank);
        return radau_step_vary(&slip, radau, 1.0, &v->x);
    }
    return true;
}

/* ---- at an event ---- */

/* By how much later a contact is without load. */
static double delay_at_flank(const SlipMode *slip, const Balance *b, const Variation *x) {
    const int i = fabs(b->x[0]) < fabs(b->x[1]) ? 0 : 1;
    const RightHandSide *p = &b->rhs;
    const double jerk = p->by_time + p->by_theta * b->omega + p->by_omega * b->alpha;
    const double alpha = p->by_theta * x->theta + p->by_omega * x->omega + balance_mobility(slip, b);
    const double rate =
        balance_contact_change(slip, b, i, b->omega, b->alpha, jerk) + b->axial[i] * slip->inputs->F_ext[1];
    return finite_or_zero(-balance_contact_change(slip, b, i, x->theta, x->omega, alpha) / rate);
}

/* A stop turns omega into -e omega, or 0; at rest omega is 0. A contact that changes its flank carries nothing at that
 * moment, so that alpha does not jump unless the other one changes as well. */
static void pass_inertial(const Mechanism *m, const Segment *segment, Carried *v) {
    const SlipMode slip = present_slip(m);
    Balance before;
    balance_at(&slip, m->state.theta.hi, segment->omega, 0.0, &before);
    if (segment->end == EVENT_FLANK) {
        v->delay = delay_at_flank(&slip, &before, &v->x);
        v->x.theta += before.omega * v->delay;
        v->x.omega += before.alpha * v->delay;
        return;
    }
    if (segment->end == EVENT_REST) {
        v->delay = finite_or_zero(-v->x.omega / before.alpha);
        v->x.omega = 0.0;
        return;
    }
    v->delay = finite_or_zero(-v->x.theta / segment->omega);
    v->x.omega = finite_or_zero(m->state.omega.hi / segment->omega) * (v->x.omega + before.alpha * v->delay);
    v->x.theta = 0.0;
}

/* It stops where its speed has vanished, or with a jump of its speed: where the torque is back in the band while the
 * damper loads other flanks than the spring, and where F_0 changes its sign and with it the edge. */
static void pass_without_inertia(const Mechanism *m, const Segment *segment, Carried *v) {
    const double slope = spring_rate(&m->params.spring, axial_position(m)) * m->configuration.geometry.dz_dtheta;
    v->delay = 0.0;
    if (segment->end == EVENT_STOP) {
        v->x.theta = 0.0;
    } else if (segment->end == EVENT_FLANK && !is_viscous(m)) {
        v->delay = finite_or_zero(-slope * v->x.theta / (slope * segment->omega + m->inputs.F_ext[1]));
    } else if (segment->end == EVENT_REST && is_viscous(m)) {
        v->delay = delay_at_edge(m, present_direction(m), v->x.theta, segment->omega);
    }
    v->x.theta += segment->omega * v->delay;
}

static void pass_event(const Mechanism *m, const Segment *segment, Carried *v) {
    if (segment->end != EVENT_NONE && has_inertia(&m->params)) pass_inertial(m, segment, v);
    if (segment->end != EVENT_NONE && !has_inertia(&m->params)) pass_without_inertia(m, segment, v);
}

/* At the edge of the band speed and acceleration begin at 0, but for rounding: up to this share of what adds up to them.
 * Only where a contact locks can a damper let go with a jump. */
static const double BEGINNING = 1e-9;

/* Back to a variation at a fixed time, by the motion that follows the event. */
static void enter_next(Mechanism *m, Carried *v) {
    const double omega = m->state.omega.hi;
    const bool slipped = v->slipped && omega != 0.0 && is_viscous(m);
    const int direction = present_direction(m);
    segment_enter(m);
    /* so slow that the torque is on the edge to rounding, it is taken to rest; or it just reaches the stop */
    if (slipped && (m->state.mode == MODE_LOWER_STOP || m->state.mode == MODE_UPPER_STOP)) v->x.theta = 0.0;
    if (slipped && m->state.mode == MODE_STICK) v->x.theta += omega * delay_at_edge(m, direction, v->x.theta, omega);
    if (!is_slip(m->state.mode) || (v->delay == 0.0 && !v->rested)) return;
    const SlipMode slip = present_slip(m);
    const Balance after = balance_from_here(m, &slip);
    const bool bursts = slip.regime == REGIME_VISCOUS && fabs(after.omega) > BEGINNING * after.rhs.size;
    if (v->rested && (bursts || slip.regime == REGIME_RATE_INDEPENDENT))
        v->delay = delay_at_edge(m, slip.direction, v->x.theta, 0.0);
    if (slip.regime == REGIME_RATE_INDEPENDENT) return; /* the delay is for a jump to know */
    v->x.theta -= after.omega * v->delay;
    v->x.omega -= after.alpha * v->delay;
    v->delay = 0.0;
}

/* ---- the step ---- */

/* False where there is no variation. */
static bool carry_through(Mechanism *m, double left, Carried *v) {
    Segment segment;
    for (;;) {
        enter_next(m, v);
        if (!(left > 0.0)) return true;
        const Inputs inputs = m->inputs;
        const double t = segment_run(m, left, &segment);
        if (!(t <= left) || !carry(m, &segment, &inputs, t, v)) return false;
        pass_event(m, &segment, v);
        left -= t;
        v->slipped = segment.kind == SEGMENT_CLOSED_FORM || segment.kind == SEGMENT_RADAU;
        v->rested = segment.kind == SEGMENT_REST && left > 0.0;
    }
}

void step_sensitivity(const Mechanism *m, StepSensitivity *out) {
    Mechanism again = *m; /* the course is m's own: not to be freed */
    Carried v = {.delay = 0.0};
    *out = (StepSensitivity){0.0, 0.0};
    if (!(m->state.step.h > 0.0)) return;
    mechanism_rewind(&again);
    again.params.ledger = false;
    if (!carry_through(&again, m->state.step.h, &v)) return;
    const SlipMode slip = present_slip(&again);
    if (again.state.omega.hi == 0.0) v.x.omega = 0.0;
    else if (slip.regime == REGIME_RATE_INDEPENDENT) v.x.omega = speed_on_edge(&slip, again.state.theta.hi) * v.x.theta;
    *out = (StepSensitivity){finite_or_zero(v.x.theta), finite_or_zero(v.x.omega)};
}
