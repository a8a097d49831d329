/* Segments at rest: in stick, at an end stop, wedged. */
#ifndef DUALCAM_REST_H
#define DUALCAM_REST_H

#include "forward/segment.h"

/* The fast exit of a step at rest: under constant inputs, and inside the rest interval of an earlier step, only
 * the peak of the torque changes. Returns false if the step is to be made by segments. */
bool rest_goes_on(Mechanism *m);

/* Proposes rest for up to `left` seconds, until the torque leaves the rest interval, F_0 changes its sign or
 * a wedge ends. */
void rest_propose(Mechanism *m, double left, Segment *segment);

/* Proposes rest for t seconds, whatever the torque. */
void rest_propose_for(const Mechanism *m, double t, Segment *segment);

/* Is the mechanism wedged with the torque beyond a finite edge of the stick band? With inertia the torque would then
 * move the mechanism, but no pair of flanks agrees with the reactions of the motion that would begin (P. Painleve,
 * 1895). At rest the acceleration and the reactions of each pair are linear in torque and axial load, so under inputs
 * that are polynomials they are polynomials of the time. The wedge ends when a pair agrees. */
bool wedge_holds(const Mechanism *m);

/* Over all pairs of flanks the largest of the least of: acceleration and reactions, as shares of their terms. Negative
 * while wedge_holds(). */
double wedge_agreement(const Mechanism *m);

#endif
