/* The stick band, and the time for which rest lasts.
 *
 * At rest T_release <= tau <= T_load (docs/mechanism.md, section 3). Both edges are proportional to the axial load F_0
 * = F_s + F_ext, with one factor for F_0 > 0 and another one for F_0 < 0. The functions here read the mechanism and
 * change nothing. */
#ifndef DUALCAM_STICK_H
#define DUALCAM_STICK_H

#include "forward/state.h"
#include "numerics/tolerances.h"

/* A difference of torques or loads below this share of their size is zero. */
static inline double stick_tie(const Mechanism *m) {
    return m->model.transmission.straight ? STICK_TIE_STRAIGHT : STICK_TIE_CURVED;
}

double stick_axial_load(const Mechanism *m); /* F_0, N */

/* The sizes of the terms of F_0, N, and of tau - factor F_0, N.m: rounding errors are a few eps of these sizes. */
double stick_axial_size(const Mechanism *m);
double stick_torque_size(const Mechanism *m, double factor);

/* Is the axial force, N, more than the rounding of F_0? */
bool stick_force_counts(const Mechanism *m, double force);

/* Is F_0 zero, to the rounding of a reaction? */
bool stick_is_unloaded(const Mechanism *m);

/* The band's edges per F_0 > 0 at the present angle. */
BandFactors stick_band(const Mechanism *m);

/* The band's edges per F_0 for F_0 of the sign of `side`. */
BandFactors stick_edges(const Mechanism *m, double side);

/* The torque at an edge, N.m. */
double stick_edge(double factor, double F_0);

/* The direction in which the torque is beyond the stick band (the inclusion of docs/mechanism.md, section 3). +1:
 * beyond the upper edge, so that loading begins; -1: beyond the lower edge, so that releasing begins; 0: inside the
 * band. On an edge, to rounding, the side decides on which the torque leaves the rounding, however late. */
int stick_direction_beyond_band(const Mechanism *m);

/* The mode of rest inside the band: MODE_WEDGED if one edge is infinite and the torque is beyond the frictionless
 * torque z' F_0 toward that edge, else MODE_STICK. */
Mode stick_mode(const Mechanism *m);

/* The interval of torque in which m->state.mode, a mode of rest, lasts under constant inputs. Not valid where more
 * torque might find a slip mode. */
RestInterval stick_rest_interval(const Mechanism *m);

/* The time, s, at most `left`, for which rest lasts under inputs that are polynomials. The time is at least the square
 * of the rounding of `left`. */
double stick_rest_time(const Mechanism *m, double left);

/* R_i per pin end and per F_0. */
double stick_sharing(const Mechanism *m, int i);

/* R_i per pin end, N, shared as without friction: in stick the two reactions are not unique (docs/mechanism.md,
 * section 3). */
double stick_reaction(const Mechanism *m, int i);

#endif
