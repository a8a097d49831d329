#include "collocation/step_energy.h"

#include <float.h>
#include <math.h>

#include "elementary/elementary.h"
#include "numerics/tolerances.h"

/* Work, heat and change of the spring energy, by their sizes. */
static inline double energy_passed(const Booking *b, const double spring[2]) {
    return fabs(b->work_in) + fabs(b->work_ext) + fabs(b->heat_cam[0]) + fabs(b->heat_cam[1]) + b->heat_damper +
           b->heat_shaft + fabs(spring[1] - spring[0]);
}

EnergyBalance step_energy_balance(const SlipMode *slip, const Booking *b, const EnergyEnds *e) {
    const Params *p = slip->params;
    const double spring[2] = {spring_energy(&p->spring, e->z[0]), spring_energy(&p->spring, e->z[1])};
    const double stored = (spring[1] - spring[0]) + (e->kinetic[1] - e->kinetic[0]);
    const double heat = b->heat_cam[0] + b->heat_cam[1] + b->heat_damper + b->heat_shaft;
    const double gained = stored - (b->work_in - b->work_ext - heat);
    const double passed = energy_passed(b, spring);
    const double z = fabs(slip->piece->z[0]) + fabs(slip->piece->z[1]); /* the rounding of z is a share of this size */
    const double energies = passed + fabs(spring[0]) + fabs(spring[1]) + e->kinetic[0] + e->kinetic[1];
    const double rounding = STEP_ENERGY_ROUNDING * energies + STEP_HEIGHT_ROUNDING * fabs(e->spring_force) * z +
                            e->angle_noise * fabs(e->tau);
    const double allowed = STEP_ENERGY_SHARE * p->tolerance * (passed + e->kinetic[1]) + DBL_MIN;
    return (EnergyBalance){.gained = gained, .error = max_of(fabs(gained) - rounding, 0.0) / allowed};
}
