#include "sensitivity/step_sensitivity.h"

#include <math.h>

#include "collocation/radau_step.h"
#include "contact/contact.h"
#include "elementary/elementary.h"
#include "forward/candidate.h"
#include "forward/decide.h"
#include "forward/lifecycle.h"
#include "forward/step.h"
#include "forward/stick.h"
#include "numerics/tolerances.h"

/* ---- the edge E of the stick band, E = rho F_0 ---- */

/* A derivative that does not exist counts as 0. */
static double finite_or_zero(double x) {
    return isfinite(x) ? x : 0.0;
}

/* The torque beyond the edge, tau - E, with derivatives. */
typedef struct {
    RightHandSide rhs; /* rate-independent: by_theta is dE/dtheta, `value` the speed along the edge */
    Partials by;       /* of tau - E by inputs and parameters, N.m per unit; 0 by the state */
} Excess;

/* Is there a torque that moves cam 2 in `direction`? Then *slip is the slip mode along the edge. */
static bool edge_slip(const Mechanism *m, int direction, SlipMode *slip) {
    const int side = stick_axial_load(m) < 0.0 ? -1 : 1; /* the band is mirrored */
    int flank[2];
    Transfer transfer;
    Geometry g = m->configuration.geometry;
    cam_set_load(&m->params, stick_axial_load(m), &g);
    if (!contact_edge(&g, side * direction, flank, &transfer)) return false;
    for (int i = 0; i < 2; i++) flank[i] *= side;
    *slip = slip_mode_from_here(m, slip_index(direction, flank));
    slip->regime = REGIME_RATE_INDEPENDENT;
    return true;
}

/* At one angle. The residual Delta tau - P F_0 of the edge gives the derivatives: tau - E is the residual over Delta.
 * */
static Excess edge_excess(const SlipMode *slip, double theta) {
    Balance on_edge;
    Excess excess;
    balance_at(slip, theta, 0.0, 0.0, &on_edge);
    excess.rhs = on_edge.rhs;
    on_edge.tau -= on_edge.rhs.net;
    on_edge.omega = on_edge.damper = 0.0; /* no force depends on the speed */
    balance_partials(slip, &on_edge, &excess.by);
    const double delta = excess.by.by[KNOWN_TAU];
    for (int known = 0; known < KNOWN_COUNT; known++)
        excess.by.by[known] = known < KNOWN_TAU ? 0.0 : excess.by.by[known] / delta;
    return excess;
}

/* The change of theta along the edge, per unit of the known. */
static double give(const Excess *excess, int known) {
    return excess->by.by[known] / excess->rhs.by_theta;
}

/* The changes of theta on the edge, at constant time. 0 where cam 2 rests inside the band. */
static void edge_give(const Mechanism *m, const Excess *excess, Variation *x) {
    const double slope = excess->rhs.by_theta;
    const bool held =
        fabs(excess->rhs.net) <= SENSITIVITY_ROUNDING * stick_torque_size(m, m->configuration.geometry.dz_dtheta);
    for (int known = x->first; known < x->end; known++)
        x->theta[known] = held && slope > 0.0 ? give(excess, known) : 0.0;
}

/* The times, s per unit, by which the torque passes the edge later, if theta varies as in x: g = tau - E(theta) = 0
 * comes later by -dg/(dg/dt). `omega`: rad/s, of cam 2. */
static void edge_delays(const Mechanism *m, int direction, double omega, const Variation *x,
                        double delay[KNOWN_COUNT]) {
    SlipMode slip;
    const bool exists = edge_slip(m, direction, &slip);
    Excess excess = {.by = {.by = {0.0}}};
    if (exists) excess = edge_excess(&slip, m->state.theta.hi);
    const double *by = excess.by.by, slope = excess.rhs.by_theta;
    const double rate = m->inputs.tau[1] + by[KNOWN_F_EXT] * m->inputs.F_ext[1] - slope * omega;
    for (int known = x->first; known < x->end; known++)
        delay[known] = finite_or_zero(exists ? (slope * x->theta[known] - by[known]) / rate : 0.0);
}

/* Of a central difference of order 4, times 12. */
static const double offset[4] = {-2.0, -1.0, 1.0, 2.0}, weight[4] = {1.0, -8.0, 8.0, -1.0};

/* While theta follows the edge, the change of the speed is the time derivative of the change of theta, by a central
 * difference of order 4 along the motion. F_ext varies at most by a small share of F_0. */
static void edge_speed_give(const SlipMode *slip, double theta, double omega, Variation *x) {
    const Inputs *in = slip->inputs;
    const Excess now = edge_excess(slip, theta);
    Balance here;
    balance_at(slip, theta, 0.0, 0.0, &here);
    const double width = slip->piece->upper - slip->piece->lower;
    const double t = SENSITIVITY_DIFFERENCE * min_of(width / fabs(omega), fabs(here.force) / fabs(in->F_ext[1]));
    for (int known = x->first; known < x->end; known++) x->omega[known] = 0.0;
    for (int k = 0; k < 4; k++) {
        const Inputs there = {.tau = {in->tau[0]}, .F_ext = {in->F_ext[0] + in->F_ext[1] * offset[k] * t}};
        SlipMode moved = *slip;
        moved.inputs = &there;
        const Excess excess = edge_excess(&moved, theta + omega * offset[k] * t);
        for (int known = x->first; known < x->end; known++)
            x->omega[known] += weight[k] * (give(&excess, known) - give(&now, known)) / (12.0 * t);
    }
}

/* ---- the variation through a step ---- */

typedef struct {
    Variation x;
    /* s per unit, by which the event just passed comes later; x is taken at the event's own time. Else 0. */
    double delay[KNOWN_COUNT];
    bool late;    /* `delay` is set */
    bool moved;   /* cam 2 has moved in this step */
    bool slipped; /* the latest segment was slip */
    bool rested;  /* the latest segment was rest; the next one begins where the torque leaves the band */
} Carried;

static SlipMode present_slip(const Mechanism *m) {
    return slip_mode_from_here(m, present_slip_index(m));
}

static bool is_viscous(const Mechanism *m) {
    return present_slip(m).regime == REGIME_VISCOUS;
}

static bool is_at_stop(Mode mode) {
    return mode == MODE_LOWER_STOP || mode == MODE_UPPER_STOP;
}

static void clear(double of[KNOWN_COUNT]) {
    for (int known = 0; known < KNOWN_COUNT; known++) of[known] = 0.0;
}

static void clear_delay(Carried *v) {
    clear(v->delay);
    v->late = false;
}

/* The times by which the torque passes the edge of the band later. */
static void find_delay_at_edge(const Mechanism *m, int direction, double omega, Carried *v) {
    edge_delays(m, direction, omega, &v->x, v->delay);
    v->late = true;
}

/* ---- inside a segment ---- */

/* Not by parameters: in closed form the parameters that are 0 there have no part. */
static void carry_in_closed_form(const LinearSlipMode *slip, double t, Variation *x) {
    Kernel k;
    oscillator_kernel(&slip->oscillator, t, &k);
    for (int known = x->first; known < x->end; known++) {
        const double torque = known == KNOWN_TAU ? 1.0 : known == KNOWN_F_EXT ? -slip->transfer.rho : 0.0;
        const double theta = x->theta[known], omega = x->omega[known];
        if (slip->regime == REGIME_VISCOUS) {
            x->omega[known] = k.ds * (torque - slip->stiffness * theta) / slip->damping;
            x->theta[known] = k.ds * theta + torque * k.s / slip->damping;
            continue;
        }
        const double w2 = slip->oscillator.stiffness;
        x->theta[known] = (1.0 - w2 * k.p1) * theta + k.s * omega + torque * k.p1 / slip->mass;
        x->omega[known] = -w2 * k.s * theta + k.ds * omega + torque * k.s / slip->mass;
    }
}

/* Without inertia and damping theta is where the edge E(theta) equals the torque, whatever theta was before: d theta =
 * d(tau - E)/E'. Following the edge ends at a fold, E' = 0, when the torque gets to the torque of the fold. */
static void carry_along_edge(const Mechanism *m, const SlipMode *slip, Carried *v) {
    const Excess excess = edge_excess(slip, m->state.theta.hi);
    edge_give(m, &excess, &v->x);
    for (int known = v->x.first; known < v->x.end; known++)
        v->delay[known] = finite_or_zero(-excess.by.by[known] / (excess.rhs.value * excess.rhs.by_theta));
    v->late = true;
}

/* At the end of a jump that comes later by dt, d theta is (d(tau - E) + rate dt)/E'. The rate is that of the torque
 * beyond the edge. */
static void carry_over_jump(const Mechanism *m, int direction, double duration, Carried *v) {
    SlipMode slip;
    v->moved = true;
    if (duration > 0.0) clear_delay(v);
    clear(v->x.theta);
    if (!edge_slip(m, direction, &slip)) return;
    const Excess excess = edge_excess(&slip, m->state.theta.hi);
    edge_give(m, &excess, &v->x);
    for (int known = v->x.first; known < v->x.end; known++) v->x.theta[known] += excess.rhs.value * v->delay[known];
}

/* At an event, or before cam 2 has moved, a wedge ends the motion whatever the variation. */
static bool carry_through_wedge(Carried *v) {
    clear(v->x.omega);
    return v->late || !v->moved;
}

/* At a stop the angle is that of the stop. */
static void carry_through_rest(Mode mode, Carried *v) {
    const bool moved = v->moved;
    Variation x = v->x;
    clear(x.omega);
    if (is_at_stop(mode)) clear(x.theta);
    *v = (Carried){.x = x, .moved = moved};
}

static bool carry_along_slip(const Mechanism *m, const Segment *segment, const Inputs *inputs, Carried *v) {
    const int index = present_slip_index(m);
    const SlipMode slip = slip_mode_from_here(m, index);
    v->moved = true;
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
    SlipMode at_start = slip_mode_of(&m->params, &m->model.transmission, m->model.law, inputs, step->start.theta,
                                     slip.direction, slip.flank);
    at_start.work = m->work;
    return radau_step_vary(&at_start, step, &v->x);
}

/* Carries the variation through a segment in `mode` that has been applied; `inputs`: at its start. False where the
 * variation is not known. */
static bool carry(const Mechanism *m, const Segment *segment, const Inputs *inputs, Mode mode, Carried *v) {
    switch (segment->kind) {
        case SEGMENT_AT_EVENT: return true;
        case SEGMENT_WEDGE: return carry_through_wedge(v);
        case SEGMENT_REST: carry_through_rest(mode, v); return true;
        case SEGMENT_JUMP: carry_over_jump(m, direction_of(mode), segment->duration, v); return true;
        default: return carry_along_slip(m, segment, inputs, v);
    }
}

/* ---- at an event ---- */

/* The times by which a contact loses its load later. */
static void find_delay_at_flank(const SlipMode *slip, const Balance *b, Carried *v) {
    const int i = fabs(b->x[0]) < fabs(b->x[1]) ? 0 : 1;
    const RightHandSide *p = &b->rhs;
    Partials by;
    balance_response(slip, b, &by);
    BalanceRates along;
    balance_rates(slip, b, 0.0, &along);
    for (int known = v->x.first; known < v->x.end; known++) {
        BalanceChange change = balance_change_by(slip, b, (Known)known);
        change.theta = v->x.theta[known];
        change.omega = v->x.omega[known];
        change.alpha = p->by_theta * change.theta + p->by_omega * change.omega;
        if (known >= KNOWN_TAU) change.alpha += by.by[known];
        double of_x[2];
        balance_contact_changes(slip, b, &change, of_x);
        v->delay[known] = finite_or_zero(-of_x[i] / along.contact[i]);
    }
}

/* A stop turns omega into -e omega, or 0; at rest omega is 0. A contact that changes its flank carries no load at that
 * moment, so that alpha does not jump unless the other contact changes its flank as well. */
static void pass_inertial(const Mechanism *m, EventKind event, double omega, Carried *v) {
    const SlipMode slip = present_slip(m);
    const double returned = finite_or_zero(m->state.omega.hi / omega);
    Balance before;
    balance_at(&slip, m->state.theta.hi, omega, 0.0, &before);
    if (event == EVENT_FLANK) find_delay_at_flank(&slip, &before, v);
    for (int known = v->x.first; known < v->x.end; known++) {
        double *theta = &v->x.theta[known], *speed = &v->x.omega[known], *delay = &v->delay[known];
        if (event == EVENT_REST) {
            *delay = finite_or_zero(-*speed / before.alpha);
            *speed = 0.0;
        } else if (event == EVENT_STOP) {
            *delay = finite_or_zero(-*theta / omega);
            *speed = returned * (*speed + before.alpha * *delay);
            *theta = 0.0;
        } else {
            *theta += before.omega * *delay;
            *speed += before.alpha * *delay;
        }
    }
    v->late = true;
}

/* The times by which F_0 changes its sign later, and with F_0 the edge that theta follows. */
static void find_delay_at_mirror(const Mechanism *m, double omega, Carried *v) {
    const SlipMode slip = present_slip(m);
    const double z = m->configuration.z;
    const double slope = spring_rate(&m->params.spring, z) * m->configuration.geometry.dz_dtheta;
    for (int known = v->x.first; known < v->x.end; known++)
        v->delay[known] =
            finite_or_zero(-(slope * v->x.theta[known] + balance_force_by(&slip, (Known)known, 1.0, z, 0.0)) /
                           (slope * omega + m->inputs.F_ext[1]));
    v->late = true;
}

/* Cam 2 stops where its speed has vanished, or with a jump of its speed. The speed jumps where the torque is back in
 * the band while the damper loads other flanks than the spring, and where F_0 and with it the edge change their
 * signs. */
static void pass_without_inertia(const Mechanism *m, EventKind event, double omega, Carried *v) {
    clear_delay(v);
    if (event == EVENT_STOP) clear(v->x.theta);
    else if (event == EVENT_FLANK && !is_viscous(m)) find_delay_at_mirror(m, omega, v);
    else if (event == EVENT_REST && is_viscous(m)) find_delay_at_edge(m, direction_of(m->state.mode), omega, v);
    for (int known = v->x.first; known < v->x.end; known++) v->x.theta[known] += omega * v->delay[known];
}

/* `omega`: the speed at the event, before the event changed it. */
static void pass_event(const Mechanism *m, EventKind event, double omega, Carried *v) {
    if (event == EVENT_NONE) return; /* the motion goes on */
    if (has_inertia(&m->params)) pass_inertial(m, event, omega, v);
    else pass_without_inertia(m, event, omega, v);
}

/* Slip without inertia has ended in a mode of rest because the speed is no more than rounding: theta waits for the
 * torque to reach the edge, or cam 2 just reaches the stop. `m` is in the new mode; omega and direction are those
 * before. */
static void end_of_viscous_slip(const Mechanism *m, double omega, int direction, Carried *v) {
    if (is_at_stop(m->state.mode)) clear(v->x.theta);
    if (m->state.mode != MODE_STICK) return;
    double delay[KNOWN_COUNT];
    edge_delays(m, direction, omega, &v->x, delay);
    for (int known = v->x.first; known < v->x.end; known++) v->x.theta[known] += omega * delay[known];
}

/* Back to a variation at a fixed time, by the motion that follows the event. */
static void end_delay(const Mechanism *m, Carried *v) {
    if (!is_slip(m->state.mode) || (!v->late && !v->rested)) return;
    const SlipMode slip = present_slip(m);
    const Balance after = balance_from_here(m, &slip);
    const bool bursts = slip.regime == REGIME_VISCOUS && fabs(after.omega) > SENSITIVITY_ROUNDING * after.rhs.size;
    if (v->rested && (bursts || slip.regime == REGIME_RATE_INDEPENDENT)) find_delay_at_edge(m, slip.direction, 0.0, v);
    if (slip.regime == REGIME_RATE_INDEPENDENT) return; /* a jump that follows needs the delay */
    for (int known = v->x.first; known < v->x.end; known++) {
        v->x.theta[known] -= after.omega * v->delay[known];
        v->x.omega[known] -= after.alpha * v->delay[known];
    }
    clear_delay(v);
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

static double after_decision(StepVisitor *visitor, const Mechanism *m, double left) {
    Carrier *c = (Carrier *)visitor;
    if (c->viscous_slip_ends) end_of_viscous_slip(m, c->omega, c->direction, &c->carried);
    end_delay(m, &c->carried);
    return left;
}

static bool after_segment(StepVisitor *visitor, const Mechanism *m, const Segment *segment, const SegmentPast *past) {
    Carrier *c = (Carrier *)visitor;
    if (!carry(m, segment, &past->inputs, past->mode, &c->carried)) return false;
    pass_event(m, segment->end, past->omega, &c->carried);
    c->left -= segment->duration;
    c->carried.slipped = segment->kind == SEGMENT_CLOSED_FORM || segment->kind == SEGMENT_RADAU;
    c->carried.rested = segment->kind == SEGMENT_REST && c->left > 0.0;
    return true;
}

/* Sets what does not follow from the mechanism's motion: the ledger is not kept. The closed form knows no derivatives
 * by parameters: the motion is then integrated. */
static void prepare(bool by_parameters, Mechanism *again) {
    mechanism_rewind(again);
    again->params.ledger = false;
    if (!by_parameters || !again->model.closed_form) return;
    again->model.closed_form = false;
    again->params.tolerance = TOLERANCE_MIN; /* the closed form has all digits */
}

/* Speed at the end: without inertia the speed follows from the angle. */
static void find_speed(const Mechanism *m, Variation *x) {
    const SlipMode slip = present_slip(m);
    const double omega = m->state.omega.hi;
    if (omega == 0.0) clear(x->omega);
    else if (slip.regime == REGIME_RATE_INDEPENDENT) edge_speed_give(&slip, m->state.theta.hi, omega, x);
}

/* Where peak = 1, the variation has left out the peak. */
static void leave_out_peaks(const Params *p, StepSensitivity *out) {
    for (int i = 0; i < 2; i++)
        if (p->cam[i].law.peak == 1.0) out->dtheta[KNOWN_PEAK_1 + i] = out->domega[KNOWN_PEAK_1 + i] = 0.0;
}

void step_sensitivity(const Mechanism *m, bool by_parameters, StepSensitivity *out) {
    Mechanism again = *m; /* the transmission is m's own: not to be freed */
    Carrier c = {.visitor = {before_decision, after_decision, after_segment, .every_decision = true},
                 .left = m->state.step.h};
    Variation *x = &c.carried.x;
    x->first = by_parameters ? KNOWN_FRICTION_1 : 0;
    x->end = by_parameters ? KNOWN_COUNT : KNOWN_FRICTION_1;
    x->theta[KNOWN_THETA] = 1.0;
    x->omega[KNOWN_OMEGA] = has_inertia(&m->params) ? 1.0 : 0.0;
    for (int known = x->first; known < x->end; known++) out->dtheta[known] = out->domega[known] = 0.0;
    if (!(m->state.step.h > 0.0)) return;
    prepare(by_parameters, &again);
    if (!mechanism_go_through(&again, m->state.step.h, &c.visitor)) return;
    find_speed(&again, x);
    for (int known = x->first; known < x->end; known++) {
        out->dtheta[known] = finite_or_zero(x->theta[known]);
        out->domega[known] = finite_or_zero(x->omega[known]);
    }
    leave_out_peaks(&again.params, out);
}
