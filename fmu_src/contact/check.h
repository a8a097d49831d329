/* Checks of parameters that the range of a single variable cannot express. */
#ifndef DUALCAM_CHECK_H
#define DUALCAM_CHECK_H

#include <stdbool.h>

#include "geometry/transmission.h"
#include "model/fault.h"
#include "model/params.h"

/* Each function returns false and fills `fault` if its condition does not hold. */

/* The stops are in order, and the lead angles are not both zero, so that the grooves fix the pin. */
bool check_params(const Params *params, Fault *fault);

/* initial.theta lies between the stops. Only a mechanism that starts from initial.theta needs this check. */
bool check_initial(const Params *params, Fault *fault);

/* No friction falls with the sliding speed. To be called where nothing but friction would determine a speed: without
 * inertia, with an elastic shaft. `cause` and `remedy` complete the message. */
bool check_falling_friction(const Params *params, const char *cause, const char *remedy, Fault *fault);

/* Friction does not fall with the load. To be called without inertia: there damping can take the load off a contact
 * while cam 2 moves. Friction that grows as the load vanishes then gives two reactions, or none.
 * `remedy` completes the message. */
bool check_loaded_friction(const Params *params, const char *remedy, Fault *fault);

/* Without inertia: something limits the speed, since the friction of a table is constant above its last sample.
 * `remedy` completes the message. */
bool check_limited_speed(const Params *params, const char *remedy, Fault *fault);

/* A torque that loads exists everywhere between the stops: kappa_1 + kappa_2 > 0 at sigma = +1 (docs/mechanism.md,
 * section 3). */
bool check_jam(const Params *params, const Transmission *transmission, Fault *fault);

/* The grooves reach from stop to stop and pass check_jam(). Replaces *transmission by the transmission of these
 * parameters unless it is this already. On failure *transmission is unchanged. `resources`: see transmission_build().
 * */
bool check_transmission(const Params *params, const char *resources, Transmission *transmission, Fault *fault);

#endif
