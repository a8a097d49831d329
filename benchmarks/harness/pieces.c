/* The timed loop over pieces of constant torque. */
#define _POSIX_C_SOURCE 199309L
#include "slave.h"

/* Pieces of constant torque, each of `steps` steps of equal length. The variables `read` are read at the end of each
 * piece. */
typedef struct {
    const double *duration;
    const double *tau;
    size_t count;
    size_t steps;
    const fmi2ValueReference *read;
    size_t reads;
} Pieces;

static fmi2Status run_once(const Slave *s, const Pieces *p, double points[], double *sum) {
    double start = 0.0;
    for (size_t i = 0; i < p->count; i++) {
        const double step = p->duration[i] / (double)p->steps;
        for (size_t k = 0; k < p->steps; k++) {
            const fmi2Status done = step_once(s, start + (double)k * step, step, p->tau[i], sum);
            if (done != fmi2OK) return done;
        }
        start += p->duration[i];
        const fmi2Status got = s->get_real(s->component, p->read, p->reads, points + i * p->reads);
        if (got != fmi2OK) return got;
    }
    return fmi2OK;
}

/* Seconds per run, over `repeats` runs. Each run starts from a saved state, if there is one; restoring the state is not
 * timed. `points` gets the values that were read, `status` the status. */
EXPORT double seconds_pieces(const Slave *s, const Pieces *p, fmi2FMUstate state, size_t repeats, double points[],
                             int *status) {
    double seconds = 0.0, sum = 0.0;
    for (size_t i = 0; i < repeats; i++) {
        if (state != NULL && s->set_state(s->component, state) != fmi2OK) break;
        const double start = now();
        *status = (int)run_once(s, p, points, &sum);
        seconds += now() - start;
        if (*status != (int)fmi2OK) break;
    }
    return seconds / (double)repeats;
}
