#include "contact/slip_mode.h"

#include "elementary/elementary.h"
#include "model/elements.h"
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

/* F = F_s + F_ext + D and its derivatives by theta and omega. */
typedef struct {
    double value, by_theta, by_omega; /* N, N/rad, N.s/rad */
} AxialForce;

static AxialForce axial_force(const SlipMode *slip, const SlipCoefficients *k, double omega, double z, double F_ext) {
    const SpringParams *spring = &slip->params->spring;
    const double v = k->dz_dtheta.value * omega, damping = slip_damper_rate(slip, v);
    return (AxialForce){
        .value = spring_force(spring, z) + F_ext + slip_damper_force(slip, v),
        .by_theta = spring_rate(spring, z) * k->dz_dtheta.value + damping * k->dz_dtheta.slope * omega,
        .by_omega = damping * k->dz_dtheta.value,
    };
}

/* Sliding distance of contact i per angle of cam 2, m: psi_i' hypot(r_i, a_i). The sliding speed v_i is that times
 * sigma omega. */
static Dual sliding_of(const SlipMode *slip, const SlipCoefficients *k, int i) {
    const double r = slip->params->cam[i].radius, a = k->slope[i].value, length = sqrt(r * r + a * a);
    return dual_multiply(k->dpsi_dtheta[i], (Dual){length, a * k->slope[i].slope / length});
}

void slip_set_friction(const SlipMode *slip, double omega, double z, double F_ext, SlipCoefficients *k) {
    const double rate = slip->regime == REGIME_RATE_INDEPENDENT ? 0.0 : omega, speed = slip->direction * rate;
    const AxialForce force = axial_force(slip, k, rate, z, F_ext);
    const double load = fabs(force.value), side = force.value < 0.0 ? -1.0 : 1.0;
    for (int i = 0; i < 2; i++) {
        const CamParams *cam = &slip->params->cam[i];
        const double per_sliding = slip_load_per_sliding(slip, i), sign = slip->direction * slip->flank[i];
        const Dual sliding = sliding_of(slip, k, i);
        const FrictionCoefficient mu = friction_at(cam, speed * sliding.value, load * per_sliding * sliding.value);
        const double by_sliding = sign * (mu.by_speed * speed + mu.by_load * load * per_sliding);
        const double by_force = sign * mu.by_load * side * per_sliding * sliding.value;
        const double by_speed = slip->regime == REGIME_RATE_INDEPENDENT ? 0.0 : sign * mu.by_speed * slip->direction;
        const Dual f = {sign * mu.value, by_sliding * sliding.slope + by_force * force.by_theta};
        k->friction[i] = f.value;
        k->dfriction_domega[i] = by_speed * sliding.value + by_force * force.by_omega;
        k->dfriction_dload[i] = by_force;
        dual_contact_factors_set_varying(&k->factors, i, cam->radius, f, k->slope[i]);
    }
    dual_contact_factors_multiply(&k->factors);
    k->dfactors_domega = slip_factors_by(slip, k, k->dfriction_domega);
    k->dfactors_dload = slip_factors_by(slip, k, k->dfriction_dload);
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
    return damping + p->shaft.damping > 0.0 ? REGIME_VISCOUS : REGIME_RATE_INDEPENDENT;
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
    slip.friction_varies = any_friction_varies(p);
    for (int i = 0; i < 2; i++) {
        slip.flank[i] = flank[i];
        slip.signed_friction[i] = direction * flank[i] * p->cam[i].friction;
    }
    slip.law = law;
    slip.c = direction > 0 ? d->c_load : d->c_release;
    slip.q = direction > 0 ? d->q_load : d->q_release;
    slip.follower_has_inertia = p->inertia.follower_mass + p->inertia.follower > 0.0;
    slip.inputs_are_constant = inputs_constant(inputs);
    slip.to_rounding = false;
    slip.regime = slip_regime(p, direction);
    if (transmission->straight) set_coefficients(&slip, straight_point(slip.piece), &slip.coefficients);
    return slip;
}
