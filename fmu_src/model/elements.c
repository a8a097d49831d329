#include "model/elements.h"

#include <math.h>

#include "numerics/tolerances.h"

double spring_force(const SpringParams *spring, double z) {
    return spring->preload + z * (spring->stiffness + z * (spring->stiffness2 + z * spring->stiffness3));
}

double spring_rate(const SpringParams *spring, double z) {
    return spring->stiffness + z * (2.0 * spring->stiffness2 + 3.0 * spring->stiffness3 * z);
}

double spring_terms(const SpringParams *spring, double z, double dz) {
    const double size = fabs(z), bent = size + SPRING_BENDS * dz; /* at z = 0 k2 and k3 act in second order */
    return (size + dz) * fabs(spring->stiffness) +
           bent * ((bent + 2.0 * dz) * fabs(spring->stiffness2) + bent * (bent + 3.0 * dz) * fabs(spring->stiffness3));
}

double spring_rate_terms(const SpringParams *spring, double z, double dz) {
    const double size = fabs(z), bent = size + SPRING_BENDS * dz;
    return fabs(spring->stiffness) + 2.0 * (size + dz) * fabs(spring->stiffness2) +
           3.0 * bent * (bent + 2.0 * dz) * fabs(spring->stiffness3);
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
