/* The functions of FMI 2.0 and of FMI 3.0 under one name each. calls.c has those that differ by names alone, and
 * calls_fmi2.c and calls_fmi3.c have the others. Each call is checked (guard.h). The functions return true where the FMU
 * says OK. `run->c` is the instance. */
#ifndef FUZZ_CALLS_H
#define FUZZ_CALLS_H

#include "run.h"

/* ---- life ---- */

/* With run->options, below OPTIONS. Ends the program if the FMU refuses. */
enum { OPTIONS = 8 };
void call_instantiate(Run *run, Use use);
void call_free(Run *run);
/* Up to initialization mode. `tolerance` and `stop` may be NULL. */
bool call_enter_initialization(Run *run, const double *tolerance, double start, const double *stop);
bool call_exit_initialization(Run *run);
bool call_terminate(Run *run);
bool call_reset(Run *run);
bool call_logging(Run *run, bool on, size_t n, const char *const categories[]);

/* ---- variables ---- */

bool call_get_reals(Run *run, const unsigned vr[], size_t n, double value[]);
bool call_get_integers(Run *run, const unsigned vr[], size_t n, int value[]);
bool call_get_booleans(Run *run, const unsigned vr[], size_t n);
bool call_get_texts(Run *run, const unsigned vr[], size_t n);
bool call_set_reals(Run *run, const unsigned vr[], size_t n, const double value[]);
bool call_set_integers(Run *run, const unsigned vr[], size_t n, const int value[]);
bool call_set_booleans(Run *run, const unsigned vr[], size_t n, const int value[]);
bool call_set_texts(Run *run, const unsigned vr[], size_t n, const char *const value[]);
bool call_directional(Run *run, const unsigned unknown[], size_t unknowns, const unsigned known[], size_t knowns,
                      const double seed[], double product[]);
bool call_output_derivatives(Run *run, const unsigned vr[], size_t n, const int order[], double value[]);

/* ---- FMU states ---- */

bool call_get_state(Run *run, void **state);
bool call_set_state(Run *run, void *state);
bool call_free_state(Run *run, void **state);
bool call_state_size(Run *run, void *state, size_t *size);
bool call_serialize(Run *run, void *state, void *bytes, size_t size);
bool call_deserialize(Run *run, const void *bytes, size_t size, void **state);

/* ---- time ---- */

/* Sets run->time after success, and run->event. */
bool call_step(Run *run, double t, double h);
bool call_enter_events(Run *run);
/* From event mode on: into continuous-time mode or, in co-simulation, into step mode. */
bool call_leave_events(Run *run);
bool call_update_states(Run *run);
bool call_complete_step(Run *run);
bool call_set_time(Run *run, double time);
bool call_set_states(Run *run, const double x[], size_t n);
bool call_get_states(Run *run, double x[], size_t n);
bool call_get_derivatives(Run *run, double derivative[], size_t n);
bool call_get_indicators(Run *run, double indicator[], size_t n);
bool call_get_nominals(Run *run, double nominal[], size_t n);

/* ---- what only one version has ---- */

/* One call that the input chooses. */
void call_special(Run *run);

#endif
