/* The checks of an FMU in a host that does not help: no memory, unusual arithmetic, small stacks, loggers that do not
 * return. Each check ends the program at the first thing that is not as it must be. */
#ifndef FAULTS_FAULTS_H
#define FAULTS_FAULTS_H

#include "../lifecycle/checks.h"
#include "calls.h"

/* ---- runs.c ---- */

/* Random steps of a scene from the first seed on, with derivatives, and a state that goes through bytes into a second
 * instance; the picture at the end. The same calls give the same picture. */
Picture life(const Scene *scene);
/* The same in model exchange, by Euler's method. A scene that model exchange refuses gives zeros. */
Picture exchanged_life(const Scene *scene);
/* The scenes, but for the last one, whose table does not exist. */
const Scene *possible_scenes(size_t *count);

/* ---- the checks ---- */

/* Whatever the host's rounding, flushing of small numbers and traps are, each call gives the same bits and leaves them
 * as they are. */
void check_arithmetic(void);
/* No memory at the n-th allocation of a life, for each n: a refusal with one message, after which the life goes on. */
void check_memory(void);
/* A thread with a stack of 64 kB is enough for each call. Prints the deepest use. */
void check_stack(void);
/* A logger that does not return, or calls the instance, leaves a usable instance. */
void check_loggers(void);
/* Instances in several threads at once give the bits of a run alone. */
void check_threads(void);
/* A locale with a decimal comma changes no number. Needs the name of such a locale in the environment: LC_ALL. */
void check_locale(void);

#endif
