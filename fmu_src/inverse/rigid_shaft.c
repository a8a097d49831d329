#include "inverse/rigid_shaft.h"

#include <math.h>
#include <stdio.h>

#include "model/elements.h"
#include "numerics/sign.h"
#include "numerics/tolerances.h"

double rigid_shaft_stop_margin(const StopParams *stop) {
    return IMPOSED_STOP_ROUNDING * (stop->upper - stop->lower);
}

OperatingPoint rigid_shaft_operating_point(const Inverse *m) {
    const int direction = m->continuous ? 0 : sign_of(m->inputs.omega[0]);
    return (OperatingPoint){
        .theta = m->inputs.theta[0],
        .omega = m->inputs.omega[0],
        .alpha = m->inputs.alpha[0],
        .F_ext = m->inputs.F_ext[0],
        .direction = direction != 0 ? direction : m->state.direction,
    };
}

/* The axial load A and the moment W of inverse.h, with the sizes of what adds up to them. */
static Load load_of(const Params *p, const ContactStatics *statics, const OperatingPoint *at, double damper) {
    const Geometry *g = &statics->geometry;
    const double omega2 = at->omega * at->omega;
    const double spring = spring_force(&p->spring, statics->z);
    const double axial[4] = {spring, at->F_ext, damper,
                             p->inertia.follower_mass * (g->dz_dtheta * at->alpha + statics->d2z_dtheta2 * omega2)};
    const double moment[2] = {p->inertia.follower * g->dpsi_dtheta[0] * at->alpha,
                              p->inertia.follower * statics->d2gamma_dtheta2 * omega2};
    Load load = {.axial_size = fabs(p->spring.preload)}; /* the spring's force may be a difference */
    for (int k = 0; k < 4; k++) {
        load.axial += axial[k];
        load.axial_size += fabs(axial[k]);
    }
    for (int k = 0; k < 2; k++) {
        load.moment += moment[k];
        load.moment_size += fabs(moment[k]);
    }
    return load;
}

bool rigid_shaft_required_torque(const Params *p, const TransmissionPiece *piece, const OperatingPoint *at,
                                 RequiredTorque *out) {
    out->statics = contact_statics_at(p, piece, at->theta);
    out->damper = damper_force(&p->damper, at->direction, out->statics.geometry.dz_dtheta * at->omega);
    const double force = spring_force(&p->spring, out->statics.z) + at->F_ext + out->damper;
    contact_statics_set_motion(p, at->omega, force, &out->statics);
    out->load = load_of(p, &out->statics, at, out->damper);
    if (!contact_statics_forces(&out->statics, at->direction, &out->load, &out->forces)) return false;
    out->tau = out->forces.torque + p->shaft.damping * at->omega + p->inertia.shaft * at->alpha;
    return isfinite(out->tau);
}

double rigid_shaft_kinetic_energy(const Params *p, const ContactStatics *statics, double omega) {
    const Geometry *g = &statics->geometry;
    return kinetic_energy_of(&p->inertia, g->dz_dtheta, g->dpsi_dtheta[0], omega);
}

void rigid_shaft_describe_wedge(Fault *fault, const OperatingPoint *at) {
    snprintf(fault->text, sizeof fault->text,
             "theta = %s, omega = %s, alpha = %s, F_ext = %s: the contacts wedge, no torque brings about this "
             "motion in the %s direction; allowed is motion in which each contact bears on the flank that its reaction "
             "presses on, as with a smaller alpha or less friction",
             shortest_decimal(at->theta).text, shortest_decimal(at->omega).text, shortest_decimal(at->alpha).text,
             shortest_decimal(at->F_ext).text, at->direction > 0 ? "loading" : "releasing");
}
