/* The stick band, and for how long rest lasts.
 *
 * At rest T_release <= tau <= T_load (docs/mechanism.md, section 3). Both edges are proportional to the axial load
 * F_0 = F_s + F_ext, with one factor for F_0 > 0 and another one for F_0 < 0. Nothing here moves anything. */
#ifndef DUALCAM_STICK_H
#define DUALCAM_STICK_H

#include "forward/state.h"
#include "numerics/tolerances.h"

/* A difference of torques or loads below this share of their size is zero. */
static inline double stick_tie(const Mechanism *m) {
    return m->model.transmission.straight ? STICK_TIE_STRAIGHT : STICK_TIE_CURVED;
}

typedef struct {
    double release, load; /* m, torque per F_0 at the edges of an interval of torque; may be infinite */
} EdgeFactors;

double stick_axial_load(const Mechanism *m); /* F_0, N */

/* The sizes of the terms of F_0, N, and of tau - factor F_0, N.m: rounding errors are a few eps of these sizes. */
double stick_axial_size(const Mechanism *m);
double stick_torque_size(const Mechanism *m, double factor);

/* The band's edges per F_0 > 0 at the present angle. */
BandFactors stick_band(const Mechanism *m);

/* The band's edges per F_0 for F_0 of the sign of `side`. */
EdgeFactors stick_edges(const Mechanism *m, double side);
double stick_edge(double factor, double F_0); /* N.m */

/* +1: the torque loads; -1: the torque releases; 0: the torque is inside the stick band (the inclusion of section 3).
 * On an edge, to rounding, the first time derivative that is not zero decides. */
int stick_pressed(const Mechanism *m);

/* Is the torque on the band's edge of that direction, to rounding? */
bool stick_is_on_edge(const Mechanism *m, int direction);

/* MODE_STICK, or MODE_WEDGED: at rest inside the band, where an edge is infinite, torque beyond the frictionless
 * balance z' F_0 pushes into the wedge. */
Mode stick_mode(const Mechanism *m);

/* The interval of torque in which m->state.mode, a mode of rest, stays under constant inputs. Not valid where more
 * torque might find a slip mode. */
RestInterval stick_rest_interval(const Mechanism *m);

/* For how much of `left` seconds a resting mechanism stays at rest under inputs that are polynomials. On the very edge of
 * the band, where no slip mode agrees, until the torque is beyond the edge by more than a tie; at least a rounding of
 * `left`. */
double stick_rest_time(const Mechanism *m, double left);

/* R_i per contact and per F_0. */
double stick_sharing(const Mechanism *m, int i);

/* N per contact: frictionless sharing, since in stick the two reactions are not unique (section 3). */
double stick_reaction(const Mechanism *m, int i);

#endif
