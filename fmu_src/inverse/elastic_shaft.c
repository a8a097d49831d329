#include "inverse/elastic_shaft.h"

#include <float.h>
#include <math.h>
#include <stdio.h>

#include "closed_form/linear_slip.h"
#include "numerics/quadrature.h"
#include "numerics/root.h"

enum {
    STRIDES = 64,    /* at least, from stop to stop */
    SOUNDINGS = 4,   /* per stride, in search of the place where cam 2 comes to rest */
    PLACES = 8,      /* per part of the way, in search of a snap */
    MAX_PARTS = 100, /* of the way from one stride to the next */
};

/* tau and the edge of the band are known to a few roundings; a difference below this share of their size is none. */
static const double TIE = 16.0 * DBL_EPSILON;

static int sign_of(double x) {
    return (x > 0.0) - (x < 0.0);
}

/* ---- the edge of the band ---- */

typedef struct {
    const Inverse *m;
    const TransmissionPiece *piece;
    int direction;
    double F_ext; /* N */
    double theta; /* rad, of the far end */
    double level; /* how far theta has come, times direction; see passing_angle() */
} Edge;

typedef struct {
    ContactStatics statics;
    ContactForces forces;
    double F_0;    /* N */
    double torque; /* N.m; infinite where no torque moves cam 2 that way */
    bool finite;
} Brink;

static void brink_at(const Edge *e, double x, Brink *out) {
    out->statics = contact_statics_at(&e->m->params, e->piece, x);
    out->F_0 = spring_force(&e->m->params.spring, out->statics.z) + e->F_ext;
    out->finite = contact_statics_on_edge(&out->statics, e->direction, out->F_0, &out->forces);
    out->torque = out->finite ? out->forces.torque : (e->direction > 0 ? INFINITY : -INFINITY);
    if (out->F_0 == 0.0) out->torque = 0.0; /* no load, no friction, however locked */
}

static int branch_of(const Brink *b) {
    return b->finite ? flank_branch(b->forces.flank) : 4;
}

/* How far the shaft's torque is beyond the edge, N.m: > 0 moves cam 2 on. */
static double excess_at(const void *scene, double x) {
    const Edge *e = scene;
    Brink b;
    brink_at(e, x, &b);
    return e->direction * (e->m->params.shaft.stiffness * (e->theta - x) - b.torque);
}

static bool pushes(const Edge *e, double x) {
    Brink b;
    brink_at(e, x, &b);
    if (!isfinite(b.torque)) return false;
    const double K = e->m->params.shaft.stiffness;
    const double size = K * (fabs(e->theta) + fabs(x)) + fabs(b.torque);
    return e->direction * (K * (e->theta - x) - b.torque) > TIE * size;
}

/* The angle of the far end at which the edge is at x, times direction: cam 2 passes x when theta does that. */
static double passing_angle(const Edge *e, double x) {
    Brink b;
    brink_at(e, x, &b);
    return e->direction * (x + b.torque / e->m->params.shaft.stiffness);
}

/* How that grows as cam 2 goes on: 1 + E'/K with E' = d(rho F_0)/dx = rho' F_0 + rho F_s' z'. Below zero cam 2 cannot
 * stay: it snaps. */
static double rise_at(const Edge *e, const Brink *b) {
    const Params *p = &e->m->params;
    if (!b->finite) return 1.0;
    const double rate = contact_statics_drho_dtheta(&b->statics, e->direction, &b->forces) * b->F_0 +
                        b->forces.transfer.rho * spring_rate(&p->spring, b->statics.z) * b->statics.geometry.dz_dtheta;
    return 1.0 + rate / p->shaft.stiffness;
}

static double passing_rise(const void *scene, double x) {
    Brink b;
    brink_at(scene, x, &b);
    return rise_at(scene, &b);
}

/* ---- booking a way of cam 2 ---- */

/* Rates are per radian of x, which falls where cam 2 releases. While cam 2 is at x, theta is where the passing angle
 * is largest on the way so far: where it has fallen, the torque is beyond the edge. */
static void integrand(const void *scene, double x, QuadratureSample *out) {
    const Edge *e = scene;
    const Params *p = &e->m->params;
    Brink b;
    brink_at(e, x, &b);
    *out = (QuadratureSample){.branch = -1};
    if (!isfinite(b.torque)) return;
    const double snapping = p->shaft.stiffness * (e->direction * e->level - x);
    const bool snaps = e->direction * (snapping - b.torque) > 0.0;
    const double tau = snaps ? snapping : b.torque;
    out->branch = branch_of(&b) + 8 * snaps;
    out->rate[RATE_WORK_IN] = tau;
    out->rate[RATE_WORK_EXT] = e->F_ext * b.statics.geometry.dz_dtheta;
    out->rate[RATE_HEAT_DAMPER] = tau - b.torque;
    out->size[SIZE_TORQUE] = fabs(tau);
    for (int i = 0; i < 2 && b.finite; i++) {
        out->rate[RATE_HEAT_CAM1 + i] = e->direction * contact_statics_heat(&b.statics, &b.forces, i);
        out->size[SIZE_REACTION1 + i] = fabs(b.forces.x[i]) * cam_length(&b.statics.geometry, i) / p->contacts;
    }
}

static double sample_angle(double from, double to, int k) {
    return k == PLACES ? to : from + (to - from) * k / (int)PLACES;
}

/* Where it rises least between a and b, by golden section: there is one minimum. */
static double flattest(const Edge *e, double a, double b) {
    static const double RATIO = 0.61803398874989485;
    double left = b - RATIO * (b - a), right = a + RATIO * (b - a);
    double f_left = passing_rise(e, left), f_right = passing_rise(e, right);
    for (int i = 0; i < 50; i++) {
        if (f_left < f_right) {
            b = right;
            right = left;
            f_right = f_left;
            left = b - RATIO * (b - a);
            f_left = passing_rise(e, left);
        } else {
            a = left;
            left = right;
            f_left = f_right;
            right = a + RATIO * (b - a);
            f_right = passing_rise(e, right);
        }
    }
    return f_left < f_right ? left : right;
}

/* The passing angle and its rise at one place. */
typedef struct {
    double x, f, rise;
    int branch; /* which flanks bear, or 4: none */
} Sounding;

static Sounding sound(const Edge *e, double x) {
    Brink b;
    brink_at(e, x, &b);
    const double angle = e->direction * (x + b.torque / e->m->params.shaft.stiffness);
    return (Sounding){.x = x, .f = angle, .rise = rise_at(e, &b), .branch = branch_of(&b)};
}

/* Might it fall between two places at which it rises? A cubic's rise halfway decides, with some doubt. */
static bool may_dip(const Sounding *a, const Sounding *b) {
    const double halfway = 1.5 * (b->f - a->f) / fabs(b->x - a->x) - 0.25 * (a->rise + b->rise);
    return fmin(fmin(a->rise, b->rise), halfway) < 0.1 * fmax(fmax(a->rise, b->rise), halfway);
}

/* Does the passing angle leap down where other flanks take over between a and b? Then *before and *after are the
 * places on both sides: no double lies between. */
static bool leaps(const Edge *e, const Sounding *a, const Sounding *b, double *before, double *after) {
    if (a->branch == b->branch) return false;
    Sounding left = *a, right = *b;
    for (double x = 0.5 * (left.x + right.x); x != left.x && x != right.x; x = 0.5 * (left.x + right.x)) {
        const Sounding middle = sound(e, x);
        if (middle.branch == a->branch) left = middle;
        else right = middle;
    }
    *before = left.x;
    *after = right.x;
    return right.f < left.f - 4.0 * TIE * (fabs(left.f) + fabs(left.x));
}

/* Between two places: does it turn, from rising to falling or back, or leap down? */
static bool turns(const Edge *e, const Sounding *a, const Sounding *b, double *before, double *after) {
    if (leaps(e, a, b, before, after)) return true;
    Sounding last = *b;
    if (a->rise >= 0.0 && b->rise >= 0.0) {
        if (!may_dip(a, b)) return false;
        last = sound(e, flattest(e, a->x, b->x));
    }
    if ((a->rise >= 0.0) == (last.rise >= 0.0)) return false;
    *before = *after = root_between(passing_rise, e, a->x, a->rise, last.x, last.rise);
    return *before != a->x;
}

/* The first turn on a way: how far it goes on as it begins, and from where then. */
static void next_turn(const Edge *e, double from, double to, double *before, double *after) {
    Sounding a = sound(e, from);
    for (int k = 1; k <= PLACES; k++) {
        const Sounding b = sound(e, sample_angle(from, to, k));
        if (turns(e, &a, &b, before, after)) return;
        a = b;
    }
    *before = *after = to;
}

/* Books the way of cam 2 from one place to another on the same piece; e->level goes on from call to call. */
static bool book_way(Edge *e, Quadrature *quadrature, double from, double to) {
    quadrature->scene = e;
    for (int part = 0; part < MAX_PARTS && from != to; part++) {
        double before = to, after = to;
        if (part < MAX_PARTS - 1) next_turn(e, from, to, &before, &after);
        if (!quadrature_over(quadrature, from, before)) return false;
        e->level = fmax(e->level, passing_angle(e, before));
        from = after;
    }
    return true;
}

/* ---- moving ---- */

/* Cam 2 and where its moves are booked, if they are. */
typedef struct {
    const Inverse *m;
    double cam;
    double F_ext;
    double F_rate;          /* N/s, of F_ext; in a step it comes in stairs */
    Quadrature *quadrature; /* or NULL */
    bool moved;             /* since somebody cleared this */
} ElasticShaftCam;

static double stop_of(const Inverse *m, int direction) {
    return direction > 0 ? m->params.stop.upper : m->params.stop.lower;
}

/* The end of a stride from x: the piece's border, a stop, or a share of the way between the stops. */
static double stride_end(const Edge *e, double x) {
    const StopParams *stop = &e->m->params.stop;
    const double breakpoint =
        e->direction > 0 ? fmin(e->piece->upper, stop->upper) : fmax(e->piece->lower, stop->lower);
    const double stride = x + e->direction * (stop->upper - stop->lower) / (int)STRIDES;
    return e->direction * (stride - breakpoint) < 0.0 ? stride : breakpoint;
}

static double rest_between(const Edge *e, double a, double b) {
    return root_between(excess_at, e, a, excess_at(e, a), b, excess_at(e, b));
}

/* Where cam 2 comes to rest on the stride from x, or the stride's end with *rests = false. A summit of the passing
 * angle may hold it, however narrow what is left of it. */
static double rest_on_stride(const Edge *e, double x, double end, bool *rests) {
    Sounding a = sound(e, x);
    *rests = true;
    for (int k = 1; k <= SOUNDINGS; k++) {
        const Sounding b = sound(e, k == SOUNDINGS ? end : x + (end - x) * k / (int)SOUNDINGS);
        double summit, after;
        if (excess_at(e, b.x) <= 0.0) return rest_between(e, a.x, b.x);
        if (turns(e, &a, &b, &summit, &after) && excess_at(e, summit) <= 0.0) return rest_between(e, a.x, summit);
        a = b;
    }
    *rests = false;
    return end;
}

/* Moves cam 2 in `direction` as far as the shaft pushes it while the far end goes from one angle to another. */
static bool push(ElasticShaftCam *d, double theta_from, double theta_to, int direction) {
    Edge e = {.m = d->m, .direction = direction, .F_ext = d->F_ext, .theta = theta_to};
    const double stop = stop_of(d->m, direction);
    bool first = true, rests = false;
    while (!rests && direction * (stop - d->cam) > 0.0) {
        e.piece = transmission_piece(&d->m->transmission, d->cam, direction);
        if (!pushes(&e, d->cam)) break;
        if (first) e.level = fmax(direction * theta_from, passing_angle(&e, d->cam));
        first = false;
        const double end = stride_end(&e, d->cam);
        const double x = rest_on_stride(&e, d->cam, end, &rests);
        if (x == d->cam) break;
        if (d->quadrature != NULL && !book_way(&e, d->quadrature, d->cam, x)) return false;
        d->cam = x;
        d->moved = true;
    }
    return true;
}

/* After the load or the parameters changed while the far end stood still. */
static bool settle(ElasticShaftCam *d, double theta) {
    return push(d, theta, theta, 1) && push(d, theta, theta, -1);
}

static bool follow(ElasticShaftCam *d, double theta_from, double theta_to) {
    return settle(d, theta_from) &&
           (theta_from == theta_to || push(d, theta_from, theta_to, sign_of(theta_to - theta_from)));
}

/* ---- at a standstill ---- */

static Edge edge_of(const ElasticShaftCam *d, double theta, int direction) {
    return (Edge){.m = d->m,
                  .piece = transmission_piece(&d->m->transmission, d->cam, direction),
                  .direction = direction,
                  .F_ext = d->F_ext,
                  .theta = theta};
}

/* Is the torque on the edge in that direction (0), inside the band (-1) or beyond it (1)? */
static int side_of_edge(const Edge *e, double x, const Brink *b) {
    if (!isfinite(b->torque)) return -1;
    const double K = e->m->params.shaft.stiffness;
    const double size = K * (fabs(e->theta) + fabs(x)) + fabs(b->torque);
    const double beyond = e->direction * (K * (e->theta - x) - b->torque);
    return fabs(beyond) <= 4.0 * TIE * size ? 0 : sign_of(beyond);
}

bool elastic_shaft_is_on_edge(const Inverse *m, double cam, int direction, ContactForces *forces) {
    const ElasticShaftCam d = {.m = m, .cam = cam, .F_ext = m->inputs.F_ext[0]};
    const Edge e = edge_of(&d, m->inputs.theta[0], direction);
    Brink b;
    brink_at(&e, cam, &b);
    *forces = b.forces;
    return b.finite && direction * (stop_of(m, direction) - cam) > 0.0 && side_of_edge(&e, cam, &b) == 0;
}

/* At a stop and pressed into it, beyond the band. */
static bool is_stopped(const ElasticShaftCam *d, double theta, int direction) {
    if (direction * (stop_of(d->m, direction) - d->cam) > 0.0) return false;
    const Edge e = edge_of(d, theta, direction);
    Brink b;
    brink_at(&e, d->cam, &b);
    return side_of_edge(&e, d->cam, &b) > 0;
}

/* x = theta - E/K on the edge: dx/dtheta = 1/(1 + E'/K) */
static double following(const Edge *e, const Brink *b) {
    const double rise = rise_at(e, b);
    return rise > 0.0 ? 1.0 / rise : 0.0;
}

/* Does cam 2 slip in that direction while the far end turns at omega? The edge E = rho F_0 moves with F_ext. */
static bool slips(const ElasticShaftCam *d, double theta, double omega, int direction, Brink *b, double *speed) {
    const Edge e = edge_of(d, theta, direction);
    brink_at(&e, d->cam, b);
    const double ahead = b->finite ? omega - b->forces.transfer.rho * d->F_rate / d->m->params.shaft.stiffness : omega;
    *speed = ahead * following(&e, b);
    const bool free = direction * (stop_of(d->m, direction) - d->cam) > 0.0;
    return direction * ahead > 0.0 && free && side_of_edge(&e, d->cam, b) == 0;
}

/* The reactions as friction would share the load at rest, or as it does on the edge. */
static void describe(const ElasticShaftCam *d, double theta, double omega, ElasticShaftState *out) {
    const Params *p = &d->m->params;
    Brink b;
    double speed;
    int direction = omega < 0.0 ? -1 : 1;
    bool moves = slips(d, theta, omega, direction, &b, &speed);
    if (!moves && d->F_rate != 0.0) {
        direction = -direction;
        moves = slips(d, theta, omega, direction, &b, &speed);
    }
    const Mode rest = is_stopped(d, theta, 1)    ? MODE_UPPER_STOP
                      : is_stopped(d, theta, -1) ? MODE_LOWER_STOP
                                                 : MODE_STICK;
    *out = (ElasticShaftState){
        .cam = d->cam,
        .tau = p->shaft.stiffness * (theta - d->cam),
        .speed = moves ? speed : 0.0,
        .statics = b.statics,
        .mode = !moves          ? rest
                : direction > 0 ? MODE_LOADING
                                : MODE_RELEASING,
    };
    const Geometry *g = &b.statics.geometry;
    for (int i = 0; i < 2; i++) {
        const double frictionless = b.F_0 * g->dpsi_dtheta[i] / g->radius[i];
        out->reaction[i] = (moves && b.finite ? b.forces.x[i] : frictionless) * cam_length(g, i) / p->contacts;
    }
}

double elastic_shaft_start(const Inverse *m) {
    const StopParams *stop = &m->params.stop;
    const double theta = m->inputs.theta[0];
    ElasticShaftCam d = {.m = m, .cam = fmin(fmax(theta, stop->lower), stop->upper), .F_ext = m->inputs.F_ext[0]};
    settle(&d, theta);
    return d.cam;
}

void elastic_shaft_present(const Inverse *m, ElasticShaftState *out) {
    const double theta = m->inputs.theta[0];
    ElasticShaftCam d = {.m = m, .cam = m->state.cam, .F_ext = m->inputs.F_ext[0], .F_rate = m->inputs.F_ext[1]};
    follow(&d, m->state.theta, theta);
    describe(&d, theta, m->inputs.omega[0], out);
}

/* ---- the step ---- */

static double shaft_energy(const Inverse *m, double theta, double cam) {
    return 0.5 * m->params.shaft.stiffness * (theta - cam) * (theta - cam);
}

static void enter(InverseState *state, Mode mode) {
    if (state->mode == mode) return;
    state->events++;
    state->mode = mode;
}

typedef struct {
    ElasticShaftCam drag;
    Quadrature quadrature;
    InverseState *next;
} Tow;

static void record(Tow *t, double theta) {
    ElasticShaftState now;
    describe(&t->drag, theta, 0.0, &now);
    double *peak = t->quadrature.peak;
    peak[SIZE_TORQUE] = fmax(peak[SIZE_TORQUE], fabs(now.tau));
    for (int i = 0; i < 2; i++) peak[SIZE_REACTION1 + i] = fmax(peak[SIZE_REACTION1 + i], fabs(now.reaction[i]));
}

/* The far end goes to theta, in one direction. `opens`: the direction is a new one. */
static bool tow(Tow *t, double theta, double F_ext, bool opens) {
    InverseState *next = t->next;
    const int direction = sign_of(theta - next->theta);
    t->drag.F_ext = F_ext;
    if (!settle(&t->drag, next->theta)) return false;
    record(t, next->theta);
    if (direction == 0) return true;
    if (opens) {
        ElasticShaftState start;
        describe(&t->drag, next->theta, direction, &start);
        enter(next, start.mode);
    }
    t->drag.moved = false;
    if (!push(&t->drag, next->theta, theta, direction)) return false;
    if (t->drag.moved) {
        enter(next, direction > 0 ? MODE_LOADING : MODE_RELEASING);
        next->direction = direction;
    }
    next->theta = theta;
    record(t, theta);
    return true;
}

static bool is_constant(const Bernstein *p) {
    for (int i = 1; i <= p->degree; i++)
        if (p->c[i] != p->c[0]) return false;
    return true;
}

/* One monotone part of the motion. The stairs of F_ext at both ends are half as long, with the force that there is at
 * the very ends: so cam 2, while it slips, ends on the edge of the band. */
static bool tow_part(Tow *t, const Imposed *motion, double a, double b) {
    const int stairs = is_constant(&motion->F_ext) ? 0 : ELASTIC_SHAFT_STAIRS;
    for (int k = 0; k <= stairs; k++) {
        const double s = k == stairs ? b : a + (b - a) * (k + 0.5) / stairs;
        const double nearest = k == 0 ? a : a + (b - a) * k / stairs;
        if (!tow(t, imposed_theta(motion, s), bernstein_value(&motion->F_ext, nearest), k == 0)) return false;
    }
    return true;
}

static bool tow_all(Tow *t, const Imposed *motion) {
    double crossing[BERNSTEIN_MAX + 1], a = 0.0;
    const int count = bernstein_crossings(&motion->turning, crossing);
    crossing[count] = 1.0;
    if (!tow(t, motion->theta.c[0], motion->F_ext.c[0], true)) return false; /* with the force of this step */
    for (int k = 0; k <= count; k++) {
        if (!tow_part(t, motion, a, crossing[k])) return false;
        a = crossing[k];
    }
    return tow(t, motion->theta.c[motion->theta.degree], motion->F_ext.c[motion->F_ext.degree], false);
}

static void record_speed(Quadrature *quadrature, const Imposed *motion) {
    const double fastest = fabs(imposed_omega(motion, bernstein_peak(&motion->turning)));
    quadrature->peak[SIZE_OMEGA] = fmax(quadrature->peak[SIZE_OMEGA], fastest);
}

static void book(InverseState *next, const Quadrature *quadrature, double into_shaft) {
    const double *total = quadrature->total;
    const Booking booking = {
        .work_in = total[RATE_WORK_IN] + into_shaft,
        .work_ext = total[RATE_WORK_EXT],
        .heat_cam = {total[RATE_HEAT_CAM1], total[RATE_HEAT_CAM2]},
        .heat_damper = total[RATE_HEAT_DAMPER],
    };
    ledger_book(&next->ledger, &booking);
    next->ledger.peak = (Peaks){quadrature->peak[SIZE_TORQUE],
                                quadrature->peak[SIZE_OMEGA],
                                {quadrature->peak[SIZE_REACTION1], quadrature->peak[SIZE_REACTION2]}};
}

bool elastic_shaft_advance(const Inverse *m, const Imposed *motion, double omega, InverseState *next, Fault *fault) {
    const Peaks *peak = &next->ledger.peak;
    const double shaft_before = shaft_energy(m, next->theta, next->cam);
    Tow t = {.next = next};
    t.quadrature = (Quadrature){.integrand = integrand,
                                .tolerance = m->params.tolerance,
                                .peak = {peak->torque, peak->omega, peak->reaction[0], peak->reaction[1]}};
    t.drag = (ElasticShaftCam){.m = m, .cam = next->cam, .quadrature = m->params.ledger ? &t.quadrature : NULL};
    if (!tow_all(&t, motion)) {
        snprintf(fault->text, sizeof fault->text,
                 "theta = %.17g: cam 2 cannot pass %.17g rad, where the contacts wedge; allowed is motion short of it",
                 next->theta, t.quadrature.bad);
        return false;
    }
    record_speed(&t.quadrature, motion);
    next->cam = t.drag.cam;
    next->omega = omega;
    if (m->params.ledger) book(next, &t.quadrature, shaft_energy(m, next->theta, next->cam) - shaft_before);
    ElasticShaftState end;
    describe(&t.drag, next->theta, omega, &end);
    enter(next, end.mode);
    return true;
}
