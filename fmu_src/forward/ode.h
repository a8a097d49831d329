/* The mechanism as an ordinary differential equation that somebody else's solver integrates, for model exchange:
 * d theta/dt = omega, d omega/dt = alpha, in a mode that changes at events only. Needs inertia: without it the speed
 * is no state. Here m->continuous is true. */
#ifndef DUALCAM_ODE_H
#define DUALCAM_ODE_H

#include "forward/state.h"
#include "model/fault.h"

enum { ODE_STATES = 2 }; /* theta, rad; omega, rad/s */

/* Where one of these changes its sign, the mode may change. One that does not matter in the present mode is 1. */
typedef enum {
    INDICATOR_VELOCITY, /* rad/s, slip: speed in the direction of the slip */
    INDICATOR_LOAD,     /* N.m, rest: upper edge of the stick band less the torque */
    INDICATOR_RELEASE,  /* N.m, rest: torque less the lower edge */
    INDICATOR_LOWER,    /* rad, releasing: way to the lower end stop */
    INDICATOR_UPPER,    /* rad, loading: way to the upper end stop */
    INDICATOR_FLANK_1,  /* N/m, slip with friction: x_i on the flank on which the contact bears */
    INDICATOR_FLANK_2,
    ODE_INDICATORS
} Indicator;

/* False, with the reason, if there is no inertia. */
bool ode_is_possible(const Mechanism *m, Fault *fault);

/* A solver may look a little beyond the stops, but no further: theta is held there. */
void ode_set_states(Mechanism *m, const double x[ODE_STATES]);
void ode_get_states(const Mechanism *m, double x[ODE_STATES]);

/* False, with the reason, where friction leaves no acceleration (P. Painleve, 1895) or it is not finite. */
bool ode_rates(const Mechanism *m, double rate[ODE_STATES], Fault *fault);

void ode_indicators(const Mechanism *m, double indicator[ODE_INDICATORS]);

#endif
