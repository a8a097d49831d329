/* Can the mechanism work with these parameters? What the range of a single variable cannot tell. */
#ifndef DUALCAM_CHECK_H
#define DUALCAM_CHECK_H

#include <stdbool.h>

#include "geometry/transmission.h"
#include "model/fault.h"
#include "model/params.h"

/* Each returns false and fills `fault` if not. */

/* Stops in order, something that fixes the pin. */
bool check_params(const Params *params, Fault *fault);

/* initial.theta between the stops: only where the mechanism starts from there. */
bool check_initial(const Params *params, Fault *fault);

/* A torque that loads exists everywhere between the stops: kappa_1 + kappa_2 > 0 at sigma = +1. */
bool check_jam(const Params *params, const Transmission *transmission, Fault *fault);

/* The grooves reach from stop to stop and pass check_jam(). Replaces *course by that of these parameters unless it is; where
 * they fail it stays as it was. `resources`: see transmission_build(). */
bool check_transmission(const Params *params, const char *resources, Transmission *transmission, Fault *fault);

#endif
