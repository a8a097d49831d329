/* How the motion goes on from the present instant, as time derivatives: one-sided at a mode change, those of what
 * comes next with the present inputs. */
#ifndef DUALCAM_MOTION_DERIVATIVES_H
#define DUALCAM_MOTION_DERIVATIVES_H

#include "contact/taylor.h"
#include "forward/decide.h"

typedef struct {
    double theta[3], z[3]; /* d/dt to d^3/dt^3 */
} MotionDerivatives;

void motion_derivatives(const Mechanism *m, MotionDerivatives *out);

/* The motion along one way to slip, up to the coefficient `last` of omega, with its derivatives by one knob. */
void taylor_of_motion(const Mechanism *m, const SlipMode *slip, Known known, int last, Taylor *out);

#endif
