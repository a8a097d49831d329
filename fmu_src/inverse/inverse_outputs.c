#include "inverse/inverse_outputs.h"

#include <math.h>
#include <stdio.h>

#include "contact/contact.h"
#include "inverse/elastic_shaft.h"
#include "inverse/rigid_shaft.h"
#include "model/elements.h"

bool inverse_reaches(const Inverse *m, double theta, Fault *fault) {
    const StopParams *stop = &m->params.stop;
    const double margin = rigid_shaft_stop_margin(stop);
    if (has_elastic_shaft(m) || (theta >= stop->lower - margin && theta <= stop->upper + margin)) return true;
    const bool below = theta < stop->lower;
    snprintf(fault->text, sizeof fault->text, "theta = %s is beyond the %s stop: allowed is theta %s %s = %s",
             shortest_decimal(theta).text, below ? "lower" : "upper",
             below ? ">=" : "<=", below ? "stop.lower" : "stop.upper",
             shortest_decimal(below ? stop->lower : stop->upper).text);
    return false;
}

/* ---- motion and loads ---- */

/* Cam 2 as it is now. */
typedef struct {
    ContactStatics statics;
    double theta, omega; /* rad, rad/s */
    Mode mode;
} CamState;

static CamState present_cam(const Inverse *m) {
    if (has_elastic_shaft(m)) {
        ElasticShaftState shaft;
        elastic_shaft_present(m, &shaft);
        return (CamState){.statics = shaft.statics, .theta = shaft.x, .omega = shaft.speed, .mode = shaft.mode};
    }
    const OperatingPoint at = rigid_shaft_operating_point(m);
    return (CamState){
        .statics = contact_statics_at(&m->params, inverse_piece(m, at.theta, at.direction), at.theta),
        .theta = at.theta,
        .omega = at.omega,
        .mode = rigid_shaft_mode(at.omega),
    };
}

bool inverse_motion_outputs(const Inverse *m, InverseMotionOutputs *out, Fault *fault) {
    if (!inverse_reaches(m, m->inputs.theta[0], fault)) return false;
    const CamState cam = present_cam(m);
    *out = (InverseMotionOutputs){
        .z = transmission_z(&m->transmission, cam.theta),
        .v = cam.statics.geometry.dz_dtheta * cam.omega,
    };
    return true;
}

static void set_friction(const Inverse *m, const Geometry *g, double omega, InverseTorqueOutputs *out) {
    for (int i = 0; i < 2; i++) {
        out->friction_coefficient[i] = g->friction[i];
        out->friction_power[i] =
            g->friction[i] * fabs(out->reaction[i]) * m->params.contacts * fabs(omega) * cam_sliding(g, i);
    }
    out->total_friction_power = out->friction_power[0] + out->friction_power[1];
}

bool inverse_torque_outputs(const Inverse *m, InverseTorqueOutputs *out, Fault *fault) {
    if (!inverse_reaches(m, m->inputs.theta[0], fault)) return false;
    if (has_elastic_shaft(m)) {
        ElasticShaftState shaft;
        elastic_shaft_present(m, &shaft);
        *out = (InverseTorqueOutputs){.tau = shaft.tau, .reaction = {shaft.reaction[0], shaft.reaction[1]}};
        set_friction(m, &shaft.statics.geometry, shaft.speed, out);
        return true;
    }
    const OperatingPoint at = rigid_shaft_operating_point(m);
    RequiredTorque required;
    if (!rigid_shaft_required_torque(&m->params, inverse_piece(m, at.theta, at.direction), &at, &required)) {
        rigid_shaft_describe_wedge(fault, &at);
        return false;
    }
    out->tau = required.tau;
    for (int i = 0; i < 2; i++)
        out->reaction[i] = required.forces.x[i] * cam_length(&required.statics.geometry, i) / m->params.contacts;
    set_friction(m, &required.statics.geometry, at.omega, out);
    return true;
}

/* N.m, of an edge of the stick band. Without a load there is no friction, even if a contact locks. */
static double edge_torque(double factor, double F_0) {
    return F_0 == 0.0 ? 0.0 : factor * F_0;
}

/* T_release/T_load; at F_0 = 0 both are zero, and the ratio is its limit. 0 where no torque moves the mechanism either
 * way. */
static double efficiency_of(const Params *p, double load, double release, double F_0) {
    if (load == 0.0 && release == 0.0) return has_friction(p) ? 0.0 : 1.0;
    if (isinf(load) && isinf(release)) return 0.0;
    return F_0 == 0.0 ? release / load : edge_torque(release, F_0) / edge_torque(load, F_0);
}

static double damper_force_at(const Inverse *m, double v) {
    return v == 0.0 ? 0.0 : damper_force(&m->params.damper, v > 0.0 ? 1 : -1, v) + 0.0; /* + 0.0: no -0 */
}

bool inverse_load_outputs(const Inverse *m, InverseLoadOutputs *out, Fault *fault) {
    if (!inverse_reaches(m, m->inputs.theta[0], fault)) return false;
    const CamState cam = present_cam(m);
    const Geometry *g = &cam.statics.geometry;
    Geometry at_rest = *g;
    const double z = transmission_z(&m->transmission, cam.theta);
    const double spring = spring_force(&m->params.spring, z), F_0 = spring + m->inputs.F_ext[0];
    cam_set_load(&m->params, F_0, &at_rest);
    const BandFactors band = contact_band(&at_rest);
    const double load = F_0 < 0.0 ? band.release : band.load, release = F_0 < 0.0 ? band.load : band.release;
    *out = (InverseLoadOutputs){
        .theta_cam = cam.theta,
        .gamma = transmission_gamma(&m->transmission, cam.theta),
        .spring_force = spring,
        .damper_force = has_elastic_shaft(m) ? 0.0 : damper_force_at(m, g->dz_dtheta * cam.omega),
        .sliding_speed = {g->dpsi_dtheta[0] * fabs(cam.omega) * cam_length(g, 0),
                          g->dpsi_dtheta[1] * fabs(cam.omega) * cam_length(g, 1)},
        .torque_load = edge_torque(load, F_0),
        .torque_release = edge_torque(release, F_0),
        .efficiency = efficiency_of(&m->params, load, release, F_0),
        .mode = (int)cam.mode,
        .friction_class = (int)m->state.friction_class,
        .events = m->state.events,
    };
    return true;
}

/* ---- energy ---- */

/* Spring, kinetic and shaft; the accounts are zero. */
static InverseEnergyOutputs stored_energy(const Inverse *m) {
    const InverseState *state = &m->state;
    const double deflection = state->theta - state->cam, K = m->params.shaft.stiffness;
    const ContactStatics statics = contact_statics_at(&m->params, inverse_piece(m, state->cam, 0), state->cam);
    return (InverseEnergyOutputs){
        .spring = spring_energy(&m->params.spring, transmission_z(&m->transmission, state->cam)),
        .kinetic = has_elastic_shaft(m) ? 0.0 : rigid_shaft_kinetic_energy(&m->params, &statics, state->omega),
        .shaft = 0.5 * K * deflection * deflection,
    };
}

double inverse_stored_energy(const Inverse *m) {
    const InverseEnergyOutputs now = stored_energy(m);
    return now.spring + now.kinetic + now.shaft;
}

void inverse_energy_outputs(const Inverse *m, InverseEnergyOutputs *out) {
    const Ledger *l = &m->state.ledger;
    *out = stored_energy(m);
    out->work_in = l->work_in.hi;
    out->work_ext = l->work_ext.hi;
    out->work_tuning = l->work_tuning.hi;
    out->heat_cam[0] = l->heat_cam[0].hi;
    out->heat_cam[1] = l->heat_cam[1].hi;
    out->heat_damper = l->heat_damper.hi;
    out->heat_shaft = l->heat_shaft.hi;
    out->heat_stop = l->heat_stop.hi;
}

void inverse_audit_outputs(const Inverse *m, Audit *out) {
    out->residual = m->params.ledger ? ledger_residual(&m->state.ledger, inverse_stored_energy(m)) : 0.0;
}
