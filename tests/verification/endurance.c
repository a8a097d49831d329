/* Loops of endurance.py: many lives of instances, many steps of one instance. */
#define _POSIX_C_SOURCE 199309L
#include "../../benchmarks/harness/slave.h"

/* The functions and words of a life. */
typedef struct {
    fmi2InstantiateTYPE *instantiate;
    fmi2SetupExperimentTYPE *setup;
    fmi2EnterInitializationModeTYPE *enter;
    fmi2ExitInitializationModeTYPE *leave;
    fmi2ResetTYPE *reset;
    fmi2FreeInstanceTYPE *release;
    fmi2DoStepTYPE *do_step;
    fmi2GetFMUstateTYPE *get_state;
    fmi2FreeFMUstateTYPE *free_state;
    const char *guid;
} Life;

static int run(const Life *l, fmi2Component c) {
    return (int)l->setup(c, fmi2False, 0.0, 0.0, fmi2False, 0.0) | (int)l->enter(c) | (int)l->leave(c) |
           (int)l->do_step(c, 0.0, 1e-3, fmi2True);
}

/* n instances, one after the other: instantiate, a run, reset, a second run, a saved state, free. Returns 0 if every
 * call was OK. */
EXPORT int live(const Life *l, size_t n) {
    static const fmi2CallbackFunctions NONE = {NULL, NULL, NULL, NULL, NULL};
    int worst = 0;
    for (size_t i = 0; i < n; i++) {
        fmi2FMUstate state = NULL;
        const fmi2Component c =
            l->instantiate("cam", fmi2CoSimulation, l->guid, "file:///resources", &NONE, fmi2False, fmi2False);
        if (c == NULL) return -1;
        worst |= run(l, c) | (int)l->reset(c) | run(l, c) | (int)l->get_state(c, &state);
        worst |= (int)l->free_state(c, &state);
        l->release(c);
    }
    return worst;
}

/* Steps number `first` to `first` + n - 1 of `size` seconds; the torque repeats after `period` steps. Returns seconds,
 * or -1 if a call was not OK. */
EXPORT double repeat(const Slave *s, size_t first, size_t n, double size, const double torque[], size_t period) {
    double sum = 0.0;
    int worst = 0;
    const double start = now();
    for (size_t i = first; i < first + n; i++)
        worst |= (int)step_once(s, (double)i * size, size, torque[i % period], &sum);
    return worst == 0 ? now() - start : -1.0;
}
