/* Where the polynomials of a transmission must end: at the stops, and where the pin meets a knot of a table, for there
 * the third derivative of the groove jumps. */
#ifndef DUALCAM_TRANSMISSION_BREAKPOINT_H
#define DUALCAM_TRANSMISSION_BREAKPOINT_H

#include <stdbool.h>
#include <stddef.h>

#include "geometry/groove.h"

typedef struct {
    double theta; /* rad */
    bool knot;    /* a knot of a table lies there */
} TransmissionBreakpoint;

/* All breakpoints in order, from `lower` to `upper`, to be freed by the caller; NULL if memory is short. */
TransmissionBreakpoint *transmission_breakpoints(const Groove groove[2], double lower, double upper, size_t *count);

#endif
