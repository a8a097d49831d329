/* Inverse dynamics with an elastic shaft: the angle theta of its far end is imposed, and cam 2, at angle x, follows as
 * friction lets it. The law is kinetostatic and independent of rate (docs/mechanism.md, sections 6 and 7):
 *     tau = K (theta - x),    T_release(x) <= tau <= T_load(x)
 * Inside the stick band friction holds x. Where tau would leave the band, x moves just so far that tau is on the edge:
 * loading, to the first x with theta <= x + T_load(x)/K. Where this sum falls along the motion (a soft shaft, an edge
 * that falls), x snaps to where the sum has recovered. The energy that the shaft then releases and friction does not
 * take counts as heat of the damper. An end stop holds x against any torque that presses into it.
 *
 * Work: d(K (theta - x)^2/2) = tau (dtheta - dx), so work_in = change of the shaft's energy + integral of tau dx. */
#ifndef DUALCAM_ELASTIC_SHAFT_H
#define DUALCAM_ELASTIC_SHAFT_H

#include "inverse/contact_statics.h"
#include "inverse/elastic_cam.h"
#include "inverse/inverse_state.h"

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

/* Cam 2 as it stands, while the far end is at theta and turns at omega. */
void elastic_shaft_state(const ElasticCam *cam, double theta, double omega, ElasticShaftState *out);

/* With cam 2 at x and the present inputs: is the torque on the edge of the band in this direction, and is cam 2 free to
 * go on? `forces` are those on the edge. */
bool elastic_shaft_is_on_edge(const Inverse *m, double x, int direction, ContactForces *forces);

#endif
