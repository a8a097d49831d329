#include "inverse/inverse.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "closed_form/linear_slip.h"
#include "contact/check.h"
#include "inverse/elastic_shaft.h"
#include "inverse/rigid_shaft.h"

/* ---- geometry ---- */

bool inverse_rebuild(Inverse *m, Fault *fault) {
    return check_params(&m->params, fault) && check_transmission(&m->params, m->resources, &m->transmission, fault);
}

void inverse_free(Inverse *m) {
    transmission_free(&m->transmission);
    m->transmission = (Transmission){.count = 0};
}

/* With an elastic shaft the stops hold cam 2, and the far end is free. */
static bool is_in_reach(const Inverse *m, double theta) {
    const StopParams *stop = &m->params.stop;
    const double slack = rigid_shaft_slack(stop);
    return has_elastic_shaft(m) || (theta >= stop->lower - slack && theta <= stop->upper + slack);
}

bool inverse_reaches(const Inverse *m, double theta, Fault *fault) {
    if (is_in_reach(m, theta)) return true;
    snprintf(fault->text, sizeof fault->text,
             "theta = %.17g is beyond the stops: allowed is stop.lower = %.17g to stop.upper = %.17g", theta,
             m->params.stop.lower, m->params.stop.upper);
    return false;
}

/* ---- the present, with the inputs as they are ---- */

static const TransmissionPiece *piece_of(const Inverse *m, double theta, int direction) {
    return transmission_piece(&m->transmission, theta, direction);
}

static Mode rigid_mode(double omega) {
    return omega > 0.0 ? MODE_LOADING : omega < 0.0 ? MODE_RELEASING : MODE_STICK;
}

/* Cam 2 as it is now. */
typedef struct {
    ContactStatics statics;
    double theta, omega; /* rad, rad/s */
    Mode mode;
} Now;

static Now now_of(const Inverse *m) {
    if (has_elastic_shaft(m)) {
        ElasticShaftState d;
        elastic_shaft_present(m, &d);
        return (Now){.statics = d.statics, .theta = d.cam, .omega = d.speed, .mode = d.mode};
    }
    const Instant at = rigid_shaft_present(m);
    return (Now){.statics = contact_statics_at(&m->params, piece_of(m, at.theta, at.direction), at.theta),
                 .theta = at.theta,
                 .omega = at.omega,
                 .mode = rigid_mode(at.omega)};
}

bool inverse_motion(const Inverse *m, InverseMotion *out, Fault *fault) {
    if (!inverse_reaches(m, m->inputs.theta[0], fault)) return false;
    const Now now = now_of(m);
    *out = (InverseMotion){.z = transmission_z(&m->transmission, now.theta),
                           .v = now.statics.geometry.dz_dtheta * now.omega};
    return true;
}

bool inverse_contact(const Inverse *m, InverseContact *out, Fault *fault) {
    if (!inverse_reaches(m, m->inputs.theta[0], fault)) return false;
    if (has_elastic_shaft(m)) {
        ElasticShaftState d;
        elastic_shaft_present(m, &d);
        *out = (InverseContact){.tau = d.tau, .reaction = {d.reaction[0], d.reaction[1]}};
        return true;
    }
    const Instant at = rigid_shaft_present(m);
    Effort effort;
    if (!rigid_shaft_effort(&m->params, piece_of(m, at.theta, at.direction), &at, &effort)) {
        rigid_shaft_describe_wedge(fault, &at);
        return false;
    }
    out->tau = effort.tau;
    for (int i = 0; i < 2; i++)
        out->reaction[i] = effort.forces.x[i] * cam_length(&effort.statics.geometry, i) / m->params.contacts;
    return true;
}

static double edge(double factor, double F_0) {
    return F_0 == 0.0 ? 0.0 : factor * F_0; /* no load, no friction, however locked */
}

/* T_release/T_load; where both vanish with F_0, the ratio they had before. */
static double efficiency(const Params *p, double load, double release, double F_0) {
    if (load == 0.0 && release == 0.0) return has_friction(p) ? 0.0 : 1.0;
    return F_0 == 0.0 ? release / load : edge(release, F_0) / edge(load, F_0);
}

static double damping_of(const Inverse *m, double v) {
    return v == 0.0 ? 0.0 : damper_force(&m->params.damper, v > 0.0 ? 1 : -1, v) + 0.0; /* no -0 */
}

bool inverse_loads(const Inverse *m, InverseLoadOutputs *out, Fault *fault) {
    if (!inverse_reaches(m, m->inputs.theta[0], fault)) return false;
    const Now now = now_of(m);
    const Geometry *g = &now.statics.geometry;
    const double z = transmission_z(&m->transmission, now.theta);
    const double spring = spring_force(&m->params.spring, z), F_0 = spring + m->inputs.F_ext[0];
    const BandFactors band = contact_band(g);
    const double load = F_0 < 0.0 ? band.release : band.load, release = F_0 < 0.0 ? band.load : band.release;
    *out = (InverseLoadOutputs){
        .theta_cam = now.theta,
        .gamma = transmission_gamma(&m->transmission, now.theta),
        .spring_force = spring,
        .damper_force = has_elastic_shaft(m) ? 0.0 : damping_of(m, g->dz_dtheta * now.omega),
        .sliding_speed = {g->dpsi_dtheta[0] * fabs(now.omega) * cam_length(g, 0),
                          g->dpsi_dtheta[1] * fabs(now.omega) * cam_length(g, 1)},
        .torque_load = edge(load, F_0),
        .torque_release = edge(release, F_0),
        .efficiency = efficiency(&m->params, load, release, F_0),
        .mode = (int)now.mode,
        .events = m->state.events,
    };
    return true;
}

/* ---- energy ---- */

static InverseEnergy stored(const Inverse *m, const InverseState *state) {
    const double deflection = state->theta - state->cam, K = m->params.shaft.stiffness;
    const ContactStatics statics = contact_statics_at(&m->params, piece_of(m, state->cam, 0), state->cam);
    return (InverseEnergy){
        .spring = spring_energy(&m->params.spring, transmission_z(&m->transmission, state->cam)),
        .kinetic = has_elastic_shaft(m) ? 0.0 : rigid_shaft_kinetic(&m->params, &statics, state->omega),
        .shaft = 0.5 * K * deflection * deflection,
    };
}

static double sum_of_stored(const InverseEnergy *e) {
    return e->spring + e->kinetic + e->shaft;
}

void inverse_energy(const Inverse *m, InverseEnergy *out) {
    const Ledger *l = &m->state.ledger;
    *out = stored(m, &m->state);
    out->work_in = l->work_in.hi;
    out->work_ext = l->work_ext.hi;
    out->work_tuning = l->work_tuning.hi;
    out->heat_cam[0] = l->heat_cam[0].hi;
    out->heat_cam[1] = l->heat_cam[1].hi;
    out->heat_damper = l->heat_damper.hi;
    out->heat_shaft = l->heat_shaft.hi;
    out->heat_stop = l->heat_stop.hi;
}

void inverse_audit(const Inverse *m, Audit *out) {
    const InverseEnergy now = stored(m, &m->state);
    out->residual = m->params.ledger ? ledger_residual(&m->state.ledger, sum_of_stored(&now)) : 0.0;
}

/* ---- start and tuning ---- */

bool inverse_start(Inverse *m, Fault *fault) {
    if (!inverse_rebuild(m, fault) || !inverse_reaches(m, m->inputs.theta[0], fault)) return false;
    const double theta = m->inputs.theta[0], omega = m->inputs.omega[0];
    m->state = (InverseState){
        .theta = theta,
        .omega = omega,
        .cam = has_elastic_shaft(m) ? elastic_shaft_start(m) : theta,
        .mode = rigid_mode(omega),
        .direction = omega < 0.0 ? -1 : 1,
    };
    if (has_elastic_shaft(m)) m->state.mode = now_of(m).mode;
    const InverseEnergy energy = stored(m, &m->state);
    ledger_open(&m->state.ledger, sum_of_stored(&energy));
    return true;
}

bool inverse_retune(Inverse *m, const Params *params, Fault *fault) {
    if (!check_params(params, fault) || !check_jam(params, &m->transmission, fault)) return false;
    const double z = transmission_z(&m->transmission, m->state.cam);
    const double jump = spring_energy(&params->spring, z) - spring_energy(&m->params.spring, z);
    if (m->params.ledger && jump != 0.0) sum_add(&m->state.ledger.work_tuning, jump);
    m->params = *params;
    return true;
}

/* ---- the step ---- */

/* A master that repeats its inputs moves nothing, whatever speed it repeats. */
static bool is_repetition(const Inverse *m, Given given) {
    const InverseInputs *u = &m->inputs;
    return given == GIVEN_ENDS && u->theta[0] == m->state.theta && u->omega[0] == m->state.omega;
}

static Imposed motion_of(const Inverse *m, Given given, double h) {
    if (is_repetition(m, given)) {
        Imposed rest = imposed_motion(&m->inputs, GIVEN_ENDS, m->state.theta, 0.0, h);
        rest.theta = (Bernstein){0, {m->state.theta}};
        rest.turning = rest.quickening = (Bernstein){0, {0.0}};
        return rest;
    }
    return imposed_motion(&m->inputs, given, m->state.theta, m->state.omega, h);
}

static bool is_finite(const Imposed *motion) {
    double sum = 0.0;
    for (int i = 0; i <= motion->theta.degree; i++) sum += motion->theta.c[i];
    for (int i = 0; i <= motion->turning.degree; i++) sum += motion->turning.c[i] / motion->h;
    for (int i = 0; i <= motion->quickening.degree; i++) sum += motion->quickening.c[i] / motion->h / motion->h;
    for (int i = 0; i <= motion->F_ext.degree; i++) sum += motion->F_ext.c[i];
    return isfinite(sum);
}

static bool check_motion(const Inverse *m, const Imposed *motion, double h, Fault *fault) {
    if (is_finite(motion))
        return inverse_reaches(m, motion->theta.c[0], fault) &&
               inverse_reaches(m, motion->theta.c[motion->theta.degree], fault);
    snprintf(
        fault->text, sizeof fault->text,
        "the motion to theta = %.17g, omega = %.17g within %.17g s leaves the range of numbers; allowed are finite "
        "values",
        m->inputs.theta[0], m->inputs.omega[0], h);
    return false;
}

static bool is_finite_ledger(const Ledger *l) {
    return isfinite(l->work_in.hi + l->work_ext.hi + l->heat_cam[0].hi + l->heat_cam[1].hi + l->heat_damper.hi +
                    l->heat_shaft.hi);
}

bool inverse_advance(Inverse *m, double h, Given given, Fault *fault) {
    const Imposed motion = motion_of(m, given, h);
    if (!check_motion(m, &motion, h, fault)) return false;
    const bool repeats = is_repetition(m, given);
    InverseInputs inputs = m->inputs;
    imposed_finish(&motion, given, &inputs);
    InverseState next = m->state;
    if (has_elastic_shaft(m)) {
        if (!elastic_shaft_advance(m, &motion, inputs.omega[0], &next, fault)) return false;
    } else if (!repeats && !rigid_shaft_advance(m, &motion, inputs.omega[0], &next, fault)) {
        return false;
    }
    if (!is_finite_ledger(&next.ledger)) {
        snprintf(fault->text, sizeof fault->text,
                 "step of %.17g s to theta = %.17g: an account leaves the range of numbers; allowed are finite values",
                 h, inputs.theta[0]);
        return false;
    }
    m->state = next;
    m->inputs = inputs;
    return true;
}

/* ---- model exchange ---- */

void inverse_settle(Inverse *m) {
    const double omega = m->inputs.omega[0];
    if (omega != 0.0) m->state.direction = omega > 0.0 ? 1 : -1;
}

double inverse_indicator(const Inverse *m) {
    static const double LATE_SPEED = 1e-10; /* rad/s: an event is late by this, so that rest is none */
    return m->state.direction * m->inputs.omega[0] + LATE_SPEED;
}
