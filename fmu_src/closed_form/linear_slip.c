#include "closed_form/linear_slip.h"

#include <math.h>

static Regime regime_of(const Params *p, double damping) {
    if (has_inertia(p)) return REGIME_INERTIAL;
    return damping != 0.0 ? REGIME_VISCOUS : REGIME_RATE_INDEPENDENT;
}

static bool is_possible(const LinearSlipMode *linear) {
    if (!linear->transfer.regular) return false;
    if (linear->regime == REGIME_INERTIAL) return linear->mass > 0.0;
    return linear->regime == REGIME_RATE_INDEPENDENT ? linear->transfer.delta > 0.0 : linear->damping > 0.0;
}

static Oscillator oscillator_of_linear_slip(const LinearSlipMode *linear) {
    if (linear->regime == REGIME_INERTIAL)
        return oscillator_of(linear->damping / linear->mass, linear->stiffness / linear->mass);
    if (linear->regime == REGIME_VISCOUS) return oscillator_of(linear->stiffness / linear->damping, 0.0);
    return oscillator_of(0.0, 0.0);
}

void linear_slip_build(LinearSlipMode *linear, const Params *p, const Geometry *g, int direction, const int flank[2]) {
    const Transfer t = contact_transfer(g, direction, flank);
    const double c = direction > 0 ? p->damper.c_load : p->damper.c_release;
    const double follower = p->inertia.follower_mass * g->dz_dtheta;
    const double follower_inertia = p->inertia.follower * g->dpsi_dtheta[0];
    *linear = (LinearSlipMode){
        .direction = direction,
        .flank = {flank[0], flank[1]},
        .transfer = t,
        .mass = p->inertia.shaft + t.rho * follower + t.rho_kappa1 * follower_inertia,
        .damping = p->shaft.damping + t.rho * c * g->dz_dtheta,
        .stiffness = t.rho * p->spring.stiffness * g->dz_dtheta,
        .damper = c,
    };
    for (int i = 0; i < 2; i++) {
        linear->speed[i] = t.axial[i] * c * g->dz_dtheta;
        linear->acceleration[i] = t.axial[i] * follower + t.moment[i] * follower_inertia;
        linear->reaction[i] = cam_length(g, i) / p->contacts;
        linear->heat[i] = direction * flank[i] * cam_heat(g, i);
    }
    linear->regime = regime_of(p, linear->damping);
    linear->possible = is_possible(linear);
    if (linear->possible) linear->oscillator = oscillator_of_linear_slip(linear);
}

double linear_slip_net_torque(const LinearSlipMode *linear, const SlipStart *start) {
    return start->tau - linear->transfer.rho * start->force;
}

/* Rate of the net torque by the inputs alone, N.m/s. */
static double load_rate(const LinearSlipMode *linear, const SlipStart *l) {
    return l->tau_rate - linear->transfer.rho * l->F_ext_rate;
}

/* Slip begins only where the torque is beyond the edge of the stick band. Rounding at the edge must not start the
 * motion backwards: alpha, or without inertia omega, keeps to the direction. */
static void start_inertial(const LinearSlipMode *linear, SlipStart *l) {
    l->alpha = (linear_slip_net_torque(linear, l) - linear->damping * l->omega) / linear->mass;
    if (l->omega == 0.0 && linear->direction * l->alpha < 0.0) l->alpha = 0.0;
    if (l->tau_rate != 0.0 || l->F_ext_rate != 0.0) l->drive = load_rate(linear, l) / linear->mass;
    l->alpha_drive = l->drive - linear->oscillator.stiffness * l->omega;
}

static void start_viscous(const LinearSlipMode *linear, SlipStart *l) {
    l->omega = linear_slip_net_torque(linear, l) / linear->damping;
    if (linear->direction * l->omega < 0.0) l->omega = 0.0;
    l->alpha = (load_rate(linear, l) - linear->stiffness * l->omega) / linear->damping;
}

/* On the edge of the stick band N stays 0: the spring force follows the inputs. `offset` removes the N that
 * rounding has left; without it a long ramp in many steps would drift away from the edge. */
static void start_rate_independent(const LinearSlipMode *linear, SlipStart *l) {
    if (linear->stiffness == 0.0) return;
    l->omega = load_rate(linear, l) / linear->stiffness;
    l->offset = linear_slip_net_torque(linear, l) / linear->stiffness;
}

SlipStart linear_slip_start(const LinearSlipMode *linear, const Params *p, const Geometry *g, double theta,
                            double omega, const Inputs *inputs) {
    SlipStart l = {
        .theta = theta,
        .omega = omega,
        .tau = inputs->tau[0],
        .tau_rate = inputs->tau[1],
        .F_ext = inputs->F_ext[0],
        .F_ext_rate = inputs->F_ext[1],
        .force = p->spring.preload + p->spring.stiffness * (g->dz_dtheta * theta) + inputs->F_ext[0],
    };
    switch (linear->regime) {
        case REGIME_INERTIAL: start_inertial(linear, &l); break;
        case REGIME_VISCOUS: start_viscous(linear, &l); break;
        case REGIME_RATE_INDEPENDENT: start_rate_independent(linear, &l); break;
    }
    return l;
}

/* b0 = omega + alpha/(2a), the speed at which damping alone would settle, without the cancellation in that sum.
 * With inertia 2a = B/M and M alpha = N - B omega, so b0 = N/B. Without inertia 2a = K/B and B alpha = dN/dt - K
 * omega, so b0 is the rate of the inputs over K. */
static double settled_speed(const LinearSlipMode *linear, const SlipStart *l) {
    if (linear->regime == REGIME_VISCOUS) return load_rate(linear, l) / linear->stiffness;
    const bool held_back = l->omega == 0.0 && l->alpha == 0.0; /* see start_inertial */
    return held_back ? 0.0 : linear_slip_net_torque(linear, l) / linear->damping;
}

/* b0 or omega0, see oscillator.h. */
static double base_speed(const LinearSlipMode *linear, const SlipStart *l, const Kernel *k) {
    return k->lead != 0.0 ? settled_speed(linear, l) : l->omega;
}

LinearMotion linear_slip_motion_at_start(const LinearSlipMode *linear, const SlipStart *l) {
    return (LinearMotion){
        .omega = l->omega, .alpha = l->alpha, .jerk = l->alpha_drive - linear->oscillator.decay2 * l->alpha};
}

void linear_slip_motion(const LinearSlipMode *linear, const SlipStart *l, const Kernel *k, LinearMotion *motion) {
    const double decay2 = linear->oscillator.decay2, w2 = linear->oscillator.stiffness;
    const double b = base_speed(linear, l, k);
    const bool settles = k->lead != 0.0;
    /* s + 2a p1 = t - w2 p2: of a growing solution both terms on the left grow and cancel */
    const double base_time = decay2 < 0.0 ? k->t - w2 * k->p2 : k->s + decay2 * k->p1;
    const double alpha = l->alpha * k->ds + l->alpha_drive * k->s;
    const double omega = settles ? b * (1.0 - w2 * k->p1) - k->lead * k->ds * l->alpha + l->drive * k->p1
                                 : l->omega + (l->alpha * k->s + l->alpha_drive * k->p1);
    *motion = (LinearMotion){
        .t = k->t,
        .dtheta = b * base_time + l->alpha * (settles ? -k->lead * k->s : k->p1) + l->drive * k->p2 + l->offset,
        .domega = settles ? omega - l->omega : l->alpha * k->s + l->alpha_drive * k->p1,
        .omega = omega,
        .alpha = alpha,
        .jerk = l->drive - decay2 * alpha - w2 * omega,
        .settled = settles,
    };
}

/* x_i; with the time derivatives of force, omega and alpha, the time derivative of x_i. */
static inline double contact(const LinearSlipMode *linear, int i, double force, double omega, double alpha) {
    return linear->transfer.axial[i] * force + linear->speed[i] * omega + linear->acceleration[i] * alpha;
}

ContactLoad linear_slip_contact(const LinearSlipMode *linear, const Params *p, const Geometry *g, const SlipStart *l,
                                const LinearMotion *motion, int i) {
    const double spring = p->spring.stiffness * g->dz_dtheta;
    const double w2 = linear->oscillator.stiffness, decay2 = linear->oscillator.decay2;
    const double snap = -decay2 * motion->jerk - w2 * motion->alpha; /* d jerk/dt */
    const double force = l->force + spring * motion->dtheta + l->F_ext_rate * motion->t;
    return (ContactLoad){
        .value = contact(linear, i, force, motion->omega, motion->alpha),
        .rate = contact(linear, i, spring * motion->omega + l->F_ext_rate, motion->alpha, motion->jerk),
        .second = contact(linear, i, spring * motion->alpha, motion->jerk, snap),
    };
}

ContactLoadPair linear_slip_contacts(const LinearSlipMode *linear, double force, double force_rate,
                                     const LinearMotion *motion) {
    return (ContactLoadPair){
        .value = {contact(linear, 0, force, motion->omega, motion->alpha),
                  contact(linear, 1, force, motion->omega, motion->alpha)},
        .rate = {contact(linear, 0, force_rate, motion->alpha, motion->jerk),
                 contact(linear, 1, force_rate, motion->alpha, motion->jerk)},
    };
}

double linear_slip_contact_size(const LinearSlipMode *linear, const Params *p, const Geometry *g, const SlipStart *l,
                                int i) {
    const double spring = fabs(p->spring.stiffness * g->dz_dtheta);
    const double force = fabs(p->spring.preload) + spring * fabs(l->theta) + fabs(l->F_ext);
    return fabs(linear->transfer.axial[i]) * force + fabs(linear->speed[i] * l->omega) +
           fabs(linear->acceleration[i] * l->alpha);
}

/* integral of omega^2 over the segment, J per N.m.s/rad */
static double integral_of_square(const LinearSlipMode *linear, const SlipStart *l, Kernel *k) {
    if (!k->has_square) oscillator_square(&linear->oscillator, k);
    const double *q = k->square, b = base_speed(linear, l, k);
    const double free = q[0] * b * b + q[3] * l->alpha * l->alpha + 2.0 * q[1] * b * l->alpha;
    if (l->drive == 0.0) return free;
    return free + l->drive * (q[5] * l->drive + 2.0 * (q[2] * b + q[4] * l->alpha));
}

/* m^3, from the integrals of x_i omega. */
static void book_wear(const LinearSlipMode *linear, const Params *p, const Geometry *g, const double moved[2],
                      Booking *booking) {
    for (int i = 0; i < 2; i++)
        booking->wear[i] = linear->direction * linear->flank[i] * wear_per_sliding(p, i) * cam_length2(g, i) *
                           g->dpsi_dtheta[i] * moved[i];
}

/* The power of the reactions follows from the axial side. So its balance with the work of the torque checks the motion
 * and is no identity:
 *     integral of x_i omega = axial integral of (F_s + F_ext) omega + speed integral of omega^2
 *                             + acceleration (omega1^2 - omega0^2)/2 */
void linear_slip_book(const LinearSlipMode *linear, const Params *p, const Geometry *g, const SlipStart *l,
                      const LinearMotion *motion, Kernel *k, Booking *booking) {
    const double dtheta = motion->dtheta;
    double work_in = l->tau * dtheta, work_ext = l->F_ext * dtheta; /* work_ext: per z' until the end */
    if (l->tau_rate != 0.0 || l->F_ext_rate != 0.0) {
        /* of t omega over the segment: t (theta1 - theta0) less the integral of theta - theta0 */
        const double decay2 = linear->oscillator.decay2, w2 = linear->oscillator.stiffness;
        const double base = /* as base_time in linear_slip_motion() */
            decay2 < 0.0 ? 0.5 * k->t * k->t - w2 * k->p3 : k->p1 + decay2 * k->p2;
        const double angle_integral =
            base_speed(linear, l, k) * base + l->alpha * (k->lead != 0.0 ? -k->lead * k->p1 : k->p2) + l->drive * k->p3;
        const double omega_moment = motion->t * dtheta - angle_integral;
        work_in += l->tau_rate * omega_moment;
        work_ext += l->F_ext_rate * omega_moment;
    }
    const double dz_dtheta = g->dz_dtheta;
    const double force = l->force - l->F_ext; /* F_s at the start */
    const double work_axial = dtheta * (force + 0.5 * p->spring.stiffness * dz_dtheta * dtheta) + work_ext;
    const bool damped = linear->damper != 0.0 || p->shaft.damping != 0.0;
    const double square = damped ? integral_of_square(linear, l, k) : 0.0;
    const double kinetic = motion->domega * (l->omega + 0.5 * motion->domega);
    double moved[2]; /* the integrals of x_i omega */
    for (int i = 0; i < 2; i++) {
        moved[i] =
            linear->transfer.axial[i] * work_axial + linear->speed[i] * square + linear->acceleration[i] * kinetic;
        booking->heat_cam[i] = linear->heat[i] * moved[i];
    }
    booking->work_in = work_in;
    booking->work_ext = dz_dtheta * work_ext;
    booking->heat_damper = linear->damper * dz_dtheta * dz_dtheta * square;
    booking->heat_shaft = p->shaft.damping * square;
    if (has_wear(p)) book_wear(linear, p, g, moved, booking);
}

Booking linear_slip_jump_booking(const LinearSlipMode *linear, const Params *p, const Geometry *g, const SlipStart *l,
                                 double dtheta) {
    const double work_axial = dtheta * (l->force + 0.5 * p->spring.stiffness * g->dz_dtheta * dtheta);
    Booking booking = {
        .work_in = linear->transfer.rho * work_axial,
        .work_ext = g->dz_dtheta * l->F_ext * dtheta,
    };
    const double moved[2] = {linear->transfer.axial[0] * work_axial, linear->transfer.axial[1] * work_axial};
    for (int i = 0; i < 2; i++) booking.heat_cam[i] = linear->heat[i] * linear->transfer.axial[i] * work_axial;
    if (has_wear(p)) book_wear(linear, p, g, moved, &booking);
    return booking;
}
