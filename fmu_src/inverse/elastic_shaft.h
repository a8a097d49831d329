/* Inverse dynamics with an elastic shaft: what is imposed is the angle theta of its far end, and cam 2, at angle x,
 * is dragged along. Kinetostatic and independent of rate (mechanism page, sections 6 and 7):
 *     tau = K (theta - x),    T_release(x) <= tau <= T_load(x)
 * Inside that band friction holds x. Where tau would leave it, x moves just so far that tau is on its edge: loading,
 * to the first x at which theta <= x + T_load(x)/K. Where that sum falls along the way (a soft shaft, an edge that
 * falls), x snaps on to where it has recovered; what the shaft gives up then and friction does not take counts as
 * heat of the damper. An end stop holds x against any torque that presses into it.
 *
 * Work: d(K (theta - x)^2/2) = tau (dtheta - dx), so that work_in = change of the shaft's energy + integral tau dx. */
#ifndef DUALCAM_ELASTIC_SHAFT_H
#define DUALCAM_ELASTIC_SHAFT_H

#include "contact/contact_statics.h"
#include "inverse/inverse.h"

/* Cam 2 and what its position implies. */
typedef struct {
    double cam;         /* rad */
    double speed;       /* rad/s */
    double tau;         /* N.m */
    double reaction[2]; /* N, per contact */
    ContactStatics statics;
    Mode mode;
} ElasticShaftState;

/* x for theta and F_ext of m->inputs, where the shaft has been relaxed. */
double elastic_shaft_start(const Inverse *m);

/* What there would be if theta went straight from the state's to that of m->inputs, at the present F_ext. */
void elastic_shaft_present(const Inverse *m, ElasticShaftState *out);

/* With cam 2 there and the present inputs: is the torque on the edge of the band in that direction, and cam 2 free to go
 * on? Then *bearing is how. */
bool elastic_shaft_is_on_edge(const Inverse *m, double cam, int direction, ContactForces *forces);

/* Carries `next`, the state at the start, along the motion, which ends at `omega`. A polynomial F_ext is followed in
 * ELASTIC_SHAFT_STAIRS stairs per monotone part of the motion. */
bool elastic_shaft_advance(const Inverse *m, const Imposed *motion, double omega, InverseState *next, Fault *fault);

enum { ELASTIC_SHAFT_STAIRS = 64 };

#endif
