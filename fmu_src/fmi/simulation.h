/* How time goes on, whatever the version of FMI: the step of co-simulation, and what model exchange has instead.
 * Where these functions return false, the log says why and names `function`, and nothing has changed. */
#ifndef DUALCAM_SIMULATION_H
#define DUALCAM_SIMULATION_H

#include "fmi/instance.h"

/* ---- co-simulation ---- */

/* An instant inside a step at which the master takes part. */
typedef struct {
    double time;           /* s */
    bool inputs_requested; /* true: the master sets inputs of this instant, which the step has not reached.
                              false: the step has reached this instant, and the master may read variables. */
    bool may_end;          /* the master may end the step here or later */
} IntermediatePoint;

/* Returns the time at which the master wants the step to end, s; INFINITY: no change. */
typedef double IntermediateUpdate(Instance *instance, const IntermediatePoint *point);

typedef struct {
    double time; /* s, at which the step ended */
    bool early;  /* before t + h */
    bool event;  /* the mode changed at the end of the step, and the master handles events */
} StepEnd;

/* A step from time t, which is the instance's time to rounding, to exactly t + h, in which the master takes part as
 * Instance.intermediate says. If the master handles events and allows early return, the step ends at the first mode
 * change after its start. `update`, if not NULL, is called
 *   - at the thirds of the step and at its end for the sampled inputs, before anything moves: the inputs are then the
 *     cubics through these values and the present ones;
 *   - at each mode change inside the step, in order;
 *   - at the end of the step. */
bool simulation_step(Instance *instance, const char *function, double t, double h, IntermediateUpdate *update,
                     StepEnd *end);

/* ---- model exchange ---- */

/* `phases`: where this version of FMI allows the function. */
bool simulation_set_time(Instance *instance, const char *function, unsigned phases, double time);
bool simulation_set_states(Instance *instance, const char *function, const double x[], size_t n);
bool simulation_get_states(Instance *instance, const char *function, double x[], size_t n);
bool simulation_get_derivatives(Instance *instance, const char *function, double derivative[], size_t n);
bool simulation_get_indicators(Instance *instance, const char *function, double indicator[], size_t n);
bool simulation_get_nominals(Instance *instance, const char *function, unsigned phases, double nominal[], size_t n);

/* The integrator's step to the present time, states and inputs is completed. */
bool simulation_complete_integrator_step(Instance *instance, const char *function);

/* Event mode: handles the events. *states_changed: the continuous states have new values. */
bool simulation_update_discrete_states(Instance *instance, const char *function, bool *states_changed);

#endif
