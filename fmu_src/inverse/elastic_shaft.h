/* Inverse dynamics with an elastic shaft: the angle theta of its far end is imposed, and cam 2, at angle x, follows as
 * friction lets it (docs/mechanism.md, section 7). An end stop holds x against any torque that presses into it.
 *
 * Work: d(K (theta - x)^2/2) = tau (dtheta - dx), so work_in = change of the shaft's energy + integral of tau dx. */
#ifndef DUALCAM_ELASTIC_SHAFT_H
#define DUALCAM_ELASTIC_SHAFT_H

#include "inverse/contact_statics.h"
#include "inverse/elastic_cam.h"
#include "inverse/inverse_state.h"
#include "model/fault.h"

/* Cam 2, and what follows from its position. */
typedef struct {
    double x;           /* rad, angle of cam 2 */
    double speed;       /* rad/s, of cam 2 */
    double tau;         /* N.m */
    double reaction[2]; /* N, per pin end; at rest as without friction */
    ContactStatics statics;
    Mode mode;
} ElasticShaftState;

/* The angle of cam 2 for theta and F_ext of m->inputs, if the shaft carried no torque before;
 * NAN: the work is spent. */
double elastic_shaft_start(const Inverse *m);

/* The state if theta goes straight from the angle of m->state to that of m->inputs, at the present F_ext; NAN where
 * the work is spent. */
void elastic_shaft_present(const Inverse *m, ElasticShaftState *out);

/* With cam 2 at x and the present inputs: is the torque on the edge of the band in this direction, and is cam 2 free to
 * go on? `forces` are those on the edge. */
bool elastic_shaft_is_on_edge(const Inverse *m, double x, int direction, ContactForces *forces);

/* Carries `next`, the state at the start, along the motion, which ends at the speed `omega`. In each monotone part of
 * the motion a polynomial F_ext is followed in ELASTIC_FORCE_INTERVALS intervals of constant F_ext. False, with the
 * reason, where the contacts wedge on the path of cam 2. */
bool elastic_shaft_advance(const Inverse *m, const ImposedMotion *motion, double omega, InverseState *next,
                           Fault *fault);

#endif
