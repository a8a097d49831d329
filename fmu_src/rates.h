/* How the motion goes on from the present instant, as time derivatives: one-sided at a mode change, those of what
 * comes next with the present inputs. */
#ifndef DUALCAM_RATES_H
#define DUALCAM_RATES_H

#include "decide.h"
#include "taylor.h"

typedef struct {
    double theta[3], z[3]; /* d/dt to d^3/dt^3 */
} Rates;

void rates_of_motion(const Mechanism *m, Rates *out);

/* The motion along one way to slip, up to the coefficient `last` of omega, with its derivatives by one knob. */
void rates_along(const Mechanism *m, const Way *way, Knob knob, int last, Taylor *out);

#endif
