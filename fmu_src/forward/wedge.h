/* How long a mechanism with inertia stays wedged beyond a finite edge of the stick band.
 *
 * There the torque would move the mechanism, but no pair of flanks agrees with the reactions of the motion that would
 * begin (P. Painleve, 1895). At rest the acceleration and the reactions of each pair are linear in torque and axial
 * load, so under inputs that are polynomials they are polynomials of the time. The wedge ends when a pair agrees. */
#ifndef DUALCAM_WEDGE_H
#define DUALCAM_WEDGE_H

#include "forward/state.h"

/* Is the torque beyond a finite edge of the band, in a mechanism with inertia that is wedged? */
bool wedge_holds(const Mechanism *m);

/* The time, s, at most `left`, until a pair of flanks agrees. */
double wedge_time(const Mechanism *m, double left);

/* Over all pairs of flanks the largest of the least of: acceleration and reactions, as shares of their terms. Negative
 * while wedge_holds(). */
double wedge_agreement(const Mechanism *m);

#endif
