#include "inverse/rigid_shaft.h"

#include <float.h>
#include <math.h>
#include <stdio.h>

#include "elementary/elementary.h"
#include "inverse/step_booking.h"
#include "model/elements.h"
#include "numerics/root.h"
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

/* ---- one step ---- */

/* A part of the motion in one direction, on one piece of the transmission. */
typedef struct {
    const Inverse *m;
    const ImposedMotion *motion;
    const TransmissionPiece *piece;
    int direction;
    bool without_speed; /* the part is passed quasi-statically: omega = alpha = 0 */
} MotionPart;

typedef struct {
    MotionPart part;
    InverseState *next;
    Quadrature quadrature;
    Fault *fault;
} RigidStep;

/* ---- work and heat along a part ---- */

static OperatingPoint operating_point_on(const MotionPart *part, double s) {
    return (OperatingPoint){
        .theta = imposed_theta(part->motion, s),
        .omega = part->without_speed ? 0.0 : imposed_omega(part->motion, s),
        .alpha = part->without_speed ? 0.0 : imposed_alpha(part->motion, s),
        .F_ext = bernstein_value(&part->motion->F_ext, s),
        .direction = part->direction,
    };
}

/* Work and heat per unit of s. */
static void motion_integrand(const void *scene, double s, QuadratureSample *out) {
    const MotionPart *part = scene;
    const Params *p = &part->m->params;
    const OperatingPoint at = operating_point_on(part, s);
    RequiredTorque required;
    *out = (QuadratureSample){.branch = -1};
    work_add(part->m->work, 1);
    if (work_is_spent(part->m->work) || !rigid_shaft_required_torque(p, part->piece, &at, &required)) return;
    const double dtheta_ds = bernstein_value(&part->motion->dtheta_ds, s);
    const Geometry *g = &required.statics.geometry;
    out->branch = flank_branch(required.forces.flank);
    out->rate[RATE_WORK_IN] = required.tau * dtheta_ds;
    out->rate[RATE_WORK_EXT] = at.F_ext * g->dz_dtheta * dtheta_ds;
    out->rate[RATE_HEAT_CAM1] = contact_statics_heat(&required.statics, &required.forces, 0) * fabs(dtheta_ds);
    out->rate[RATE_HEAT_CAM2] = contact_statics_heat(&required.statics, &required.forces, 1) * fabs(dtheta_ds);
    out->rate[RATE_HEAT_DAMPER] = required.damper * g->dz_dtheta * dtheta_ds;
    out->rate[RATE_HEAT_SHAFT] = p->shaft.damping * at.omega * dtheta_ds;
    out->size[SIZE_TORQUE] = fabs(required.tau);
    out->size[SIZE_OMEGA] = fabs(at.omega);
    for (int i = 0; i < 2; i++) {
        out->size[SIZE_REACTION1 + i] = fabs(required.forces.x[i]) * cam_length(g, i) / p->contacts;
        if (has_wear(p))
            out->rate[RATE_SLIDING1 + i] =
                contact_statics_sliding(&required.statics, &required.forces, i) * fabs(dtheta_ds);
    }
}

static bool integrate(RigidStep *step, double a, double b) {
    if (quadrature_over(&step->quadrature, a, b)) return true;
    const OperatingPoint at = operating_point_on(&step->part, step->quadrature.bad);
    rigid_shaft_describe_wedge(step->fault, &at);
    return false;
}

/* ---- parts of the motion ---- */

/* A reversal passes through rest, if only for an instant, so it counts as two mode changes. Then the number of mode
 * changes does not depend on where steps end. */
static void enter_mode(InverseState *state, Mode mode) {
    if (state->mode == mode) return;
    state->events += state->mode != MODE_STICK && mode != MODE_STICK ? 2 : 1;
    state->mode = mode;
}

typedef struct {
    const Bernstein *theta;
    double level; /* rad */
} LevelCrossing;

/* A ScalarFunction of a LevelCrossing. */
static double above_level(const void *scene, double s) {
    const LevelCrossing *c = scene;
    return bernstein_value(c->theta, s) - c->level;
}

/* The s between a and b at which theta passes `level`. */
static double crossing_of(const ImposedMotion *motion, double level, double a, double b) {
    const LevelCrossing c = {&motion->theta, level};
    return root_between(above_level, &c, a, above_level(&c, a), b, above_level(&c, b));
}

/* From s = a to b, in one direction and inside the stops: one piece of the transmission after another. */
static bool follow_part(RigidStep *step, double a, double b) {
    MotionPart *part = &step->part;
    const Transmission *transmission = &part->m->transmission;
    const int direction = part->direction;
    const double end = imposed_theta(part->motion, b);
    step->next->direction = direction;
    enter_mode(step->next, direction > 0 ? MODE_LOADING : MODE_RELEASING);
    part->piece = transmission_piece(transmission, imposed_theta(part->motion, a), direction);
    const TransmissionPiece *const last =
        direction > 0 ? transmission->piece + transmission->count - 1 : transmission->piece;
    while (part->piece != last) { /* at most one turn per piece */
        const double breakpoint = direction > 0 ? part->piece->upper : part->piece->lower;
        if (direction * (end - breakpoint) <= 0.0) break;
        const double c = crossing_of(part->motion, breakpoint, a, b);
        if (!integrate(step, a, c)) return false;
        part->piece += direction;
        a = c;
    }
    return integrate(step, a, b);
}

static double kinetic_energy_at(const RigidStep *step, double theta, double omega) {
    const Inverse *m = step->part.m;
    const ContactStatics statics = contact_statics_at(&m->params, inverse_piece(m, theta, 0), theta);
    return rigid_shaft_kinetic_energy(&m->params, &statics, omega);
}

static double kinetic_energy_on(const RigidStep *step, double s) {
    return kinetic_energy_at(step, imposed_theta(step->part.motion, s), imposed_omega(step->part.motion, s));
}

/* One monotone part of the motion. While the polynomial lies beyond a stop, cam 2 rests there. The stop takes the
 * kinetic energy; the imposed motion gives it back when it returns. */
static bool follow_between_stops(RigidStep *step, double a, double b) {
    const StopParams *stop = &step->part.m->params.stop;
    const ImposedMotion *motion = step->part.motion;
    const double margin = rigid_shaft_stop_margin(stop);
    const double lower = stop->lower - margin, upper = stop->upper + margin;
    const int direction = step->part.direction;
    const double first = direction > 0 ? lower : upper, second = direction > 0 ? upper : lower;
    const bool starts_beyond = direction * (imposed_theta(motion, a) - first) < 0.0;
    const bool ends_beyond = direction * (imposed_theta(motion, b) - second) > 0.0;
    if (direction * (imposed_theta(motion, b) - first) <= 0.0) return true;
    if (direction * (imposed_theta(motion, a) - second) >= 0.0) return true;
    const double from = starts_beyond ? crossing_of(motion, first, a, b) : a;
    const double to = ends_beyond ? crossing_of(motion, second, a, b) : b;
    if (starts_beyond) step->quadrature.total[RATE_WORK_IN] += kinetic_energy_on(step, from);
    if (!follow_part(step, from, to)) return false;
    if (ends_beyond) {
        sum_add(&step->next->ledger.heat_stop, kinetic_energy_on(step, to));
        enter_mode(step->next, MODE_STICK);
    }
    return true;
}

static bool follow_motion(RigidStep *step) {
    const Bernstein *dtheta_ds = &step->part.motion->dtheta_ds;
    double crossing[BERNSTEIN_MAX + 1];
    const int count = bernstein_crossings(dtheta_ds, crossing);
    crossing[count] = 1.0;
    double a = 0.0;
    for (int k = 0; k <= count; k++) {
        const double b = crossing[k];
        step->part.direction = sign_of(bernstein_value(dtheta_ds, 0.5 * (a + b)));
        if (step->part.direction != 0 && !follow_between_stops(step, a, b)) return false;
        a = b;
    }
    return true;
}

/* Where the motion does not begin at the state's angle and speed, cam 2 first goes to its begin without speed, and the
 * kinetic energy changes at once. */
static bool go_to_begin_of_motion(RigidStep *step) {
    const ImposedMotion *motion = step->part.motion;
    const double theta = motion->theta.c[0], start = motion->dtheta_ds.c[0];
    const double before = step->next->theta, distance = theta - before;
    if (distance == 0.0 && start == step->next->omega * motion->h) return true;
    step->quadrature.total[RATE_WORK_IN] +=
        kinetic_energy_at(step, theta, start / motion->h) - kinetic_energy_at(step, before, step->next->omega);
    if (distance == 0.0) return true;
    const ImposedMotion slow = {.h = motion->h,
                                .theta = {1, {before, theta}},
                                .dtheta_ds = {0, {distance}},
                                .d2theta_ds2 = {0, {0.0}},
                                .F_ext = {0, {motion->F_ext.c[0]}}};
    step->part.motion = &slow;
    step->part.without_speed = true;
    step->part.direction = sign_of(distance);
    const bool done = follow_part(step, 0.0, 1.0);
    step->part.motion = motion;
    step->part.without_speed = false;
    return done;
}

/* ---- swings beyond the stops ---- */

/* rad per step, the largest coefficient: |dtheta/ds| is nowhere larger. */
static double fastest_of(const ImposedMotion *motion) {
    const Bernstein *dtheta_ds = &motion->dtheta_ds;
    double fastest = 0.0;
    for (int k = 0; k <= dtheta_ds->degree; k++) fastest = max_of(fastest, fabs(dtheta_ds->c[k]));
    return fastest;
}

/* rad per step. The place s in the step is known to a rounding of 1, so that theta is known to this share of dtheta/ds.
 * Between two angles inside the stops a motion may swing far beyond the stops. The motion then passes the angles
 * between the stops so fast that theta, and with it the energies, can have fewer digits than the tolerance. */
static double fastest_allowed(const Params *p) {
    return p->tolerance * (p->stop.upper - p->stop.lower) / DBL_EPSILON;
}

static void describe_swing(const Inverse *m, const ImposedMotion *motion, double omega, Fault *fault) {
    snprintf(fault->text, sizeof fault->text,
             "step of %s s to theta = %s, omega = %s: the imposed motion swings beyond the stops at up to %.3g rad per "
             "step, too fast for the tolerance; allowed are %.3g rad per step, as with a shorter step or a smaller "
             "omega",
             shortest_decimal(motion->h).text, shortest_decimal(motion->theta.c[motion->theta.degree]).text,
             shortest_decimal(omega).text, fastest_of(motion), fastest_allowed(&m->params));
}

bool rigid_shaft_advance(const Inverse *m, const ImposedMotion *motion, double omega, InverseState *next,
                         Fault *fault) {
    if (fastest_of(motion) > fastest_allowed(&m->params)) {
        describe_swing(m, motion, omega, fault);
        return false;
    }
    const Ledger before = next->ledger;
    RigidStep step = {.part = {.m = m, .motion = motion}, .next = next, .fault = fault};
    step.quadrature = step_booking_begin(m, &next->ledger);
    step.quadrature.integrand = motion_integrand;
    step.quadrature.scene = &step.part;
    if (!go_to_begin_of_motion(&step) || !follow_motion(&step)) return false;
    if (m->params.ledger) step_booking_finish(m, &step.quadrature, 0.0, &next->ledger);
    else next->ledger = before;
    next->theta = motion->theta.c[motion->theta.degree];
    next->cam = next->theta;
    next->omega = omega;
    if (next->omega != 0.0) next->direction = sign_of(next->omega);
    enter_mode(next, rigid_shaft_mode(next->omega));
    return true;
}
