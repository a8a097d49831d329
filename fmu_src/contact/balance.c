#include "contact/balance.h"

#include <math.h>

#include "platform/attributes.h"

double input_value(const double u[INPUT_ORDER + 1], double t) {
    return u[0] + t * (u[1] + t / 2.0 * (u[2] + t / 3.0 * u[3]));
}

double input_rate(const double u[INPUT_ORDER + 1], double t) {
    return u[1] + t * (u[2] + t / 2.0 * u[3]);
}

void inputs_advance(Inputs *inputs, double t) {
    input_shift(inputs->tau, t);
    input_shift(inputs->F_ext, t);
}

/* The inputs at one instant. */
typedef struct {
    double tau, F_ext, tau_rate, F_rate; /* N.m, N, N.m/s, N/s */
} Drive;

static inline Drive drive_at(const SlipMode *slip, double t) {
    const Inputs *in = slip->inputs;
    if (slip->steady) return (Drive){.tau = in->tau[0], .F_ext = in->F_ext[0]};
    return (Drive){input_value(in->tau, t), input_value(in->F_ext, t), input_rate(in->tau, t),
                   input_rate(in->F_ext, t)};
}

/* ---- geometry and friction, with derivatives by theta ---- */

/* gamma' = a2/(a1+a2), z' = a1 gamma'; differentiated:
 *     gamma'' = (a2' phi' - a1' gamma')/(a1+a2)          z'' = a1' gamma'^2 + a2' phi'^2
 *     gamma''' = (a2'' phi' - a1'' gamma' - 2 gamma'' (a1'+a2'))/(a1+a2)
 *     z''' = a1'' gamma'^2 + a2'' phi'^2 + 2 gamma'' (a1' gamma' - a2' phi') */
static inline void factors_of(const SlipMode *slip, TransmissionPoint s, ContactFactors *factors) {
    for (int i = 0; i < 2; i++) s.slope[i] = fmax(s.slope[i], 0.0); /* level, but for the polynomial's rounding */
    const double inverse = 1.0 / (s.slope[0] + s.slope[1]);
    const double g = s.slope[1] * inverse, f = s.slope[0] * inverse;
    const double gg = (s.dslope_dtheta[1] * f - s.dslope_dtheta[0] * g) * inverse;
    const double zz = s.dslope_dtheta[0] * g * g + s.dslope_dtheta[1] * f * f;
    factors->dz_dtheta = (Dual){s.slope[0] * g, zz};
    factors->dpsi_dtheta[0] = (Dual){g, gg};
    factors->dpsi_dtheta[1] = (Dual){f, -gg};
    factors->d2z_dtheta2 = (Dual){zz, 0.0};
    factors->d2gamma_dtheta2 = (Dual){gg, 0.0};
    if (slip->heavy) {
        const double dslope_dtheta = s.dslope_dtheta[0] + s.dslope_dtheta[1];
        factors->d2gamma_dtheta2.slope =
            (s.d2slope_dtheta2[1] * f - s.d2slope_dtheta2[0] * g - 2.0 * gg * dslope_dtheta) * inverse;
        factors->d2z_dtheta2.slope = s.d2slope_dtheta2[0] * g * g + s.d2slope_dtheta2[1] * f * f +
                                     2.0 * gg * (s.dslope_dtheta[0] * g - s.dslope_dtheta[1] * f);
    }
    for (int i = 0; i < 2; i++) {
        const double r = slip->params->cam[i].radius;
        factors->slope[i] = (Dual){s.slope[i], s.dslope_dtheta[i]};
        factors->rn[i] = dual_line(r * (slip->mu[i] * r), r, factors->slope[i]);
        factors->d[i] = dual_line(r, -slip->mu[i], factors->slope[i]);
    }
    factors->q = dual_multiply(factors->d[0], factors->rn[1]);
    factors->delta = dual_add(factors->q, dual_multiply(factors->rn[0], factors->d[1]));
    factors->p = dual_multiply(factors->rn[0], factors->rn[1]);
}

static TransmissionPoint straight_point(const TransmissionPiece *piece) {
    return (TransmissionPoint){.slope = {piece->slope[0][0], piece->slope[0][1]}};
}

/* The form at theta, in *here unless the way has it, and z. */
static const ContactFactors *factors_at(const SlipMode *slip, double theta, ContactFactors *here, double *z) {
    const TransmissionPiece *piece = slip->piece;
    if (slip->transmission->straight) {
        *z = piece->z[0] + (theta - piece->middle) * piece->scale * piece->z[1];
        return &slip->factors;
    }
    const TransmissionPoint point = slip->heavy ? piece_point(piece, theta, TRANSMISSION_SECOND_DERIVATIVES)
                                                : piece_point(piece, theta, TRANSMISSION_FIRST_DERIVATIVES);
    *z = point.z;
    factors_of(slip, point, here);
    return here;
}

/* ---- the way ---- */

static Regime regime_of_slip_mode(const SlipMode *slip) {
    if (has_inertia(slip->params)) return REGIME_INERTIAL;
    return slip->c + slip->q + slip->params->shaft.damping > 0.0 ? REGIME_VISCOUS : REGIME_RATE_INDEPENDENT;
}

SlipMode slip_mode_of(const Params *p, const Transmission *transmission, const Inputs *inputs, double theta,
                      int direction, const int flank[2]) {
    const DamperParams *d = &p->damper;
    SlipMode slip; /* its form is set where it is used */
    slip.params = p;
    slip.transmission = transmission;
    slip.piece = transmission_piece(transmission, theta, direction);
    slip.inputs = inputs;
    slip.direction = direction;
    for (int i = 0; i < 2; i++) {
        slip.flank[i] = flank[i];
        slip.mu[i] = direction * flank[i] * p->cam[i].friction;
    }
    slip.c = direction > 0 ? d->c_load : d->c_release;
    slip.q = direction > 0 ? d->q_load : d->q_release;
    slip.heavy = p->inertia.follower_mass + p->inertia.follower > 0.0;
    slip.steady = inputs_constant(inputs);
    slip.to_rounding = false;
    slip.regime = regime_of_slip_mode(&slip);
    if (transmission->straight) factors_of(&slip, straight_point(slip.piece), &slip.factors);
    return slip;
}

/* ---- the equation of motion ---- */

/* J Delta + P m z' + Q I gamma' */
static inline Dual mass_of(const SlipMode *slip, const ContactFactors *f) {
    const InertiaParams *i = &slip->params->inertia;
    const Dual shaft = dual_scale(i->shaft, f->delta);
    if (!slip->heavy) return shaft;
    return dual_add(shaft, dual_add(dual_multiply(dual_scale(i->follower_mass, f->p), f->dz_dtheta),
                                    dual_multiply(dual_scale(i->follower, f->q), f->dpsi_dtheta[0])));
}

/* P m z'' + Q I gamma'' */
static inline Dual swirl_of(const SlipMode *slip, const ContactFactors *f) {
    const InertiaParams *i = &slip->params->inertia;
    return dual_add(dual_multiply(dual_scale(i->follower_mass, f->p), f->d2z_dtheta2),
                    dual_multiply(dual_scale(i->follower, f->q), f->d2gamma_dtheta2));
}

static inline RightHandSide rhs_of_inertial(const SlipMode *slip, const ContactFactors *f, double z, const Drive *in,
                                            double omega) {
    const Params *p = slip->params;
    const double v = f->dz_dtheta.value * omega;
    const double damper = v * (slip->c + slip->q * fabs(v));
    const double damper_rate = slip->c + 2.0 * slip->q * fabs(v);
    const double spring = spring_force(&p->spring, z), F_ext = in->F_ext;
    const Dual load = {spring + F_ext + damper,
                       spring_rate(&p->spring, z) * f->dz_dtheta.value + damper_rate * f->dz_dtheta.slope * omega};
    const double shaft_torque = p->shaft.damping * omega, torque = in->tau, tau = torque - shaft_torque;
    const Dual mass = mass_of(slip, f);
    Dual net = {f->delta.value * tau - f->p.value * load.value,
                f->delta.slope * tau - f->p.slope * load.value - f->p.value * load.slope};
    double net_by_omega = -f->delta.value * p->shaft.damping - f->p.value * damper_rate * f->dz_dtheta.value;
    if (slip->heavy) {
        const Dual swirl = swirl_of(slip, f);
        net.value -= swirl.value * omega * omega;
        net.slope -= swirl.slope * omega * omega;
        net_by_omega -= 2.0 * swirl.value * omega;
    }
    const double inverse = 1.0 / mass.value;
    const double alpha = net.value * inverse;
    const double force_size = fabs(spring) + fabs(F_ext) + fabs(damper);
    return (RightHandSide){
        .value = alpha,
        .size = (fabs(f->delta.value) * (fabs(torque) + fabs(shaft_torque)) + fabs(f->p.value) * force_size) *
                fabs(inverse),
        .by_theta = (net.slope - alpha * mass.slope) * inverse,
        .by_omega = net_by_omega * inverse,
        .by_time = (f->delta.value * in->tau_rate - f->p.value * in->F_rate) * inverse,
        .resistance = fabs(mass.value),
        .possible = mass.value * f->delta.value > 0.0,
        .stable = true,
    };
}

/* B omega + C omega |omega| = N with B = Delta b + P c z', C = P q z'^2, N = Delta tau - P F_0. Of two roots, which a
 * locked contact (P < 0) can cause, the one nearer to zero: there more torque means more speed. It is written without
 * cancellation. Backward, where a step may look, it is continued as an odd function. */
static inline RightHandSide rhs_of_viscous(const SlipMode *slip, const ContactFactors *f, double z, const Drive *in) {
    const Params *p = slip->params;
    const double tau = in->tau;
    const double spring = spring_force(&p->spring, z), F_ext = in->F_ext;
    const Dual load = {spring + F_ext, spring_rate(&p->spring, z) * f->dz_dtheta.value};
    const Dual n = {f->delta.value * tau - f->p.value * load.value,
                    f->delta.slope * tau - f->p.slope * load.value - f->p.value * load.slope};
    const Dual pz = dual_multiply(f->p, f->dz_dtheta);
    const Dual b = dual_add(dual_scale(p->shaft.damping, f->delta), dual_scale(slip->c, pz));
    const Dual c = dual_scale(slip->q, dual_multiply(pz, f->dz_dtheta));
    const double sign = b.value < 0.0 || (b.value == 0.0 && c.value < 0.0) ? -1.0 : 1.0;
    const bool alike = b.value * c.value >= 0.0;
    const double four_cn = alike ? fabs(c.value * n.value) : c.value * slip->direction * n.value;
    const double square = b.value * b.value + 4.0 * four_cn;
    const double sum = b.value + sign * sqrt(fmax(square, 0.0));
    const double omega = sum != 0.0 ? 2.0 * n.value / sum : 0.0;
    const double steepness = b.value + 2.0 * c.value * fabs(omega); /* dN/d omega */
    const double inverse = steepness != 0.0 ? 1.0 / steepness : 0.0;
    const double n_size = fabs(f->delta.value * tau) + fabs(f->p.value) * (fabs(spring) + fabs(F_ext));
    return (RightHandSide){
        .value = omega,
        .size = sum != 0.0 ? 2.0 * n_size / fabs(sum) : 0.0,
        .by_theta = (n.slope - omega * (b.slope + c.slope * fabs(omega))) * inverse,
        .by_time = (f->delta.value * in->tau_rate - f->p.value * in->F_rate) * inverse,
        .possible = (sum != 0.0 || c.value != 0.0) && square >= 0.0 && f->delta.value != 0.0,
        .stable = sign * f->delta.value > 0.0,
    };
}

/* On the band's edge E(theta) = rho F_0 the torque fixes theta, so (tau - rho F_ext)' = dE/dtheta omega. Value: that
 * omega; by_theta holds dE/dtheta itself, N.m/rad, which a step along the edge
 * solves with. */
static inline RightHandSide rhs_of_rate_independent(const SlipMode *slip, const ContactFactors *f, double z,
                                                    const Drive *in) {
    const Params *p = slip->params;
    const Dual load = {spring_force(&p->spring, z) + in->F_ext, spring_rate(&p->spring, z) * f->dz_dtheta.value};
    const double inverse = 1.0 / f->delta.value;
    const double rho = f->p.value * inverse;
    const double rho_rate = (f->p.slope - rho * f->delta.slope) * inverse;
    const double stiffness = rho_rate * load.value + rho * load.slope;
    const double rate = in->tau_rate - rho * in->F_rate;
    return (RightHandSide){
        .value = stiffness > 0.0 ? rate / stiffness : 0.0,
        .by_theta = stiffness,
        .net = in->tau - rho * load.value,
        .resistance = stiffness,
        .possible = f->delta.value != 0.0,
        .stable = stiffness > 0.0,
    };
}

NOINLINE static RightHandSide rhs_of(const SlipMode *slip, const ContactFactors *f, double z, const Drive *in,
                                     double omega) {
    switch (slip->regime) {
        case REGIME_INERTIAL: return rhs_of_inertial(slip, f, z, in, omega);
        case REGIME_VISCOUS: return rhs_of_viscous(slip, f, z, in);
        default: return rhs_of_rate_independent(slip, f, z, in);
    }
}

RightHandSide balance_rhs(const SlipMode *slip, double theta, double omega, double t) {
    ContactFactors here;
    double z;
    const ContactFactors *f = factors_at(slip, theta, &here, &z);
    const Drive in = drive_at(slip, t);
    return rhs_of(slip, f, z, &in, omega);
}

void balance_at(const SlipMode *slip, double theta, double omega, double t, Balance *out) {
    const Params *p = slip->params;
    ContactFactors here;
    double z;
    const ContactFactors *f = factors_at(slip, theta, &here, &z);
    const Drive in = drive_at(slip, t);
    const RightHandSide rhs = rhs_of(slip, f, z, &in, omega);
    const bool inertial = slip->regime == REGIME_INERTIAL;
    const double alpha = inertial ? rhs.value : 0.0;
    if (!inertial) omega = rhs.value;
    const double v = f->dz_dtheta.value * omega, damper = v * (slip->c + slip->q * fabs(v));
    const double force = spring_force(&p->spring, z) + in.F_ext;
    double axial = force + damper, moment = 0.0;
    if (slip->heavy) {
        axial += p->inertia.follower_mass * (f->dz_dtheta.value * alpha + f->d2z_dtheta2.value * omega * omega);
        moment = p->inertia.follower * (f->dpsi_dtheta[0].value * alpha + f->d2gamma_dtheta2.value * omega * omega);
    }
    const double inverse = 1.0 / f->delta.value;
    *out = (Balance){
        .theta = theta,
        .omega = omega,
        .alpha = alpha,
        .rhs = rhs,
        .tau = in.tau,
        .F_ext = in.F_ext,
        .force = force,
        .damper = damper,
        .z = z,
        .dz_dtheta = f->dz_dtheta.value,
        .dpsi_dtheta = {f->dpsi_dtheta[0].value, f->dpsi_dtheta[1].value},
        .axial = {f->rn[1].value * inverse, f->rn[0].value * inverse},
        .x = {(f->rn[1].value * axial - f->d[1].value * moment) * inverse,
              (f->rn[0].value * axial + f->d[0].value * moment) * inverse},
    };
    for (int i = 0; i < 2; i++)
        out->length2[i] = p->cam[i].radius * p->cam[i].radius + f->slope[i].value * f->slope[i].value;
}

/* ---- how it changes ---- */

/* The share of the course's size that counts as a term of z and of the slopes: their rounding is some eps of that size,
 * where other sums count as zero below 1e-13 of their terms. */
static const double TRANSMISSION_SHARE = 0.01;

/* Size of the terms of P, which vanishes on a dwell or where a contact begins to lock. */
static double grip_size(const SlipMode *slip, const ContactFactors *f) {
    double size = 1.0;
    for (int i = 0; i < 2; i++) {
        const CamParams *cam = &slip->params->cam[i];
        size *= cam->radius *
                (f->slope[i].value + cam->friction * cam->radius + TRANSMISSION_SHARE * slip->transmission->slope_size);
    }
    return size;
}

/* Rates of change along the motion, and what they are made of. */
typedef struct {
    double rhs;                              /* d pace/dt */
    double alpha, jerk;                      /* rad/s^2, rad/s^3: as far as they act on the loads */
    double axial, moment;                    /* N, N.m: A and W of the balance */
    double axial_rate, moment_rate;          /* N/s, N.m/s */
    double spring_rate, damper_rate, F_rate; /* N/s, N.s/m, N/s */
} Drift;

static Drift drift_of(const SlipMode *slip, const ContactFactors *f, const Drive *in, const Balance *now) {
    const Params *p = slip->params;
    const double m = p->inertia.follower_mass, I = p->inertia.follower;
    const bool inertial = slip->regime == REGIME_INERTIAL;
    const double omega = now->omega, spin2 = omega * omega, v = f->dz_dtheta.value * omega;
    Drift d = {
        .rhs = now->rhs.by_time + (slip->regime == REGIME_RATE_INDEPENDENT ? 0.0 : now->rhs.by_theta * omega) +
               now->rhs.by_omega * now->alpha,
        .spring_rate = spring_rate(&p->spring, now->z) * v,
        .damper_rate = slip->c + 2.0 * slip->q * fabs(v),
        .F_rate = in->F_rate,
    };
    d.alpha = inertial ? now->alpha : d.rhs;
    d.jerk = inertial ? d.rhs : 0.0;
    const double follow = f->dz_dtheta.value * d.alpha + f->d2z_dtheta2.value * spin2; /* d^2 z/dt^2 */
    d.axial = now->force + now->damper + m * (inertial ? follow : 0.0);
    d.moment = I * (f->dpsi_dtheta[0].value * now->alpha + f->d2gamma_dtheta2.value * spin2);
    d.axial_rate = d.spring_rate + d.F_rate + d.damper_rate * follow +
                   m * (f->dz_dtheta.value * d.jerk + 3.0 * f->d2z_dtheta2.value * omega * d.alpha +
                        f->d2z_dtheta2.slope * spin2 * omega);
    d.moment_rate = I * (f->dpsi_dtheta[0].value * d.jerk + 3.0 * f->d2gamma_dtheta2.value * omega * d.alpha +
                         f->d2gamma_dtheta2.slope * spin2 * omega);
    return d;
}

/* The same sums without their signs: their rounding errors are a few eps of these. */
typedef struct {
    double force, torque, rhs; /* N, N.m, rad/s^2 */
    double axial, moment;      /* N, N.m */
    double axial_rate, moment_rate;
} Sizes;

static double force_size(const SlipMode *slip, const Balance *now) {
    const SpringParams *spring = &slip->params->spring;
    const double z = fabs(now->z) + TRANSMISSION_SHARE * slip->transmission->z_size;
    return fabs(spring->preload) + fabs(now->F_ext) + fabs(now->damper) +
           z * (fabs(spring->stiffness) + z * (fabs(spring->stiffness2) + z * fabs(spring->stiffness3)));
}

static Sizes sizes_of(const SlipMode *slip, const ContactFactors *f, const Balance *now, const Drift *d) {
    const Params *p = slip->params;
    const double m = p->inertia.follower_mass, I = p->inertia.follower;
    const double omega = fabs(now->omega), spin2 = omega * omega;
    const double dz_dtheta = fabs(f->dz_dtheta.value), d2z_dtheta2 = fabs(f->d2z_dtheta2.value);
    const double dpsi_dtheta = fabs(f->dpsi_dtheta[0].value), d2gamma_dtheta2 = fabs(f->d2gamma_dtheta2.value);
    const bool inertial = slip->regime == REGIME_INERTIAL;
    Sizes size = {.force = force_size(slip, now), .torque = fabs(now->tau) + p->shaft.damping * omega};
    const double swirl = (fabs(f->p.value) * m * d2z_dtheta2 + fabs(f->q.value) * I * d2gamma_dtheta2) * spin2;
    if (inertial)
        size.rhs = (fabs(f->delta.value) * size.torque + fabs(f->p.value) * size.force + swirl) / now->rhs.resistance;
    const double alpha = inertial ? size.rhs : fabs(d->alpha);
    const double jerk =
        inertial ? fabs(now->rhs.by_theta) * omega + fabs(now->rhs.by_omega) * size.rhs + fabs(now->rhs.by_time) : 0.0;
    size.axial = size.force + m * (dz_dtheta * size.rhs + d2z_dtheta2 * spin2);
    size.moment = I * (dpsi_dtheta * size.rhs + d2gamma_dtheta2 * spin2);
    size.axial_rate = fabs(d->spring_rate) + fabs(d->F_rate) +
                      d->damper_rate * (dz_dtheta * alpha + d2z_dtheta2 * spin2) +
                      m * (dz_dtheta * jerk + 3.0 * d2z_dtheta2 * omega * alpha);
    size.moment_rate = I * (dpsi_dtheta * jerk + 3.0 * d2gamma_dtheta2 * omega * alpha);
    return size;
}

/* d x_1/dt from x_1 = (rn2 A - d2 W)/Delta, and the sizes of both; likewise x_2 = (rn1 A + d1 W)/Delta. */
static void contact_rates(const SlipMode *slip, const ContactFactors *f, const Balance *now, const Drift *d,
                          const Sizes *size, int i, BalanceRates *out) {
    const int other = 1 - i;
    const double omega = now->omega, inverse = 1.0 / fabs(f->delta.value);
    const Dual rn = f->rn[other], arm = dual_scale(i == 0 ? -1.0 : 1.0, f->d[other]);
    const double rn_size = fabs(rn.value) + slip->params->cam[other].radius * slip->transmission->slope_size;
    out->contact[i] = (rn.slope * omega * d->axial + rn.value * d->axial_rate + arm.slope * omega * d->moment +
                       arm.value * d->moment_rate - now->x[i] * f->delta.slope * omega) /
                      f->delta.value;
    out->size[i] = (rn_size * size->axial + fabs(arm.value) * size->moment) * inverse;
    out->rate_size[i] = (fabs(rn.slope * omega) * size->axial + fabs(rn.value) * size->axial_rate +
                         fabs(arm.slope * omega) * size->moment + fabs(arm.value) * size->moment_rate +
                         out->size[i] * fabs(f->delta.slope * omega)) *
                        inverse;
}

void balance_rates(const SlipMode *slip, const Balance *now, double t, BalanceRates *out) {
    ContactFactors here;
    double z;
    const ContactFactors *f = factors_at(slip, now->theta, &here, &z);
    const Drive in = drive_at(slip, t);
    const Drift d = drift_of(slip, f, &in, now);
    const Sizes size = sizes_of(slip, f, now, &d);
    const double shaft_torque = slip->regime == REGIME_INERTIAL ? slip->params->shaft.damping * now->omega : 0.0;
    *out = (BalanceRates){
        .rhs = d.rhs,
        .rhs_size = size.rhs,
        .net = now->tau - shaft_torque - f->p.value / f->delta.value * now->force,
        .net_size = size.torque + grip_size(slip, f) / fabs(f->delta.value) * size.force,
    };
    for (int i = 0; i < 2; i++) contact_rates(slip, f, now, &d, &size, i, out);
}

/* ---- what it depends on ---- */

/* The factors of the equation of motion, as far as they depend on friction at contact i: derivatives by mu_i. */
static ContactFactors factors_by_friction(const SlipMode *slip, const ContactFactors *f, int i) {
    const double r = slip->params->cam[i].radius, sign = slip->direction * slip->flank[i];
    const double rn = r * r * sign, d = -f->slope[i].value * sign;
    const double q = i == 0 ? d * f->rn[1].value : f->d[0].value * rn;
    return (ContactFactors){
        .q = {.value = q},
        .delta = {.value = q + (i == 0 ? rn * f->d[1].value : f->rn[0].value * d)},
        .p = {.value = i == 0 ? rn * f->rn[1].value : f->rn[0].value * rn},
    };
}

/* Delta (tau - b omega) - P (F_0 + D) - [P m z'' + Q I gamma''] omega^2 - [J Delta + P m z' + Q I gamma'] alpha */
void balance_partials(const SlipMode *slip, const Balance *now, Partials *out) {
    const Params *p = slip->params;
    const double J = p->inertia.shaft, m = p->inertia.follower_mass, I = p->inertia.follower, b = p->shaft.damping;
    const double omega = now->omega, spin2 = omega * omega, alpha = now->alpha, torque = now->tau - b * omega;
    ContactFactors here;
    double z;
    const ContactFactors *f = factors_at(slip, now->theta, &here, &z);
    const double v = f->dz_dtheta.value * omega, load = now->force + now->damper;
    const double resistance = slip->c + 2.0 * slip->q * fabs(v); /* dD/dv */
    const double load_slope = spring_rate(&p->spring, z) * f->dz_dtheta.value + resistance * f->dz_dtheta.slope * omega;
    const Dual swirl = swirl_of(slip, f), mass = mass_of(slip, f);
    double *by = out->by;
    *out = (Partials){.by = {0.0}};
    by[KNOWN_THETA] = f->delta.slope * torque - f->p.slope * load - f->p.value * load_slope - swirl.slope * spin2 -
                      mass.slope * alpha;
    by[KNOWN_OMEGA] = -f->delta.value * b - f->p.value * resistance * f->dz_dtheta.value - 2.0 * swirl.value * omega;
    by[KNOWN_ALPHA] = -mass.value;
    by[KNOWN_TAU] = f->delta.value;
    by[KNOWN_F_EXT] = by[KNOWN_PRELOAD] = -f->p.value;
    by[KNOWN_STIFFNESS] = -f->p.value * z;
    by[KNOWN_STIFFNESS2] = -f->p.value * z * z;
    by[KNOWN_STIFFNESS3] = -f->p.value * z * z * z;
    by[slip->direction > 0 ? KNOWN_C_LOAD : KNOWN_C_RELEASE] = -f->p.value * v;
    by[slip->direction > 0 ? KNOWN_Q_LOAD : KNOWN_Q_RELEASE] = -f->p.value * v * fabs(v);
    for (int i = 0; i < 2; i++) {
        const ContactFactors d = factors_by_friction(slip, f, i);
        const double mass_rate =
            J * d.delta.value + m * d.p.value * f->dz_dtheta.value + I * d.q.value * f->dpsi_dtheta[0].value;
        const double swirl_rate = m * d.p.value * f->d2z_dtheta2.value + I * d.q.value * f->d2gamma_dtheta2.value;
        by[KNOWN_FRICTION_1 + i] = d.delta.value * torque - d.p.value * load - swirl_rate * spin2 - mass_rate * alpha;
    }
}

double balance_mobility(const SlipMode *slip, const Balance *now) {
    Partials p;
    balance_partials(slip, now, &p);
    return -p.by[KNOWN_TAU] / p.by[slip->regime == REGIME_INERTIAL ? KNOWN_ALPHA : KNOWN_OMEGA];
}

/* How k alpha + k' omega^2 changes, with k = z' or gamma'. */
static double swing_change(const Balance *b, Dual k, Dual k_rate, double dtheta, double domega, double dalpha) {
    const double spin2 = b->omega * b->omega;
    return (k.slope * b->alpha + k_rate.slope * spin2) * dtheta + 2.0 * k_rate.value * b->omega * domega +
           k.value * dalpha;
}

/* x_i = (rn A -+ d W)/Delta, see contact_rates(). */
COLD double balance_contact_change(const SlipMode *slip, const Balance *now, int i, double dtheta, double domega,
                                   double dalpha) {
    const Params *p = slip->params;
    const double m = p->inertia.follower_mass, I = p->inertia.follower, omega = now->omega, alpha = now->alpha;
    ContactFactors here;
    double z;
    const ContactFactors *f = factors_at(slip, now->theta, &here, &z);
    const Dual rn = f->rn[1 - i], arm = dual_scale(i == 0 ? -1.0 : 1.0, f->d[1 - i]);
    const double follow = f->dz_dtheta.value * alpha + f->d2z_dtheta2.value * omega * omega;
    const double axial = now->force + now->damper + m * follow;
    const double moment = I * (f->dpsi_dtheta[0].value * alpha + f->d2gamma_dtheta2.value * omega * omega);
    const double resistance = slip->c + 2.0 * slip->q * fabs(f->dz_dtheta.value * omega); /* dD/dv */
    const double axial_change = spring_rate(&p->spring, z) * f->dz_dtheta.value * dtheta +
                                resistance * (f->dz_dtheta.slope * omega * dtheta + f->dz_dtheta.value * domega) +
                                m * swing_change(now, f->dz_dtheta, f->d2z_dtheta2, dtheta, domega, dalpha);
    const double moment_change = I * swing_change(now, f->dpsi_dtheta[0], f->d2gamma_dtheta2, dtheta, domega, dalpha);
    return (rn.value * axial_change + arm.value * moment_change +
            (rn.slope * axial + arm.slope * moment - now->x[i] * f->delta.slope) * dtheta) /
           f->delta.value;
}

Booking balance_power(const SlipMode *slip, const Balance *now) {
    const double omega = now->omega, v = now->dz_dtheta * omega;
    Booking power = {
        .work_in = now->tau * omega,
        .work_ext = now->F_ext * v,
        .heat_damper = now->damper * v,
        .heat_shaft = slip->params->shaft.damping * omega * omega,
    };
    for (int i = 0; i < 2; i++)
        power.heat_cam[i] = slip->direction * slip->flank[i] * slip->params->cam[i].friction * now->x[i] *
                            now->length2[i] * now->dpsi_dtheta[i] * omega;
    return power;
}
