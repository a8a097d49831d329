/* Calls that must be refused. */
#include "checks.h"

#include <math.h>
#include <string.h>

/* Each must be refused with a message and leave an instance that a reset brings back to life. */
#define REFUSED(call)                                                                                   \
    do {                                                                                                \
        messages = 0;                                                                                   \
        REQUIRE((call) == fmi2Error);                                                                   \
        REQUIRE(messages >= 1);                                                                         \
        messages = 0;                                                                                   \
        REQUIRE(fmi2Reset(c) == fmi2OK);                                                                \
    } while (0)

static void check_bad_values(fmi2Component c) {
    const fmi2ValueReference unknown = 0xfffffff0u, input = reference(is_inverse() ? "theta" : "tau"),
                             mode = reference("mode"), friction = reference("cam1.friction"), z = reference("z"),
                             table = reference("cam1.table");
    const double one = 1.0, minus = -1.0, bad[] = {NAN, INFINITY, -INFINITY};
    const fmi2Integer order[] = {1, 4};
    double value = 0.0;
    fmi2Integer integer = 0;
    REFUSED(fmi2SetReal(c, &unknown, 1, &one));
    REFUSED(fmi2GetReal(c, &unknown, 1, &value));
    REFUSED(fmi2GetInteger(c, &input, 1, &integer));
    REFUSED(fmi2SetInteger(c, &mode, 1, &integer));
    REFUSED(fmi2SetReal(c, &friction, 1, &minus));
    REFUSED(fmi2SetReal(c, &z, 1, &one));
    for (size_t i = 0; i < COUNT_OF(bad); i++) REFUSED(fmi2SetReal(c, &input, 1, &bad[i]));
    REFUSED(fmi2SetRealInputDerivatives(c, &z, 1, order, &one));
    REFUSED(fmi2SetRealInputDerivatives(c, &input, 1, order + 1, &one));
    REFUSED(fmi2SetRealInputDerivatives(c, &input, 1, order, bad));

    char path[PATH + 2];
    memset(path, 'x', sizeof path);
    path[sizeof path - 1] = '\0';
    const fmi2String too_long = path + 1, none = NULL;
    REFUSED(fmi2SetString(c, &table, 1, &too_long));
    REFUSED(fmi2SetString(c, &table, 1, &none));
    const fmi2String longest = path + 2;
    REQUIRE(fmi2SetString(c, &table, 1, &longest) == fmi2OK);
    fmi2String read = NULL;
    REQUIRE(fmi2GetString(c, &table, 1, &read) == fmi2OK && strcmp(read, longest) == 0);
    REQUIRE(fmi2Reset(c) == fmi2OK);
}

static void check_bad_life(fmi2Component c) {
    const Scene *scene = scene_called("default");
    const fmi2Byte garbage[64] = {0};
    fmi2FMUstate state = NULL;
    REFUSED(fmi2DoStep(c, 0.0, 1e-3, fmi2True));
    REFUSED(fmi2ExitInitializationMode(c));
    REFUSED(fmi2DeSerializeFMUstate(c, garbage, sizeof garbage, &state));
    REQUIRE(state == NULL);

    const double steps[][2] = {{0.0, -1e-3}, {0.0, NAN}, {0.0, INFINITY}, {0.5, 1e-3}, {NAN, 1e-3}};
    for (size_t i = 0; i < COUNT_OF(steps); i++) {
        REQUIRE(begin(c, scene));
        REFUSED(fmi2DoStep(c, steps[i][0], steps[i][1], fmi2True));
    }
    REQUIRE(begin(c, scene));
    REFUSED(fmi2EnterInitializationMode(c));
    REQUIRE(begin(c, scene));
    REQUIRE(fmi2DoStep(c, 0.0, 1e-3, fmi2True) == fmi2OK);
    REQUIRE(fmi2Terminate(c) == fmi2OK);
    REFUSED(fmi2DoStep(c, 1e-3, 1e-3, fmi2True));
}

/* A motion past the stops is refused, and the way there, too; what is allowed goes on. */
static void check_bad_motion(fmi2Component c) {
    REQUIRE(begin(c, scene_called("ellipses")));
    const fmi2ValueReference theta = reference("theta"), tau = reference("tau");
    const double inside = 0.3, outside = 0.7;
    double value;
    REQUIRE(fmi2SetReal(c, &theta, 1, &outside) == fmi2OK);
    messages = 0;
    REQUIRE(fmi2DoStep(c, 0.0, 1e-3, fmi2True) == fmi2Error);
    REQUIRE(fmi2GetReal(c, &tau, 1, &value) == fmi2Error && messages == 2);
    REQUIRE(fmi2SetReal(c, &theta, 1, &inside) == fmi2OK);
    REQUIRE(fmi2DoStep(c, 0.0, 1e-3, fmi2True) == fmi2OK);
    REQUIRE(fmi2GetReal(c, &tau, 1, &value) == fmi2OK && isfinite(value));
    REQUIRE(fmi2Reset(c) == fmi2OK);
}

void check_bad_calls(void) {
    REQUIRE(fmi2Instantiate("x", fmi2CoSimulation, "another guid", NULL, &callbacks, fmi2False, fmi2False) == NULL);
    REQUIRE(fmi2Instantiate("x", fmi2CoSimulation, NULL, NULL, &callbacks, fmi2False, fmi2False) == NULL);
    fmi2Component c = instantiate(&callbacks);
    check_bad_values(c);
    check_bad_life(c);
    if (is_inverse()) check_bad_motion(c);
    REQUIRE(begin(c, scene_called("default")));
    fmi2FreeInstance(c); /* without terminate */
    fmi2FreeInstance(NULL);

    const fmi2ValueReference unknown = 0xfffffff0u;
    const double one = 1.0;
    c = instantiate(&no_callbacks); /* nobody listens */
    REQUIRE(fmi2SetReal(c, &unknown, 1, &one) == fmi2Error);
    fmi2FreeInstance(c);
}
