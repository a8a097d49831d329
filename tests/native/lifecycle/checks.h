/* The checks of the lifecycle test. Each one ends the program at the first thing that is not as it must be. */
#ifndef LIFECYCLE_CHECKS_H
#define LIFECYCLE_CHECKS_H

#include "run.h"

/* From here the run goes on alike: on, restored, and in other instances that got the state as bytes. */
void check_snapshots(fmi2Component c, const Scene *scene, double time);
/* By time; in co-simulation alone. */
void check_output_derivatives(fmi2Component c);
/* By inputs and a tunable parameter, and of the latest step. What does not exist is refused with a message. */
void check_derivatives(fmi2Component c);
/* Twice from one saved state, with steps of Euler's method. */
void check_model_exchange(const Scene *scene);
void check_bad_calls(void);
void check_bad_tables(void);
void check_bad_friction_tables(void);
/* A state whose table is lost, or jams, is refused by all but the instance that has read the table. */
void check_lost_tables(void);
/* Many lives, one after the other and in one instance. */
void check_many_lives(void);
/* Many at once, that hand a state round. */
void check_many_at_once(void);
/* Prints the reason for which a scene was refused and frees the instance; returns the empty set of modes. */
unsigned refused(fmi2Component c, const Scene *scene);

#endif
