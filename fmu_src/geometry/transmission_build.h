/* The construction of a transmission from parameters: polynomials from breakpoint to breakpoint, halved until each is
 * accurate. */
#ifndef DUALCAM_TRANSMISSION_BUILD_H
#define DUALCAM_TRANSMISSION_BUILD_H

#include "geometry/transmission.h"

/* Precomputes the transmission between the stops. A table's relative path starts from the directory `resources`. On
 * failure returns false with the reason in `fault`; `transmission` then owns nothing. */
bool transmission_build(Transmission *transmission, const Params *params, const char *resources, Fault *fault);

#endif
