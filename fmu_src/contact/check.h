/* Checks of parameters that the range of a single variable cannot express. */
#ifndef DUALCAM_CHECK_H
#define DUALCAM_CHECK_H

#include <stdbool.h>

#include "geometry/transmission.h"
#include "model/fault.h"
#include "model/params.h"

/* Each function returns false and fills `fault` if its condition does not hold. */

/* initial.theta lies between the stops. Only a mechanism that starts from initial.theta needs this check. */
bool check_initial(const Params *params, Fault *fault);

/* No friction depends on the sliding speed: to be called where nothing but friction would determine a speed, without
 * inertia or with an elastic shaft. `cause` and `remedy` complete the message. */
bool check_speed_friction(const Params *params, const char *cause, const char *remedy, Fault *fault);

/* No damper of the follower acts beside friction that depends on the load: to be called without inertia, for the
 * damper's force is part of that load. */
bool check_damped_load(const Params *params, const char *remedy, Fault *fault);

/* Replaces *transmission by the transmission of these parameters unless it is this already. `check`: what the mechanism
 * must pass, see contact/domain.h. On failure *transmission is unchanged. `resources`: see transmission_build(). */
typedef bool TransmissionCheck(const Params *params, const Transmission *transmission, double F_ext, Fault *fault);
bool check_transmission(const Params *params, const char *resources, double F_ext, TransmissionCheck *check,
                        Transmission *transmission, Fault *fault);

#endif
