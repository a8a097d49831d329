/* Groups of outputs, from state, params and present inputs. The mode is decided with the present inputs. Reading
 * an output never changes the mechanism. */
#ifndef DUALCAM_OUTPUTS_H
#define DUALCAM_OUTPUTS_H

#include "contact/taylor.h"
#include "forward/state.h"

void mechanism_motion(const Mechanism *m, Motion *out);
void mechanism_loads(const Mechanism *m, LoadOutputs *out);
void mechanism_energy(const Mechanism *m, Energy *out);
void mechanism_audit(const Mechanism *m, Audit *out);

/* Time derivatives at the present instant; at a mode change those of the mode that follows with the present inputs. */
typedef struct {
    double theta[3], z[3]; /* orders 1 to 3; rad/s^k, m/s^k */
} MotionDerivatives;

void motion_derivatives(const Mechanism *m, MotionDerivatives *out);

/* The motion in one slip mode as Taylor polynomials, up to the coefficient `last` of omega, with their derivatives by
 * `known`. KNOWN_COUNT: without derivatives. */
void taylor_of_motion(const Mechanism *m, const SlipMode *slip, Known known, int last, Taylor *out);

#endif
