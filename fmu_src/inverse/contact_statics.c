#include "inverse/contact_statics.h"

#include <math.h>

#include "contact/contact_factors.h"
#include "model/friction_law.h"
#include "numerics/sign.h"
#include "numerics/tolerances.h"

/* gamma' = a_2/(a_1 + a_2) and z' = a_1 a_2/(a_1 + a_2), differentiated by the quotient rule with b_i = da_i/dtheta:
 *     gamma'' = (a_1 b_2 - a_2 b_1)/(a_1 + a_2)^2    z'' = (a_2^2 b_1 + a_1^2 b_2)/(a_1 + a_2)^2 */
ContactStatics contact_statics_at(const Params *params, const TransmissionPiece *piece, double theta) {
    const TransmissionPoint point = piece_point(piece, theta, TRANSMISSION_FIRST_DERIVATIVES);
    ContactStatics statics = {.params = params,
                              .geometry = cam_geometry(params->cam, point.slope),
                              .dslope_dtheta = {point.dslope_dtheta[0], point.dslope_dtheta[1]},
                              .z = point.z};
    const double *dpsi_dtheta = statics.geometry.dpsi_dtheta, sum = point.slope[0] + point.slope[1];
    statics.d2gamma_dtheta2 = (dpsi_dtheta[1] * point.dslope_dtheta[1] - dpsi_dtheta[0] * point.dslope_dtheta[0]) / sum;
    statics.d2z_dtheta2 = dpsi_dtheta[0] * dpsi_dtheta[0] * point.dslope_dtheta[0] +
                          dpsi_dtheta[1] * dpsi_dtheta[1] * point.dslope_dtheta[1];
    return statics;
}

void contact_statics_set_motion(const Params *params, double omega, double F, ContactStatics *statics) {
    statics->omega = omega;
    if (!any_friction_varies(params)) return;
    Geometry *g = &statics->geometry;
    for (int i = 0; i < 2; i++) {
        const double v = fabs(omega) * cam_sliding(g, i), N = cam_nominal_load(g, i, F, params->contacts);
        g->friction[i] = friction_at(&params->cam[i], v, N).value;
    }
}

/* ---- flanks ---- */

static void apply_load(const Load *load, ContactForces *forces) {
    const Transfer *t = &forces->transfer;
    forces->torque = t->rho * load->axial + t->rho_kappa1 * load->moment;
    for (int i = 0; i < 2; i++) forces->x[i] = t->axial[i] * load->axial + t->moment[i] * load->moment;
}

bool contact_statics_carries_nothing(const ContactForces *forces, const Load *load, int i) {
    const Transfer *t = &forces->transfer;
    const double size = fabs(t->axial[i]) * load->axial_size + fabs(t->moment[i]) * load->moment_size;
    return fabs(forces->x[i]) <= REACTION_ROUNDING * size;
}

/* Do the reactions have the signs of the flanks? */
static bool agrees(const Load *load, const ContactForces *forces) {
    if (!forces->transfer.regular || !isfinite(forces->torque)) return false;
    for (int i = 0; i < 2; i++)
        if (forces->flank[i] * forces->x[i] < 0.0 && !contact_statics_carries_nothing(forces, load, i)) return false;
    return true;
}

int contact_statics_side(const Load *load) {
    return fabs(load->axial) > REACTION_ROUNDING * load->axial_size ? sign_of(load->axial) : 0;
}

bool contact_statics_forces(const ContactStatics *statics, int direction, const Load *load, ContactForces *forces) {
    const int sign = contact_statics_side(load) < 0 ? -1 : 1;
    for (int k = 0; k < FLANK_PAIR_COUNT; k++) {
        flank_pair(k, sign, forces->flank);
        forces->transfer = contact_transfer(&statics->geometry, direction, forces->flank);
        apply_load(load, forces);
        if (agrees(load, forces)) return true;
    }
    return false;
}

/* F_0 < 0 mirrors the band: both flanks change, and the edge is the edge of the other direction for F_0 > 0. */
bool contact_statics_on_edge(ContactStatics *statics, int direction, double F_0, ContactForces *forces) {
    const int side = F_0 < 0.0 ? -1 : 1;
    cam_set_load(statics->params, F_0, &statics->geometry);
    if (!contact_edge(&statics->geometry, side * direction, forces->flank, &forces->transfer)) return false;
    for (int i = 0; i < 2; i++) forces->flank[i] *= side;
    const Load load = {.axial = F_0};
    apply_load(&load, forces);
    return true;
}

/* d ln(sliding_i)/dtheta, of sliding_i = psi_i' hypot(r_i, a_i). */
static double log_sliding_rate(const ContactStatics *statics, int i) {
    const Geometry *g = &statics->geometry;
    const double d2psi_dtheta2 = i == 0 ? statics->d2gamma_dtheta2 : -statics->d2gamma_dtheta2;
    const double by_length = g->slope[i] * statics->dslope_dtheta[i] / cam_length2(g, i);
    return g->dpsi_dtheta[i] > 0.0 ? d2psi_dtheta2 / g->dpsi_dtheta[i] + by_length : 0.0; /* else N_i = 0 */
}

double contact_statics_edge_rise(const ContactStatics *statics, int direction, double F_0,
                                 const ContactForces *forces) {
    const Geometry *g = &statics->geometry;
    DualContactFactors f;
    for (int i = 0; i < 2; i++) {
        const int sign = direction * forces->flank[i];
        const double by_load = g->friction_by_log_load[i];
        const Dual slope = {g->slope[i], statics->dslope_dtheta[i]};
        const Dual friction = {sign * g->friction[i],
                               by_load != 0.0 ? sign * by_load * log_sliding_rate(statics, i) : 0.0};
        dual_contact_factors_set_varying(&f, i, g->radius[i], friction, slope);
    }
    dual_contact_factors_multiply(&f);
    return dual_contact_factors_rho(&f).slope * F_0;
}

/* mu_i |R_i| times the sliding speed |psi_i'| hypot(r_i, a_i) per |omega| (docs/mechanism.md, section 4) */
double contact_statics_heat(const ContactStatics *statics, const ContactForces *forces, int i) {
    const Geometry *g = &statics->geometry;
    return cam_heat(g, i) * fabs(forces->x[i]);
}

double contact_statics_sliding(const ContactStatics *statics, const ContactForces *forces, int i) {
    const Geometry *g = &statics->geometry;
    return cam_length2(g, i) * g->dpsi_dtheta[i] * fabs(forces->x[i]);
}
