#include "model/elements.h"

#include <math.h>

double spring_force(const SpringParams *spring, double z) {
    return spring->preload + z * (spring->stiffness + z * (spring->stiffness2 + z * spring->stiffness3));
}

double spring_rate(const SpringParams *spring, double z) {
    return spring->stiffness + z * (2.0 * spring->stiffness2 + 3.0 * spring->stiffness3 * z);
}

double spring_energy(const SpringParams *spring, double z) {
    return z * (spring->preload +
                z * (spring->stiffness / 2.0 + z * (spring->stiffness2 / 3.0 + z * (spring->stiffness3 / 4.0))));
}

double damper_force(const DamperParams *damper, int direction, double v) {
    const double c = direction > 0 ? damper->c_load : damper->c_release;
    const double q = direction > 0 ? damper->q_load : damper->q_release;
    return v * (c + q * fabs(v));
}
