/* The mechanism as an ordinary differential equation that the importing tool's solver integrates, for model exchange:
 * d theta/dt = omega, d omega/dt = alpha, in a mode that changes at events only. Needs inertia: without it the speed
 * is no state. Here m->continuous is true. */
#ifndef DUALCAM_ODE_H
#define DUALCAM_ODE_H

#include "forward/state.h"
#include "model/fault.h"

enum { ODE_STATES = 2 }; /* theta, rad; omega, rad/s */

/* The mode may change where an indicator changes its sign. An indicator without meaning in the present mode is 1. */
typedef enum {
    INDICATOR_VELOCITY, /* rad/s, slip: speed in the direction of the slip */
    INDICATOR_LOAD,     /* N.m, rest: upper edge of the stick band less the torque */
    INDICATOR_RELEASE,  /* N.m, rest: torque less the lower edge */
    INDICATOR_LOWER,    /* rad, releasing: angle to the lower end stop */
    INDICATOR_UPPER,    /* rad, loading: angle to the upper end stop */
    INDICATOR_FLANK_1,  /* N/m, slip with friction: x_i on the flank on which the contact bears */
    INDICATOR_FLANK_2,
    ODE_INDICATORS
} Indicator;

/* False, with the reason in `fault`, if there is no inertia. */
bool ode_is_possible(const Mechanism *m, Fault *fault);

/* x[0] is limited to a little beyond the stops: a solver may evaluate there. */
void ode_set_states(Mechanism *m, const double x[ODE_STATES]);
void ode_get_states(const Mechanism *m, double x[ODE_STATES]);

/* False, with the reason in `fault`, where friction allows no acceleration (P. Painleve, 1895), or where the
 * acceleration is not finite. */
bool ode_rates(const Mechanism *m, double rate[ODE_STATES], Fault *fault);

void ode_indicators(const Mechanism *m, double indicator[ODE_INDICATORS]);

#endif
