#include "sensitivity/step_sensitivity.h"

#include <math.h>

#include "collocation/radau_variation.h"
#include "contact/loaded_contacts.h"
#include "forward/decide.h"
#include "forward/lifecycle.h"
#include "forward/step.h"
#include "forward/stick.h"
#include "numerics/tolerances.h"
#include "platform/attributes.h"

COMPACT_BEGIN

/* Per N.m of the torque's shift. */
typedef struct {
    Variation x;
    double delay; /* s, by which the event just passed comes later; x is taken at the event's own time. Else 0. */
    bool slipped; /* the latest segment was slip */
    bool rested;  /* the latest segment was rest; the next one begins where the torque leaves the band */
} Carried;

static double finite_or_zero(double x) {
    return isfinite(x) ? x : 0.0;
}

static SlipMode present_slip(const Mechanism *m) {
    return slip_mode_from_here(m, present_slip_index(m));
}

static bool is_viscous(const Mechanism *m) {
    return present_slip(m).regime == REGIME_VISCOUS;
}

/* ---- the edge of the stick band ---- */

/* Is there a torque that moves cam 2 in `direction`? Then *slip is the slip mode along the band's edge, and *rho the
 * edge's derivative by F_0. */
COMPACT static bool slip_along_edge(const Mechanism *m, int direction, SlipMode *slip, double *rho) {
    const int side = stick_axial_load(m) < 0.0 ? -1 : 1; /* the band is mirrored */
    int flank[2];
    Transfer transfer;
    Geometry g = m->configuration.geometry;
    if (!contact_edge_under(&m->params, &g, fabs(stick_axial_load(m)), side * direction, flank, &transfer))
        return false;
    for (int i = 0; i < 2; i++) flank[i] *= side;
    *slip = slip_mode_from_here(m, slip_index(direction, flank));
    slip->regime = REGIME_RATE_INDEPENDENT;
    *rho = transfer.rho_rate;
    return true;
}

/* The time by which the torque passes the edge later, s per N.m, if theta is larger by its variation `theta`. */
static double delay_at_edge(const Mechanism *m, int direction, double theta, double omega) {
    const double *tau = m->inputs.tau;
    SlipMode slip;
    double rho;
    if (!slip_along_edge(m, direction, &slip, &rho)) return 0.0;
    const double slope = balance_rhs(&slip, m->state.theta.hi, 0.0, 0.0).by_theta;
    return finite_or_zero((slope * theta - 1.0) / (tau[1] - rho * m->inputs.F_ext[1] - slope * omega));
}

/* d theta/d tau on the edge; 0 where cam 2 rests inside the band. */
static double give_of_edge(const Mechanism *m, const RightHandSide *rhs) {
    const bool held =
        fabs(rhs->net) <= SENSITIVITY_EDGE_HELD * stick_torque_size(m, m->configuration.geometry.dz_dtheta);
    return held && rhs->by_theta > 0.0 ? 1.0 / rhs->by_theta : 0.0;
}

/* d omega/d theta on the edge E(theta). E' omega is the rate of the load, so that the derivative is
 * (d rate/d theta - omega E'')/E', here by a central difference of order 4. */
static double speed_on_edge(const SlipMode *slip, double theta) {
    static const double offset[4] = {-2.0, -1.0, 1.0, 2.0}, weight[4] = {1.0, -8.0, 8.0, -1.0};
    const double step = SENSITIVITY_DIFFERENCE * (slip->piece->upper - slip->piece->lower);
    const RightHandSide now = balance_rhs(slip, theta, 0.0, 0.0);
    double change = 0.0;
    for (int k = 0; k < 4; k++) {
        const RightHandSide p = balance_rhs(slip, theta + offset[k] * step, 0.0, 0.0);
        change += weight[k] * (p.value - now.value) * p.by_theta;
    }
    return change / (12.0 * step * now.by_theta);
}

/* ---- inside a segment ---- */

static void carry_in_closed_form(const LinearSlipMode *slip, double t, Variation *x) {
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

/* Without inertia and damping theta is where the edge E(theta) equals the torque, whatever theta was before:
 * d theta = d tau/E'. Following the edge ends at a fold, E' = 0, when the torque gets to the torque of the fold. */
static void carry_along_edge(const Mechanism *m, const SlipMode *slip, Carried *v) {
    const RightHandSide rhs = balance_rhs(slip, m->state.theta.hi, 0.0, 0.0);
    v->x.theta = give_of_edge(m, &rhs);
    v->delay = finite_or_zero(-1.0 / (rhs.value * rhs.by_theta));
}

/* At the end of a jump that comes later by dt, d theta is (d tau + rate dt)/E'. The rate is that of the torque beyond
 * the edge. */
static void carry_over_jump(const Mechanism *m, int direction, double duration, Carried *v) {
    SlipMode slip;
    double rho;
    if (duration > 0.0) v->delay = 0.0;
    v->x.theta = 0.0;
    if (!slip_along_edge(m, direction, &slip, &rho)) return;
    const RightHandSide rhs = balance_rhs(&slip, m->state.theta.hi, 0.0, 0.0);
    v->x.theta = give_of_edge(m, &rhs) + rhs.value * v->delay;
}

/* At an event, or before anything has varied, a jam ends the motion whatever the variation. */
static bool carry_through_jam(Carried *v) {
    const bool known = v->delay != 0.0 || (v->x.theta == 0.0 && v->x.omega == 0.0);
    v->x.omega = 0.0;
    return known;
}

static bool carry_along_slip(const Mechanism *m, const Segment *segment, const Inputs *inputs, Carried *v) {
    const int index = present_slip_index(m);
    const SlipMode slip = slip_mode_from_here(m, index);
    if (slip.regime == REGIME_RATE_INDEPENDENT) {
        carry_along_edge(m, &slip, v);
        return true;
    }
    if (segment->kind == SEGMENT_CLOSED_FORM) {
        LinearSlipMode storage;
        carry_in_closed_form(linear_slip_of(m, index, &storage), segment->duration, &v->x);
        return true;
    }
    const RadauStep *step = &segment->location->step;
    const SlipMode at_start =
        slip_mode_of(&m->params, &m->model.transmission, inputs, step->start.theta, slip.direction, slip.flank);
    return radau_step_vary(&at_start, step, 1.0, &v->x);
}

/* Carries the variation through a segment in `mode` that has been applied; `inputs`: at its start. False where the
 * variation is not known. */
static bool carry(const Mechanism *m, const Segment *segment, const Inputs *inputs, Mode mode, Carried *v) {
    switch (segment->kind) {
        case SEGMENT_AT_STOP: return true;
        case SEGMENT_JAM: return carry_through_jam(v);
        case SEGMENT_REST: *v = (Carried){.x = {.theta = v->x.theta}}; return true;
        case SEGMENT_JUMP: carry_over_jump(m, direction_of(mode), segment->duration, v); return true;
        default: return carry_along_slip(m, segment, inputs, v);
    }
}

/* ---- at an event ---- */

/* The time by which a contact loses its load later, s per N.m. */
static double delay_at_flank(const SlipMode *slip, const Balance *b, const Variation *x) {
    const int i = fabs(b->x[0]) < fabs(b->x[1]) ? 0 : 1;
    const RightHandSide *p = &b->rhs;
    const double jerk = p->by_time + p->by_theta * b->omega + p->by_omega * b->alpha;
    const double alpha = p->by_theta * x->theta + p->by_omega * x->omega + balance_mobility(slip, b);
    const double rate =
        balance_contact_change(slip, b, i, b->omega, b->alpha, jerk) + b->axial[i] * slip->inputs->F_ext[1];
    return finite_or_zero(-balance_contact_change(slip, b, i, x->theta, x->omega, alpha) / rate);
}

/* A stop turns omega into -e omega, or 0; at rest omega is 0. A contact that changes its flank carries no load at that
 * moment, so that alpha does not jump unless the other contact changes its flank as well. */
static void pass_inertial(const Mechanism *m, EventKind event, double omega, Carried *v) {
    const SlipMode slip = present_slip(m);
    Balance before;
    balance_at(&slip, m->state.theta.hi, omega, 0.0, &before);
    if (event == EVENT_FLANK) {
        v->delay = delay_at_flank(&slip, &before, &v->x);
        v->x.theta += before.omega * v->delay;
        v->x.omega += before.alpha * v->delay;
        return;
    }
    v->delay = 0.0;
    if (event == EVENT_LET_GO) return; /* the motion is not unique there: no derivative of the instant exists */
    if (event == EVENT_REST) {
        v->delay = finite_or_zero(-v->x.omega / before.alpha);
        v->x.omega = 0.0;
        return;
    }
    v->delay = finite_or_zero(-v->x.theta / omega);
    v->x.omega = finite_or_zero(m->state.omega.hi / omega) * (v->x.omega + before.alpha * v->delay);
    v->x.theta = 0.0;
}

/* Cam 2 stops where its speed has vanished, or with a jump of its speed. The speed jumps where the torque is back in
 * the band while the damper loads other flanks than the spring, and where F_0 and with it the edge change their
 * signs. */
static void pass_without_inertia(const Mechanism *m, EventKind event, double omega, Carried *v) {
    const double slope = spring_rate(&m->params.spring, m->configuration.z) * m->configuration.geometry.dz_dtheta;
    v->delay = 0.0;
    if (event == EVENT_STOP) {
        v->x.theta = 0.0;
    } else if (event == EVENT_FLANK && !is_viscous(m)) {
        v->delay = finite_or_zero(-slope * v->x.theta / (slope * omega + m->inputs.F_ext[1]));
    } else if (event == EVENT_REST && is_viscous(m)) {
        v->delay = delay_at_edge(m, direction_of(m->state.mode), v->x.theta, omega);
    }
    v->x.theta += omega * v->delay;
}

/* `omega`: the speed at the event, before the event changed it. */
static void pass_event(const Mechanism *m, EventKind event, double omega, Carried *v) {
    if (event == EVENT_NONE) return;
    if (has_inertia(&m->params)) pass_inertial(m, event, omega, v);
    else pass_without_inertia(m, event, omega, v);
}

/* Slip without inertia has ended in a mode of rest because the speed is no more than rounding: theta waits for the
 * torque to reach the edge, or cam 2 just reaches the stop. `m` is in the new mode; omega and direction are those
 * before. */
static void end_of_viscous_slip(const Mechanism *m, double omega, int direction, Carried *v) {
    if (m->state.mode == MODE_LOWER_STOP || m->state.mode == MODE_UPPER_STOP) v->x.theta = 0.0;
    if (m->state.mode == MODE_STICK) v->x.theta += omega * delay_at_edge(m, direction, v->x.theta, omega);
}

/* Back to a variation at a fixed time, by the motion that follows the event. */
static void end_delay(const Mechanism *m, Carried *v) {
    if (!is_slip(m->state.mode) || (v->delay == 0.0 && !v->rested)) return;
    const SlipMode slip = present_slip(m);
    const Balance after = balance_from_here(m, &slip);
    const bool bursts = slip.regime == REGIME_VISCOUS && fabs(after.omega) > SENSITIVITY_AT_REST * after.rhs.size;
    if (v->rested && (bursts || slip.regime == REGIME_RATE_INDEPENDENT))
        v->delay = delay_at_edge(m, slip.direction, v->x.theta, 0.0);
    if (slip.regime == REGIME_RATE_INDEPENDENT) return; /* a jump that follows needs the delay */
    v->x.theta -= after.omega * v->delay;
    v->x.omega -= after.alpha * v->delay;
    v->delay = 0.0;
}

/* ---- the step ---- */

/* Carries the variation from segment to segment. */
typedef struct {
    StepVisitor visitor; /* first member: the step passes a pointer to it */
    Carried carried;
    double left;            /* s */
    double omega;           /* rad/s, before the decision */
    int direction;          /* likewise */
    bool viscous_slip_ends; /* if the decision finds a mode of rest */
} Carrier;

static void before_decision(StepVisitor *visitor, const Mechanism *m) {
    Carrier *c = (Carrier *)visitor;
    c->omega = m->state.omega.hi;
    c->viscous_slip_ends = c->carried.slipped && c->omega != 0.0 && is_viscous(m);
    c->direction = direction_of(m->state.mode);
}

COMPACT static double after_decision(StepVisitor *visitor, const Mechanism *m, double left) {
    Carrier *c = (Carrier *)visitor;
    if (c->viscous_slip_ends) end_of_viscous_slip(m, c->omega, c->direction, &c->carried);
    end_delay(m, &c->carried);
    return left;
}

COMPACT static bool after_segment(StepVisitor *visitor, const Mechanism *m, const Segment *segment,
                                  const SegmentPast *past) {
    Carrier *c = (Carrier *)visitor;
    if (!carry(m, segment, &past->inputs, past->mode, &c->carried)) return false;
    pass_event(m, segment->end, past->omega, &c->carried);
    c->left -= segment->duration;
    c->carried.slipped = segment->kind == SEGMENT_CLOSED_FORM || segment->kind == SEGMENT_RADAU;
    c->carried.rested = segment->kind == SEGMENT_REST && c->left > 0.0;
    return true;
}

COMPACT void step_sensitivity(const Mechanism *m, StepSensitivity *out) {
    Mechanism again = *m; /* the transmission is m's own: not to be freed */
    Carrier c = {.visitor = {before_decision, after_decision, after_segment, .every_decision = true},
                 .left = m->state.step.h};
    *out = (StepSensitivity){0.0, 0.0};
    if (!(m->state.step.h > 0.0)) return;
    mechanism_rewind(&again);
    again.params.ledger = false;
    if (!mechanism_go_through(&again, m->state.step.h, &c.visitor)) return;
    Variation *x = &c.carried.x;
    const SlipMode slip = present_slip(&again);
    if (again.state.omega.hi == 0.0) x->omega = 0.0;
    else if (slip.regime == REGIME_RATE_INDEPENDENT) x->omega = speed_on_edge(&slip, again.state.theta.hi) * x->theta;
    *out = (StepSensitivity){finite_or_zero(x->theta), finite_or_zero(x->omega)};
}

COMPACT_END
