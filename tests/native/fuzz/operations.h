/* The calls that an input of the fuzzer stands for. */
#ifndef FUZZ_OPERATIONS_H
#define FUZZ_OPERATIONS_H

#include "run.h"

/* A new instance for this use. */
void run_begin(Run *run, Bytes in, Use use, unsigned options);
/* Frees all. The instance must still be good: after a reset the default run gives what a new instance gives. */
void run_end(Run *run);

/* Up to the first step, with plausible tolerance and time. */
bool start(Run *run);
/* Plausible inputs and a step, in model exchange a step of Euler's method. Twice from a saved state, if the input says
 * so: both must agree bit for bit. */
bool drive(Run *run);

/* All calls of the input, one after the other. */
void make_calls(Run *run);

#endif
