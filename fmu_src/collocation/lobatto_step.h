/* One step of slip through grooves of any shape, without an event, by Lobatto IIIA collocation with four nodes.
 *
 * This is the common case, so it is made fast. A step is accepted only if its error is within the tolerance and if no
 * event can lie in it: the speed, the angle to the stop and both reactions stay clear of zero. event_location.h advances a
 * rejected step. */
#ifndef DUALCAM_LOBATTO_STEP_H
#define DUALCAM_LOBATTO_STEP_H

#include "contact/balance.h"
#include "geometry/cam.h"

/* The state at the start. */
typedef struct {
    double theta, omega, z;   /* rad, rad/s, m */
    const Geometry *geometry; /* at theta */
    double to_stop;           /* rad, angle to the end stop ahead */
    const Peaks *known;       /* the largest values so far; reactions per pin end */
} LobattoStart;

typedef struct {
    double h;              /* s, length */
    double dtheta, domega; /* rad, rad/s: increments; domega only with inertia */
    double omega;          /* rad/s, at the end */
    bool accurate; /* four nodes suffice. Set for a rejected step too, if the step got as far as the error estimate */
    Booking booking;
    double energy_gained; /* J, see step_energy.h */
    /* Only if a ledger is kept: */
    Peaks peak;        /* the larger values of both ends */
    bool peaks_inside; /* a larger value inside the step, above the known one, is possible */
} LobattoStep;

/* A step of `left` seconds, or to the breakpoint of the transmission ahead. False if the step is rejected. Not for the
 * rate-independent regime. */
bool lobatto_step_along(const SlipMode *slip, const LobattoStart *from, double left, LobattoStep *lobatto);

#endif
