/* The FMU that does nothing: the cost of a step through FMI 2.0 without a model.
 *
 * DoStep returns fmi2OK; all other functions are in bare.h. No working FMU can be cheaper: this FMU is the floor of
 * benchmarks/step_cost. It has the variables of DualCamForward, so that a master treats both FMUs alike.
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
