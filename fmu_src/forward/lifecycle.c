#include "forward/lifecycle.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "contact/check.h"
#include "forward/configuration.h"
#include "forward/decide.h"
#include "model/friction_law.h"
#include "numerics/tolerances.h"
#include "platform/attributes.h"

/* ---- model ---- */

/* A test defines DUALCAM_NO_CLOSED_FORM and compares the results: then helices are integrated like any other groove. */
#ifdef DUALCAM_NO_CLOSED_FORM
enum { USE_CLOSED_FORM = 0 };
#else
enum { USE_CLOSED_FORM = 1 };
#endif

void forget_cache(Cache *cache) {
    cache->rest.valid = false;
    cache->proposal = (StepProposal){INFINITY, 0};
    cache->is_decided = false;
    for (int i = 0; i < SLIP_MODE_COUNT; i++) cache->kernel[i].t = NAN;
}

/* Builds all that follows from params and transmission. */
static void build_model(Mechanism *m) {
    const Transmission *transmission = &m->model.transmission;
    m->model.friction_is_loaded = any_friction_depends_on_load(&m->params);
    m->model.closed_form =
        USE_CLOSED_FORM && transmission->straight && is_linear(&m->params) && !any_friction_varies(&m->params);
    if (any_friction_varies(&m->params))
        for (int i = 0; i < 2; i++) friction_prepare(&m->params, i, &m->model.law[i]);
    if (transmission->straight) {
        const double slope[2] = {transmission->piece->slope[0][0], transmission->piece->slope[0][1]};
        m->configuration = (Configuration){.geometry = cam_geometry(m->params.cam, slope)};
        m->configuration.band = contact_band(&m->configuration.geometry);
    }
    m->model.linear_slips = 0;
    update_configuration(m);
    forget_cache(&m->cache);
}

static bool check_mechanism(const Params *p, Fault *fault) {
    static const char inertia[] = "inertia.shaft > 0 (1e-6 kg.m2 will do)";
    return has_inertia(p) ||
           (check_speed_friction(p, "without inertia", inertia, fault) && check_damped_load(p, inertia, fault));
}

/* In the domain of docs/mechanism.md, section 3? */
static bool check_domain(const Params *p, const Transmission *transmission, double F_ext, Fault *fault) {
    return domain_check_loading(p, transmission, F_ext, fault) && domain_check_motion(p, transmission, F_ext, fault);
}

bool mechanism_rebuild(Mechanism *m, Fault *fault) {
    FrictionTables tables;
    if (!friction_tables_load(&m->params, &m->model.friction, m->resources, &tables, fault)) return false;
    const bool good =
        check_mechanism(&m->params, fault) && check_transmission(&m->params, m->resources, m->state.F_ext_at_start,
                                                                 check_domain, &m->model.transmission, fault);
    friction_tables_settle(&m->params, &m->model.friction, &tables, good);
    if (good) build_model(m);
    return good;
}

void mechanism_free(Mechanism *m) {
    transmission_free(&m->model.transmission);
    m->model.transmission = (Transmission){.count = 0};
    friction_tables_free(&m->model.friction);
}

/* ---- start ---- */

COLD static bool check_energy(const Mechanism *m, Fault *fault) {
    const double energy = stored_energy(m);
    if (fabs(energy) <= LARGEST_ENERGY) return true;
    const InitialParams *initial = &m->params.initial;
    snprintf(fault->text, sizeof fault->text,
             "initial.theta = %s, initial.omega = %s: spring and masses hold %g J; allowed are at most %g J",
             shortest_decimal(initial->theta).text, shortest_decimal(initial->omega).text, energy, LARGEST_ENERGY);
    return false;
}

bool mechanism_start(Mechanism *m, Fault *fault) {
    const Params *p = &m->params;
    m->state.F_ext_at_start = m->inputs.F_ext[0];
    if (!mechanism_rebuild(m, fault) || !check_initial(p, fault)) return false;
    m->state = (State){
        .theta = sum_of(m->params.initial.theta),
        .omega = sum_of(has_inertia(&m->params) ? m->params.initial.omega : 0.0),
        .mode = MODE_STICK,
        .flank = {1, 1},
        .F_ext_at_start = m->inputs.F_ext[0],
        .friction_class = (int)domain_class(p, &m->model.transmission, m->inputs.F_ext[0]),
    };
    update_configuration(m);
    if (!check_energy(m, fault)) return false;
    ledger_open(&m->state.ledger, stored_energy(m));
    enter_decided_mode(m);
    m->state.events = 0;
    return true;
}

/* ---- tuning ---- */

static CamTunables tunables_of_cam(const CamParams *cam) {
    const FrictionParams *law = &cam->law;
    return (CamTunables){
        .friction = cam->friction,
        .peak = law->peak,
        .stribeck_velocity = law->stribeck_velocity,
        .stribeck_exponent = law->stribeck_exponent,
        .viscous = law->viscous,
        .load_exponent = law->load_exponent,
        .load = law->load,
        .wear = cam->wear,
    };
}

static void restore_cam(const CamTunables *t, CamParams *cam) {
    cam->friction = t->friction;
    cam->law = (FrictionParams){
        .peak = t->peak,
        .stribeck_velocity = t->stribeck_velocity,
        .stribeck_exponent = (int)t->stribeck_exponent,
        .viscous = t->viscous,
        .load_exponent = t->load_exponent,
        .load = t->load,
        .table = cam->law.table,
    };
    cam->wear = t->wear;
}

static Tunables tunables_of(const Params *p) {
    return (Tunables){{tunables_of_cam(&p->cam[0]), tunables_of_cam(&p->cam[1])}, p->spring, p->damper};
}

/* Keeps the parameters of the latest step, so that the step can be repeated after they have changed. */
static void remember_tunables(Mechanism *m, const Params *next) {
    const Tunables before = tunables_of(&m->params), after = tunables_of(next);
    State *s = &m->state;
    if (!(s->step.h > 0.0) || s->step.retuned || memcmp(&before, &after, sizeof before) == 0) return;
    s->tunables = before;
    s->step.retuned = 1;
}

bool mechanism_retune(Mechanism *m, const Params *params, Fault *fault) {
    const double F_ext = m->state.F_ext_at_start;
    if (!check_mechanism(params, fault) || !check_domain(params, &m->model.transmission, F_ext, fault)) return false;
    const double z = m->configuration.z;
    const double jump = spring_energy(&params->spring, z) - spring_energy(&m->params.spring, z);
    if (m->params.ledger && jump != 0.0) sum_add(&m->state.ledger.work_tuning, jump);
    remember_tunables(m, params);
    m->params = *params;
    build_model(m);
    return true;
}

COLD void mechanism_rewind(Mechanism *m) {
    State *s = &m->state;
    const Step *step = &s->step;
    s->theta = step->theta;
    s->omega = step->omega;
    s->mode = step->mode;
    s->energy_gained = step->energy_gained;
    memcpy(s->flank, step->flank, sizeof s->flank);
    m->inputs = step->inputs;
    if (!step->retuned) {
        update_configuration(m);
        forget_cache(&m->cache);
        return;
    }
    const Tunables *t = &s->tunables;
    for (int i = 0; i < 2; i++) restore_cam(&t->cam[i], &m->params.cam[i]);
    m->params.spring = t->spring;
    m->params.damper = t->damper;
    build_model(m);
}
