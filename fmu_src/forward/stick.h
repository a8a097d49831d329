/* Rest: the stick band, and for how long a resting mechanism stays as it is.
 *
 * At rest T_release <= tau <= T_load (mechanism page, section 3), both edges proportional to the axial load
 * F_0 = F_s + F_ext on either side of F_0 = 0. Nothing here moves anything. */
#ifndef DUALCAM_STICK_H
#define DUALCAM_STICK_H

#include <float.h>

#include "forward/mechanism.h"

/* Torque and load are known to a few roundings, in curved grooves to the digits of the course; a difference below this
 * share of their size is none. */
static inline double stick_tie(const Mechanism *m) {
    const double TRANSMISSION_DIGITS = 2e-12;
    return m->model.transmission.straight ? 8.0 * DBL_EPSILON : TRANSMISSION_DIGITS;
}

typedef struct {
    double release, load; /* multiply F_0, signed: edges of a torque interval; may be infinite */
} EdgeFactors;

double stick_axial_load(const Mechanism *m); /* F_0, N */

/* The size of what F_0 adds up, N, and of tau - factor F_0, N.m: rounding errors are a few eps of these. */
double stick_axial_size(const Mechanism *m);
double stick_torque_size(const Mechanism *m, double factor);

/* The band's edges per F_0 > 0 where it stands. */
BandFactors stick_band(const Mechanism *m);

/* The band's edges per F_0 for F_0 of the sign of `side`. */
EdgeFactors stick_edges(const Mechanism *m, double side);
double stick_edge(double factor, double F_0); /* N.m */

/* +1: the torque loads, -1: it releases, 0: it is inside the stick band. The inclusion of section 3. */
int stick_pressed(const Mechanism *m);

/* Is the torque on the band's edge of that direction, and moves along with it, to rounding? */
bool stick_is_on_edge(const Mechanism *m, int direction);

/* MODE_STICK, or MODE_WEDGED: at rest inside the band, where an edge is infinite, torque beyond the frictionless
 * balance z' F_0 pushes into the wedge. */
Mode stick_mode(const Mechanism *m);

/* The interval of torque in which m->state.mode, a mode of rest, stays under constant inputs. Not valid where
 * more torque might find a way to slip. */
RestInterval stick_rest_interval(const Mechanism *m);

/* How much of `left` seconds a resting mechanism surely stays at rest under ramps. */
double stick_rest_time(const Mechanism *m, double left);

/* R_i per contact and per F_0. */
double stick_sharing(const Mechanism *m, int i);

/* N per contact: frictionless sharing, since in stick the two reactions are not unique (section 3). */
double stick_reaction(const Mechanism *m, int i);

static inline double axial_position(const Mechanism *m) {
    return m->configuration.z;
}

#endif
