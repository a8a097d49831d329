/* Runs under a master of model exchange. */
#include "checks.h"

#include <math.h>

enum { STATES_MAX = 2, INDICATORS_MAX = 7, EULER_STEPS = 3000 };

static void settle(fmi2Component c) {
    fmi2EventInfo info;
    REQUIRE(fmi2NewDiscreteStates(c, &info) == fmi2OK && !info.newDiscreteStatesNeeded);
    REQUIRE(fmi2EnterContinuousTimeMode(c) == fmi2OK);
}

/* Euler's method, whose steps end well beyond an event. Returns how many events there were. */
static int integrate(fmi2Component c, const Scene *scene) {
    const double h = 1e-4, upper = setting_of(scene, "stop.upper", 1.3963);
    const size_t nx = is_inverse() ? 0 : STATES_MAX, nz = is_inverse() ? 1 : INDICATORS_MAX;
    double x[STATES_MAX], rate[STATES_MAX], before[INDICATORS_MAX], after[INDICATORS_MAX];
    fmi2Boolean enter, end;
    int events = 0;
    for (int i = 1; i <= EULER_STEPS; i++) {
        const double t = i * h, phase = 20.0 * t;
        REQUIRE(fmi2GetEventIndicators(c, before, nz) == fmi2OK && fmi2GetDerivatives(c, rate, nx) == fmi2OK);
        REQUIRE(fmi2GetContinuousStates(c, x, nx) == fmi2OK && fmi2SetTime(c, t) == fmi2OK);
        for (size_t k = 0; k < nx; k++) x[k] += h * rate[k];
        REQUIRE(fmi2SetContinuousStates(c, x, nx) == fmi2OK);
        if (is_inverse()) {
            set_real(c, "theta", upper * (0.5 - 0.4 * cos(phase)));
            set_real(c, "omega", upper * 8.0 * sin(phase));
            set_real(c, "alpha", upper * 160.0 * cos(phase));
        } else {
            set_real(c, "tau", scene->torque * (0.4 + 0.6 * sin(phase)));
        }
        REQUIRE(fmi2CompletedIntegratorStep(c, fmi2True, &enter, &end) == fmi2OK && !enter && !end);
        REQUIRE(fmi2GetEventIndicators(c, after, nz) == fmi2OK);
        bool crossed = false;
        for (size_t k = 0; k < nz; k++) crossed = crossed || (before[k] > 0.0) != (after[k] > 0.0);
        if (!crossed) continue;
        REQUIRE(fmi2EnterEventMode(c) == fmi2OK);
        settle(c);
        check_derivatives(c);
        events++;
    }
    return events;
}

void check_model_exchange(const Scene *scene) {
    fmi2Component c = instantiate_for(fmi2ModelExchange, &callbacks);
    fmi2FMUstate state = NULL;
    if (!begin(c, scene)) { /* without inertia, or without its table */
        (void)refused(c, scene);
        return;
    }
    settle(c);
    REQUIRE(fmi2GetFMUstate(c, &state) == fmi2OK);
    const int events = integrate(c, scene);
    const Picture first = picture(c);
    REQUIRE(fmi2SetFMUstate(c, state) == fmi2OK && integrate(c, scene) == events);
    const Picture second = picture(c);
    REQUIRE(same(&first, &second) && messages == 0);
    REQUIRE(fmi2FreeFMUstate(c, &state) == fmi2OK && fmi2Terminate(c) == fmi2OK);
    fmi2FreeInstance(c);
    printf("%s: model exchange, %d events\n", scene->name, events);
}
