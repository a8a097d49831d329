/* Loops over steps whose inputs are given one by one: torque, its rate, and the follower force. */
#define _POSIX_C_SOURCE 199309L
#include <stdbool.h>

#include "slave.h"

/* Inputs of `count` steps, the first of which is number `first` of the run. The torque is a straight line in each
 * step. */
typedef struct {
    const double *tau, *tau_rate, *F_ext;
    double step;
    size_t first, count;
} Inputs;

typedef struct {
    Slave slave;
    fmi2SetRealInputDerivativesTYPE *set_rate;
    fmi2ValueReference inputs[2]; /* tau, F_ext */
} Instance;

/* The calls of a real-time loop in one step: sets both inputs and the torque's rate, steps, reads angle and speed. */
static bool take_step(const Instance *instance, const Inputs *p, size_t k) {
    const Slave *s = &instance->slave;
    const double in[2] = {p->tau[k], p->F_ext[k]};
    const fmi2Integer order = 1;
    double out[2];
    bool good = s->set_real(s->component, instance->inputs, 2, in) == fmi2OK;
    if (p->tau_rate[k] != 0.0)
        good &= instance->set_rate(s->component, instance->inputs, 1, &order, p->tau_rate + k) == fmi2OK;
    good &= s->do_step(s->component, (double)(p->first + k) * p->step, p->step, fmi2True) == fmi2OK;
    return s->get_real(s->component, s->outputs, 2, out) == fmi2OK && good;
}

/* `least` keeps the least seconds of each step over all calls, the time of one reading of the clock included. Returns
 * the number of steps that failed. */
EXPORT size_t time_steps(const Instance *instance, const Inputs *p, double least[]) {
    size_t failed = 0;
    for (size_t k = 0; k < p->count; k++) {
        const double start = now();
        failed += !take_step(instance, p, k);
        const double seconds = now() - start;
        if (seconds < least[k]) least[k] = seconds;
    }
    return failed;
}

/* Seconds of one reading of the clock. */
EXPORT double clock_seconds(void) {
    double least = 1.0;
    for (int n = 0; n < 10000; n++) {
        const double start = now(), seconds = now() - start;
        if (seconds < least) least = seconds;
    }
    return least;
}

/* The variables that are read after every step of an untimed run: mode and events, and reals. */
typedef struct {
    fmi2GetIntegerTYPE *get_integer;
    fmi2ValueReference integers[2];
    const fmi2ValueReference *reals;
    size_t count;
} Readout;

EXPORT size_t record_steps(const Instance *instance, const Inputs *p, const Readout *r, fmi2Integer integers[],
                           double reals[]) {
    const Slave *s = &instance->slave;
    size_t failed = 0;
    for (size_t k = 0; k < p->count; k++) {
        const bool good = take_step(instance, p, k);
        const bool read = r->get_integer(s->component, r->integers, 2, integers + 2 * k) == fmi2OK &&
                          s->get_real(s->component, r->reals, r->count, reals + r->count * k) == fmi2OK;
        failed += !(good && read);
    }
    return failed;
}

EXPORT size_t run_steps(const Instance *instance, const Inputs *p) {
    size_t failed = 0;
    for (size_t k = 0; k < p->count; k++) failed += !take_step(instance, p, k);
    return failed;
}
