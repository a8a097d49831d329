/* The runs of a parameter study without Python: the same calls on the same values. */
#define _POSIX_C_SOURCE 199309L
#include "../harness/slave.h"

typedef struct {
    fmi2SetFMUstateTYPE *set_state;
    fmi2ResetTYPE *reset;
    fmi2SetupExperimentTYPE *set_up;
    fmi2EnterInitializationModeTYPE *enter;
    fmi2ExitInitializationModeTYPE *leave;
    fmi2SetRealTYPE *set_real;
    fmi2DoStepTYPE *do_step;
    fmi2GetRealTYPE *get_real;
    fmi2Component component;
    fmi2FMUstate state; /* NULL: begin with fmi2Reset */
    const fmi2ValueReference *varied, *results;
    size_t varied_count, results_count; /* the first result is read halfway */
    fmi2ValueReference tau;
} Study;

static int begin(const Study *s, const double row[], const double *tau) {
    const fmi2Component c = s->component;
    int bad = s->state ? (int)s->set_state(c, s->state) : (int)s->reset(c);
    bad |= (int)s->set_real(c, s->varied, s->varied_count, row);
    if (!s->state) bad |= (int)s->set_up(c, fmi2False, 0.0, 0.0, fmi2False, 0.0) | (int)s->enter(c);
    return bad | (int)s->set_real(c, &s->tau, 1, tau) | (int)s->leave(c);
}

/* Seconds for the runs of these rows: torque for half the time, then none. Any status but fmi2OK ends in `status`. */
EXPORT double seconds_study(const Study *s, const double rows[], size_t runs, double torque, double half,
                            double results[], int *status) {
    const double start = now(), none = 0.0;
    int bad = 0;
    for (size_t k = 0; k < runs; k++) {
        double *result = results + k * s->results_count;
        bad |= begin(s, rows + k * s->varied_count, &torque);
        bad |= (int)s->do_step(s->component, 0.0, half, fmi2True);
        bad |= (int)s->get_real(s->component, s->results, 1, result);
        bad |= (int)s->set_real(s->component, &s->tau, 1, &none);
        bad |= (int)s->do_step(s->component, half, half, fmi2True);
        bad |= (int)s->get_real(s->component, s->results + 1, s->results_count - 1, result + 1);
    }
    *status = bad;
    return now() - start;
}
