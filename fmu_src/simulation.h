/* Time goes on: the step of co-simulation, and what model exchange needs instead, whatever the version of FMI.
 * Where these return false they have logged why, naming `function`, and have changed nothing. */
#ifndef DUALCAM_SIMULATION_H
#define DUALCAM_SIMULATION_H

#include "instance.h"

/* From time t, which is the instance's to rounding, to exactly t + h. */
bool simulation_step(Instance *instance, const char *function, double t, double h);

/* Ends initialization: to step mode, or in model exchange to event mode. */
bool simulation_begin(Instance *instance, const char *function);

/* Model exchange. */
bool simulation_set_time(Instance *instance, const char *function, double time);
bool simulation_set_states(Instance *instance, const char *function, const double x[], size_t n);
bool simulation_get_states(Instance *instance, const char *function, double x[], size_t n);
bool simulation_get_rates(Instance *instance, const char *function, double rate[], size_t n);
bool simulation_get_indicators(Instance *instance, const char *function, double indicator[], size_t n);
bool simulation_get_nominals(Instance *instance, const char *function, double nominal[], size_t n);

/* The solver's step to the present time, states and inputs is good. */
bool simulation_accept(Instance *instance, const char *function);

/* Event mode: carries out what is due; *moved: the continuous states are others now. */
bool simulation_settle(Instance *instance, const char *function, bool *moved);

#endif
