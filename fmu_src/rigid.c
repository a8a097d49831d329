#include "rigid.h"

#include <math.h>
#include <stdio.h>

#include "flow.h"
#include "root.h"
#include "survey.h"

/* A stop may be passed by this share of the way between the stops. */
static const double STOP_ROUNDING = 1e-9;

static int sign_of(double x) {
    return (x > 0.0) - (x < 0.0);
}

double rigid_slack(const StopParams *stop) {
    return STOP_ROUNDING * (stop->upper - stop->lower);
}

/* ---- one instant ---- */

Moment rigid_present(const Inverse *m) {
    const int direction = m->continuous ? 0 : sign_of(m->inputs.omega[0]);
    return (Moment){
        .theta = m->inputs.theta[0],
        .omega = m->inputs.omega[0],
        .alpha = m->inputs.alpha[0],
        .F_ext = m->inputs.F_ext[0],
        .direction = direction != 0 ? direction : m->state.direction,
    };
}

/* A and W of the mechanism page's section 6. */
static Burden burden_of(const Params *p, const Station *s, const Moment *now, double damper) {
    const Geometry *g = &s->geometry;
    const double square = now->omega * now->omega;
    const double spring = spring_force(&p->spring, s->z);
    const double axial[4] = {spring, now->F_ext, damper,
                             p->inertia.follower_mass * (g->lift * now->alpha + s->lift_rate * square)};
    const double twist[2] = {p->inertia.follower * g->turn[0] * now->alpha,
                             p->inertia.follower * s->turn_rate * square};
    Burden b = {.axial_size = fabs(p->spring.preload)}; /* the spring's force may be a difference */
    for (int k = 0; k < 4; k++) {
        b.axial += axial[k];
        b.axial_size += fabs(axial[k]);
    }
    for (int k = 0; k < 2; k++) {
        b.twist += twist[k];
        b.twist_size += fabs(twist[k]);
    }
    return b;
}

bool rigid_effort(const Params *p, const Piece *piece, const Moment *now, Effort *out) {
    out->station = station_at(p, piece, now->theta);
    out->damper = damper_force(&p->damper, now->direction, out->station.geometry.lift * now->omega);
    out->burden = burden_of(p, &out->station, now, out->damper);
    if (!station_bearing(&out->station, now->direction, &out->burden, &out->bearing)) return false;
    out->tau = out->bearing.torque + p->shaft.damping * now->omega + p->inertia.shaft * now->alpha;
    return isfinite(out->tau);
}

double rigid_kinetic(const Params *p, const Station *s, double omega) {
    return kinetic_energy_of(&p->inertia, s->geometry.lift, s->geometry.turn[0], omega);
}

void rigid_describe_wedge(Fault *fault, const Moment *now) {
    snprintf(fault->text, sizeof fault->text,
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
    const Piece *piece;
    int direction;
    bool slow; /* the way is gone without speed */
} Way;

static Moment moment_on(const Way *way, double s) {
    return (Moment){
        .theta = imposed_theta(way->motion, s),
        .omega = way->slow ? 0.0 : imposed_omega(way->motion, s),
        .alpha = way->slow ? 0.0 : imposed_alpha(way->motion, s),
        .F_ext = bernstein_value(&way->motion->F_ext, s),
        .direction = way->direction,
    };
}

static void look(const void *scene, double s, Reading *out) {
    const Way *way = scene;
    const Params *p = &way->m->params;
    const Moment now = moment_on(way, s);
    Effort effort;
    *out = (Reading){.branch = -1};
    if (!rigid_effort(p, way->piece, &now, &effort)) return;
    const double turning = bernstein_value(&way->motion->turning, s); /* dtheta/ds */
    const Geometry *g = &effort.station.geometry;
    out->branch = flank_branch(effort.bearing.flank);
    out->rate[RATE_WORK_IN] = effort.tau * turning;
    out->rate[RATE_WORK_EXT] = now.F_ext * g->lift * turning;
    out->rate[RATE_HEAT_CAM1] = station_heat(&effort.station, &effort.bearing, 0) * fabs(turning);
    out->rate[RATE_HEAT_CAM2] = station_heat(&effort.station, &effort.bearing, 1) * fabs(turning);
    out->rate[RATE_HEAT_DAMPER] = effort.damper * g->lift * turning;
    out->rate[RATE_HEAT_SHAFT] = p->shaft.damping * now.omega * turning;
    out->size[SIZE_TORQUE] = fabs(effort.tau);
    out->size[SIZE_OMEGA] = fabs(now.omega);
    for (int i = 0; i < 2; i++)
        out->size[SIZE_REACTION1 + i] = fabs(effort.bearing.x[i]) * cam_length(g, i) / p->contacts;
}

typedef struct {
    Way way;
    InverseState *next;
    Survey survey;
    Fault *fault;
} Walk;

/* Rest lasts for an instant at least where the direction changes, so that counts twice: the number of mode changes
 * does not depend on where steps end. */
static void enter(InverseState *state, Mode mode) {
    if (state->mode == mode) return;
    state->events += state->mode != MODE_STICK && mode != MODE_STICK ? 2 : 1;
    state->mode = mode;
}

static bool is_wedged(Walk *w) {
    const Moment now = moment_on(&w->way, w->survey.bad);
    rigid_describe_wedge(w->fault, &now);
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
static bool go(Walk *w, double a, double b) {
    const Course *course = &w->way.m->course;
    const int direction = w->way.direction;
    const double end = imposed_theta(w->way.motion, b);
    w->next->direction = direction;
    enter(w->next, direction > 0 ? MODE_LOADING : MODE_RELEASING);
    w->way.piece = course_piece(course, imposed_theta(w->way.motion, a), direction);
    const Piece *const last = direction > 0 ? course->piece + course->count - 1 : course->piece;
    while (w->way.piece != last) {
        const double border = direction > 0 ? w->way.piece->upper : w->way.piece->lower;
        if (direction * (end - border) <= 0.0) break;
        const double c = place_of(w->way.motion, border, a, b);
        if (!survey_way(&w->survey, a, c)) return is_wedged(w);
        w->way.piece += direction;
        a = c;
    }
    return survey_way(&w->survey, a, b) || is_wedged(w);
}

static double kinetic_at(const Walk *w, double theta, double omega) {
    const Inverse *m = w->way.m;
    const Station station = station_at(&m->params, course_piece(&m->course, theta, 0), theta);
    return rigid_kinetic(&m->params, &station, omega);
}

static double kinetic_on(const Walk *w, double s) {
    return kinetic_at(w, imposed_theta(w->way.motion, s), imposed_omega(w->way.motion, s));
}

/* One monotone part of the motion. What would lie beyond a stop is spent there at rest: the stop takes the kinetic
 * energy, and who imposes the motion gives it again. */
static bool go_between_stops(Walk *w, double a, double b) {
    const StopParams *stop = &w->way.m->params.stop;
    const Imposed *motion = w->way.motion;
    const double slack = rigid_slack(stop);
    const double lower = stop->lower - slack, upper = stop->upper + slack;
    const bool up = w->way.direction > 0;
    const double first = up ? lower : upper, second = up ? upper : lower;
    const int direction = w->way.direction;
    const bool starts_beyond = direction * (imposed_theta(motion, a) - first) < 0.0;
    const bool ends_beyond = direction * (imposed_theta(motion, b) - second) > 0.0;
    if (direction * (imposed_theta(motion, b) - first) <= 0.0) return true;
    if (direction * (imposed_theta(motion, a) - second) >= 0.0) return true;
    const double from = starts_beyond ? place_of(motion, first, a, b) : a;
    const double to = ends_beyond ? place_of(motion, second, a, b) : b;
    if (starts_beyond) w->survey.total[RATE_WORK_IN] += kinetic_on(w, from);
    if (!go(w, from, to)) return false;
    if (ends_beyond) {
        sum_add(&w->next->ledger.heat_stop, kinetic_on(w, to));
        enter(w->next, MODE_STICK);
    }
    return true;
}

static bool go_all(Walk *w) {
    const Imposed *motion = w->way.motion;
    double crossing[BERNSTEIN_MAX + 1];
    const int count = bernstein_crossings(&motion->turning, crossing);
    crossing[count] = 1.0;
    double a = 0.0;
    for (int k = 0; k <= count; k++) {
        const double b = crossing[k];
        w->way.direction = sign_of(bernstein_value(&motion->turning, 0.5 * (a + b)));
        if (w->way.direction != 0 && !go_between_stops(w, a, b)) return false;
        a = b;
    }
    return true;
}

/* Where the motion does not begin at the state's angle and speed, the way there is gone without speed, and the
 * kinetic energy given at once. */
static bool catch_up(Walk *w) {
    const Imposed *motion = w->way.motion;
    const double theta = motion->theta.c[0], start = motion->turning.c[0];
    const double before = w->next->theta, way = theta - before;
    if (way == 0.0 && start == w->next->omega * motion->h) return true;
    w->survey.total[RATE_WORK_IN] +=
        kinetic_at(w, theta, start / motion->h) - kinetic_at(w, before, w->next->omega);
    if (way == 0.0) return true;
    const Imposed slow = {.h = motion->h,
                          .theta = {1, {before, theta}},
                          .turning = {0, {way}},
                          .quickening = {0, {0.0}},
                          .F_ext = {0, {motion->F_ext.c[0]}}};
    w->way.motion = &slow;
    w->way.slow = true;
    w->way.direction = sign_of(way);
    const bool done = go(w, 0.0, 1.0);
    w->way.motion = motion;
    w->way.slow = false;
    return done;
}

static void book(InverseState *next, const Survey *survey) {
    const double *total = survey->total;
    const Booking booking = {
        .work_in = total[RATE_WORK_IN],
        .work_ext = total[RATE_WORK_EXT],
        .heat_cam = {total[RATE_HEAT_CAM1], total[RATE_HEAT_CAM2]},
        .heat_damper = total[RATE_HEAT_DAMPER],
        .heat_shaft = total[RATE_HEAT_SHAFT],
    };
    ledger_book(&next->ledger, &booking);
    next->ledger.peak = (Peaks){survey->peak[SIZE_TORQUE],
                                survey->peak[SIZE_OMEGA],
                                {survey->peak[SIZE_REACTION1], survey->peak[SIZE_REACTION2]}};
}

bool rigid_advance(const Inverse *m, const Imposed *motion, double omega, InverseState *next, Fault *fault) {
    const Peaks *peak = &next->ledger.peak;
    const Ledger before = next->ledger;
    Walk walk = {.way = {.m = m, .motion = motion}, .next = next, .fault = fault};
    walk.survey = (Survey){.look = look,
                           .scene = &walk.way,
                           .tolerance = m->params.tolerance,
                           .peak = {peak->torque, peak->omega, peak->reaction[0], peak->reaction[1]}};
    if (!catch_up(&walk) || !go_all(&walk)) return false;
    if (m->params.ledger) book(next, &walk.survey);
    else next->ledger = before;
    next->theta = motion->theta.c[motion->theta.degree];
    next->cam = next->theta;
    next->omega = omega;
    if (next->omega != 0.0) next->direction = sign_of(next->omega);
    enter(next, next->omega > 0.0 ? MODE_LOADING : next->omega < 0.0 ? MODE_RELEASING : MODE_STICK);
    return true;
}
