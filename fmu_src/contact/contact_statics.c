#include "contact/contact_statics.h"

#include <math.h>
#include <stddef.h>

#include "contact/contact_factors.h"
#include "contact/loaded_contacts.h"
#include "model/friction_law.h"
#include "numerics/sign.h"
#include "numerics/tolerances.h"
#include "platform/attributes.h"

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

void contact_statics_set_speed(const Params *params, double omega, ContactStatics *statics) {
    statics->omega = omega;
    if (!any_friction_varies(params)) return;
    Geometry *g = &statics->geometry;
    for (int i = 0; i < 2; i++) g->friction[i] = friction_at(&params->cam[i], fabs(omega) * cam_sliding(g, i)).value;
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

static LoadedPin loaded_pin_of(const ContactStatics *statics, int direction, const int flank[2]) {
    const Geometry *g = &statics->geometry;
    const double speed = fabs(statics->omega);
    return (LoadedPin){
        .params = statics->params,
        .direction = direction,
        .flank = {flank[0], flank[1]},
        .slope = {g->slope[0], g->slope[1]},
        .speed = {speed * cam_sliding(g, 0), speed * cam_sliding(g, 1)},
    };
}

/* Sets the friction coefficients to those under the load. False if the balance has not one answer. */
static bool set_loaded_friction(const Load *load, int direction, const int flank[2], ContactStatics *statics) {
    const LoadedPin pin = loaded_pin_of(statics, direction, flank);
    const LoadTerms loads = {.axial = load->axial, .moment = load->moment};
    LoadedContacts contacts;
    loaded_contacts_under(&pin, &loads, &contacts);
    for (int i = 0; i < 2; i++) statics->geometry.friction[i] = contacts.mu[i].value;
    return contacts.possible;
}

int contact_statics_side(const Load *load) {
    return fabs(load->axial) > REACTION_ROUNDING * load->axial_size ? sign_of(load->axial) : 0;
}

bool contact_statics_forces(ContactStatics *statics, int direction, const Load *load, ContactForces *forces) {
    const bool loaded = any_friction_depends_on_load(statics->params);
    const int sign = contact_statics_side(load) < 0 ? -1 : 1;
    for (int k = 0; k < FLANK_PAIR_COUNT; k++) {
        flank_pair(k, sign, forces->flank);
        if (loaded && !set_loaded_friction(load, direction, forces->flank, statics)) continue;
        forces->transfer = contact_transfer(&statics->geometry, direction, forces->flank);
        apply_load(load, forces);
        if (agrees(load, forces)) return true;
    }
    return false;
}

/* F_0 < 0 mirrors the band: both flanks change, and the edge is the edge of the other direction for F_0 > 0. */
bool contact_statics_on_edge(ContactStatics *statics, int direction, double F_0, ContactForces *forces) {
    const int side = F_0 < 0.0 ? -1 : 1;
    if (!contact_edge_under(statics->params, &statics->geometry, fabs(F_0), side * direction, forces->flank,
                            &forces->transfer, NULL))
        return false;
    for (int i = 0; i < 2; i++) forces->flank[i] *= side;
    const Load load = {.axial = F_0};
    apply_load(&load, forces);
    return true;
}

COMPACT double contact_statics_edge_rise(const ContactStatics *statics, int direction, double F_0,
                                         const ContactForces *forces) {
    const Geometry *g = &statics->geometry;
    double by_theta[2] = {0.0, 0.0};
    if (any_friction_depends_on_load(statics->params)) {
        const LoadedPin pin = loaded_pin_of(statics, direction, forces->flank);
        const LoadTerms loads = {.axial = F_0};
        LoadedContacts contacts;
        loaded_contacts_under(&pin, &loads, &contacts);
        const LoadResponse response = loaded_contacts_along_groove(&pin, &contacts, statics->dslope_dtheta);
        for (int i = 0; i < 2; i++) by_theta[i] = response.friction[i];
    }
    DualContactFactors f;
    for (int i = 0; i < 2; i++) {
        const Dual slope = {g->slope[i], statics->dslope_dtheta[i]};
        const Dual friction = {direction * forces->flank[i] * g->friction[i], by_theta[i]};
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
