#include "contact/balance.h"

#include <math.h>

#include "contact/residual.h"
#include "elementary/elementary.h"
#include "numerics/tolerances.h"
#include "platform/attributes.h"

/* ---- the right-hand side ---- */

/* Delta (tau - b omega) - P F - (P m z'' + Q I gamma'') omega^2, with derivatives. */
typedef struct {
    Dual value; /* N.m m^3, and per rad */
    double by_omega;
    double size; /* sum of the magnitudes of the terms, without that in omega^2 */
} NetTorque;

static inline NetTorque net_torque(const SlipMode *slip, const SlipCoefficients *k, double z, const InputValues *in,
                                   double omega) {
    const Params *p = slip->params;
    const DualContactFactors *f = &k->factors;
    const double v = k->dz_dtheta.value * omega;
    const double damper = slip_damper_force(slip, v), damper_rate = slip_damper_rate(slip, v);
    const double spring = spring_force(&p->spring, z), F_ext = in->F_ext;
    const Dual load = {spring + F_ext + damper,
                       spring_rate(&p->spring, z) * k->dz_dtheta.value + damper_rate * k->dz_dtheta.slope * omega};
    const double shaft_torque = p->shaft.damping * omega, tau = in->tau - shaft_torque;
    NetTorque net = {
        .value = {f->delta.value * tau - f->p.value * load.value,
                  f->delta.slope * tau - f->p.slope * load.value - f->p.value * load.slope},
        .by_omega = -f->delta.value * p->shaft.damping - f->p.value * damper_rate * k->dz_dtheta.value,
        .size = fabs(f->delta.value) * (fabs(in->tau) + fabs(shaft_torque)) +
                fabs(f->p.value) * (fabs(spring) + fabs(F_ext) + fabs(damper)),
    };
    if (slip->follower_has_inertia) {
        const Dual by_speed = slip_inertia_by_speed(slip, k);
        net.value.value -= by_speed.value * omega * omega;
        net.value.slope -= by_speed.slope * omega * omega;
        net.by_omega -= 2.0 * by_speed.value * omega;
    }
    return net;
}

/* alpha = net torque/[J Delta + P m z' + Q I gamma'] */
static inline RightHandSide rhs_of_inertial(const SlipMode *slip, const SlipCoefficients *k, double z,
                                            const InputValues *in, double omega) {
    const DualContactFactors *f = &k->factors;
    const NetTorque net = net_torque(slip, k, z, in, omega);
    const Dual inertia = slip_inertia(slip, k);
    const double inverse = 1.0 / inertia.value;
    const double alpha = net.value.value * inverse;
    return (RightHandSide){
        .value = alpha,
        .size = net.size * fabs(inverse),
        .by_theta = (net.value.slope - alpha * inertia.slope) * inverse,
        .by_omega = net.by_omega * inverse,
        .by_time = (f->delta.value * in->tau_rate - f->p.value * in->F_ext_rate) * inverse,
        .possible = inertia.value * f->delta.value > 0.0,
    };
}

/* The solution of B omega + C omega |omega| = N in the direction of slip. */
typedef struct {
    double omega;  /* rad/s */
    double sign;   /* of B, or of C where B = 0 */
    double sum;    /* B + sign sqrt(B^2 + 4 C N) */
    double square; /* B^2 + 4 C N */
} ViscousSpeed;

/* A locked contact (P < 0) can cause two roots; the root nearer to zero is taken, for there more torque means more
 * speed. The form 2 N/(B + sqrt(B^2 + 4 C N)) does not cancel. For speeds against the direction, where an iteration may
 * look, the law is continued as an odd function. */
static inline ViscousSpeed viscous_speed(double b, double c, double n, int direction) {
    const double sign = b < 0.0 || (b == 0.0 && c < 0.0) ? -1.0 : 1.0;
    const bool same_sign = b * c >= 0.0;
    const double four_cn = same_sign ? fabs(c * n) : c * direction * n;
    const double square = b * b + 4.0 * four_cn;
    const double sum = b + sign * sqrt(max_of(square, 0.0));
    return (ViscousSpeed){.omega = sum != 0.0 ? 2.0 * n / sum : 0.0, .sign = sign, .sum = sum, .square = square};
}

/* B omega + C omega |omega| = N with B = Delta b + P c z', C = P q z'^2, N = Delta tau - P F_0. */
static inline RightHandSide rhs_of_viscous(const SlipMode *slip, const SlipCoefficients *k, double z,
                                           const InputValues *in) {
    const DualContactFactors *f = &k->factors;
    const NetTorque net = net_torque(slip, k, z, in, 0.0);
    const Dual n = net.value;
    const Dual pz = dual_multiply(f->p, k->dz_dtheta);
    const Dual b = dual_add(dual_scale(slip->params->shaft.damping, f->delta), dual_scale(slip->c, pz));
    const Dual c = dual_scale(slip->q, dual_multiply(pz, k->dz_dtheta));
    const ViscousSpeed speed = viscous_speed(b.value, c.value, n.value, slip->direction);
    const double omega = speed.omega;
    const double steepness = b.value + 2.0 * c.value * fabs(omega); /* dN/d omega */
    const double inverse = steepness != 0.0 ? 1.0 / steepness : 0.0;
    return (RightHandSide){
        .value = omega,
        .size = speed.sum != 0.0 ? 2.0 * net.size / fabs(speed.sum) : 0.0,
        .by_theta = (n.slope - omega * (b.slope + c.slope * fabs(omega))) * inverse,
        .by_time = (f->delta.value * in->tau_rate - f->p.value * in->F_ext_rate) * inverse,
        .possible = (speed.sum != 0.0 || c.value != 0.0) && speed.square >= 0.0 && speed.sign * f->delta.value > 0.0,
    };
}

/* m: dE/dF_0 of the edge E = rho F_0 of the stick band, which is rho unless friction depends on the load. */
static double edge_rate(const SlipMode *slip, const SlipCoefficients *k, double rho, double F_0) {
    const ContactFactors *by = &k->dfactors_dload;
    return slip->friction_varies ? rho + F_0 * (by->p - rho * by->delta) / k->factors.delta.value : rho;
}

/* On the band's edge tau = E(theta) = rho F_0, so that (tau - rho F_ext)' = dE/dtheta omega gives omega. by_theta holds
 * dE/dtheta, N.m/rad, the derivative that an iteration along the edge needs. */
static inline RightHandSide rhs_of_rate_independent(const SlipMode *slip, const SlipCoefficients *k, double z,
                                                    const InputValues *in) {
    const Params *p = slip->params;
    const Dual load = {spring_force(&p->spring, z) + in->F_ext, spring_rate(&p->spring, z) * k->dz_dtheta.value};
    const Dual rho = dual_contact_factors_rho(&k->factors);
    const double stiffness = rho.slope * load.value + rho.value * load.slope;
    const double rate = in->tau_rate - edge_rate(slip, k, rho.value, load.value) * in->F_ext_rate;
    return (RightHandSide){
        .value = stiffness > 0.0 ? rate / stiffness : 0.0,
        .by_theta = stiffness,
        .net = in->tau - rho.value * load.value,
        .possible = k->factors.delta.value > 0.0,
    };
}

/* With the coefficients k as they are. */
NOINLINE static RightHandSide rhs_of_coefficients(const SlipMode *slip, const SlipCoefficients *k, double z,
                                                  const InputValues *in, double omega) {
    switch (slip->regime) {
        case REGIME_INERTIAL: return rhs_of_inertial(slip, k, z, in, omega);
        case REGIME_VISCOUS: return rhs_of_viscous(slip, k, z, in);
        default: return rhs_of_rate_independent(slip, k, z, in);
    }
}

/* ---- where friction varies ---- */

/* What the speed and the load change through the friction coefficients. Without inertia the coefficients depend on the
 * load alone. */
NOINLINE static RightHandSide rhs_of_varying(const SlipMode *slip, const SlipCoefficients *k, double z,
                                             const InputValues *in, double omega) {
    RightHandSide rhs = rhs_of_coefficients(slip, k, z, in, omega);
    if (slip->regime == REGIME_RATE_INDEPENDENT) return rhs;
    const bool inertial = slip->regime == REGIME_INERTIAL;
    const double speed = inertial ? omega : rhs.value, b = slip->params->shaft.damping;
    const double dz_dtheta = k->dz_dtheta.value, v = dz_dtheta * speed;
    const MotionTerms terms = {
        .torque = in->tau - b * speed,
        .load = spring_force(&slip->params->spring, z) + in->F_ext + slip_damper_force(slip, v),
        .omega = speed,
        .alpha = inertial ? rhs.value : 0.0,
    };
    /* of the residual by what the balance gives: alpha, or omega */
    const double steepness =
        inertial ? slip_inertia(slip, k).value
                 : b * k->factors.delta.value + k->factors.p.value * dz_dtheta * slip_damper_rate(slip, v);
    if (inertial) rhs.by_omega += residual_change(slip, k, &k->dfactors_domega, &terms) / steepness;
    rhs.by_time += residual_change(slip, k, &k->dfactors_dload, &terms) * in->F_ext_rate / steepness;
    return rhs;
}

static inline RightHandSide rhs_of(const SlipMode *slip, const SlipCoefficients *k, double z, const InputValues *in,
                                   double omega) {
    return slip->friction_varies ? rhs_of_varying(slip, k, z, in, omega) : rhs_of_coefficients(slip, k, z, in, omega);
}

RightHandSide balance_rhs(const SlipMode *slip, double theta, double omega, double t) {
    SlipCoefficients storage;
    double z;
    const InputValues in = slip_inputs_at(slip, t);
    const SlipCoefficients *k = slip_coefficients_at(slip, theta, omega, in.F_ext, &storage, &z);
    return rhs_of(slip, k, z, &in, omega);
}

/* ---- the balance ---- */

/* Sets what theta, omega, alpha, z and the inputs of the balance imply, but the contact loads; returns A and W. */
static inline Loads describe(const SlipMode *slip, const SlipCoefficients *k, Balance *b) {
    const Params *p = slip->params;
    const double inverse = 1.0 / k->factors.delta.value;
    b->dz_dtheta = k->dz_dtheta.value;
    b->force = spring_force(&p->spring, b->z) + b->F_ext;
    b->damper = slip_damper_force(slip, b->dz_dtheta * b->omega);
    for (int i = 0; i < 2; i++) {
        b->dpsi_dtheta[i] = k->dpsi_dtheta[i].value;
        b->friction[i] = slip_friction(slip, k, i);
        b->axial[i] = k->factors.rn[1 - i].value * inverse;
        b->length2[i] = p->cam[i].radius * p->cam[i].radius + k->slope[i].value * k->slope[i].value;
    }
    return loads_of(slip, k, b->force + b->damper, b->omega, b->alpha);
}

void balance_at(const SlipMode *slip, double theta, double omega, double t, Balance *b) {
    SlipCoefficients storage;
    const InputValues in = slip_inputs_at(slip, t);
    const SlipCoefficients *k = slip_coefficients_at(slip, theta, omega, in.F_ext, &storage, &b->z);
    const bool inertial = slip->regime == REGIME_INERTIAL;
    b->rhs = rhs_of(slip, k, b->z, &in, omega);
    b->theta = theta;
    b->omega = inertial ? omega : b->rhs.value;
    b->alpha = inertial ? b->rhs.value : 0.0;
    b->tau = in.tau;
    b->F_ext = in.F_ext;
    const Loads load = describe(slip, k, b);
    const double inverse = 1.0 / k->factors.delta.value;
    b->x[0] = (k->factors.rn[1].value * load.axial - k->factors.d[1].value * load.moment) * inverse;
    b->x[1] = (k->factors.rn[0].value * load.axial + k->factors.d[0].value * load.moment) * inverse;
}

/* Friction heat: mu_i |R_i| times the sliding speed (docs/mechanism.md, section 4). */
Booking balance_power(const SlipMode *slip, const Balance *balance) {
    const double omega = balance->omega, v = balance->dz_dtheta * omega;
    Booking power = {
        .work_in = balance->tau * omega,
        .work_ext = balance->F_ext * v,
        .heat_damper = balance->damper * v,
        .heat_shaft = slip->params->shaft.damping * omega * omega,
    };
    for (int i = 0; i < 2; i++)
        power.heat_cam[i] =
            balance->friction[i] * balance->x[i] * balance->length2[i] * balance->dpsi_dtheta[i] * omega;
    for (int i = 0; has_wear(slip->params) && i < 2; i++)
        power.wear[i] = wear_per_sliding(slip->params, i) * slip->direction * slip->flank[i] * balance->x[i] *
                        balance->length2[i] * balance->dpsi_dtheta[i] * omega;
    return power;
}

/* m/s, in the direction of slip */
static double sliding_speed(const SlipMode *slip, const Balance *b, int i) {
    return slip->direction * b->omega * b->dpsi_dtheta[i] * sqrt(b->length2[i]);
}

/* N, N_i (model/friction_law.h), with the sign of F */
static double signed_load(const SlipMode *slip, const Balance *b, int i) {
    return (b->force + b->damper) * b->dpsi_dtheta[i] * sqrt(b->length2[i]) * slip_load_per_sliding(slip, i);
}

double balance_friction_share(const SlipMode *slip, const Balance *from, const Balance *to) {
    double share = 1.0;
    for (int i = 0; i < 2; i++) {
        const FrictionFall *fall = &slip->law[i].fall;
        const double part = friction_share(fall, sliding_speed(slip, from, i), sliding_speed(slip, to, i));
        if (part < 1.0) share = min_of(share, fall->table ? part : STEP_SAFETY * part);
        const double from_load = signed_load(slip, from, i), to_load = signed_load(slip, to, i);
        share = min_of(
            share, fall->table ? friction_table_load_share(fall->table, fall->overshoot, fabs(from_load), fabs(to_load))
                               : friction_load_share(fall, from_load, to_load));
    }
    return share;
}
