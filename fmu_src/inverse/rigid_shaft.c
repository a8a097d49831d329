#include "inverse/rigid_shaft.h"

#include <math.h>
#include <stdio.h>

#include "closed_form/linear_slip.h"
#include "numerics/quadrature.h"
#include "numerics/root.h"

/* A stop may be passed by this share of the way between the stops. */
static const double STOP_ROUNDING = 1e-9;

static int sign_of(double x) {
    return (x > 0.0) - (x < 0.0);
}

double rigid_shaft_slack(const StopParams *stop) {
    return STOP_ROUNDING * (stop->upper - stop->lower);
}

/* ---- one instant ---- */

Instant rigid_shaft_present(const Inverse *m) {
    const int direction = m->continuous ? 0 : sign_of(m->inputs.omega[0]);
    return (Instant){
        .theta = m->inputs.theta[0],
        .omega = m->inputs.omega[0],
        .alpha = m->inputs.alpha[0],
        .F_ext = m->inputs.F_ext[0],
        .direction = direction != 0 ? direction : m->state.direction,
    };
}

/* A and W of the mechanism page's section 6. */
static Load load_of(const Params *p, const ContactStatics *s, const Instant *now, double damper) {
    const Geometry *g = &s->geometry;
    const double square = now->omega * now->omega;
    const double spring = spring_force(&p->spring, s->z);
    const double axial[4] = {spring, now->F_ext, damper,
                             p->inertia.follower_mass * (g->dz_dtheta * now->alpha + s->d2z_dtheta2 * square)};
    const double moment[2] = {p->inertia.follower * g->dpsi_dtheta[0] * now->alpha,
                              p->inertia.follower * s->d2gamma_dtheta2 * square};
    Load b = {.axial_size = fabs(p->spring.preload)}; /* the spring's force may be a difference */
    for (int k = 0; k < 4; k++) {
        b.axial += axial[k];
        b.axial_size += fabs(axial[k]);
    }
    for (int k = 0; k < 2; k++) {
        b.moment += moment[k];
        b.moment_size += fabs(moment[k]);
    }
    return b;
}

bool rigid_shaft_effort(const Params *p, const TransmissionPiece *piece, const Instant *now, Effort *out) {
    out->statics = contact_statics_at(p, piece, now->theta);
    out->damper = damper_force(&p->damper, now->direction, out->statics.geometry.dz_dtheta * now->omega);
    out->load = load_of(p, &out->statics, now, out->damper);
    if (!contact_statics_forces(&out->statics, now->direction, &out->load, &out->forces)) return false;
    out->tau = out->forces.torque + p->shaft.damping * now->omega + p->inertia.shaft * now->alpha;
    return isfinite(out->tau);
}

double rigid_shaft_kinetic(const Params *p, const ContactStatics *s, double omega) {
    return kinetic_energy_of(&p->inertia, s->geometry.dz_dtheta, s->geometry.dpsi_dtheta[0], omega);
}

void rigid_shaft_describe_wedge(Fault *fault, const Instant *now) {
    snprintf(
        fault->text, sizeof fault->text,
        "theta = %.17g, omega = %.17g, alpha = %.17g, F_ext = %.17g: the contacts wedge, no torque moves them in "
        "the %s direction there; allowed is motion in which each contact bears on a flank that its reaction agrees "
        "with",
        now->theta, now->omega, now->alpha, now->F_ext, now->direction > 0 ? "loading" : "releasing");
}

/* ---- along the motion ---- */

/* What a surveyor needs. */
typedef struct {
    const Inverse *m;
    const Imposed *motion;
    const TransmissionPiece *piece;
    int direction;
    bool slow; /* the way is gone without speed */
} PathPart;

static Instant moment_on(const PathPart *part, double s) {
    return (Instant){
        .theta = imposed_theta(part->motion, s),
        .omega = part->slow ? 0.0 : imposed_omega(part->motion, s),
        .alpha = part->slow ? 0.0 : imposed_alpha(part->motion, s),
        .F_ext = bernstein_value(&part->motion->F_ext, s),
        .direction = part->direction,
    };
}

static void integrand(const void *scene, double s, QuadratureSample *out) {
    const PathPart *part = scene;
    const Params *p = &part->m->params;
    const Instant now = moment_on(part, s);
    Effort effort;
    *out = (QuadratureSample){.branch = -1};
    if (!rigid_shaft_effort(p, part->piece, &now, &effort)) return;
    const double turning = bernstein_value(&part->motion->turning, s); /* dtheta/ds */
    const Geometry *g = &effort.statics.geometry;
    out->branch = flank_branch(effort.forces.flank);
    out->rate[RATE_WORK_IN] = effort.tau * turning;
    out->rate[RATE_WORK_EXT] = now.F_ext * g->dz_dtheta * turning;
    out->rate[RATE_HEAT_CAM1] = contact_statics_heat(&effort.statics, &effort.forces, 0) * fabs(turning);
    out->rate[RATE_HEAT_CAM2] = contact_statics_heat(&effort.statics, &effort.forces, 1) * fabs(turning);
    out->rate[RATE_HEAT_DAMPER] = effort.damper * g->dz_dtheta * turning;
    out->rate[RATE_HEAT_SHAFT] = p->shaft.damping * now.omega * turning;
    out->size[SIZE_TORQUE] = fabs(effort.tau);
    out->size[SIZE_OMEGA] = fabs(now.omega);
    for (int i = 0; i < 2; i++)
        out->size[SIZE_REACTION1 + i] = fabs(effort.forces.x[i]) * cam_length(g, i) / p->contacts;
}

typedef struct {
    PathPart part;
    InverseState *next;
    Quadrature quadrature;
    Fault *fault;
} Walker;

/* Rest lasts for an instant at least where the direction changes, so that counts twice: the number of mode changes
 * does not depend on where steps end. */
static void enter(InverseState *state, Mode mode) {
    if (state->mode == mode) return;
    state->events += state->mode != MODE_STICK && mode != MODE_STICK ? 2 : 1;
    state->mode = mode;
}

static bool is_wedged(Walker *w) {
    const Instant now = moment_on(&w->part, w->quadrature.bad);
    rigid_shaft_describe_wedge(w->fault, &now);
    return false;
}

typedef struct {
    const Bernstein *theta;
    double level;
} Crossing;

static double above(const void *scene, double s) {
    const Crossing *c = scene;
    return bernstein_value(c->theta, s) - c->level;
}

/* Where the angle is `level`, on a way from s = a to b on which it passes that. */
static double place_of(const Imposed *motion, double level, double a, double b) {
    const Crossing c = {&motion->theta, level};
    return root_between(above, &c, a, above(&c, a), b, above(&c, b));
}

/* From s = a to b, in one direction and inside the stops: piece after piece. */
static bool go(Walker *w, double a, double b) {
    const Transmission *transmission = &w->part.m->transmission;
    const int direction = w->part.direction;
    const double end = imposed_theta(w->part.motion, b);
    w->next->direction = direction;
    enter(w->next, direction > 0 ? MODE_LOADING : MODE_RELEASING);
    w->part.piece = transmission_piece(transmission, imposed_theta(w->part.motion, a), direction);
    const TransmissionPiece *const last =
        direction > 0 ? transmission->piece + transmission->count - 1 : transmission->piece;
    while (w->part.piece != last) {
        const double breakpoint = direction > 0 ? w->part.piece->upper : w->part.piece->lower;
        if (direction * (end - breakpoint) <= 0.0) break;
        const double c = place_of(w->part.motion, breakpoint, a, b);
        if (!quadrature_over(&w->quadrature, a, c)) return is_wedged(w);
        w->part.piece += direction;
        a = c;
    }
    return quadrature_over(&w->quadrature, a, b) || is_wedged(w);
}

static double kinetic_at(const Walker *w, double theta, double omega) {
    const Inverse *m = w->part.m;
    const ContactStatics statics =
        contact_statics_at(&m->params, transmission_piece(&m->transmission, theta, 0), theta);
    return rigid_shaft_kinetic(&m->params, &statics, omega);
}

static double kinetic_on(const Walker *w, double s) {
    return kinetic_at(w, imposed_theta(w->part.motion, s), imposed_omega(w->part.motion, s));
}

/* One monotone part of the motion. What would lie beyond a stop is spent there at rest: the stop takes the kinetic
 * energy, and who imposes the motion gives it again. */
static bool go_between_stops(Walker *w, double a, double b) {
    const StopParams *stop = &w->part.m->params.stop;
    const Imposed *motion = w->part.motion;
    const double slack = rigid_shaft_slack(stop);
    const double lower = stop->lower - slack, upper = stop->upper + slack;
    const bool up = w->part.direction > 0;
    const double first = up ? lower : upper, second = up ? upper : lower;
    const int direction = w->part.direction;
    const bool starts_beyond = direction * (imposed_theta(motion, a) - first) < 0.0;
    const bool ends_beyond = direction * (imposed_theta(motion, b) - second) > 0.0;
    if (direction * (imposed_theta(motion, b) - first) <= 0.0) return true;
    if (direction * (imposed_theta(motion, a) - second) >= 0.0) return true;
    const double from = starts_beyond ? place_of(motion, first, a, b) : a;
    const double to = ends_beyond ? place_of(motion, second, a, b) : b;
    if (starts_beyond) w->quadrature.total[RATE_WORK_IN] += kinetic_on(w, from);
    if (!go(w, from, to)) return false;
    if (ends_beyond) {
        sum_add(&w->next->ledger.heat_stop, kinetic_on(w, to));
        enter(w->next, MODE_STICK);
    }
    return true;
}

static bool go_all(Walker *w) {
    const Imposed *motion = w->part.motion;
    double crossing[BERNSTEIN_MAX + 1];
    const int count = bernstein_crossings(&motion->turning, crossing);
    crossing[count] = 1.0;
    double a = 0.0;
    for (int k = 0; k <= count; k++) {
        const double b = crossing[k];
        w->part.direction = sign_of(bernstein_value(&motion->turning, 0.5 * (a + b)));
        if (w->part.direction != 0 && !go_between_stops(w, a, b)) return false;
        a = b;
    }
    return true;
}

/* Where the motion does not begin at the state's angle and speed, the way there is gone without speed, and the
 * kinetic energy given at once. */
static bool catch_up(Walker *w) {
    const Imposed *motion = w->part.motion;
    const double theta = motion->theta.c[0], start = motion->turning.c[0];
    const double before = w->next->theta, part = theta - before;
    if (part == 0.0 && start == w->next->omega * motion->h) return true;
    w->quadrature.total[RATE_WORK_IN] +=
        kinetic_at(w, theta, start / motion->h) - kinetic_at(w, before, w->next->omega);
    if (part == 0.0) return true;
    const Imposed slow = {.h = motion->h,
                          .theta = {1, {before, theta}},
                          .turning = {0, {part}},
                          .quickening = {0, {0.0}},
                          .F_ext = {0, {motion->F_ext.c[0]}}};
    w->part.motion = &slow;
    w->part.slow = true;
    w->part.direction = sign_of(part);
    const bool done = go(w, 0.0, 1.0);
    w->part.motion = motion;
    w->part.slow = false;
    return done;
}

static void book(InverseState *next, const Quadrature *quadrature) {
    const double *total = quadrature->total;
    const Booking booking = {
        .work_in = total[RATE_WORK_IN],
        .work_ext = total[RATE_WORK_EXT],
        .heat_cam = {total[RATE_HEAT_CAM1], total[RATE_HEAT_CAM2]},
        .heat_damper = total[RATE_HEAT_DAMPER],
        .heat_shaft = total[RATE_HEAT_SHAFT],
    };
    ledger_book(&next->ledger, &booking);
    next->ledger.peak = (Peaks){quadrature->peak[SIZE_TORQUE],
                                quadrature->peak[SIZE_OMEGA],
                                {quadrature->peak[SIZE_REACTION1], quadrature->peak[SIZE_REACTION2]}};
}

bool rigid_shaft_advance(const Inverse *m, const Imposed *motion, double omega, InverseState *next, Fault *fault) {
    const Peaks *peak = &next->ledger.peak;
    const Ledger before = next->ledger;
    Walker walker = {.part = {.m = m, .motion = motion}, .next = next, .fault = fault};
    walker.quadrature = (Quadrature){.integrand = integrand,
                                     .scene = &walker.part,
                                     .tolerance = m->params.tolerance,
                                     .peak = {peak->torque, peak->omega, peak->reaction[0], peak->reaction[1]}};
    if (!catch_up(&walker) || !go_all(&walker)) return false;
    if (m->params.ledger) book(next, &walker.quadrature);
    else next->ledger = before;
    next->theta = motion->theta.c[motion->theta.degree];
    next->cam = next->theta;
    next->omega = omega;
    if (next->omega != 0.0) next->direction = sign_of(next->omega);
    enter(next, next->omega > 0.0 ? MODE_LOADING : next->omega < 0.0 ? MODE_RELEASING : MODE_STICK);
    return true;
}
