/* The timed loops of step_cost.py, and nothing else. Functions come in as pointers, so that neither the
 * compiler nor the linker can hoist, merge or vectorise their calls; every loop calls all of them alike.
 */
#define _POSIX_C_SOURCE 199309L
#include <stddef.h>
#include <time.h>

#include "fmi2FunctionTypes.h"

#define EXPORT __attribute__((visibility("default")))

typedef double Exp(double x);
typedef void Sincos(double x, double *sine, double *cosine);

typedef struct {
    fmi2SetRealTYPE *set_real;
    fmi2DoStepTYPE *do_step;
    fmi2GetRealTYPE *get_real;
    fmi2Component component;
    fmi2ValueReference input;      /* tau */
    fmi2ValueReference outputs[2]; /* theta, omega */
} Slave;

static double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Seconds for n times one exp and one sincos: inputs from memory, results summed. The calls do not
 * wait for each other. */
EXPORT double seconds_plain(Exp *exp_, Sincos *sincos_, const double x[], size_t n, double *sum) {
    const double start = now();
    double total = 0.0;
    for (size_t i = 0; i < n; i++) {
        double sine, cosine;
        sincos_(x[i], &sine, &cosine);
        total += exp_(-x[i]) + sine + cosine;
    }
    *sum = total;
    return now() - start;
}

/* The same, each call waiting for the one before: the exponent is the sine just found, the next angle
 * depends on the exponential. */
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

/* Seconds for n steps: set the input, step, get both outputs. Leaves the status other than fmi2OK, if
 * there was any, in `status`, and the sum of the outputs in `sum`. */
EXPORT double seconds_steps(const Slave *s, double time, const double step[], const double tau[], size_t n,
                            int *status, double *sum) {
    const double start = now();
    double total = 0.0, out[2];
    int worst = fmi2OK;
    for (size_t i = 0; i < n; i++) {
        const fmi2Status set = s->set_real(s->component, &s->input, 1, &tau[i]);
        const fmi2Status done = s->do_step(s->component, time, step[i], fmi2True);
        const fmi2Status got = s->get_real(s->component, s->outputs, 2, out);
        if (set != fmi2OK || done != fmi2OK || got != fmi2OK) worst = set > done ? (int)set : (int)done;
        time += step[i];
        total += out[0] + out[1];
    }
    *status = worst;
    *sum = total;
    return now() - start;
}
