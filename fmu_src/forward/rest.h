/* Segments at rest: in stick, at an end stop, wedged. */
#ifndef DUALCAM_REST_H
#define DUALCAM_REST_H

#include "forward/segment.h"

/* The fast exit of a step at rest: under constant inputs, and inside the rest interval of an earlier step, only
 * the peak of the torque changes. Returns false if the step is to be made by segments. */
bool rest_goes_on(Mechanism *m);

/* Proposes rest for up to `left` seconds, until the torque leaves the rest interval or F_0 changes its sign. */
void rest_propose(Mechanism *m, double left, Segment *segment);

/* Proposes rest for t seconds, whatever the torque. */
void rest_propose_for(const Mechanism *m, double t, Segment *segment);

#endif
