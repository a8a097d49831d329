/* The breakpoint of the transmission ahead, where a step is to end, and the time to reach an angle ahead.
 *
 * Between two breakpoints the transmission is one polynomial. A step may overshoot the breakpoint a little, because the
 * polynomial continues smoothly. The less smooth the transmission is there, the less a step may overshoot. */
#ifndef DUALCAM_BREAKPOINT_H
#define DUALCAM_BREAKPOINT_H

#include "contact/balance.h"

typedef struct {
    double distance;  /* rad, >= 0, from theta to the breakpoint; infinite in straight grooves */
    double overshoot; /* rad, by which a step may end beyond the breakpoint */
} Breakpoint;

/* The breakpoint ahead of theta in the direction of the slip mode. */
Breakpoint breakpoint_ahead(const SlipMode *slip, double theta);

/* The distance at which a step to the breakpoint aims, rad: the middle of the overshoot. */
static inline double breakpoint_aim(const Breakpoint *breakpoint) {
    return breakpoint->distance + 0.5 * breakpoint->overshoot;
}

/* The distance that no step may exceed, rad. */
static inline double breakpoint_limit(const Breakpoint *breakpoint) {
    return breakpoint->distance + breakpoint->overshoot;
}

/* Time to that aim under constant acceleration, s. */
double breakpoint_time(const SlipMode *slip, const Balance *start, const Breakpoint *breakpoint);

/* Time over `distance`, rad, under constant acceleration, s; infinite if the distance is never covered. speed and alpha
 * count in the direction of the motion. */
double ballistic_time(double speed, double alpha, double distance);

#endif
