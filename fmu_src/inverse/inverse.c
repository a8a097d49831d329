#include "inverse/inverse.h"

#include <math.h>
#include <stdio.h>

#include "contact/check.h"
#include "contact/domain.h"
#include "inverse/elastic_shaft.h"
#include "inverse/rigid_shaft.h"
#include "model/elements.h"
#include "numerics/tolerances.h"

/* ---- start and tuning ---- */

static bool check_inverse(const Params *p, Fault *fault) {
    return !(p->shaft.stiffness > 0.0) ||
           check_speed_friction(p, "with an elastic shaft", "shaft.stiffness = 0", fault);
}

bool inverse_rebuild(Inverse *m, Fault *fault) {
    FrictionTables tables;
    if (!friction_tables_load(&m->params, &m->friction, m->resources, &tables, fault)) return false;
    const bool good =
        check_inverse(&m->params, fault) && check_transmission(&m->params, m->resources, m->state.F_ext_at_start,
                                                               domain_check_loading, &m->transmission, fault);
    friction_tables_settle(&m->params, &m->friction, &tables, good);
    return good;
}

void inverse_free(Inverse *m) {
    transmission_free(&m->transmission);
    m->transmission = (Transmission){.count = 0};
    friction_tables_free(&m->friction);
}

/* The search for the place of cam 2 has spent its work. */
static bool describe_start(const Inverse *m, Fault *fault) {
    snprintf(fault->text, sizeof fault->text,
             "theta = %s, F_ext = %s: cam 2 finds no place at the end of the shaft; allowed are %d evaluations of "
             "the motion",
             shortest_decimal(m->inputs.theta[0]).text, shortest_decimal(m->inputs.F_ext[0]).text,
             (int)work_of_call(m->work_limit).most);
    return false;
}

bool inverse_start(Inverse *m, Fault *fault) {
    const double F_ext = m->state.F_ext_at_start = m->inputs.F_ext[0];
    if (!inverse_rebuild(m, fault) || !inverse_reaches(m, m->inputs.theta[0], fault)) return false;
    const double theta = m->inputs.theta[0], omega = m->inputs.omega[0];
    m->state = (InverseState){
        .theta = theta,
        .omega = omega,
        .cam = has_elastic_shaft(m) ? elastic_shaft_start(m) : theta,
        .mode = rigid_shaft_mode(omega),
        .direction = omega < 0.0 ? -1 : 1,
        .F_ext_at_start = F_ext,
        .friction_class = domain_class(&m->params, &m->transmission, F_ext),
    };
    if (has_elastic_shaft(m)) {
        ElasticShaftState shaft;
        elastic_shaft_present(m, &shaft);
        m->state.mode = shaft.mode;
        if (isnan(shaft.x)) return describe_start(m, fault);
    }
    ledger_open(&m->state.ledger, inverse_stored_energy(m));
    return true;
}

bool inverse_retune(Inverse *m, const Params *params, Fault *fault) {
    const double F_ext = m->state.F_ext_at_start;
    if (!check_inverse(params, fault) || !domain_check_loading(params, &m->transmission, F_ext, fault)) return false;
    const double z = transmission_z(&m->transmission, m->state.cam);
    const double jump = spring_energy(&params->spring, z) - spring_energy(&m->params.spring, z);
    if (m->params.ledger && jump != 0.0) sum_add(&m->state.ledger.work_tuning, jump);
    m->params = *params;
    return true;
}

/* ---- the step ---- */

/* Angle and speed are those of the latest communication point: cam 2 does not move, whatever this speed is. */
static bool is_repetition(const Inverse *m, GivenInput given) {
    const InverseInputs *u = &m->inputs;
    return given == GIVEN_ENDS && u->theta[0] == m->state.theta && u->omega[0] == m->state.omega;
}

static ImposedMotion motion_of(const Inverse *m, GivenInput given, double h) {
    if (is_repetition(m, given)) {
        ImposedMotion rest = imposed_motion_over(&m->inputs, GIVEN_ENDS, m->state.theta, 0.0, h);
        rest.theta = (Bernstein){0, {m->state.theta}};
        rest.dtheta_ds = rest.d2theta_ds2 = (Bernstein){0, {0.0}};
        return rest;
    }
    return imposed_motion_over(&m->inputs, given, m->state.theta, m->state.omega, h);
}

static bool is_finite(const ImposedMotion *motion) {
    double sum = 0.0;
    for (int i = 0; i <= motion->theta.degree; i++) sum += motion->theta.c[i];
    for (int i = 0; i <= motion->dtheta_ds.degree; i++) sum += motion->dtheta_ds.c[i] / motion->h;
    for (int i = 0; i <= motion->d2theta_ds2.degree; i++) sum += motion->d2theta_ds2.c[i] / motion->h / motion->h;
    for (int i = 0; i <= motion->F_ext.degree; i++) sum += motion->F_ext.c[i];
    return isfinite(sum);
}

static bool check_motion(const Inverse *m, const ImposedMotion *motion, double h, Fault *fault) {
    if (is_finite(motion))
        return inverse_reaches(m, motion->theta.c[0], fault) &&
               inverse_reaches(m, motion->theta.c[motion->theta.degree], fault);
    snprintf(fault->text, sizeof fault->text,
             "the motion to theta = %s, omega = %s within %s s is not finite; allowed are inputs that make finite "
             "theta, omega, alpha and F_ext",
             shortest_decimal(m->inputs.theta[0]).text, shortest_decimal(m->inputs.omega[0]).text,
             shortest_decimal(h).text);
    return false;
}

static bool check_ledger(const Ledger *l, double h, double theta, Fault *fault) {
    const double sum =
        l->work_in.hi + l->work_ext.hi + l->heat_cam[0].hi + l->heat_cam[1].hi + l->heat_damper.hi + l->heat_shaft.hi;
    if (isfinite(sum)) return true;
    snprintf(fault->text, sizeof fault->text,
             "step of %s s to theta = %s: energy.work_in or another account is not finite; allowed is motion with "
             "finite energy",
             shortest_decimal(h).text, shortest_decimal(theta).text);
    return false;
}

/* Moves `next` along the motion. */
static bool follow(const Inverse *m, const ImposedMotion *motion, bool repeats, double omega, InverseState *next,
                   Fault *fault) {
    if (has_elastic_shaft(m)) return elastic_shaft_advance(m, motion, omega, next, fault);
    return repeats || rigid_shaft_advance(m, motion, omega, next, fault);
}

/* The same with a limit of work. */
static bool follow_within_limit(Inverse *m, const ImposedMotion *motion, bool repeats, double omega, InverseState *next,
                                Fault *fault) {
    Work work = work_of_call(m->work_limit);
    m->work = &work;
    const bool done = follow(m, motion, repeats, omega, next, fault);
    m->work = NULL;
    if (!work_is_spent(&work)) return done;
    snprintf(fault->text, sizeof fault->text,
             "step of %s s to theta = %s needs too many evaluations of the motion; allowed are %d",
             shortest_decimal(motion->h).text, shortest_decimal(m->inputs.theta[0]).text, (int)work.most);
    return false;
}

bool inverse_advance(Inverse *m, double h, GivenInput given, Fault *fault) {
    const ImposedMotion motion = motion_of(m, given, h);
    if (!check_motion(m, &motion, h, fault)) return false;
    const bool repeats = is_repetition(m, given);
    InverseInputs inputs = m->inputs;
    imposed_motion_finish(&motion, given, &inputs);
    InverseState next = m->state;
    if (!follow_within_limit(m, &motion, repeats, inputs.omega[0], &next, fault)) return false;
    if (!check_ledger(&next.ledger, h, inputs.theta[0], fault)) return false;
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
    return m->state.direction * m->inputs.omega[0] + LATE_SPEED;
}
