#include "contact/balance.h"

#include <math.h>

#include "contact/loaded_slip.h"
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
        .resistance = fabs(inertia.value),
        .possible = inertia.value * f->delta.value > 0.0,
        .stable = true,
        .settles = inertia.value > 0.0,
        .single = true,
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
    const Params *p = slip->params;
    const DualContactFactors *f = &k->factors;
    const double tau = in->tau, spring = spring_force(&p->spring, z), F_ext = in->F_ext;
    const Dual load = {spring + F_ext, spring_rate(&p->spring, z) * k->dz_dtheta.value};
    const Dual n = {f->delta.value * tau - f->p.value * load.value,
                    f->delta.slope * tau - f->p.slope * load.value - f->p.value * load.slope};
    const double n_size = fabs(f->delta.value * tau) + fabs(f->p.value) * (fabs(spring) + fabs(F_ext));
    const Dual pz = dual_multiply(f->p, k->dz_dtheta);
    const Dual b = dual_add(dual_scale(p->shaft.damping, f->delta), dual_scale(slip->c, pz));
    const Dual c = dual_scale(slip->q, dual_multiply(pz, k->dz_dtheta));
    const ViscousSpeed speed = viscous_speed(b.value, c.value, n.value, slip->direction);
    const double omega = speed.omega;
    const double steepness = b.value + 2.0 * c.value * fabs(omega); /* dN/d omega */
    const double inverse = steepness != 0.0 ? 1.0 / steepness : 0.0;
    return (RightHandSide){
        .value = omega,
        .size = speed.sum != 0.0 ? 2.0 * n_size / fabs(speed.sum) : 0.0,
        .by_theta = (n.slope - omega * (b.slope + c.slope * fabs(omega))) * inverse,
        .by_time = (f->delta.value * in->tau_rate - f->p.value * in->F_ext_rate) * inverse,
        .possible = (speed.sum != 0.0 || c.value != 0.0) && speed.square >= 0.0 && f->delta.value != 0.0,
        .stable = speed.sign * f->delta.value > 0.0,
    };
}

/* On the band's edge tau = E(theta) = rho F_0, so that (tau - rho F_ext)' = dE/dtheta omega gives omega. by_theta holds
 * dE/dtheta, N.m/rad, the derivative that an iteration along the edge needs. */
static inline RightHandSide rhs_of_rate_independent(const SlipMode *slip, const SlipCoefficients *k, double z,
                                                    const InputValues *in) {
    const Params *p = slip->params;
    const Dual load = {spring_force(&p->spring, z) + in->F_ext, spring_rate(&p->spring, z) * k->dz_dtheta.value};
    const Dual rho = dual_contact_factors_rho(&k->factors);
    const double stiffness = rho.slope * load.value + rho.value * load.slope;
    const bool loaded = slip->friction_is_loaded;
    const double rho_rate = loaded ? k->loaded.tangent.p / k->loaded.tangent.delta : rho.value; /* dE/dF_0 */
    const double rate = in->tau_rate - rho_rate * in->F_ext_rate;
    return (RightHandSide){
        .value = stiffness > 0.0 ? rate / stiffness : 0.0,
        .by_theta = stiffness,
        .net = in->tau - rho.value * load.value,
        .resistance = stiffness,
        .possible = k->factors.delta.value != 0.0 && !(loaded && !k->loaded.possible),
        .stable = stiffness > 0.0,
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

static MotionTerms terms_of(const SlipMode *slip, const SlipCoefficients *k, double z, const InputValues *in,
                            double omega, double alpha) {
    return (MotionTerms){
        .torque = in->tau - slip->params->shaft.damping * omega,
        .load =
            spring_force(&slip->params->spring, z) + in->F_ext + slip_damper_force(slip, k->dz_dtheta.value * omega),
        .omega = omega,
        .alpha = alpha,
    };
}

/* Without inertia: Delta (tau - b omega) - P (F_0 + D), with its derivatives. */
static Dual viscous_residual(const SlipMode *slip, const SlipCoefficients *k, double z, const InputValues *in,
                             double omega, double *by_omega) {
    const Params *p = slip->params;
    const DualContactFactors *f = &k->factors;
    const double v = k->dz_dtheta.value * omega, torque = in->tau - p->shaft.damping * omega;
    const double damper_rate = slip_damper_rate(slip, v);
    const Dual load = {spring_force(&p->spring, z) + in->F_ext + slip_damper_force(slip, v),
                       spring_rate(&p->spring, z) * k->dz_dtheta.value + damper_rate * k->dz_dtheta.slope * omega};
    *by_omega = k->dfactors_domega.delta * torque - k->dfactors_domega.p * load.value -
                f->delta.value * p->shaft.damping - f->p.value * damper_rate * k->dz_dtheta.value;
    return (Dual){f->delta.value * torque - f->p.value * load.value,
                  f->delta.slope * torque - f->p.slope * load.value - f->p.value * load.slope};
}

/* Sets friction to that at the speed omega and, if it depends on the load, under the load there. */
static void set_friction(const SlipMode *slip, double omega, double z, const InputValues *in, SlipCoefficients *k) {
    if (slip->friction_is_loaded) loaded_slip_set(slip, omega, z, in, k);
    else slip_set_friction(slip, omega, k);
}

/* The torque left, tau - b omega - rho (F_0 + D), and its derivative by the speed; NAN where Delta has lost the sign of
 * `delta`, beyond which friction jams. Leaves *k at this speed. */
static Dual torque_left(const SlipMode *slip, SlipCoefficients *k, double z, const InputValues *in, double omega,
                        double delta) {
    double by_omega;
    set_friction(slip, omega, z, in, k);
    const double now = k->factors.delta.value;
    if (!(now * delta > 0.0) || (slip->friction_is_loaded && !k->loaded.possible)) return (Dual){NAN, NAN};
    const double left = viscous_residual(slip, k, z, in, omega, &by_omega).value / now;
    return (Dual){left, (by_omega - left * k->dfactors_domega.delta) / now};
}

/* The search for the speed nearest to rest at which no torque is left, rad/s. Torque is left at `low`. At `high` the
 * torque left has the other sign, or friction jams. Damping that takes the load off the contacts can turn the torque
 * left before it has reached zero, and a longer step would pass two zeros: `turn` is a speed at which it
 * grows again. */
typedef struct {
    double low, high, turn;
    bool falls; /* at `low`: the torque left becomes smaller with the speed */
} SpeedSearch;

/* The torque left at the speed `omega`, in the direction of the motion: narrows the search. */
static void narrow_search(SpeedSearch *search, double omega, Dual left) {
    if (!(left.value > 0.0)) {
        search->high = omega;
        search->turn = INFINITY;
    } else if (search->falls && left.slope > 0.0) {
        search->turn = omega;
    } else {
        search->low = omega;
        search->falls = left.slope < 0.0;
    }
}

/* The next speed: the smallest torque left before a turn, by bisection; else a Newton step inside the bracket, which at
 * most doubles the speed. */
static double next_speed(SpeedSearch *search, double omega, Dual left) {
    if (search->turn < INFINITY) {
        if (search->turn - search->low > VISCOUS_BLOCKED * search->turn) return 0.5 * (search->low + search->turn);
        *search = (SpeedSearch){.low = search->turn, .high = search->high, .turn = INFINITY, .falls = false};
        omega = search->low;
    } else {
        const double next = omega - left.value / left.slope;
        if (next > search->low && next < min_of(search->high, 2.0 * omega)) return next;
    }
    return search->high < INFINITY ? 0.5 * (search->low + search->high) : 2.0 * omega;
}

/* The speed nearest to rest at which no torque is left, by Newton's method inside a bracket: from rest on, where the
 * torque left has the sign of the motion, up to a speed at which it has the other sign or friction jams. `frozen`: the
 * speed with friction at rest. *k is at rest, and is left at the speed found. */
static double speed_under_friction(const SlipMode *slip, SlipCoefficients *k, double z, const InputValues *in,
                                   double frozen) {
    const double delta = k->factors.delta.value;
    const Dual at_rest = torque_left(slip, k, z, in, 0.0, delta);
    const double sign = at_rest.value < 0.0 ? -1.0 : 1.0, newton = fabs(at_rest.value / at_rest.slope);
    double omega = sign * frozen > 0.0 ? min_of(fabs(frozen), newton) : 0.5 * newton;
    SpeedSearch search = {.low = 0.0, .high = INFINITY, .turn = INFINITY, .falls = at_rest.slope < 0.0};
    bool blocked = false,
         enclosed = false; /* enclosed: the torque left is known to change its sign, not to end at a jam */
    if (!(at_rest.value != 0.0 && isfinite(omega))) return at_rest.value == 0.0 ? 0.0 : NAN;
    for (int n = 0; n < VISCOUS_ITERATIONS; n++) {
        slip_count(slip, 1);
        const Dual now = torque_left(slip, k, z, in, sign * omega, delta), left = {sign * now.value, now.slope};
        blocked = isnan(left.value) || (blocked && left.value > 0.0);
        enclosed |= left.value <= 0.0;
        narrow_search(&search, omega, left);
        if (blocked && search.high - search.low <= VISCOUS_BLOCKED * search.high) return NAN; /* a lock before a root */
        const double next = next_speed(&search, omega, left);
        if (fabs(next - omega) <= VISCOUS_ROUNDING * omega && isfinite(left.value))
            return enclosed || left.slope < 0.0 ? sign * omega : NAN;
        omega = next;
    }
    return NAN;
}

/* N.m m^3: the magnitudes of the torques in the residual, without damping. */
static double size_of_terms(const SlipMode *slip, const SlipCoefficients *k, double z, const InputValues *in) {
    const double load = fabs(spring_force(&slip->params->spring, z)) + fabs(in->F_ext);
    return fabs(k->factors.delta.value * in->tau) + fabs(k->factors.p.value) * load;
}

/* With quadratic damping alone by_omega vanishes at rest, where the size is that of the damper's law. Near a dwell the damper
 * hardly acts, and the size is that of the friction. */
COMPACT static RightHandSide finish_loaded_viscous(const SlipMode *slip, const SlipCoefficients *k, double z,
                                                   const InputValues *in, double by_theta, double by_omega,
                                                   double omega) {
    const MotionTerms terms = terms_of(slip, k, z, in, omega, 0.0);
    const double delta = k->factors.delta.value, inverse = by_omega != 0.0 ? 1.0 / by_omega : 0.0;
    const RightHandSide frozen = rhs_of_coefficients(slip, k, z, in, 0.0);
    const double size = fabs(inverse) * size_of_terms(slip, k, z, in);
    return (RightHandSide){
        .value = omega,
        .size = frozen.possible && (by_omega == 0.0 || frozen.size < size) ? frozen.size : size,
        .by_theta = -by_theta * inverse,
        .by_time = -(delta * in->tau_rate - loaded_slip_lever(slip, k, &terms) * in->F_ext_rate) * inverse,
        .possible = k->loaded.possible && (by_omega != 0.0 || slip->q > 0.0) && delta != 0.0,
        .stable = !(by_omega * delta > 0.0),
    };
}

static RightHandSide rhs_of_viscous_friction(const SlipMode *slip, SlipCoefficients *k, double z,
                                             const InputValues *in) {
    set_friction(slip, 0.0, z, in, k);
    const double omega = speed_under_friction(slip, k, z, in, rhs_of_coefficients(slip, k, z, in, 0.0).value);
    if (!isfinite(omega)) return (RightHandSide){.possible = false};
    const DualContactFactors *f = &k->factors;
    double by_omega;
    const Dual residual = viscous_residual(slip, k, z, in, omega, &by_omega);
    if (slip->friction_is_loaded) return finish_loaded_viscous(slip, k, z, in, residual.slope, by_omega, omega);
    return (RightHandSide){
        .value = omega,
        .size = size_of_terms(slip, k, z, in) / fabs(by_omega),
        .by_theta = -residual.slope / by_omega,
        .by_time = -(f->delta.value * in->tau_rate - f->p.value * in->F_ext_rate) / by_omega,
        .possible = by_omega != 0.0 && f->delta.value != 0.0,
        .stable = by_omega * f->delta.value < 0.0,
    };
}

/* N.m m^3 s/rad: the derivative of the net torque by the speed, through the friction coefficients. */
static double rhs_by_friction(const SlipMode *slip, const SlipCoefficients *k, double z, const InputValues *in,
                              double omega, double alpha) {
    const MotionTerms terms = terms_of(slip, k, z, in, omega, alpha);
    return residual_change(slip, k, &k->dfactors_domega, &terms);
}

/* With inertia, where friction depends on the load. */
COMPACT static RightHandSide rhs_of_loaded(const SlipMode *slip, SlipCoefficients *k, double z, const InputValues *in,
                                           double omega) {
    loaded_slip_set(slip, omega, z, in, k);
    const ContactFactors *f = &k->loaded.tangent;
    const LoadedMotionResponse by = loaded_slip_motion(slip, k, z, omega);
    const double inverse = 1.0 / by.inertia;
    const double torque = fabs(in->tau) + fabs(slip->params->shaft.damping * omega);
    const double load = fabs(spring_force(&slip->params->spring, z)) + fabs(in->F_ext) +
                        fabs(slip_damper_force(slip, k->dz_dtheta.value * omega));
    return (RightHandSide){
        .value = k->loaded.alpha,
        .size = (fabs(f->delta) * torque + fabs(f->p) * load) * fabs(inverse),
        .by_theta = by.alpha_by[0],
        .by_omega = by.alpha_by[1],
        .by_time = (f->delta * in->tau_rate - f->p * in->F_ext_rate) * inverse,
        .resistance = by.inertia,
        .possible = k->loaded.possible && (by.inertia > 0.0 || by.inertia * f->delta > 0.0),
        .stable = by.inertia * f->delta > 0.0,
        .settles = by.inertia > 0.0,
        .single = k->loaded.single,
    };
}

/* Without inertia the coefficients are set to the speed found. */
NOINLINE static RightHandSide rhs_of_varying(const SlipMode *slip, SlipCoefficients *k, double z, const InputValues *in,
                                             double omega) {
    if (slip->regime == REGIME_VISCOUS) return rhs_of_viscous_friction(slip, k, z, in);
    if (slip->friction_is_loaded && slip->regime == REGIME_INERTIAL) return rhs_of_loaded(slip, k, z, in, omega);
    if (slip->friction_is_loaded) loaded_slip_set(slip, omega, z, in, k);
    RightHandSide rhs = rhs_of_coefficients(slip, k, z, in, omega);
    if (slip->regime == REGIME_INERTIAL)
        rhs.by_omega += rhs_by_friction(slip, k, z, in, omega, rhs.value) / slip_inertia(slip, k).value;
    return rhs;
}

/* `storage` holds the coefficients where friction varies. */
static inline RightHandSide rhs_of(const SlipMode *slip, const SlipCoefficients *k, double z, const InputValues *in,
                                   double omega, SlipCoefficients *storage) {
    return slip->friction_varies ? rhs_of_varying(slip, storage, z, in, omega)
                                 : rhs_of_coefficients(slip, k, z, in, omega);
}

RightHandSide balance_rhs(const SlipMode *slip, double theta, double omega, double t) {
    SlipCoefficients storage;
    double z;
    const SlipCoefficients *k = slip_coefficients_at(slip, theta, omega, &storage, &z);
    const InputValues in = slip_inputs_at(slip, t);
    return rhs_of(slip, k, z, &in, omega, &storage);
}

/* ---- the balance ---- */

/* A and W. */
typedef struct {
    double axial, moment; /* N, N.m */
} Loads;

static inline Loads loads_of(const SlipMode *slip, const SlipCoefficients *k, double force, double omega,
                             double alpha) {
    if (!slip->follower_has_inertia) return (Loads){force, 0.0};
    const InertiaParams *i = &slip->params->inertia;
    return (Loads){
        force + i->follower_mass * (k->dz_dtheta.value * alpha + k->d2z_dtheta2.value * omega * omega),
        i->follower * (k->dpsi_dtheta[0].value * alpha + k->d2gamma_dtheta2.value * omega * omega),
    };
}

void balance_at(const SlipMode *slip, double theta, double omega, double t, Balance *out) {
    const Params *p = slip->params;
    SlipCoefficients storage;
    double z;
    const SlipCoefficients *k = slip_coefficients_at(slip, theta, omega, &storage, &z);
    const DualContactFactors *f = &k->factors;
    const InputValues in = slip_inputs_at(slip, t);
    const RightHandSide rhs = rhs_of(slip, k, z, &in, omega, &storage);
    const bool inertial = slip->regime == REGIME_INERTIAL;
    const double alpha = inertial ? rhs.value : 0.0;
    if (!inertial) omega = rhs.value;
    const double damper = slip_damper_force(slip, k->dz_dtheta.value * omega);
    const double force = spring_force(&p->spring, z) + in.F_ext;
    const Loads load = loads_of(slip, k, force + damper, omega, alpha);
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
        .dz_dtheta = k->dz_dtheta.value,
        .dpsi_dtheta = {k->dpsi_dtheta[0].value, k->dpsi_dtheta[1].value},
        .friction = {slip_friction(slip, k, 0), slip_friction(slip, k, 1)},
        .axial = {f->rn[1].value * inverse, f->rn[0].value * inverse},
        .x = {(f->rn[1].value * load.axial - f->d[1].value * load.moment) * inverse,
              (f->rn[0].value * load.axial + f->d[0].value * load.moment) * inverse},
    };
    for (int i = 0; slip->friction_varies && slip->friction_is_loaded && i < 2; i++) {
        out->axial[i] = k->loaded.tangent.rn[1 - i] / k->loaded.tangent.delta;
        out->x[i] = k->loaded.x[i];
    }
    for (int i = 0; i < 2; i++)
        out->length2[i] = p->cam[i].radius * p->cam[i].radius + k->slope[i].value * k->slope[i].value;
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

/* N, of one contact */
static double reaction_of(const SlipMode *slip, const Balance *b, int i) {
    return fabs(b->x[i]) * sqrt(b->length2[i]) / slip->params->contacts;
}

double balance_friction_share(const SlipMode *slip, const Balance *from, const Balance *to) {
    double share = 1.0;
    for (int i = 0; i < 2; i++) {
        const FrictionFall *fall = &slip->law[i].fall;
        const double part = friction_share(fall, sliding_speed(slip, from, i), sliding_speed(slip, to, i));
        if (part < 1.0) share = min_of(share, fall->table ? part : STEP_SAFETY * part);
        if (!fall->table && fall->level == 0.0) continue;
        const double from_load = reaction_of(slip, from, i), to_load = reaction_of(slip, to, i);
        share = min_of(share, fall->table ? friction_table_load_share(fall->table, fall->overshoot, from_load, to_load)
                                          : friction_level_share(fall->level, fall->overshoot, from_load, to_load));
    }
    return share;
}
