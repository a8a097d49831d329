/* Output derivatives, directional derivatives and derivatives of the latest step. */
#include "checks.h"

#include <math.h>

static size_t outputs(fmi2ValueReference vr[4]) {
    static const char *const forward[] = {"theta", "omega", "z", "v"}, *const inverse[] = {"tau", "z", "v"};
    const size_t count = is_inverse() ? COUNT_OF(inverse) : COUNT_OF(forward);
    for (size_t i = 0; i < count; i++) vr[i] = reference(is_inverse() ? inverse[i] : forward[i]);
    return count;
}

void check_output_derivatives(fmi2Component c) {
    fmi2ValueReference vr[5];
    const size_t count = outputs(vr);
    for (fmi2Integer order = 1; order <= 2; order++) {
        const fmi2Integer orders[] = {order, order, order, order};
        double value[4];
        REQUIRE(fmi2GetRealOutputDerivatives(c, vr, count, orders, value) == fmi2OK);
        for (size_t i = 0; i < count; i++) REQUIRE(!isnan(value[i]));
    }
}

void check_derivatives(fmi2Component c) {
    fmi2ValueReference vr[5];
    const size_t count = outputs(vr);
    const fmi2ValueReference known[] = {reference(is_inverse() ? "alpha" : "tau"), reference("F_ext"),
                                        reference("cam1.friction")};
    const double seed[] = {1.0, -2.0, 0.5};
    if (!is_inverse()) {
        vr[count] = reference("alpha");
        REQUIRE(!isnan(get_real(c, "step.dtheta_dtau")) && !isnan(get_real(c, "step.domega_dtau")));
    }
    const int before = messages;
    double change[5] = {0.0};
    const size_t unknowns = is_inverse() ? count : count + 1;
    const bool exists =
        fmi2GetDirectionalDerivative(c, vr, unknowns, known, COUNT_OF(known), seed, change) == fmi2OK;
    REQUIRE(messages == (exists ? before : before + 1));
    for (size_t i = 0; i < unknowns; i++) REQUIRE(!isnan(change[i]));
    messages = before;
}
