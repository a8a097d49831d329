/* Timed loops over many instances: making them, stepping them in turn. */
#define _POSIX_C_SOURCE 199309L
#include "../harness/slave.h"

/* The functions and words that make an instance ready for its first step. */
typedef struct {
    fmi2InstantiateTYPE *instantiate;
    fmi2SetupExperimentTYPE *setup;
    fmi2EnterInitializationModeTYPE *enter;
    fmi2ExitInitializationModeTYPE *leave;
    fmi2FreeInstanceTYPE *release;
    fmi2SetRealTYPE *set_real;
    fmi2ValueReference initial; /* initial.theta */
    const char *guid;
    const char *resources;
    const fmi2CallbackFunctions *callbacks;
} Maker;

/* Seconds of making n instances, in two parts: instantiate, initialise. */
EXPORT int make(const Maker *m, size_t n, fmi2Component made[], double seconds[2]) {
    const double theta = 0.7, start = now();
    for (size_t i = 0; i < n; i++) {
        made[i] = m->instantiate("cam", fmi2CoSimulation, m->guid, m->resources, m->callbacks, fmi2False, fmi2False);
        if (made[i] == NULL) return 1;
    }
    const double between = now();
    int worst = 0;
    for (size_t i = 0; i < n; i++) {
        worst |= (int)m->set_real(made[i], &m->initial, 1, &theta) | (int)m->setup(made[i], 0, 0.0, 0.0, 0, 0.0);
        worst |= (int)m->enter(made[i]) | (int)m->leave(made[i]);
    }
    seconds[0] = between - start;
    seconds[1] = now() - between;
    return worst;
}

/* Seconds of `rounds` rounds in which each of n instances takes one step, starting at `time`; tau alternates
 * between two values. */
EXPORT double sweep(const Slave *s, const fmi2Component all[], size_t n, double time, size_t rounds,
                    const double tau[2], int *status) {
    Slave one = *s;
    double sum = 0.0;
    const double step = 1e-3, start = now();
    for (size_t k = 0; k < rounds; k++) {
        for (size_t i = 0; i < n; i++) {
            one.component = all[i];
            *status |= (int)step_once(&one, time + (double)k * step, step, tau[k / 32 % 2], &sum);
        }
    }
    return now() - start;
}

EXPORT void release(const Maker *m, size_t n, fmi2Component all[]) {
    for (size_t i = 0; i < n; i++) m->release(all[i]);
}
