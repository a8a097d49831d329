/* What only FMI 3.0 has: the intermediate update of a step, adjoint derivatives, dependencies, refused functions. */
#ifndef FUZZ_SPECIAL_FMI3_H
#define FUZZ_SPECIAL_FMI3_H

#include "fmi3Functions.h"

/* The master's part in a step: calls that the input chooses. `environment` is the Run. */
void intermediate_update(fmi3InstanceEnvironment environment, fmi3Float64 time, fmi3Boolean set_requested,
                         fmi3Boolean get_allowed, fmi3Boolean finished, fmi3Boolean can_return_early,
                         fmi3Boolean *return_requested, fmi3Float64 *return_time);

#endif
