#include "inverse/elastic_shaft.h"

#include <math.h>
#include <stdio.h>

#include "elementary/elementary.h"
#include "inverse/band_edge.h"
#include "inverse/step_booking.h"
#include "model/friction_law.h"
#include "numerics/sign.h"
#include "numerics/tolerances.h"

static BandEdge edge_of(const ElasticCam *cam, double theta, int direction) {
    return (BandEdge){
        .params = &cam->m->params,
        .piece = inverse_piece(cam->m, cam->x, direction),
        .direction = direction,
        .F_ext = cam->F_ext,
        .theta = theta,
    };
}

static bool is_free(const ElasticCam *cam, int direction) {
    return direction * (stop_ahead(&cam->m->params.stop, direction) - cam->x) > 0.0;
}

bool elastic_shaft_is_on_edge(const Inverse *m, double x, int direction, ContactForces *forces) {
    const ElasticCam cam = {.m = m, .x = x, .F_ext = m->inputs.F_ext[0]};
    const BandEdge edge = edge_of(&cam, m->inputs.theta[0], direction);
    EdgePoint point;
    band_edge_at(&edge, x, &point);
    *forces = point.forces;
    return point.finite && is_free(&cam, direction) && band_edge_side(&edge, x, &point) == 0;
}

/* Is cam 2 at a stop, and pressed into the stop by a torque beyond the band? */
static bool is_stopped(const ElasticCam *cam, double theta, int direction) {
    if (is_free(cam, direction)) return false;
    const BandEdge edge = edge_of(cam, theta, direction);
    EdgePoint point;
    band_edge_at(&edge, cam->x, &point);
    return band_edge_side(&edge, cam->x, &point) > 0;
}

/* dx/dtheta of cam 2 on the edge: 1/(d theta_h/dx). */
static double speed_ratio(const BandEdge *edge, const EdgePoint *point) {
    const double slope = edge_point_slope(edge, point);
    return slope > 0.0 ? 1.0 / slope : 0.0;
}

/* Does cam 2 slip in this direction while the far end turns at omega? The edge E = rho F_0 moves with F_ext, so the far
 * end turns against the edge at omega - dE/dF_0 F_ext'/K. */
static bool slips(const ElasticCam *cam, double theta, double omega, int direction, EdgePoint *point, double *speed) {
    const BandEdge edge = edge_of(cam, theta, direction);
    band_edge_at(&edge, cam->x, point);
    const double against_edge =
        point->finite ? omega - point->forces.transfer.rho_rate * cam->F_ext_rate / edge.params->shaft.stiffness
                      : omega;
    *speed = against_edge * speed_ratio(&edge, point);
    return direction * against_edge > 0.0 && is_free(cam, direction) && band_edge_side(&edge, cam->x, point) == 0;
}

static Mode mode_at_rest(const ElasticCam *cam, double theta) {
    if (is_stopped(cam, theta, 1)) return MODE_UPPER_STOP;
    return is_stopped(cam, theta, -1) ? MODE_LOWER_STOP : MODE_STICK;
}

/* Cam 2 as it stands, while the far end is at theta and turns at omega. */
static void state_at(const ElasticCam *cam, double theta, double omega, ElasticShaftState *out) {
    const Params *p = &cam->m->params;
    EdgePoint point;
    double speed;
    int direction = omega < 0.0 ? -1 : 1;
    bool moves = slips(cam, theta, omega, direction, &point, &speed);
    if (!moves && cam->F_ext_rate != 0.0) {
        direction = -direction;
        moves = slips(cam, theta, omega, direction, &point, &speed);
    }
    const Mode slip_mode = direction > 0 ? MODE_LOADING : MODE_RELEASING;
    *out = (ElasticShaftState){
        .x = cam->x,
        .tau = p->shaft.stiffness * (theta - cam->x),
        .speed = moves ? speed : 0.0,
        .statics = point.statics,
        .mode = moves ? slip_mode : mode_at_rest(cam, theta),
    };
    Geometry *g = &out->statics.geometry;
    for (int i = 0; i < 2; i++) {
        const double frictionless = point.F_0 * g->dpsi_dtheta[i] / g->radius[i];
        out->reaction[i] = (moves && point.finite ? point.forces.x[i] : frictionless) * cam_length(g, i) / p->contacts;
        if (!moves) g->friction[i] = friction_at_rest(&p->cam[i], fabs(out->reaction[i]));
    }
}

double elastic_shaft_start(const Inverse *m) {
    const StopParams *stop = &m->params.stop;
    const double theta = m->inputs.theta[0];
    Work work = work_of_call(m->work_limit);
    ElasticCam cam = {.m = m, .F_ext = m->inputs.F_ext[0], .work = &work};
    cam.x = min_of(max_of(theta, stop->lower), stop->upper);
    elastic_cam_relax(&cam, theta);
    return work_is_spent(&work) ? NAN : cam.x;
}

void elastic_shaft_present(const Inverse *m, ElasticShaftState *out) {
    const double theta = m->inputs.theta[0];
    Work work = work_of_call(m->work_limit);
    ElasticCam cam = {.m = m, .x = m->state.cam, .F_ext = m->inputs.F_ext[0], .F_ext_rate = m->inputs.F_ext[1]};
    cam.work = &work;
    elastic_cam_follow(&cam, m->state.theta, theta);
    if (work_is_spent(&work)) cam.x = NAN;
    state_at(&cam, theta, m->inputs.omega[0], out);
}

/* ---- one step ---- */

typedef struct {
    ElasticCam cam;
    Quadrature quadrature;
    InverseState *next; /* theta, mode, events and direction go along with cam 2 */
} ElasticStep;

static void enter_mode(InverseState *state, Mode mode) {
    if (state->mode == mode) return;
    state->events++;
    state->mode = mode;
}

static void raise_peaks(ElasticStep *step, double theta) {
    ElasticShaftState now;
    state_at(&step->cam, theta, 0.0, &now);
    double *peak = step->quadrature.peak;
    peak[SIZE_TORQUE] = max_of(peak[SIZE_TORQUE], fabs(now.tau));
    for (int i = 0; i < 2; i++) peak[SIZE_REACTION1 + i] = max_of(peak[SIZE_REACTION1 + i], fabs(now.reaction[i]));
}

/* The far end goes to theta in one direction, at constant F_ext. `opens`: it begins a monotone part of the motion. */
static bool move_far_end(ElasticStep *step, double theta, double F_ext, bool opens) {
    ElasticCam *cam = &step->cam;
    InverseState *next = step->next;
    const int direction = sign_of(theta - next->theta);
    cam->F_ext = F_ext;
    if (!elastic_cam_relax(cam, next->theta)) return false;
    raise_peaks(step, next->theta);
    if (direction == 0) return true;
    if (opens) {
        ElasticShaftState start;
        state_at(cam, next->theta, direction, &start);
        enter_mode(next, start.mode);
    }
    cam->moved = false;
    if (!elastic_cam_slip(cam, next->theta, theta, direction)) return false;
    if (cam->moved) {
        enter_mode(next, direction > 0 ? MODE_LOADING : MODE_RELEASING);
        next->direction = direction;
    }
    next->theta = theta;
    raise_peaks(step, theta);
    return true;
}

static bool is_constant(const Bernstein *p) {
    for (int i = 1; i <= p->degree; i++)
        if (p->c[i] != p->c[0]) return false;
    return true;
}

/* One monotone part of the motion, from s = a to b. The first and the last interval of F_ext have half the length, and
 * F_ext is its value at a and at b there. So cam 2, while it slips, ends on the edge of the band. */
static bool follow_part(ElasticStep *step, const ImposedMotion *motion, double a, double b) {
    const int intervals = is_constant(&motion->F_ext) ? 0 : ELASTIC_FORCE_INTERVALS;
    for (int k = 0; k <= intervals; k++) {
        const double end = k == intervals ? b : a + (b - a) * (k + 0.5) / intervals;
        const double sample = k == 0 ? a : a + (b - a) * k / intervals;
        if (!move_far_end(step, imposed_theta(motion, end), bernstein_value(&motion->F_ext, sample), k == 0))
            return false;
    }
    return true;
}

static bool follow_motion(ElasticStep *step, const ImposedMotion *motion) {
    const Bernstein *theta = &motion->theta, *F_ext = &motion->F_ext;
    double crossing[BERNSTEIN_MAX + 1], a = 0.0;
    const int count = bernstein_crossings(&motion->dtheta_ds, crossing);
    crossing[count] = 1.0;
    if (!move_far_end(step, theta->c[0], F_ext->c[0], true)) return false; /* the inputs may have jumped */
    for (int k = 0; k <= count; k++) {
        if (!follow_part(step, motion, a, crossing[k])) return false;
        a = crossing[k];
    }
    return move_far_end(step, theta->c[theta->degree], F_ext->c[F_ext->degree], false);
}

static double shaft_energy(const Inverse *m, double theta, double x) {
    return 0.5 * m->params.shaft.stiffness * (theta - x) * (theta - x);
}

bool elastic_shaft_advance(const Inverse *m, const ImposedMotion *motion, double omega, InverseState *next,
                           Fault *fault) {
    const double shaft_before = shaft_energy(m, next->theta, next->cam);
    ElasticStep step = {.next = next, .quadrature = step_booking_begin(m, &next->ledger)};
    step.cam = (ElasticCam){.m = m, .x = next->cam, .work = m->work};
    if (m->params.ledger) step.cam.quadrature = &step.quadrature;
    if (!follow_motion(&step, motion)) {
        snprintf(fault->text, sizeof fault->text,
                 "theta = %s: cam 2 cannot pass the angle %s rad, where the contacts wedge; allowed is motion that "
                 "ends before this angle",
                 shortest_decimal(next->theta).text, shortest_decimal(step.quadrature.bad).text);
        return false;
    }
    const double fastest = fabs(imposed_omega(motion, bernstein_peak(&motion->dtheta_ds)));
    step.quadrature.peak[SIZE_OMEGA] = max_of(step.quadrature.peak[SIZE_OMEGA], fastest);
    next->cam = step.cam.x;
    next->omega = omega;
    if (m->params.ledger)
        step_booking_finish(m, &step.quadrature, shaft_energy(m, next->theta, next->cam) - shaft_before, &next->ledger);
    ElasticShaftState end;
    state_at(&step.cam, next->theta, omega, &end);
    enter_mode(next, end.mode);
    return true;
}
