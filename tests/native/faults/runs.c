/* Lives of an instance that end in a picture. */
#include "faults.h"

#include <string.h>

enum { STEPS = 40, EULER_STEPS = 400, STATES_MAX = 2, INDICATORS_MAX = 7 };

static const uint64_t FIRST_SEED = 88172645463325252u;

const Scene *possible_scenes(size_t *count) {
    const Scene *scene = scenes(count);
    *count -= 1;
    return scene;
}

/* The present state of `c` as bytes in a new instance. */
static fmi2Component copied(fmi2Component c) {
    fmi2FMUstate state = NULL, other_state = NULL;
    size_t size = 0;
    REQUIRE(fmi2GetFMUstate(c, &state) == fmi2OK && fmi2SerializedFMUstateSize(c, state, &size) == fmi2OK);
    fmi2Byte *bytes = malloc(size);
    REQUIRE(bytes != NULL && fmi2SerializeFMUstate(c, state, bytes, size) == fmi2OK);
    REQUIRE(fmi2FreeFMUstate(c, &state) == fmi2OK);
    const fmi2Component other = instantiate(&callbacks);
    REQUIRE(fmi2DeSerializeFMUstate(other, bytes, size, &other_state) == fmi2OK);
    REQUIRE(fmi2SetFMUstate(other, other_state) == fmi2OK && fmi2FreeFMUstate(other, &other_state) == fmi2OK);
    free(bytes);
    return other;
}

Picture life(const Scene *scene) {
    random_state = FIRST_SEED;
    fmi2Component c = begun(scene);
    double time = 0.0;
    for (int i = 0; i < STEPS; i++) {
        random_step(c, &time, scene);
        if (i % 10 == 0) {
            check_output_derivatives(c);
            check_derivatives(c);
        }
        if (i != STEPS / 2) continue;
        const fmi2Component other = copied(c);
        fmi2FreeInstance(c);
        c = other;
    }
    const Picture end = picture(c);
    REQUIRE(fmi2Terminate(c) == fmi2OK);
    fmi2FreeInstance(c);
    return end;
}

static void settle(fmi2Component c) {
    fmi2EventInfo info;
    REQUIRE(fmi2NewDiscreteStates(c, &info) == fmi2OK && !info.newDiscreteStatesNeeded);
    REQUIRE(fmi2EnterContinuousTimeMode(c) == fmi2OK);
}

static void euler_step(fmi2Component c, const Scene *scene, double t, double h) {
    const size_t nx = is_inverse() ? 0 : STATES_MAX, nz = is_inverse() ? 1 : INDICATORS_MAX;
    double x[STATES_MAX], rate[STATES_MAX], before[INDICATORS_MAX], after[INDICATORS_MAX];
    fmi2Boolean enter, end;
    REQUIRE(fmi2GetEventIndicators(c, before, nz) == fmi2OK && fmi2GetDerivatives(c, rate, nx) == fmi2OK);
    REQUIRE(fmi2GetContinuousStates(c, x, nx) == fmi2OK && fmi2SetTime(c, t) == fmi2OK);
    for (size_t k = 0; k < nx; k++) x[k] += h * rate[k];
    REQUIRE(fmi2SetContinuousStates(c, x, nx) == fmi2OK);
    if (chance(0.05)) set_real(c, is_inverse() ? "F_ext" : "tau", random_in(-0.5, 1.0) * scene->torque);
    REQUIRE(fmi2CompletedIntegratorStep(c, fmi2True, &enter, &end) == fmi2OK);
    REQUIRE(fmi2GetEventIndicators(c, after, nz) == fmi2OK);
    bool crossed = false;
    for (size_t k = 0; k < nz; k++) crossed = crossed || (before[k] > 0.0) != (after[k] > 0.0);
    if (!crossed) return;
    REQUIRE(fmi2EnterEventMode(c) == fmi2OK);
    settle(c);
    check_derivatives(c);
}

Picture exchanged_life(const Scene *scene) {
    random_state = FIRST_SEED;
    Picture end;
    memset(&end, 0, sizeof end);
    const fmi2Component c = instantiate_for(fmi2ModelExchange, &callbacks);
    if (begin(c, scene)) {
        settle(c);
        for (int i = 1; i <= EULER_STEPS; i++) euler_step(c, scene, 1e-3 * i, 1e-3);
        end = picture(c);
    }
    fmi2FreeInstance(c);
    return end;
}
