/* Many instances, one after the other and at once. */
#include "checks.h"

enum { LIVES = 1000, AT_ONCE = 50 };

void check_many_lives(void) {
    size_t count;
    const Scene *scene = scenes(&count);
    fmi2Component lasting = instantiate(&callbacks);
    for (size_t i = 0; i < LIVES; i++) {
        const Scene *next = i % 20 == 0 ? &scene[i / 20 % (count - 1)] : scene; /* the last one cannot be */
        fmi2Component c = instantiate(i % 2 ? &callbacks : &no_callbacks), both[] = {c, lasting};
        for (size_t k = 0; k < 2; k++) {
            REQUIRE(begin(both[k], next));
            REQUIRE(fmi2DoStep(both[k], 0.0, 1e-3, fmi2True) == fmi2OK);
            if (i % 3 == 0 || k == 1) REQUIRE(fmi2Reset(both[k]) == fmi2OK);
        }
        fmi2FreeInstance(c);
    }
    fmi2FreeInstance(lasting);
}

void check_many_at_once(void) {
    size_t count;
    const Scene *scene = scenes(&count);
    fmi2Component crowd[AT_ONCE];
    fmi2FMUstate state = NULL;
    for (size_t i = 0; i < AT_ONCE; i++) {
        crowd[i] = begun(&scene[i % (count - 1)]);
        const bool takes = i > 0 && i % 5 == 0;
        if (takes) REQUIRE(fmi2SetFMUstate(crowd[i], state) == fmi2OK);
        double time = 0.0;
        REQUIRE(fmi2GetRealStatus(crowd[i], fmi2LastSuccessfulTime, &time) == fmi2OK);
        REQUIRE(fmi2DoStep(crowd[i], time, 1e-3, fmi2True) == fmi2OK);
        REQUIRE(fmi2GetFMUstate(crowd[i], &state) == fmi2OK);
    }
    for (size_t i = 0; i < AT_ONCE; i++) { /* in another order than they came */
        const size_t place = 7 * i % AT_ONCE;
        if (i == AT_ONCE - 1) REQUIRE(fmi2FreeFMUstate(crowd[place], &state) == fmi2OK);
        fmi2FreeInstance(crowd[place]);
    }
}
