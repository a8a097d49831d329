/* Time goes on: the step of co-simulation, and what model exchange needs instead, whatever the version of FMI.
 * Where these return false they have logged why, naming `function`, and have changed nothing. */
#ifndef DUALCAM_SIMULATION_H
#define DUALCAM_SIMULATION_H

#include "fmi/instance.h"

/* From time t, which is the instance's to rounding, to exactly t + h. */
bool simulation_step(Instance *instance, const char *function, double t, double h);

/* An instant inside a step at which the master takes part. */
typedef struct {
    double time;          /* s */
    bool asks_for_inputs; /* the step has not come to it, and its inputs may be set; else the variables may be read */
    bool may_end;         /* the master may end the step here or later */
} Visit;

/* Returns when the master wants the step to end, s; INFINITY: as it was to. */
typedef double Visitor(Instance *instance, const Visit *visit);

typedef struct {
    double time; /* s, where the step ended */
    bool early;  /* before t + h */
    bool event;  /* the mode changed at its end, and the master has an event mode */
} StepEnd;

/* The same, as the master follows it (Instance.following). If it has an event mode and takes early returns, the step
 * ends at the first mode change after its start. `visitor`, if not NULL, is called
 *   - at the thirds of the step and its end for the inputs sampled, through which cubics are laid (from their present
 *     values), before anything moves;
 *   - at each mode change inside the step, in order;
 *   - at its end. */
bool simulation_follow(Instance *instance, const char *function, double t, double h, Visitor *visitor, StepEnd *end);

/* Ends initialization: to step mode, or, where the master has one, to event mode. */
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
