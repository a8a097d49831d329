/* Where a stretch of slip ends: velocity zero, an end stop, a contact changing its flank.
 *
 * Everything watched is a combination of 1, t, theta, omega and alpha along one arc, so its second
 * derivative obeys the homogeneous equation of oscillator.h, whose zeros are known in closed form. They
 * cut time into bows on which the first derivative is monotone; its root, if any, cuts a bow into
 * pieces on which the quantity itself is monotone. So the first zero is bracketed with certainty, never
 * stepped over, and then found to rounding by Newton steps that fall back to bisection. Under constant inputs the
 * first derivative is homogeneous as well: then its zeros are known, and bows are needless. */
#ifndef DUALCAM_LINEAR_EVENT_H
#define DUALCAM_LINEAR_EVENT_H

#include "closed_form/linear_slip.h"
#include "model/event_kind.h"

/* A reaction this small against the loads that make it is zero: the flank is decided by its rate. */
#define NO_REACTION 1e-13

typedef struct {
    EventKind kind;
    double t; /* s since the launch */
} Event;

/* A stretch of slip: all that describes the motion from a launch on. */
typedef struct {
    const LinearSlipMode *linear;
    const Params *params;
    const Geometry *geometry;
    SlipStart start;
    double room; /* rad, >= 0: way to the end stop ahead */
    bool flanks; /* friction acts, so the sign of the reactions matters */
    /* m, edge of the stick band per F_0. Without inertia the pin rests as soon as the torque is back in
     * the band. That is where the speed is zero, unless the damper has put it on other flanks. */
    double edge;
} LinearSegment;

/* Reactions and speeds at both ends of a stretch of length arc.t: what tells that nothing happens. */
typedef struct {
    LinearMotion motion;
    ContactLoadPair start, end;
    bool monotone; /* omega and x_i are so for sure: largest and smallest at the ends */
} SegmentEnds;

/* Contacts only if they matter, to flanks or ledger. */
void event_ends(const LinearSegment *stretch, const Kernel *kernel, SegmentEnds *ends);

/* True if no event can lie in (0, ends->arc.t]: a cheap sufficient test, exact but for rare cases. */
bool event_quiet(const LinearSegment *stretch, const SegmentEnds *ends);

/* Up to where there is anything to search: velocity zero, if its time is known before, or EVENT_NONE at `horizon`. */
Event event_last(const LinearSegment *stretch, double horizon);

/* The first event up to that one. `kernel` and `ends` describe the arc up to `last`, and then the one up to the event that
 * is returned. */
Event event_first(const LinearSegment *stretch, Event last, Kernel *kernel, SegmentEnds *ends);

/* Raises the peaks of |omega| and |R_i| to the largest on [0, ends->arc.t]. */
void event_peaks(const LinearSegment *stretch, const SegmentEnds *ends, Peaks *peak);

#endif
