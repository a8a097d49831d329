#include "flow.h"

#include <math.h>

double spring_force(const SpringParams *spring, double z) {
    return spring->preload + z * (spring->stiffness + z * (spring->stiffness2 + z * spring->stiffness3));
}

double spring_rate(const SpringParams *spring, double z) {
    return spring->stiffness + z * (2.0 * spring->stiffness2 + 3.0 * spring->stiffness3 * z);
}

double spring_energy(const SpringParams *spring, double z) {
    return z * (spring->preload +
                z * (spring->stiffness / 2.0 + z * (spring->stiffness2 / 3.0 + z * (spring->stiffness3 / 4.0))));
}

double damper_force(const DamperParams *damper, int direction, double v) {
    const double c = direction > 0 ? damper->c_load : damper->c_release;
    const double q = direction > 0 ? damper->q_load : damper->q_release;
    return v * (c + q * fabs(v));
}

static FlowKind kind_of(const Params *p, double damping) {
    if (has_inertia(p)) return FLOW_INERTIAL;
    return damping != 0.0 ? FLOW_VISCOUS : FLOW_QUASISTATIC;
}

static bool is_possible(const Slip *slip) {
    if (!slip->transfer.regular) return false;
    if (slip->kind == FLOW_INERTIAL) return slip->mass > 0.0;
    return slip->kind == FLOW_QUASISTATIC || slip->damping != 0.0;
}

static Oscillator oscillator_of_slip(const Slip *slip) {
    if (slip->kind == FLOW_INERTIAL)
        return oscillator_of(slip->damping / slip->mass, slip->stiffness / slip->mass);
    if (slip->kind == FLOW_VISCOUS) return oscillator_of(slip->stiffness / slip->damping, 0.0);
    return oscillator_of(0.0, 0.0);
}

void slip_build(Slip *slip, const Params *p, const Geometry *g, int direction, const int flank[2]) {
    const Transfer t = contact_transfer(g, direction, flank);
    const double c = direction > 0 ? p->damper.c_load : p->damper.c_release;
    const double follower = p->inertia.follower_mass * g->lift;
    const double twist = p->inertia.follower * g->turn[0];
    *slip = (Slip){
        .direction = direction,
        .flank = {flank[0], flank[1]},
        .transfer = t,
        .mass = p->inertia.shaft + t.rho * follower + t.rho_kappa1 * twist,
        .damping = p->shaft.damping + t.rho * c * g->lift,
        .stiffness = t.rho * p->spring.stiffness * g->lift,
        .damper = c,
    };
    for (int i = 0; i < 2; i++) {
        slip->speed[i] = t.axial[i] * c * g->lift;
        slip->acceleration[i] = t.axial[i] * follower + t.twist[i] * twist;
        slip->reaction[i] = cam_length(g, i) / p->contacts;
        slip->heat[i] = direction * flank[i] * cam_heat(g, i);
    }
    slip->kind = kind_of(p, slip->damping);
    slip->possible = is_possible(slip);
    if (slip->possible) slip->oscillator = oscillator_of_slip(slip);
}

double slip_net_torque(const Slip *slip, const Launch *launch) {
    return launch->tau - slip->transfer.rho * launch->force;
}

/* Rate at which the net torque changes by the inputs alone. */
static double load_rate(const Slip *slip, const Launch *l) {
    return l->tau_rate - slip->transfer.rho * l->F_ext_rate;
}

/* Slip begins only where the torque presses past the band's edge, so rounding at the edge must not
 * start it backwards: both launches keep to the direction. */
static void launch_inertial(const Slip *slip, Launch *l) {
    l->alpha = (slip_net_torque(slip, l) - slip->damping * l->omega) / slip->mass;
    if (l->omega == 0.0 && slip->direction * l->alpha < 0.0) l->alpha = 0.0;
    if (l->tau_rate != 0.0 || l->F_ext_rate != 0.0) l->drive = load_rate(slip, l) / slip->mass;
    l->curvature = l->drive - slip->oscillator.stiffness * l->omega;
}

static void launch_viscous(const Slip *slip, Launch *l) {
    l->omega = slip_net_torque(slip, l) / slip->damping;
    if (slip->direction * l->omega < 0.0) l->omega = 0.0;
    l->alpha = (load_rate(slip, l) - slip->stiffness * l->omega) / slip->damping;
}

/* On the edge of the band N stays 0: the spring takes what the inputs bring. What rounding has left of
 * N is moved off, or a long ramp in many steps would drift away from the edge. */
static void launch_quasistatic(const Slip *slip, Launch *l) {
    if (slip->stiffness == 0.0) return;
    l->omega = load_rate(slip, l) / slip->stiffness;
    l->offset = slip_net_torque(slip, l) / slip->stiffness;
}

Launch slip_launch(const Slip *slip, const Params *p, const Geometry *g, double theta, double omega,
                   const Inputs *inputs) {
    Launch l = {
        .theta = theta,
        .omega = omega,
        .tau = inputs->tau[0],
        .tau_rate = inputs->tau[1],
        .F_ext = inputs->F_ext[0],
        .F_ext_rate = inputs->F_ext[1],
        .force = p->spring.preload + p->spring.stiffness * (g->lift * theta) + inputs->F_ext[0], /* it is linear */
    };
    switch (slip->kind) {
        case FLOW_INERTIAL: launch_inertial(slip, &l); break;
        case FLOW_VISCOUS: launch_viscous(slip, &l); break;
        case FLOW_QUASISTATIC: launch_quasistatic(slip, &l); break;
    }
    return l;
}

/* omega + alpha/(2a), the speed that damping alone would settle at, without the cancellation in that sum:
 * 2a = B/M and M alpha = N - B omega, or without inertia 2a = K/B and B alpha = dN/dt - K omega. */
static double settled_speed(const Slip *slip, const Launch *l) {
    if (slip->kind == FLOW_VISCOUS) return load_rate(slip, l) / slip->stiffness;
    const bool held_back = l->omega == 0.0 && l->alpha == 0.0; /* see launch_inertial */
    return held_back ? 0.0 : slip_net_torque(slip, l) / slip->damping;
}

/* The speed that the closed forms start from: see oscillator.h. */
static double base_speed(const Slip *slip, const Launch *l, const Kernel *k) {
    return k->lead != 0.0 ? settled_speed(slip, l) : l->omega;
}

Arc slip_arc_start(const Slip *slip, const Launch *l) {
    return (Arc){.omega = l->omega, .alpha = l->alpha, .jerk = l->curvature - slip->oscillator.decay2 * l->alpha};
}

void slip_arc(const Slip *slip, const Launch *l, const Kernel *k, Arc *arc) {
    const double decay2 = slip->oscillator.decay2, w2 = slip->oscillator.stiffness;
    const double b = base_speed(slip, l, k);
    const bool settles = k->lead != 0.0;
    const double alpha = l->alpha * k->ds + l->curvature * k->s;
    const double omega = settles ? b * (1.0 - w2 * k->p1) - k->lead * k->ds * l->alpha + l->drive * k->p1
                                 : l->omega + (l->alpha * k->s + l->curvature * k->p1);
    *arc = (Arc){
        .t = k->t,
        .dtheta = b * (k->s + decay2 * k->p1) + l->alpha * (settles ? -k->lead * k->s : k->p1) + l->drive * k->p2 +
                  l->offset,
        .domega = settles ? omega - l->omega : l->alpha * k->s + l->curvature * k->p1,
        .omega = omega,
        .alpha = alpha,
        .jerk = l->drive - decay2 * alpha - w2 * omega,
        .settled = settles,
    };
}

/* x_i, or with the time derivatives of all three its own. */
static inline double contact(const Slip *slip, int i, double force, double omega, double alpha) {
    return slip->transfer.axial[i] * force + slip->speed[i] * omega + slip->acceleration[i] * alpha;
}

Contact slip_contact(const Slip *slip, const Params *p, const Geometry *g, const Launch *l, const Arc *arc, int i) {
    const double spring = p->spring.stiffness * g->lift;
    const double w2 = slip->oscillator.stiffness, decay2 = slip->oscillator.decay2;
    const double snap = -decay2 * arc->jerk - w2 * arc->alpha; /* d jerk/dt */
    const double force = l->force + spring * arc->dtheta + l->F_ext_rate * arc->t;
    return (Contact){
        .value = contact(slip, i, force, arc->omega, arc->alpha),
        .rate = contact(slip, i, spring * arc->omega + l->F_ext_rate, arc->alpha, arc->jerk),
        .curvature = contact(slip, i, spring * arc->alpha, arc->jerk, snap),
    };
}

ContactPair slip_contacts(const Slip *slip, double force, double force_rate, const Arc *arc) {
    return (ContactPair){
        .value = {contact(slip, 0, force, arc->omega, arc->alpha), contact(slip, 1, force, arc->omega, arc->alpha)},
        .rate = {contact(slip, 0, force_rate, arc->alpha, arc->jerk),
                 contact(slip, 1, force_rate, arc->alpha, arc->jerk)},
    };
}

Contact slip_contact_size(const Slip *slip, const Params *p, const Geometry *g, const Launch *l, int i) {
    const double axial = fabs(slip->transfer.axial[i]);
    const double speed = fabs(slip->speed[i]), acceleration = fabs(slip->acceleration[i]);
    const double spring = fabs(p->spring.stiffness * g->lift);
    const double omega = fabs(l->omega), alpha = fabs(l->alpha);
    const double decay2 = fabs(slip->oscillator.decay2), w2 = fabs(slip->oscillator.stiffness);
    const double jerk = fabs(l->drive) + decay2 * alpha + w2 * omega;
    const double force = fabs(p->spring.preload) + spring * fabs(l->theta) + fabs(l->F_ext);
    return (Contact){
        .value = axial * force + speed * omega + acceleration * alpha,
        .rate = axial * (spring * omega + fabs(l->F_ext_rate)) + speed * alpha + acceleration * jerk,
        .curvature = axial * spring * alpha + speed * jerk + acceleration * (decay2 * jerk + w2 * alpha),
    };
}

/* integral of omega^2 over the arc, J per N.m.s/rad */
static double integral_of_square(const Slip *slip, const Launch *l, Kernel *k) {
    if (!k->squared) oscillator_square(&slip->oscillator, k);
    const double *q = k->square, b = base_speed(slip, l, k);
    const double free = q[0] * b * b + q[3] * l->alpha * l->alpha + 2.0 * q[1] * b * l->alpha;
    if (l->drive == 0.0) return free;
    return free + l->drive * (q[5] * l->drive + 2.0 * (q[2] * b + q[4] * l->alpha));
}

/* The reactions' power follows from the axial side, so that the balance with the torque's work is a
 * check of the motion and not an identity:
 *     integral of x_i omega = axial integral of (F_s + F_ext) omega + speed integral of omega^2
 *                             + acceleration (omega1^2 - omega0^2)/2 */
Booking slip_booking(const Slip *slip, const Params *p, const Geometry *g, const Launch *l, const Arc *arc, Kernel *k) {
    const double dtheta = arc->dtheta;
    double work_in = l->tau * dtheta, work_ext = l->F_ext * dtheta; /* work_ext: per z' */
    if (l->tau_rate != 0.0 || l->F_ext_rate != 0.0) {
        /* integral of t omega = t (theta1 - theta0) - integral of (theta - theta0) */
        const double sweep = base_speed(slip, l, k) * (k->p1 + slip->oscillator.decay2 * k->p2) +
                             l->alpha * (k->lead != 0.0 ? -k->lead * k->p1 : k->p2) + l->drive * k->p3;
        const double moment = arc->t * dtheta - sweep;
        work_in += l->tau_rate * moment;
        work_ext += l->F_ext_rate * moment;
    }
    const double lift = g->lift;
    const double force = l->force - l->F_ext; /* F_s at the start */
    const double work_axial = dtheta * (force + 0.5 * p->spring.stiffness * lift * dtheta) + work_ext;
    const bool damped = slip->damper != 0.0 || p->shaft.damping != 0.0;
    const double square = damped ? integral_of_square(slip, l, k) : 0.0;
    const double kinetic = arc->domega * (l->omega + 0.5 * arc->domega);
    Booking booking = {
        .work_in = work_in,
        .work_ext = lift * work_ext,
        .heat_damper = slip->damper * lift * lift * square,
        .heat_shaft = p->shaft.damping * square,
    };
    for (int i = 0; i < 2; i++) {
        booking.heat_cam[i] = slip->heat[i] * (slip->transfer.axial[i] * work_axial + slip->speed[i] * square +
                                               slip->acceleration[i] * kinetic);
    }
    return booking;
}

Booking slip_jump_booking(const Slip *slip, const Params *p, const Geometry *g, const Launch *l, double dtheta) {
    const double work_axial = dtheta * (l->force + 0.5 * p->spring.stiffness * g->lift * dtheta);
    Booking booking = {
        .work_in = slip->transfer.rho * work_axial,
        .work_ext = g->lift * l->F_ext * dtheta,
    };
    for (int i = 0; i < 2; i++) booking.heat_cam[i] = slip->heat[i] * slip->transfer.axial[i] * work_axial;
    return booking;
}
