/* The construction of a transmission's polynomials: interpolation in Chebyshev points, compared with the groove laws,
 * and halving of the pieces until each polynomial is accurate. */
#ifndef DUALCAM_TRANSMISSION_FIT_H
#define DUALCAM_TRANSMISSION_FIT_H

#include "geometry/transmission.h"

/* Fills the pieces of a transmission whose grooves and stops are set and whose grooves reach the stops. On failure
 * returns false with the reason in `fault`; the caller then frees the pieces made so far. */
bool transmission_fit(Transmission *transmission, const Params *params, Fault *fault);

#endif
