/* Another FMI 2.0 co-simulation FMU for tests/test_study_trouble.py, as unlike the cam's as FMI allows: steps of one
 * length, no saved states, an output that starts from a value of its own, an enumeration. It decays,
 *
 *     dx/dt = -rate x     or, by the other law,     dx/dt = -rate,
 *
 * counts the runs of an instance, finds a negative rate fatal, and warns of a rate above 4.5.
 */
#include <math.h>

#include "fmi2Functions.h"

/* bare.h's under other names, as these two do more here */
#undef fmi2Instantiate
#undef fmi2Reset
#define fmi2Instantiate bare_instantiate
#define fmi2Reset bare_reset
#include "../benchmarks/null_fmu/bare.h"
#undef fmi2Instantiate
#undef fmi2Reset

#define STEP 0.125

enum { X, RATE };     /* reals */
enum { LAW, RESETS }; /* integers */
enum { FROZEN };      /* booleans */
enum { EXPONENTIAL = 1, LINEAR };

static const fmi2CallbackFunctions *calls_back;

fmi2Status fmi2Reset(fmi2Component c) {
    Values *values = c;
    values->real[X] = 1.0, values->real[RATE] = 1.0;
    values->integer[LAW] = EXPONENTIAL, values->boolean[FROZEN] = fmi2False;
    values->integer[RESETS]++;
    return fmi2OK;
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *callbacks, fmi2Boolean visible, fmi2Boolean logging) {
    Values *values = bare_instantiate(name, type, guid, resources, callbacks, visible, logging);
    if (values == NULL) return NULL;
    fmi2Reset(values);
    calls_back = callbacks;
    return values;
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    (void)c;
    return fmi2OK;
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real step, fmi2Boolean no_set_state) {
    Values *values = c;
    (void)time, (void)no_set_state;
    if (fabs(step - STEP) > 1e-12) return fmi2Discard;
    if (values->real[RATE] < 0.0) {
        calls_back->logger(NULL, "decay", fmi2Fatal, "logStatusFatal", "it grows");
        return fmi2Fatal;
    }
    if (values->boolean[FROZEN]) return fmi2OK;
    if (values->integer[LAW] == EXPONENTIAL)
        values->real[X] *= exp(-values->real[RATE] * step);
    else
        values->real[X] -= values->real[RATE] * step;
    if (values->real[RATE] <= 4.5) return fmi2OK;
    calls_back->logger(NULL, "decay", fmi2Warning, "logStatusWarning", "it is fast");
    return fmi2Warning;
}
