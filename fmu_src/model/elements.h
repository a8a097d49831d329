/* The laws of spring and damper. */
#ifndef DUALCAM_ELEMENTS_H
#define DUALCAM_ELEMENTS_H

#include "model/params.h"

/* N: F_s = preload + k z + k2 z^2 + k3 z^3 */
double spring_force(const SpringParams *spring, double z);

/* N/m: dF_s/dz */
double spring_rate(const SpringParams *spring, double z);

/* N: the size of the terms of F_s without the preload. Where z is known to a share s of dz, m, F_s is known to the
 * share s of this size: dF_s/dz counts at z, and not where the spring's force is larger. */
double spring_terms(const SpringParams *spring, double z, double dz);

/* N/m: the same for dF_s/dz. */
double spring_rate_terms(const SpringParams *spring, double z, double dz);

/* J: the integral of F_s from 0 to z */
double spring_energy(const SpringParams *spring, double z);

/* N: D = v (c + q |v|) with the coefficients of this direction (+1 loading, -1 releasing); v in m/s */
double damper_force(const DamperParams *damper, int direction, double v);

#endif
