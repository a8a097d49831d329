/* An FMU as the timed loops see it. Its functions come in as pointers, so that neither the compiler nor the linker
 * can hoist, merge or vectorise their calls. */
#ifndef SLAVE_H
#define SLAVE_H

#include <stddef.h>

#include "clock.h"
#include "fmi2FunctionTypes.h"

typedef struct {
    fmi2SetRealTYPE *set_real;
    fmi2DoStepTYPE *do_step;
    fmi2GetRealTYPE *get_real;
    fmi2SetFMUstateTYPE *set_state;
    fmi2Component component;
    fmi2ValueReference input;      /* tau */
    fmi2ValueReference outputs[2]; /* theta, omega */
} Slave;

/* One communication step: sets the input, steps, reads both outputs and adds these to `sum`. */
static inline fmi2Status step_once(const Slave *s, double time, double step, double tau, double *sum) {
    double out[2];
    const fmi2Status set = s->set_real(s->component, &s->input, 1, &tau);
    const fmi2Status done = s->do_step(s->component, time, step, fmi2True);
    const fmi2Status got = s->get_real(s->component, s->outputs, 2, out);
    *sum += out[0] + out[1];
    if (set != fmi2OK) return set;
    return done != fmi2OK ? done : got;
}

#endif
