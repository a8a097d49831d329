#include "contact/loaded_slip.h"

#include <math.h>

#include "model/elements.h"
#include "platform/attributes.h"

/* ---- the pin ---- */

/* Sliding distance of contact i per angle of cam 2, m, and its derivative by theta. */
static Dual sliding_of(const SlipMode *slip, const SlipCoefficients *k, int i) {
    const double r = slip->params->cam[i].radius, a = k->slope[i].value, length = sqrt(r * r + a * a);
    return dual_multiply(k->dpsi_dtheta[i], (Dual){length, a * k->slope[i].slope / length});
}

/* rad/s, in the direction of slip; along the edge of the stick band friction is that at rest. */
static double sliding_rate(const SlipMode *slip, double omega) {
    return slip->regime == REGIME_RATE_INDEPENDENT ? 0.0 : slip->direction * omega;
}

static LoadedPin pin_of(const SlipMode *slip, double omega, const SlipCoefficients *k) {
    const double rate = sliding_rate(slip, omega);
    return (LoadedPin){
        .params = slip->params,
        .direction = slip->direction,
        .flank = {slip->flank[0], slip->flank[1]},
        .searches = slip->searches,
        .slope = {k->slope[0].value, k->slope[1].value},
        .speed = {rate * sliding_of(slip, k, 0).value, rate * sliding_of(slip, k, 1).value},
        .work = slip->work,
    };
}

/* ---- changes ---- */

/* df_i at constant R_i, from the changes of theta and omega: through v_i and through the groove's length in R_i. */
COMPACT static void add_own_changes(const SlipMode *slip, const LoadedPin *pin, const SlipCoefficients *k, double omega,
                                    double dtheta, double domega, LoadChange *change) {
    const bool moves = slip->regime != REGIME_RATE_INDEPENDENT;
    for (int i = 0; i < 2; i++) {
        const Dual sliding = sliding_of(slip, k, i);
        const double dv = moves ? slip->direction * (sliding.slope * omega * dtheta + sliding.value * domega) : 0.0;
        const double dslope = k->slope[i].slope * dtheta;
        change->slope[i] = dslope;
        change->friction[i] = slip->direction * slip->flank[i] * k->loaded.mu[i].by_speed * dv +
                              loaded_pin_friction_by_slope(pin, &k->loaded, i) * dslope;
    }
}

COMPACT LoadResponse loaded_slip_response(const SlipMode *slip, double omega, const SlipCoefficients *k,
                                          const LoadStep *step) {
    const LoadedPin pin = pin_of(slip, omega, k);
    LoadChange change = {.axial = step->axial, .moment = step->moment};
    add_own_changes(slip, &pin, k, omega, step->theta, step->omega, &change);
    for (int i = 0; i < 2; i++) change.friction[i] += step->friction[i];
    return loaded_contacts_response(&pin, &k->loaded, &change);
}

COMPACT ContactFactors loaded_slip_change(const SlipMode *slip, double omega, const SlipCoefficients *k,
                                          const LoadStep *step) {
    const CamParams *cam = slip->params->cam;
    const double radius[2] = {cam[0].radius, cam[1].radius}, slope[2] = {k->slope[0].value, k->slope[1].value};
    const LoadResponse response = loaded_slip_response(slip, omega, k, step);
    return contact_factors_change(&k->factors, radius, slope, response.friction);
}

COMPACT double loaded_slip_lever(const SlipMode *slip, const SlipCoefficients *k, const MotionTerms *terms) {
    const LoadStep step = {.axial = 1.0};
    const ContactFactors by = loaded_slip_change(slip, terms->omega, k, &step);
    return k->factors.p.value - residual_change(slip, k, &by, terms);
}

COMPACT double loaded_slip_inertia(const SlipMode *slip, const SlipCoefficients *k, const MotionTerms *terms) {
    const double inertia = slip_inertia(slip, k).value;
    if (!slip->follower_has_inertia) return inertia;
    const InertiaParams *in = &slip->params->inertia;
    const LoadStep step = {.axial = in->follower_mass * k->dz_dtheta.value,
                           .moment = in->follower * k->dpsi_dtheta[0].value};
    const ContactFactors by = loaded_slip_change(slip, terms->omega, k, &step);
    return inertia - residual_change(slip, k, &by, terms);
}

/* ---- the coefficients ---- */

/* The changes of A and W with theta (first) and omega, at constant alpha. */
COMPACT static void load_steps(const SlipMode *slip, const SlipCoefficients *k, double z, double omega, double alpha,
                               LoadStep step[2]) {
    const InertiaParams *in = &slip->params->inertia;
    const double m = in->follower_mass, I = in->follower, omega2 = omega * omega;
    const bool moves = slip->regime != REGIME_RATE_INDEPENDENT;
    const double damper_rate = moves ? slip_damper_rate(slip, k->dz_dtheta.value * omega) : 0.0;
    step[0] = (LoadStep){
        .theta = 1.0,
        .axial = spring_rate(&slip->params->spring, z) * k->dz_dtheta.value + damper_rate * k->dz_dtheta.slope * omega,
    };
    step[1] = (LoadStep){.omega = moves ? 1.0 : 0.0, .axial = damper_rate * k->dz_dtheta.value};
    if (!slip->follower_has_inertia) return;
    step[0].axial += m * (k->dz_dtheta.slope * alpha + k->d2z_dtheta2.slope * omega2);
    step[0].moment = I * (k->dpsi_dtheta[0].slope * alpha + k->d2gamma_dtheta2.slope * omega2);
    step[1].axial += 2.0 * m * k->d2z_dtheta2.value * omega;
    step[1].moment = 2.0 * I * k->d2gamma_dtheta2.value * omega;
}

COMPACT LoadedMotionResponse loaded_slip_motion(const SlipMode *slip, const SlipCoefficients *k, double z,
                                                double omega) {
    const ContactFactors *f = &k->loaded.tangent;
    const LoadedPin pin = pin_of(slip, omega, k);
    LoadStep step[2];
    load_steps(slip, k, z, omega, k->loaded.alpha, step);
    LoadedMotionResponse out = {.inertia = slip_inertia_with(slip, k, f)};
    for (int n = 0; n < 2; n++) {
        LoadChange change = {.axial = step[n].axial, .moment = step[n].moment};
        add_own_changes(slip, &pin, k, omega, step[n].theta, step[n].omega, &change);
        const LoadTerms left = loaded_contacts_unbalanced(&pin, &k->loaded, &change);
        const double torque = left.torque - step[n].omega * slip->params->shaft.damping;
        out.alpha_by[n] = (f->delta * torque - f->p * left.axial - f->q * left.moment) / out.inertia;
    }
    return out;
}

/* The factors and their derivatives, from k->loaded. */
COMPACT static void set_factors(const SlipMode *slip, double z, double omega, double alpha, SlipCoefficients *k) {
    const CamParams *cam = slip->params->cam;
    LoadStep step[2];
    load_steps(slip, k, z, omega, alpha, step);
    const LoadResponse by_theta = loaded_slip_response(slip, omega, k, &step[0]);
    const LoadResponse by_omega = loaded_slip_response(slip, omega, k, &step[1]);
    const double radius[2] = {cam[0].radius, cam[1].radius}, slope[2] = {k->slope[0].value, k->slope[1].value};
    for (int i = 0; i < 2; i++) {
        k->friction[i] = k->loaded.friction[i];
        k->dfriction_domega[i] = by_omega.friction[i];
        dual_contact_factors_set_varying(&k->factors, i, radius[i], (Dual){k->friction[i], by_theta.friction[i]},
                                         k->slope[i]);
    }
    dual_contact_factors_multiply(&k->factors);
    k->dfactors_domega = contact_factors_change(&k->factors, radius, slope, k->dfriction_domega);
}

/* The parts of A and W that do not depend on alpha, and those per alpha. */
static void find_loads(const SlipMode *slip, const SlipCoefficients *k, double force, double omega, LoadTerms *loads,
                       LoadTerms *by_alpha) {
    const InertiaParams *in = &slip->params->inertia;
    const double omega2 = omega * omega;
    *loads = (LoadTerms){.axial = force};
    *by_alpha = (LoadTerms){.torque = in->shaft};
    if (!slip->follower_has_inertia) return;
    loads->axial += in->follower_mass * k->d2z_dtheta2.value * omega2;
    loads->moment = in->follower * k->d2gamma_dtheta2.value * omega2;
    by_alpha->axial = in->follower_mass * k->dz_dtheta.value;
    by_alpha->moment = in->follower * k->dpsi_dtheta[0].value;
}

COMPACT void loaded_slip_set(const SlipMode *slip, double omega, double z, const InputValues *in, SlipCoefficients *k) {
    const Params *p = slip->params;
    const bool moves = slip->regime != REGIME_RATE_INDEPENDENT;
    const double damper = moves ? slip_damper_force(slip, k->dz_dtheta.value * omega) : 0.0;
    const LoadedPin pin = pin_of(slip, omega, k);
    LoadTerms loads, by_alpha;
    const double spring = spring_force(&p->spring, z);
    find_loads(slip, k, spring + in->F_ext + damper, omega, &loads, &by_alpha);
    loads.size = fabs(spring) + fabs(in->F_ext) + fabs(damper);
    loads.torque = in->tau - p->shaft.damping * omega;
    if (slip->regime == REGIME_INERTIAL) {
        loaded_contacts_moving(&pin, &loads, &by_alpha, &k->loaded);
        for (int i = 0; i < 2; i++) k->friction[i] = k->loaded.friction[i];
        return;
    }
    loaded_contacts_under(&pin, &loads, &k->loaded);
    set_factors(slip, z, omega, k->loaded.alpha, k);
}

COMPACT void loaded_slip_set_under(const SlipMode *slip, const LoadedMotion *b, SlipCoefficients *k) {
    const LoadedPin pin = pin_of(slip, b->omega, k);
    LoadTerms loads, by_alpha;
    find_loads(slip, k, b->force + b->damper, b->omega, &loads, &by_alpha);
    loads.size = fabs(b->force) + fabs(b->F_ext) + fabs(b->damper);
    loads.torque = b->torque;
    loads.axial += by_alpha.axial * b->alpha;
    loads.moment += by_alpha.moment * b->alpha;
    if (b->has_torque) loaded_contacts_in_motion(&pin, &loads, &k->loaded);
    else loaded_contacts_under(&pin, &loads, &k->loaded);
    set_factors(slip, b->z, b->omega, b->alpha, k);
}
