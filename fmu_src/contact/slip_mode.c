#include "contact/slip_mode.h"

#include "elementary/elementary.h"
#include "platform/attributes.h"

/* gamma' = a_2/(a_1 + a_2) and z' = a_1 gamma', differentiated (section 2 of docs/mechanism.md):
 *     gamma'' = (a_2' phi' - a_1' gamma')/(a_1 + a_2)          z'' = a_1' gamma'^2 + a_2' phi'^2
 *     gamma''' = (a_2'' phi' - a_1'' gamma' - 2 gamma'' (a_1' + a_2'))/(a_1 + a_2)
 *     z''' = a_1'' gamma'^2 + a_2'' phi'^2 + 2 gamma'' (a_1' gamma' - a_2' phi') */
static inline void set_kinematics(SlipCoefficients *k, const TransmissionPoint *s, bool third_derivatives) {
    const double inverse = 1.0 / (s->slope[0] + s->slope[1]);
    const double g = s->slope[1] * inverse, f = s->slope[0] * inverse;
    const double gg = (s->dslope_dtheta[1] * f - s->dslope_dtheta[0] * g) * inverse;
    const double zz = s->dslope_dtheta[0] * g * g + s->dslope_dtheta[1] * f * f;
    k->dz_dtheta = (Dual){s->slope[0] * g, zz};
    k->dpsi_dtheta[0] = (Dual){g, gg};
    k->dpsi_dtheta[1] = (Dual){f, -gg};
    k->d2z_dtheta2 = (Dual){zz, 0.0};
    k->d2gamma_dtheta2 = (Dual){gg, 0.0};
    if (!third_derivatives) return;
    const double dslope_dtheta = s->dslope_dtheta[0] + s->dslope_dtheta[1];
    k->d2gamma_dtheta2.slope =
        (s->d2slope_dtheta2[1] * f - s->d2slope_dtheta2[0] * g - 2.0 * gg * dslope_dtheta) * inverse;
    k->d2z_dtheta2.slope = s->d2slope_dtheta2[0] * g * g + s->d2slope_dtheta2[1] * f * f +
                           2.0 * gg * (s->dslope_dtheta[0] * g - s->dslope_dtheta[1] * f);
}

ALWAYS_INLINE static inline void set_coefficients(const SlipMode *slip, TransmissionPoint s, SlipCoefficients *k) {
    for (int i = 0; i < 2; i++)
        s.slope[i] = max_of(s.slope[i], 0.0); /* the polynomial of a level groove rounds below 0 */
    set_kinematics(k, &s, slip->follower_has_inertia);
    for (int i = 0; i < 2; i++) k->slope[i] = (Dual){s.slope[i], s.dslope_dtheta[i]};
    if (slip->friction_varies) return;
    for (int i = 0; i < 2; i++) {
        dual_contact_factors_set(&k->factors, i, slip->params->cam[i].radius, slip->signed_friction[i], k->slope[i]);
    }
    dual_contact_factors_multiply(&k->factors);
}

/* Apart from piece_point(): together the two need more registers than there are. */
NOINLINE static void set_curved_coefficients(const SlipMode *slip, const TransmissionPoint *s, SlipCoefficients *k) {
    set_coefficients(slip, *s, k);
}

double slip_coefficients_curved(const SlipMode *slip, double theta, SlipCoefficients *out) {
    const TransmissionPoint point = slip->follower_has_inertia
                                        ? piece_point(slip->piece, theta, TRANSMISSION_SECOND_DERIVATIVES)
                                        : piece_point(slip->piece, theta, TRANSMISSION_FIRST_DERIVATIVES);
    set_curved_coefficients(slip, &point, out);
    return point.z;
}

/* v_i = sigma omega psi_i' hypot(r_i, a_i) */
void slip_set_friction(const SlipMode *slip, double omega, SlipCoefficients *k) {
    const Params *p = slip->params;
    const double speed = slip->regime == REGIME_RATE_INDEPENDENT ? 0.0 : slip->direction * omega;
    double radius[2], slope[2];
    for (int i = 0; i < 2; i++) {
        const double r = p->cam[i].radius, length = sqrt(r * r + k->slope[i].value * k->slope[i].value);
        const Dual sliding = dual_multiply(
            k->dpsi_dtheta[i], (Dual){length, k->slope[i].value * k->slope[i].slope / length}); /* per angle */
        const FrictionCoefficient mu = friction_at(&p->cam[i], speed * sliding.value);
        const double sign = slip->direction * slip->flank[i], by_speed = sign * mu.by_speed;
        const Dual f = {sign * mu.value, by_speed * speed * sliding.slope};
        radius[i] = r;
        slope[i] = k->slope[i].value;
        k->friction[i] = f.value;
        k->dfriction_domega[i] =
            slip->regime == REGIME_RATE_INDEPENDENT ? 0.0 : by_speed * slip->direction * sliding.value;
        dual_contact_factors_set_varying(&k->factors, i, r, f, k->slope[i]);
    }
    dual_contact_factors_multiply(&k->factors);
    k->dfactors_domega = contact_factors_change(&k->factors, radius, slope, k->dfriction_domega);
}

NOINLINE InputValues input_values_at(const Inputs *in, double t) {
    return (InputValues){input_value(in->tau, t), input_value(in->F_ext, t), input_rate(in->tau, t),
                         input_rate(in->F_ext, t)};
}

static TransmissionPoint straight_point(const TransmissionPiece *piece) {
    return (TransmissionPoint){.slope = {piece->slope[0][0], piece->slope[0][1]}};
}

Regime slip_regime(const Params *p, int direction) {
    if (has_inertia(p)) return REGIME_INERTIAL;
    const DamperParams *d = &p->damper;
    const double damping = direction > 0 ? d->c_load + d->q_load : d->c_release + d->q_release;
    const bool damped = damping + p->shaft.damping > 0.0 || any_friction_varies(p);
    return damped ? REGIME_VISCOUS : REGIME_RATE_INDEPENDENT;
}

SlipMode slip_mode_of(const Params *p, const Transmission *transmission, const FrictionConstants *law,
                      const Inputs *inputs, double theta, int direction, const int flank[2]) {
    const DamperParams *d = &p->damper;
    SlipMode slip; /* field by field: zeroing the coefficients would cost more than all fields */
    slip.params = p;
    slip.transmission = transmission;
    slip.piece = transmission_piece(transmission, theta, direction);
    slip.inputs = inputs;
    slip.work = NULL;
    slip.direction = direction;
    slip.friction_is_loaded = any_friction_depends_on_load(p);
    slip.friction_varies = slip.friction_is_loaded || any_friction_varies(p);
    for (int i = 0; i < 2; i++) {
        slip.flank[i] = flank[i];
        slip.signed_friction[i] =
            direction * flank[i] * (slip.friction_varies ? friction_static(&p->cam[i]) : p->cam[i].friction);
    }
    slip.law = law;
    slip.c = direction > 0 ? d->c_load : d->c_release;
    slip.q = direction > 0 ? d->q_load : d->q_release;
    slip.follower_has_inertia = p->inertia.follower_mass + p->inertia.follower > 0.0;
    slip.inputs_are_constant = inputs_constant(inputs);
    slip.searches = false;
    slip.to_rounding = false;
    slip.regime = slip_regime(p, direction);
    if (transmission->straight) set_coefficients(&slip, straight_point(slip.piece), &slip.coefficients);
    return slip;
}
