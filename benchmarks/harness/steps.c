/* Timed loops over communication steps, and over one exp and one sincos. */
#define _POSIX_C_SOURCE 199309L
#include "slave.h"
#include "unit.h"

/* Seconds for n times one exp and one sincos, where each call waits for the one before: the exponent is the sine just
 * found, and the next angle depends on the exponential. */
EXPORT double seconds_dependent(Exp *exp_, Sincos *sincos_, const double x[], size_t n, double *sum) {
    const double start = now();
    double last = 0.0;
    for (size_t i = 0; i < n; i++) {
        double sine, cosine;
        sincos_(x[i] + last, &sine, &cosine);
        last = exp_(sine - 2.0) + 0.0625 * cosine;
    }
    *sum = last;
    return now() - start;
}

/* Seconds for n consecutive steps. `status` gets a status other than fmi2OK, if there was any, and `sum` gets the sum
 * of the outputs. */
EXPORT double seconds_steps(const Slave *s, double time, const double step[], const double tau[], size_t n,
                            int *status, double *sum) {
    const double start = now();
    double total = 0.0;
    int worst = fmi2OK;
    for (size_t i = 0; i < n; i++) {
        const fmi2Status one = step_once(s, time, step[i], tau[i], &total);
        if (one != fmi2OK) worst = (int)one;
        time += step[i];
    }
    *status = worst;
    *sum = total;
    return now() - start;
}

/* Seconds for n separate steps, each from a saved state of its own. Neither restoring the state nor reading the clock
 * is counted; a reading takes as long as the shortest time between two readings. */
EXPORT double seconds_separate(const Slave *s, const fmi2FMUstate state[], const double time[],
                               const double step[], const double tau[], size_t n, int *status, double *sum) {
    double seconds = 0.0, total = 0.0, clock = 1.0;
    int worst = fmi2OK;
    for (size_t i = 0; i < n; i++) {
        const fmi2Status set = s->set_state(s->component, state[i]);
        const double before = now(), start = now();
        const fmi2Status one = step_once(s, time[i], step[i], tau[i], &total);
        seconds += now() - start;
        if (start - before < clock) clock = start - before;
        if (set != fmi2OK || one != fmi2OK) worst = set != fmi2OK ? (int)set : (int)one;
    }
    *status = worst;
    *sum = total;
    return seconds - (double)n * clock;
}
