/* The FMU that does nothing: what a step costs through FMI 2.0 when no model is behind it.
 *
 * DoStep returns fmi2OK; the rest is bare.h. No working FMU can be cheaper: the floor of step_cost.py. It has the
 * variables of DualCamForward, so that a master treats both alike.
 */
#include "bare.h"

fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    (void)c;
    return fmi2OK;
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real step, fmi2Boolean no_set_state) {
    (void)c, (void)time, (void)step, (void)no_set_state;
    return fmi2OK;
}
